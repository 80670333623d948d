"""Fresnel: how much light a facet reflects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from math import sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.arithmetic import two_product, two_sum
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Parameters
from microfacet.directions import cosines, real_number, within
from microfacet.parameters import Parametric, each, shown, together
from microfacet.statements.notation import printed_symbol
from microfacet.statements.statement import Equation

c = sp.Symbol("c", positive=True)  # cosine between light and facet normal
eta, kappa = sp.symbols("eta kappa", positive=True)  # refractive index relative to outside; its imaginary part
F0, F90 = sp.symbols("F_0 F_90", positive=True)  # reflectance at normal and at grazing incidence
tint = sp.Symbol("t", positive=True)  # of the reflectance at 82 degrees
b82 = sp.Symbol("b", positive=True)
g = sp.Symbol("g", positive=True)
COSINE = (1e-6, 1)
INDEX = (1e-10, 1e8)  # at 1e-12 and at 1e10 single precision gives no numbers any more
ABSORPTION = (1e-20, 1e8)  # below, squares vanish in single precision before the reflectance of an index near 1 does
reflectance = r"F(\omega_o, \omega_h)"

# --- statements ---------------------------------------------------------------------------------------------------


def critical(eta: float, kappa: float) -> tuple[float, float, float]:
    """1 + kappa^2 - eta^2, and its root in two parts, where it is above 0: the cosine below which all light is reflected."""
    square, lost = two_product(eta, eta)
    absorbed, missing = two_product(kappa, kappa)
    part, first = two_sum(absorbed, -square)
    whole, second = two_sum(part, 1.0)
    total, rest = two_sum(whole, (first + second) + (missing - lost))
    root = sqrt(total) if total > 0.0 else 1.0
    back, error = two_product(root, root)
    return total, root, (((total - back) - error) + rest) / (2.0 * root)


def beyond_critical(c: float, eta: float, kappa: float) -> float:
    """c^2 - 1 + eta^2 - kappa^2 without loss of digits, next to its zero too; the zero depends on the material only."""
    total, root, rest = critical(eta, kappa)
    return ((c - root) - rest) * (c + root) if total > 0.0 else c * c - total


def dielectric(c: float, eta: float) -> float:
    """Reflectance of a dielectric; 1 beyond the angle of total reflection, and 0 for equal indices."""
    contrast = (eta - 1.0) * (eta + 1.0)
    square = beyond_critical(c, eta, 0.0)
    if not square > 0.0:
        return 1.0 if contrast < 0.0 else 0.0
    s2 = (1.0 - c) * (1.0 + c)
    g = sqrt(square)
    both = g + c
    r = 1.0 - 2.0 * c / both if 3.0 * c < g else contrast / (both * both)
    s = (c * g - s2) / (c * g + s2)
    return min(0.5 * (r * r) * (1.0 + s * s), 1.0)


def length(x: float, y: float) -> float:
    """sqrt(x^2 + y^2) of two numbers from 0, without squares that overflow or vanish."""
    larger = max(x, y)
    ratio = min(x, y) / larger if larger > 0.0 else 0.0
    return larger * sqrt(1.0 + ratio * ratio)


def conductor(c: float, eta: float, kappa: float) -> float:
    """Reflectance of a conductor of index eta + i kappa, outside index 1; for kappa = 0 that of a dielectric.

    Where the index is near 1, a + i b - c is small: it is (index^2 - 1)/(a + i b + c), of which the modulus loses no digits.
    """
    contrast = length(abs(eta - 1.0), kappa) * length(eta + 1.0, kappa)
    if not contrast > 0.0:
        return 0.0
    s2 = (1.0 - c) * (1.0 + c)
    t = beyond_critical(c, eta, kappa)
    product = eta * kappa
    # times 256, so that in single precision these squares do not vanish before the reflectance of an index near 1 does
    modulus = sqrt((256.0 * t) * (256.0 * t) + (512.0 * product) * (512.0 * product)) / 256.0
    large = sqrt(0.5 * (modulus + abs(t)))
    small = product / large if large > 0.0 else 0.0
    a = large if t > 0.0 else small
    b = small if t > 0.0 else large
    both = (a + c) * (a + c) + b * b
    near = t > 0.0 and 3.0 * c > a
    ratio = (contrast if near else (a - c) * (a - c) + b * b) / both
    across = ratio * ratio if near else ratio
    along = ((a * c - s2) * (a * c - s2) + (b * c) * (b * c)) / ((a * c + s2) * (a * c + s2) + (b * c) * (b * c))
    return min(0.5 * across * (1.0 + along), 1.0)


def schlick(c: float, F0: float, F90: float) -> float:
    """F0 (1 - u^5) + F90 u^5 with u = 1 - c: a sum of terms that are not negative, so that no digits are lost."""
    u = 1.0 - c
    fourth = (u * u) * (u * u)
    series = (1.0 + u) * (1.0 + u * u) + fourth
    return min(F0 * c * series + F90 * (fourth * u), 1.0)


def f82(c: float, F0: float, tint: float, F90: float) -> float:
    """The same, less b c (1 - c)^6."""
    b = (1.0 - tint) * (F0 * F0_AT_EDGE + F90 * (1.0 - F0_AT_EDGE)) * PER_EDGE
    u = 1.0 - c
    cube = u * u * u
    return max(schlick(c, F0, F90) - b * c * (cube * cube), 0.0)


F0_AT_EDGE = 9031.0 / 16807.0  # what F0 counts at c = 1/7: 1 - (6/7)^5
PER_EDGE = 823543.0 / 46656.0  # 1 over c (1 - c)^6 at c = 1/7


def lowest_f82(F0: Any, tint: Any, F90: Any) -> tuple[Any, Any]:
    """The cosine, and the value there, at which the tinted approximation is least between its ends; shapes broadcast.

    With u = 1 - c its derivative by u is u^4 (5 (F90 - F0) - 6 b u + 7 b u^2): the least value is at the larger root.
    """
    b = (1 - tint) * (F0 * F0_AT_EDGE + F90 * (1 - F0_AT_EDGE)) * PER_EDGE
    square = 9 - 35 * (F90 - F0) / np.where(b > 0, b, np.nan)
    rooted = square >= 0  # without a root it rises from F0 to F90
    u = np.where(rooted, np.minimum((3 + np.sqrt(np.where(rooted, square, 0.0))) / 7, 1.0), 0.0)
    return 1 - u, F0 + (F90 - F0) * u**5 - b * (1 - u) * u**6


LEAST = 1e-15  # rounding of what touches 0


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


def _returned(a: sp.Expr) -> sp.Expr:
    """What comes back of one polarisation. Kept as it is written: sympy would find it to be 1."""
    return sp.Abs((a - sp.I * _b) / (a + sp.I * _b), evaluate=False) ** 2


def _total_steps(it: Equation) -> list[Any]:
    """i b is the root of what is below 0 under it; numbers and their conjugates have the same modulus."""
    return [(sp.I * it.where[_b]) ** 2 - (eta**2 - 1 + c**2), it.means.doit() - it.equals]


refracted = printed_symbol("c_t", r"c_t", positive=True)  # cosine between refracted light and facet
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
        symbol=printed_symbol("F_dielectric", reflectance),
        means=(((c - eta * refracted) / (c + eta * refracted)) ** 2 + ((eta * c - refracted) / (eta * c + refracted)) ** 2) / 2,
        equals=((g - c) / (g + c)) ** 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2) / 2,
        computed_as=((_root - c) / (_root + c)) ** 2 * (1 + ((c * (_root + c) - 1) / (c * (_root - c) + 1)) ** 2) / 2,
        where={refracted: _refracted(), g: _root},
        rewrite_proof=list,
        computed_by=dielectric,
        within=(16, 16),
        over={c: COSINE, eta: (1.0001, INDEX[1])},
        proof=_dielectric_steps,
        proved_by="sympy: both usual forms, in terms of g",
        slides=(47, 48),
        cite="cook1982",
        note="c is the cosine between light and facet, eta the index relative to outside.",
    )
    total_F = Equation(
        key="material.fresnel.total",
        title="total reflection",
        symbol=printed_symbol("F_total", reflectance),
        means=(_returned(c) + _returned(eta**2 * c)) / 2,
        equals=sp.Integer(1),
        where={_b: sp.sqrt(1 - eta**2 - c**2)},
        computed_by=dielectric,
        within=(0, 0),
        over={c: (1e-6, 0.7), eta: (INDEX[0], 0.7)},
        proof=_total_steps,
        proved_by="sympy: g is imaginary, so each amplitude is a number over its conjugate",
        slides=(47, 48),
        cite="cook1982",
        note="True wherever c^2 + eta^2 < 1; the box lies within.",
    )
    schlick_F = Equation(
        key="material.fresnel.schlick",
        title="Schlick's approximation of Fresnel reflectance",
        symbol=printed_symbol("F_schlick", reflectance),
        equals=F0 + (1 - F0) * (1 - c) ** 5,
        within=(12, 12),
        over={c: COSINE, F0: (0.001, 1)},
        slides=(47, 48),
        cite="schlick1994",
    )


EDGE = sp.Rational(1, 7)  # cosine of some 82 degrees, where c (1 - c)^6 is largest


def _schlick(cosine: Any) -> Any:
    return F0 + (F90 - F0) * (1 - cosine) ** 5


def _f82_steps(it: Equation) -> list[Any]:
    """Its values at 1/7, at 0 and at 1; what is taken off is largest at 1/7."""
    F = it.equals.subs(it.where).doit()
    off = c * (1 - c) ** 6
    return [
        F.subs(c, EDGE) - tint * _schlick(EDGE),
        F.subs(c, 0) - F90,
        F.subs(c, 1) - F0,
        sp.factor(sp.diff(off, c)) - (1 - 7 * c) * (1 - c) ** 5,
        F.subs(tint, 1) - _schlick(c),
    ]


with sp.evaluate(False):
    _TINTED = F0 + (F90 - F0) * (1 - c) ** 5 - b82 * c * (1 - c) ** 6
    _B82 = (1 - tint) * (F0 + (F90 - F0) * sp.Rational(6, 7) ** 5) / (sp.Rational(1, 7) * sp.Rational(6, 7) ** 6)
    edge_F = Equation(
        key="material.fresnel.edge",
        title="Schlick's approximation with any reflectance at grazing incidence",
        symbol=printed_symbol("F_edge", reflectance),
        equals=F0 + (F90 - F0) * (1 - c) ** 5,
        computed_by=schlick,
        within=(16, 16),
        over={c: COSINE, F0: (1e-6, 1), F90: (1e-6, 1)},
        slides=(47, 48),
        cite="schlick1994",
        note="F_90 = 1 is Schlick's; the kernel adds two numbers that are not negative.",
    )
    f82_F = Equation(
        key="material.fresnel.f82",
        title="Schlick's approximation with a tint near grazing incidence",
        symbol=printed_symbol("F_82", reflectance),
        equals=_TINTED,
        where={b82: _B82},
        computed_as=_TINTED.subs(b82, _B82),
        computed_by=f82,
        within=(12, 12),
        over={c: COSINE, F0: (0.3, 1), tint: (0.5, 1), F90: (0.3, 1)},
        proof=_f82_steps,
        rewrite_proof=list,
        proved_by="sympy: its values at 1/7, 0 and 1, and the derivative of what is taken off",
        slides=(47, 48),
        cite="hoffman2019",
        note="t is the tint at 82 degrees.",
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
    symbol=printed_symbol("F_conductor", reflectance),
    equals=_PRINTED,
    computed_as=_PRINTED.subs({_a: _A, _b: sp.sqrt(_B2)}),
    rewrite_proof=list,
    where={_a: _A, _b: sp.sqrt(_B2)},
    computed_by=conductor,
    within=(24, 24),
    over={c: COSINE, eta: INDEX, kappa: INDEX},
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
        within=(12, 12),
        over={eta: (0.05, 5), kappa: (0.01, 10)},
        proof=_normal_steps,
        proved_by="sympy: c = 1 put into both reflectances; the dielectric's is the case kappa = 0",
        slides=(47, 48),
        cite="cook1982",
    )


# --- what a BRDF takes ------------------------------------------------------------------------------------------------


class Fresnel(Parametric):
    """Base class of the reflectances of a microfacet, functions of the cosine between light and normal.

    A subclass gives ``kernel`` and ``parameters``. If it names its statement, the gate compares both, and the table of right
    digits has a row for it.

    Attributes
    ----------
    kernel : callable
        Reflectance of one cosine and the parameters. A function of floats that numba can compile.
    statements : mapping, optional
        ``{"F": statement}``: its arguments are the cosine, then those of the constructor.
    parameters : tuple
        What the kernel takes last, numbers or arrays; best a named tuple, whose fields it reads.

    References
    ----------
    cook1982.

    Examples
    --------
    >>> import microfacet as mf
    >>> isinstance(mf.Dielectric(1.5), mf.Fresnel)
    True
    """

    kernel: ClassVar[Callable[..., float]]  # F(cosine, parameters)
    statements: ClassVar[Mapping[str, Equation]] = {}
    regular: ClassVar[bool] = False  # whether few nodes suffice for integrals over it; if not, more are taken
    parameters: Parameters

    def __init_subclass__(cls) -> None:
        """What is known of another kernel is not known of its own."""
        super().__init_subclass__()
        if "kernel" in vars(cls):
            cls.regular, cls.statements = vars(cls).get("regular", False), vars(cls).get("statements", {})

    def F(self, cosine: ArrayLike) -> NDArray[Any]:
        """Reflectance of a microfacet.

        Parameters
        ----------
        cosine : array_like
            Cosines between light and normal, in [0, 1] to within 1e-5 for rounding.

        Returns
        -------
        ndarray
            Reflectance in [0, 1].

        Raises
        ------
        ValueError
            If a cosine is outside [0, 1].

        Examples
        --------
        >>> import microfacet as mf
        >>> print(mf.Dielectric(1.5).F([1.0, 0.5, 0.0]).round(4))
        [0.04   0.0892 1.    ]
        """
        return _over_cosines(type(self).kernel)([cosines("cosine", cosine)], self.parameters)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(repr(p) if np.ndim(p) == 0 else shown(p) for p in self.parameters)})"


@cache
def _over_cosines(kernel: Callable[..., float]) -> Batch:
    return Batch(kernel, [1])


class Index(NamedTuple):
    """Parameter of `Dielectric`."""

    eta: float


class ComplexIndex(NamedTuple):
    """Parameters of `Conductor`."""

    eta: float
    k: float


class Ends(NamedTuple):
    """Parameters of `Schlick`."""

    F0: float
    F90: float


class TintedEnds(NamedTuple):
    """Parameters of `F82Tint`."""

    F0: float
    tint: float
    F90: float


def kernel_mirror(cosine: float, p: tuple[()]) -> float:
    return 1.0


def kernel_dielectric(cosine: float, p: Index) -> float:
    return dielectric(cosine, p.eta)


def kernel_conductor(cosine: float, p: ComplexIndex) -> float:
    return conductor(cosine, p.eta, p.k)


def kernel_schlick(cosine: float, p: Ends) -> float:
    return schlick(cosine, p.F0, p.F90)


def kernel_f82(cosine: float, p: TintedEnds) -> float:
    return f82(cosine, p.F0, p.tint, p.F90)


def _share(name: str, value: Any) -> float:
    """The argument as a float in [0, 1]; anything else is a ValueError that names it."""
    number = _number(name, value)
    if not 0 <= number <= 1:
        raise ValueError(f"{name} must lie in [0, 1], got {number:g}")
    return number


def _index(name: str, value: Any) -> float:
    return within(name, value, INDEX)


def _absorption(name: str, value: Any) -> float:
    """The argument as a float that is 0 or within `ABSORPTION`; anything else is a ValueError."""
    number, (low, high) = _number(name, value), ABSORPTION
    if number != 0 and not low <= number <= high:
        raise ValueError(f"{name} must be 0 or lie between {low:g} and {high:g}, got {number:g}")
    return number


def _number(name: str, value: Any) -> float:
    try:
        return real_number(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number, got {value!r}") from None


class Mirror(Fresnel):
    """Perfect mirrors: F = 1."""

    label = "perfect mirrors"
    regular = True

    kernel = staticmethod(kernel_mirror)
    parameters = ()


class Dielectric(Fresnel):
    r"""Fresnel reflectance of a dielectric, for unpolarised light.

    .. math:: F = \frac{1}{2} \left( \frac{g - c}{g + c} \right)^2
              \left( 1 + \left( \frac{c (g + c) - 1}{c (g - c) + 1} \right)^2 \right), \quad g^2 = \eta^2 - 1 + c^2

    and 1 at total reflection. Statements ``material.fresnel.dielectric`` and ``material.fresnel.total``.

    Parameters
    ----------
    eta : array_like
        Refractive index relative to the outside, dimensionless, from 1e-10 to 1e8; below 1 seen from within.

    Raises
    ------
    ValueError
        If eta is outside that range.

    References
    ----------
    cook1982.

    Examples
    --------
    >>> import microfacet as mf
    >>> print(f"{mf.Dielectric(1.5).F(1.0):.4f}")
    0.0400
    """

    label, cite = "dielectric", "cook1982"
    regular = True

    statements: ClassVar = {"F": dielectric_F}
    kernel = staticmethod(kernel_dielectric)

    def __init__(self, eta: ArrayLike) -> None:
        self.eta = each(_index, "eta", eta)
        self.parameters = Index(self.eta)


class Conductor(Fresnel):
    r"""Fresnel reflectance of a conductor, for unpolarised light.

    .. math:: F = \frac{(a - c)^2 + b^2}{2 \left( (a + c)^2 + b^2 \right)} \left( 1 +
              \frac{(a c - 1 + c^2)^2 + b^2 c^2}{(a c + 1 - c^2)^2 + b^2 c^2} \right), \quad
              (a + i b)^2 = (\eta + i k)^2 - 1 + c^2

    Statement ``material.fresnel.conductor``.

    Parameters
    ----------
    eta : array_like
        Real part of the refractive index, dimensionless, from 1e-10 to 1e8; outside the index is 1.
    k : array_like
        Imaginary part: 0, which makes it a dielectric, or from 1e-20 to 1e8; shapes broadcast. One index per colour
        channel broadcasts with directions (..., 1, 3).

    Raises
    ------
    ValueError
        If eta or k is outside its range.

    References
    ----------
    cook1982.

    Examples
    --------
    >>> import microfacet as mf
    >>> copper = mf.Conductor([0.2, 0.9, 1.4], [3.9, 2.4, 1.6])
    >>> print(copper.F(1.0).round(3))
    [0.952 0.616 0.327]
    """

    label, cite = "conductor", "cook1982"
    regular = True

    statements: ClassVar = {"F": conductor_F}
    kernel = staticmethod(kernel_conductor)

    def __init__(self, eta: ArrayLike, k: ArrayLike) -> None:
        self.eta, self.k = together(eta=each(_index, "eta", eta), k=each(_absorption, "k", k))
        self.parameters = ComplexIndex(self.eta, self.k)


class Schlick(Fresnel):
    r"""Schlick's approximation of the Fresnel reflectance.

    .. math:: F = F_0 + (F_{90} - F_0) (1 - c)^5

    Statements ``material.fresnel.schlick`` and ``material.fresnel.edge``.

    Parameters
    ----------
    F0 : array_like
        Reflectance at normal incidence, in [0, 1].
    F90 : array_like, optional
        Reflectance at grazing incidence, in [0, 1]; by default 1, as Schlick has it. Shapes broadcast.

    Raises
    ------
    ValueError
        If a reflectance is outside [0, 1].

    References
    ----------
    schlick1994.

    Examples
    --------
    >>> import microfacet as mf
    >>> print(f"{mf.Schlick(0.04).F(0.5):.4f}")
    0.0700
    """

    label, cite = "Schlick", "schlick1994"
    regular = True

    statements: ClassVar = {"F": edge_F}
    kernel = staticmethod(kernel_schlick)

    def __init__(self, F0: ArrayLike, F90: ArrayLike = 1.0) -> None:
        self.F0, self.F90 = together(F0=each(_share, "F0", F0), F90=each(_share, "F90", F90))
        self.parameters = Ends(self.F0, self.F90)


class F82Tint(Fresnel):
    r"""Schlick's approximation with a tint near 82 degrees, where metals are darker.

    .. math:: F = F_0 + (F_{90} - F_0) (1 - c)^5 - b \, c \, (1 - c)^6

    where b is such that F at c = 1/7 is ``tint`` times that of `Schlick`. Statement ``material.fresnel.f82``.

    Parameters
    ----------
    F0 : array_like
        Reflectance at normal incidence, in [0, 1].
    tint : array_like, optional
        Factor on Schlick's reflectance at c = 1/7, in [0, 1]; by default 1.
    F90 : array_like, optional
        Reflectance at grazing incidence, in [0, 1]; by default 1. Shapes broadcast.

    Raises
    ------
    ValueError
        If a number is outside [0, 1], or if the tint is so dark that F would be negative, which it can be where F0 is small.

    References
    ----------
    hoffman2019.

    Examples
    --------
    >>> import microfacet as mf
    >>> print(f"{mf.F82Tint(0.9, 0.7).F(1 / 7) / mf.Schlick(0.9).F(1 / 7):.2f}")
    0.70
    """

    label, cite = "F82 tint", "hoffman2019"
    regular = True

    statements: ClassVar = {"F": f82_F}
    kernel = staticmethod(kernel_f82)

    def __init__(self, F0: ArrayLike, tint: ArrayLike = 1.0, F90: ArrayLike = 1.0) -> None:
        given = {"F0": F0, "tint": tint, "F90": F90}
        self.F0, self.tint, self.F90 = together(**{name: each(_share, name, value) for name, value in given.items()})
        self.parameters = TintedEnds(self.F0, self.tint, self.F90)
        cosine, lowest = lowest_f82(*self.parameters)
        if np.any(lowest < -LEAST):
            parts = np.broadcast_arrays(*self.parameters, cosine, lowest)
            normal, dark, grazing, where, least = (float(part.flat[np.argmin(lowest)]) for part in parts)
            raise ValueError(
                f"tint must be lighter for F0 = {normal:g} and F90 = {grazing:g}: the reflectance falls to {least:.3g} "
                f"at cosine {where:.3g}, got {dark:g}"
            )
