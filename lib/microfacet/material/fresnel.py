"""Fresnel: how much light a facet reflects."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import sqrt
from typing import Any, ClassVar

import numpy as np
import sympy as sp

from microfacet.directions import numbers, positive, within
from microfacet.kernels import Batch, Parameters, packed
from microfacet.model import Model
from microfacet.notation import raw
from microfacet.statement import Equation

c = sp.Symbol("c", positive=True)  # cosine between light and facet normal
eta, kappa = sp.symbols("eta kappa", positive=True)  # refractive index relative to outside; its imaginary part
F0 = sp.Symbol("F_0", positive=True)
g = sp.Symbol("g", positive=True)
COSINE = (1e-6, 1)
INDEX = (1e-10, 1e8)  # at 1e-12 and at 1e10 single precision gives no numbers any more
reflectance = r"F(\omega_o, \omega_h)"

# --- statements ---------------------------------------------------------------------------------------------------


def dielectric(c: float, eta: float) -> float:
    """Reflectance of a dielectric; 1 beyond the angle of total reflection."""
    contrast = (eta - 1.0) * (eta + 1.0)
    square = contrast + c * c
    if not square > 0.0:
        return 1.0
    g = sqrt(square)
    both = g + c
    apart = contrast / both
    r = 1.0 - 2.0 * c / both if 3.0 * c < g else apart / both
    s = (c * both - 1.0) / (c * apart + 1.0)
    return 0.5 * (r * r) * (1.0 + s * s)


def conductor(c: float, eta: float, kappa: float) -> float:
    """Reflectance of a conductor of index eta + i kappa, outside index 1."""
    s2 = (1.0 - c) * (1.0 + c)
    t = (eta - kappa) * (eta + kappa) - s2
    product = eta * kappa
    length = sqrt(t * t + 4.0 * product * product)
    large = sqrt(0.5 * (length + abs(t)))
    small = product / large if large > 0.0 else 0.0
    a = large if t >= 0.0 else small
    b = small if t >= 0.0 else large
    apart = a - c
    if t >= 0.0 and abs(apart) < 0.5 * a:
        apart = ((eta - 1.0) * (eta + 1.0) - (kappa - b) * (kappa + b)) / (a + c)
    across = (apart * apart + b * b) / ((a + c) * (a + c) + b * b)
    along = ((a * c - s2) * (a * c - s2) + (b * c) * (b * c)) / ((a * c + s2) * (a * c + s2) + (b * c) * (b * c))
    return 0.5 * across * (1.0 + along)


def _refracted() -> sp.Expr:
    return sp.sqrt(1 - (1 - c**2) / eta**2)


def _dielectric_steps() -> list[Any]:
    """Both usual forms, with g = eta cos of the refracted angle and g^2 = eta^2 - 1 + c^2 put in at the end."""
    parallel, across = (eta * c - g / eta) / (eta * c + g / eta), (c - g) / (c + g)
    both = ((g - c) / (g + c)) ** 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2) / 2
    difference = sp.together(both - (across**2 + parallel**2) / 2).subs(eta, sp.sqrt(g**2 + 1 - c**2))
    return [sp.simplify(difference), sp.simplify((eta * _refracted()) ** 2 - (eta**2 - 1 + c**2))]


def _normal_steps(it: Equation) -> list[Any]:
    """Both materials at c = 1; without absorption the conductor's is the dielectric's."""
    glass = dielectric_F.computed_as.doit().subs(c, 1) - ((eta - 1) / (eta + 1)) ** 2
    put = {_A: eta, _B2: kappa**2}  # at c = 1 the square root is that of a square
    squares = [(_T.subs(c, 1) + put[_A] ** 2 + put[_B2]) / 2 - eta**2, (put[_A] ** 2 + put[_B2]) ** 2 - _LENGTH.subs(c, 1) ** 2]
    metal = conductor_F.equals.doit().subs({c: 1, _a: eta, _b: kappa}) - it.equals.doit()
    return [glass, *squares, metal, it.equals.doit().subs(kappa, 0) - ((eta - 1) / (eta + 1)) ** 2]


def _refraction_steps() -> list[Any]:
    """Snell: the sines are as the indices; then the squares of both forms of g."""
    sine = sp.sqrt(1 - c**2) / eta
    return [sp.sqrt(1 - sine**2) - _refracted(), (eta * _refracted()) ** 2 - (eta**2 - 1 + c**2)]


def _share(a: sp.Expr) -> sp.Expr:
    """What comes back of one polarisation. Kept as it is written: sympy would find it to be 1."""
    return sp.Abs((a - sp.I * _b) / (a + sp.I * _b), evaluate=False) ** 2


def _total_steps(it: Equation) -> list[Any]:
    """i b is the root of what is below 0 under it; numbers and their conjugates have the same modulus."""
    return [(sp.I * it.where[_b]) ** 2 - (eta**2 - 1 + c**2), it.means.doit() - it.equals]


refracted = raw("c_t", r"c_t", positive=True)  # cosine between refracted light and facet
_a, _b = sp.symbols("a_k b_k", positive=True)  # real and imaginary part of g, for any index

with sp.evaluate(False):
    _root = sp.sqrt(eta**2 - 1 + c**2)
    refraction = Equation(
        key="material.fresnel.refraction",
        title="cosine of the refracted ray, times the index",
        symbol=g,
        means=eta * refracted,
        equals=_root,
        where={refracted: _refracted()},
        computed_as=sp.sqrt((eta - 1) * (eta + 1) + c**2),
        proof=_refraction_steps,
        proved_by="sympy: Snell's law put in, then squares of both sides",
        over={c: COSINE, eta: (1.0001, 4)},
        slides=(47, 48),
        cite="cook1982",
    )
    dielectric_F = Equation(
        key="material.fresnel.dielectric",
        title="Fresnel reflectance of a dielectric",
        symbol=raw("F_dielectric", reflectance),
        means=(((c - eta * refracted) / (c + eta * refracted)) ** 2 + ((eta * c - refracted) / (eta * c + refracted)) ** 2) / 2,
        equals=((g - c) / (g + c)) ** 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2) / 2,
        computed_as=((_root - c) / (_root + c)) ** 2 * (1 + ((c * (_root + c) - 1) / (c * (_root - c) + 1)) ** 2) / 2,
        where={refracted: _refracted(), g: _root},
        rewrite_proof=list,
        computed_by=dielectric,
        over={c: COSINE, eta: (1.0001, 4)},
        proof=_dielectric_steps,
        proved_by="sympy: both usual forms, in terms of g",
        slides=(47, 48),
        cite="cook1982",
        note="c is the cosine between light and facet, eta the index relative to outside.",
    )
    total_F = Equation(
        key="material.fresnel.total",
        title="total reflection",
        symbol=raw("F_total", reflectance),
        means=(_share(c) + _share(eta**2 * c)) / 2,
        equals=sp.Integer(1),
        where={_b: sp.sqrt(1 - eta**2 - c**2)},
        computed_by=dielectric,
        within=(0, 0),
        over={c: (1e-6, 0.7), eta: (0.01, 0.7)},
        proof=_total_steps,
        proved_by="sympy: g is imaginary, so each amplitude is a number over its conjugate",
        slides=(47, 48),
        cite="cook1982",
        note="True wherever c^2 + eta^2 < 1; the box lies within.",
    )
    schlick_F = Equation(
        key="material.fresnel.schlick",
        title="Schlick's approximation of Fresnel reflectance",
        symbol=raw("F_schlick", reflectance),
        equals=F0 + (1 - F0) * (1 - c) ** 5,
        over={c: COSINE, F0: (0.001, 1)},
        slides=(47, 48),
        cite="schlick1994",
    )

# a + i b = sqrt((eta + i kappa)^2 - sin^2 theta), the conductor's refracted cosine times its index
_T = eta**2 - kappa**2 - (1 - c**2)
_LENGTH = sp.sqrt(_T**2 + 4 * eta**2 * kappa**2)
_A, _B2 = sp.sqrt((_LENGTH + _T) / 2), (_LENGTH - _T) / 2
_S2 = 1 - c**2


def _ratio(first: sp.Expr, second: sp.Expr, a: sp.Expr, b2: sp.Expr) -> sp.Expr:
    """|first a - second + i first b|^2 / |first a + second + i first b|^2."""
    return ((first * a - second) ** 2 + first**2 * b2) / ((first * a + second) ** 2 + first**2 * b2)


def _conductor_steps() -> list[Any]:
    """The complex square root; the s- and p-amplitudes in it; moduli squared."""
    root = _a + sp.I * _b
    perpendicular = (c - root) / (c + root)
    amplitude = (root * c - _S2) / (root * c + _S2)  # of p relative to s, but for the sign
    z = sp.Symbol("z")  # the root; the squared index is z^2 + sin^2
    numerators = [(z**2 + _S2) * c - z - (z * c - _S2) * (z - c), (z**2 + _S2) * c + z - (z * c + _S2) * (z + c)]
    return [
        sp.simplify(_A**2 - _B2 - _T),
        sp.simplify(_A**2 * _B2 - eta**2 * kappa**2),
        sp.simplify(perpendicular * sp.conjugate(perpendicular) - _ratio(sp.Integer(1), c, _a, _b**2)),
        sp.simplify(amplitude * sp.conjugate(amplitude) - _ratio(c, _S2, _a, _b**2)),
        *map(sp.expand, numerators),
    ]


with sp.evaluate(False):
    _PRINTED = (
        ((_a - c) ** 2 + _b**2)
        / (2 * ((_a + c) ** 2 + _b**2))
        * (1 + ((_a * c - 1 + c**2) ** 2 + _b**2 * c**2) / ((_a * c + 1 - c**2) ** 2 + _b**2 * c**2))
    )

conductor_F = Equation(
    key="material.fresnel.conductor",
    title="Fresnel reflectance of a conductor",
    symbol=raw("F_conductor", reflectance),
    equals=_PRINTED,
    computed_as=_PRINTED.subs({_a: _A, _b: sp.sqrt(_B2)}),
    rewrite_proof=list,
    where={_a: _A, _b: sp.sqrt(_B2)},
    computed_by=conductor,
    over={c: COSINE, eta: (0.05, 5), kappa: (0.01, 10)},
    proof=_conductor_steps,
    proved_by="sympy: complex amplitudes, their moduli squared",
    slides=(47, 48),
    cite="cook1982",
    note=r"$a_k + i b_k = \sqrt{(\eta + i \kappa)^2 - 1 + c^2}$; index $\eta + i \kappa$, outside 1.",
)

with sp.evaluate(False):
    normal_F = Equation(
        key="material.fresnel.normal",
        title="Fresnel reflectance at normal incidence",
        symbol=F0,
        equals=((eta - 1) ** 2 + kappa**2) / ((eta + 1) ** 2 + kappa**2),
        over={eta: (0.05, 5), kappa: (0.01, 10)},
        proof=_normal_steps,
        proved_by="sympy: c = 1 put into both reflectances; the dielectric's is the case kappa = 0",
        slides=(47, 48),
        cite="cook1982",
    )


# --- what a BRDF takes ------------------------------------------------------------------------------------------------


class Fresnel(Model):
    """A reflectance as a function of the cosine between light and facet normal."""

    kernel: ClassVar[Callable[..., float]]  # F(cosine, parameters)
    parameters: Parameters

    def F(self, cosine: Any) -> Any:
        """Reflectance in [0, 1] at cosines in [0, 1]; any shape."""
        values = numbers("cosine", cosine).array
        if not np.all((values >= 0) & (values <= 1)):
            raise ValueError(f"cosine must lie in [0, 1], got {values.min()} to {values.max()}")
        return _over_cosines(type(self).kernel)([values], self.parameters)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(map(repr, self.parameters))})"


@cache
def _over_cosines(kernel: Callable[..., float]) -> Batch:
    return Batch(kernel, [1])


def kernel_mirror(c: float, p: Any) -> float:
    return 1.0


class Mirror(Fresnel):
    """Perfect mirrors: F = 1."""

    kernel = staticmethod(kernel_mirror)
    parameters = ()


class Dielectric(Fresnel):
    """A dielectric of refractive index eta relative to outside, within `INDEX`, else a ValueError. cook1982."""

    kernel = staticmethod(packed(dielectric, 1, 1))

    def __init__(self, eta: float) -> None:
        self.parameters = (within("eta", eta, INDEX),)


class Conductor(Fresnel):
    """A conductor of complex index eta + i k, both within `INDEX`, else a ValueError; outside index 1. cook1982."""

    kernel = staticmethod(packed(conductor, 1, 2))

    def __init__(self, eta: float, k: float) -> None:
        self.parameters = (within("eta", eta, INDEX), within("k", k, INDEX))


class Schlick(Fresnel):
    """Schlick's approximation from the reflectance F0 at normal incidence, in (0, 1]. schlick1994."""

    kernel = staticmethod(packed(schlick_F.scalar, 1, 1))

    def __init__(self, F0: float) -> None:
        if positive("F0", F0) > 1:
            raise ValueError(f"F0 must lie in (0, 1], got {F0}")
        self.parameters = (float(F0),)
