"""Slopes: a normal is a slope, a distribution of normals is a distribution of slopes.

`Distribution` is what every distribution of normals shares. To add one, write a file like ggx.py: its statements, and a
class that names the kernel of D. All else (masking, visible normals, validation) follows from D by quadrature, unless
the class offers a closed form.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import cache, cached_property
from math import cos, inf, log, pi, sin, sqrt
from typing import Any, ClassVar

import numpy as np
import sympy as sp

from microfacet.directions import numbers, uniform, vectors
from microfacet.kernels import Batch, Parameters
from microfacet.notation import P22, Direction, alpha_x, alpha_y, chi, raw, x, y
from microfacet.statement import Equation

m = Direction("m")
NORMS = tuple(f"geometry.{name}.projected_area" for name in ("beckmann", "ggx", "normalized_blinn_phong"))
P22_at_m = raw("P22", r"P_{22}(\tilde{x}, \tilde{y})")

# --- statements ---------------------------------------------------------------------------------------------------

slope_x = Equation(
    key="geometry.slopes.x",
    title="the slope of a facet along x",
    symbol=raw("slope_x", r"\tilde{x}"),
    means=-m.x / m.z,
    equals=-sp.tan(m.theta) * sp.cos(m.phi),
    computed_as=-m.x / m.z,
    where=m.spherical,
    over={m: "hemisphere"},
    slides=(64, 65),
    cite="heitz2014",
    proof=lambda: [(-m.x / m.z).subs(m.spherical) + sp.tan(m.theta) * sp.cos(m.phi)],
)


def _solid_angle() -> sp.Expr:
    """Solid angle per slope area, from the Jacobian of the map from angles to slopes."""
    slopes = sp.Matrix([-sp.tan(m.theta) * sp.cos(m.phi), -sp.tan(m.theta) * sp.sin(m.phi)])
    return sp.sin(m.theta) / sp.simplify(slopes.jacobian([m.theta, m.phi]).det())


solid_angle = Equation(
    key="geometry.slopes.solid_angle",
    title="solid angle per area in slope space",
    symbol=raw("domega", r"\frac{d\omega_m}{d\tilde{x}\, d\tilde{y}}"),
    equals=sp.cos(m.theta) ** 3,
    computed_as=m.z**3,
    where=m.spherical,
    over={m: "hemisphere"},
    proof=lambda: [_solid_angle() - sp.cos(m.theta) ** 3],
    proved_by="sympy: Jacobian of the map from angles to slopes",
    slides=(64,),
    cite="heitz2014",
)

with sp.evaluate(False):
    normals_from_slopes = Equation(
        key="geometry.slopes.D",
        title="a distribution of normals from a distribution of slopes",
        symbol=raw("D_m", r"D(\omega_m)"),
        equals=chi(sp.cos(m.theta)) * P22_at_m / sp.cos(m.theta) ** 4,
        computed_as=chi(m.z) * P22_at_m / m.z**4,
        where=m.spherical,
        over={P22_at_m: (1e-6, 1e6), m: "hemisphere"},
        slides=(64,),
        cite="heitz2014",
    )


def normals_integral(inside: str) -> sp.Symbol:
    """The left-hand side of an integral over all normals."""
    return raw(f"integral_{zlib.crc32(inside.encode())}", rf"\int_{{\Omega}} {inside} \, d\omega_m")


def _projection_steps(it: Equation) -> list[Any]:
    """Of the check comes one cosine, of the solid angle three: they cancel the fourth power in D."""
    density = normals_from_slopes.equals.doit().subs(chi(sp.cos(m.theta)), 1)
    integrand = sp.cos(m.theta) * density * solid_angle.equals
    everywhere = sp.Integral(integrand.subs(P22_at_m, P22(x, y)).doit(), (x, -sp.oo, sp.oo), (y, -sp.oo, sp.oo))
    return [sp.simplify(integrand - P22_at_m), it.means - everywhere.simplify(), it.equals - 1]


with sp.evaluate(False):
    projected_area = Equation(
        key="geometry.slopes.projected_area",
        title="facets project to the whole surface: their slopes have a probability density",
        symbol=normals_integral(r"\left( \omega_m \cdot \omega_g \right) D(\omega_m)"),
        means=sp.Integral(P22(x, y), (x, -sp.oo, sp.oo), (y, -sp.oo, sp.oo)),
        equals=sp.Integer(1),
        proof=_projection_steps,
        proved_by="sympy: the integrand in slopes is the density of slopes",
        enclosed=NORMS,
        slides=(35, 36, 64),
        cite="heitz2014",
        note="The first validation equation; enclosed for each distribution that meets it.",
    )


# --- what every distribution shares ---------------------------------------------------------------------------------


class Distribution:
    """A distribution of normals D, 1/sr, over unit microfacet normals.

    parameters: what its kernels take as their last argument. scale: the two slope scales a quadrature should resolve; where
    a class does not say, they are found by a look at D.
    reach: in units of these, the slope beyond which hardly any facet (1e-18 of the area) lies.
    isotropic: whether D depends on the polar angle only, by default not; `validate` checks it.
    """

    kernel: ClassVar[Callable[..., float]]  # D(x, y, z, parameters)
    sample_kernel: ClassVar[Callable[..., tuple[float, float]]]  # slopes(u1, u2, parameters)
    sample_density: ClassVar[Callable[..., float]]  # density of those slopes at (x, y)
    closed_Lambda: ClassVar[Callable[..., float] | None] = None  # Lambda(x, y, z, parameters)
    parameters: Parameters
    reach: ClassVar[float] = inf
    isotropic: bool = False

    @cached_property
    def scale(self) -> tuple[float, float]:
        """How far slopes spread along x and along y: by default as `spread` finds it."""
        return spread(self.D)

    def D(self, wm: Any) -> Any:
        """D(wm), shapes (..., 3) -> (...), 1/sr; 0 below the horizon. heitz2014, section 2."""
        return _over_normals(type(self).kernel)([vectors("wm", wm)], self.parameters)

    def P22(self, slope_x: Any, slope_y: Any) -> Any:
        """Density of slopes, per unit slope area; shapes broadcast. heitz2014, slope space."""
        slopes = [numbers("slope_x", slope_x), numbers("slope_y", slope_y)]
        return _over_slopes(_slope_density(type(self).kernel))(slopes, self.parameters)

    def sample(self, u: Any) -> Any:
        """Normals with density `pdf`, shapes (..., 2) -> (..., 3), for u in [0, 1)."""
        return _sampler(type(self).sample_kernel)([uniform("u", u)], self.parameters)

    def pdf(self, wm: Any) -> Any:
        """Density of `sample`, 1/sr, shapes (..., 3) -> (...)."""
        return _over_normals(_sampled_density(type(self).sample_density))([vectors("wm", wm)], self.parameters)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{p:g}' for p in self.shown)})"

    @property
    def shown(self) -> tuple[float, ...]:
        return tuple(self.parameters)


DECADES, PER_DECADE = (-6, 3), 4  # of slopes looked at, along either axis
SPREAD = 2.0  # the scale over the slope that half of the facets exceed: near 1.73 for GGX, 2.10 for Beckmann


def spread(normals: Callable[[np.ndarray], np.ndarray]) -> tuple[float, float]:
    """How far the slopes of a distribution spread along x and y: about twice what half of the facets exceed.

    normals: a function of unit normals (n, 3) that gives (n,), 1/sr. It is looked at on a grid of slopes of all
    sizes, even in their logarithms. ValueError if it is 0 on the whole grid, or not finite.
    """
    sizes = np.logspace(*DECADES, PER_DECADE * (DECADES[1] - DECADES[0]) + 1)
    signed = np.concatenate([-sizes, sizes])
    x, y = (axis.reshape(-1) for axis in np.meshgrid(signed, signed, indexing="ij"))
    z = 1 / np.sqrt(1 + x * x + y * y)
    share = np.asarray(normals(np.stack([-x * z, -y * z, z], axis=-1))) * (z * z) ** 2 * np.abs(x * y)
    total = share.sum()
    if not 0 < total < inf:
        raise ValueError(f"a distribution of normals must have a finite norm above 0, got about {total * _STEP**2:.3g}")
    square = share.reshape(2, len(sizes), 2, len(sizes)).sum(axis=(0, 2))
    found = [float(np.interp(0.5, np.cumsum(square.sum(axis=k)) / total, sizes)) for k in (1, 0)]
    first, second = (float(f"{SPREAD * slope:.6g}") for slope in found)  # alike if they differ by rounding
    return first, second


_STEP = log(10) / PER_DECADE


@cache
def _over_normals(kernel: Callable[..., float]) -> Batch:
    return Batch(kernel, [3])


@cache
def _over_slopes(kernel: Callable[..., float]) -> Batch:
    return Batch(kernel, [1, 1])


@cache
def _slope_density(D: Callable[..., float]) -> Callable[..., float]:
    def slope_density(x: float, y: float, p: Any) -> float:
        z = 1.0 / sqrt(1.0 + x * x + y * y)
        return D(-x * z, -y * z, z, p) * (z * z * z * z)

    return slope_density


@cache
def _sampler(slopes: Callable[..., tuple[float, float]]) -> Batch:
    def normal(u1: float, u2: float, p: Any) -> tuple[float, float, float]:
        slope_x, slope_y = slopes(u1, u2, p)
        z = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        return -slope_x * z, -slope_y * z, z

    return Batch(normal, [2], 3)


@cache
def _sampled_density(density: Callable[..., float]) -> Callable[..., float]:
    def sampled_density(x: float, y: float, z: float, p: Any) -> float:
        if not z > 0.0:
            return 0.0
        return density(-x / z, -y / z, p) / (z * z * z)

    return sampled_density


def around(radius: float, u: float) -> tuple[float, float]:
    """A point at the given distance from the origin, in the direction of the given share of a turn."""
    return radius * cos(2.0 * pi * u), radius * sin(2.0 * pi * u)


# --- what the files of the distributions share ------------------------------------------------------------------------


def slope_integral(density: sp.Expr) -> sp.Integral:
    """The integral over all slopes, printed and evaluated as such."""
    return sp.Integral(density, (x, -sp.oo, sp.oo), (y, -sp.oo, sp.oo))


def unstretched_norm(density: sp.Expr) -> sp.Integral:
    """The integral of a density of slopes in polar coordinates after unstretching, where the angle has dropped out."""
    r, angle = sp.Symbol("r", positive=True), sp.Symbol("angle", real=True)
    moved = density.doit().subs({x: alpha_x * r * sp.cos(angle), y: alpha_y * r * sp.sin(angle)}) * alpha_x * alpha_y
    return sp.Integral(sp.simplify(2 * sp.pi * r * moved), (r, 0, sp.oo))


def stretched(P: Callable[[sp.Expr, sp.Expr], sp.Expr]) -> sp.Expr:
    """An isotropic density of slopes of unit scale, stretched to (alpha_x, alpha_y)."""
    return P(x / alpha_x, y / alpha_y) / (alpha_x * alpha_y)
