"""Slopes: a normal is a slope, a distribution of normals is a distribution of slopes.

`Distribution` is the base class of all distributions of normals. To add one, write a file like ggx.py: its statements, and a
class that names the kernel of D. All else (masking, visible normals, validation) follows from D by quadrature, unless
the class offers a closed form.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping
from functools import cache, cached_property
from math import cos, inf, log, pi, sin, sqrt
from typing import Any, ClassVar

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Pair, Parameters, Vector
from microfacet.directions import numbers, roughness, uniform, vectors
from microfacet.geometry.panels import Panels, panels
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.visible_normals import HORIZON
from microfacet.parameters import Parametric, each, shown, together
from microfacet.statements.notation import P22, Direction, alpha_x, alpha_y, chi, printed_symbol, x, y
from microfacet.statements.statement import Equation

m = Direction("m")
NORMS = tuple(f"geometry.{name}.projected_area" for name in ("beckmann", "ggx", "normalized_blinn_phong"))
P22_at_m = printed_symbol("P22", r"P_{22}(\tilde{x}, \tilde{y})")

# --- statements ---------------------------------------------------------------------------------------------------

slope_x = Equation(
    key="geometry.slopes.x",
    title="the slope of a facet along x",
    symbol=printed_symbol("slope_x", r"\tilde{x}"),
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
    symbol=printed_symbol("domega", r"\frac{d\omega_m}{d\tilde{x}\, d\tilde{y}}"),
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
        symbol=printed_symbol("D_m", r"D(\omega_m)"),
        equals=chi(sp.cos(m.theta)) * P22_at_m / sp.cos(m.theta) ** 4,
        computed_as=chi(m.z) * P22_at_m / m.z**4,
        where=m.spherical,
        over={P22_at_m: (1e-6, 1e6), m: "hemisphere"},
        slides=(64,),
        cite="heitz2014",
    )


def normals_integral(inside: str) -> sp.Symbol:
    """The left-hand side of an integral over all normals."""
    return printed_symbol(f"integral_{zlib.crc32(inside.encode())}", rf"\int_{{\Omega}} {inside} \, d\omega_m")


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


# --- the base class of distributions ---------------------------------------------------------------------------------


OF_LAMBDA = ("sample_visible_kernel", "facet_kernel", "smith_lobe")
OF_SAMPLES = ("sample_kernel", "sample_density", "sampled_kernel", "excess_kernel")
OF_D = ("statements", "regular", "reach", *OF_SAMPLES, "closed_Lambda", *OF_LAMBDA)
MADE_FOR = {"kernel": OF_D, "closed_Lambda": OF_LAMBDA}


class Distribution(Parametric):
    r"""Base class of the distributions of microfacet normals.

    A distribution of normals is the area of microfacets per solid angle of their normals and per area of the surface.
    A physical one obeys

    .. math:: \int_{\Omega} \left( \omega_m \cdot \omega_g \right) D(\omega_m) \, d\omega_m = 1,

    statement ``geometry.slopes.projected_area``, which `validate` checks. A subclass gives ``kernel`` and ``parameters``;
    all else is optional. What a subclass does not redefine it inherits, but for what was made for another ``kernel`` or
    another ``closed_Lambda`` than its own.

    Attributes
    ----------
    kernel : callable
        D(wm, parameters) at one unit normal ``(x, y, z)``, 1/sr; 0 below the horizon. Numba compiles it.
    sample_kernel : callable or None
        Slopes from two uniform numbers ``(u1, u2)`` and the parameters, for `sample`.
    closed_Lambda : callable or None
        Smith's Lambda in closed form; without one it is computed by quadrature.
    sample_visible_kernel : callable or None
        A visible normal of Smith's model, from a view and two uniform numbers.
    parameters : tuple
        What the kernels take last, numbers or arrays; best a named tuple, whose fields they read.
    alpha : tuple of float or None
        Roughness along x and along y where the family has one; formulas that ask for a roughness need it.
    reach : float
        Slope, in units of ``slope_scale``, beyond which less than 1e-18 of the area lies; infinite by default.
    isotropic : bool
        Whether D depends on the polar angle only; by default False. `validate` checks it.

    See Also
    --------
    GGX : A distribution with all closed forms.
    Smith : Masking and shadowing for any distribution.

    References
    ----------
    heitz2014, section 2.

    Examples
    --------
    >>> import microfacet as mf
    >>> isinstance(mf.GGX(0.3), mf.Distribution)
    True
    """

    kernel: ClassVar[Callable[..., float]]  # D(wm, parameters)
    sample_kernel: ClassVar[Callable[..., Pair] | None] = None  # slopes(u, parameters)
    sample_density: ClassVar[Callable[..., float] | None] = None  # of those slopes at (x, y), if it is not that of D
    sampled_kernel: ClassVar[Callable[..., float] | None] = None  # or, for more digits, the distribution of normals they have
    excess_kernel: ClassVar[Callable[..., float] | None] = None  # and D over that, where both may be too small for numbers
    closed_Lambda: ClassVar[Callable[..., float] | None] = None  # Lambda(w, parameters)
    # visible normals of Smith's model: normal(wo, u, parameters)
    sample_visible_kernel: ClassVar[Callable[..., Vector] | None] = None
    # the facet that a ray towards -v meets, from above or below: facet(v, u, key, at, parameters), see `streams`
    facet_kernel: ClassVar[Callable[..., Vector] | None] = None
    statements: ClassVar[Mapping[str, Equation]] = {}  # of D, Lambda and projected_area, as far as the family states them
    regular: ClassVar[bool] = False  # whether few nodes suffice for integrals over its lobe; if not, more are taken
    parameters: Parameters
    alpha: tuple[float, float] | None = None
    reach: ClassVar[float] = inf
    isotropic: bool = False

    @cached_property
    def slope_scale(self) -> tuple[float, float]:
        """Spread of the slopes along x and along y, for quadratures; by default it is found from D."""
        self.require_numbers("a search for slopes")
        return spread(self.D)

    @cached_property
    def panels(self) -> Panels:
        """Panels that cover the slopes, for integrals over them."""
        self.require_numbers("a search for slopes")
        return panels(self.D, extent(self.D))

    def __init_subclass__(cls) -> None:
        """A class inherits what it can do, but for what was made for another D or another Lambda than its own."""
        super().__init_subclass__()
        for changed, made in MADE_FOR.items():
            for name in made if changed in vars(cls) else ():
                if name not in vars(cls):
                    setattr(cls, name, vars(Distribution)[name])

    @property
    def smith_lobe(self) -> tuple[Callable[..., float], Parameters] | None:
        """One kernel of D G2/(4 cos theta_o cos theta_i) under Smith's height-correlated model, and its parameters, or None.

        Quicker than its parts.
        """
        return None

    def D(self, wm: ArrayLike) -> NDArray[Any]:
        """Distribution of normals, in 1/sr.

        Parameters
        ----------
        wm : array_like, shape (..., 3)
            Unit normals.

        Returns
        -------
        ndarray, shape (...)
            Area of microfacets per solid angle and per area of the surface, 1/sr; 0 below the horizon.

        Raises
        ------
        ValueError
            If wm does not hold unit vectors.

        References
        ----------
        heitz2014, section 2.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.GGX(0.5).D([0, 0, 1]):.4f}")
        1.2732
        """
        return _over_normals(type(self).kernel)([vectors("wm", wm)], self.parameters)

    def P22(self, slope_x: ArrayLike, slope_y: ArrayLike) -> NDArray[Any]:
        r"""Density of slopes, per unit slope area.

        .. math:: P_{22}(\tilde{x}, \tilde{y}) = \cos^4\theta_m \, D(\omega_m)

        Statement ``geometry.slopes.D``.

        Parameters
        ----------
        slope_x, slope_y : array_like
            Slopes along x and along y, dimensionless; shapes broadcast. A normal (x, y, z) has the slopes -x/z, -y/z.

        Returns
        -------
        ndarray
            Density in the plane of slopes, dimensionless.

        Raises
        ------
        ValueError
            If a slope is not a finite number.

        References
        ----------
        heitz2014.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.Beckmann(0.5).P22(0.5, 0.0):.4f}")
        0.4684
        """
        slopes = [numbers("slope_x", slope_x), numbers("slope_y", slope_y)]
        return _over_slopes(_slope_density(type(self).kernel))(slopes, self.parameters)

    def Lambda(self, wo: ArrayLike) -> NDArray[Any]:
        r"""Smith's Lambda in closed form.

        .. math:: \Lambda(\omega_o) = \frac{1}{G_1(\omega_o)} - 1
                  = \frac{1}{\cot\theta_o} \int_{\cot\theta_o}^{\infty} (q - \cot\theta_o) \, P_2(q) \, dq

        where :math:`P_2` is the density of the slopes along the view direction; statement ``visibility.smith.Lambda``.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.

        Returns
        -------
        ndarray, shape (...)
            Lambda, dimensionless, at least 0; infinite at the horizon and below.

        Raises
        ------
        ValueError
            If the class has no closed form (`Smith.Lambda` then computes it), or if wo does not hold unit vectors.

        References
        ----------
        heitz2014, section 5; eq. 69 for Beckmann, eq. 72 for GGX.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.GGX(0.5).Lambda([0.6, 0.0, 0.8]):.4f}")
        0.0340
        """
        if type(self).closed_Lambda is None:
            raise ValueError(f"{self!r} has no closed form of Lambda: Smith({self!r}).Lambda computes it by quadrature")
        return lambda_batch(type(self).closed_Lambda)([vectors("wo", wo)], self.parameters)

    def sample(self, u: ArrayLike) -> NDArray[Any]:
        """Draw normals with density `pdf`.

        Parameters
        ----------
        u : array_like, shape (..., 2)
            Uniform numbers in [0, 1).

        Returns
        -------
        ndarray, shape (..., 3)
            Unit normals above the horizon.

        Raises
        ------
        ValueError
            If the class has no sampler, or if u is outside [0, 1).

        Examples
        --------
        >>> import microfacet as mf
        >>> print(mf.GGX(0.5).sample([0.5, 0.125]).round(4))
        [-0.3162 -0.3162  0.8944]
        """
        if type(self).sample_kernel is None:
            raise ValueError(f"{self!r} has no sampler: its class must name a sample_kernel")
        return _sampler(type(self).sample_kernel)([uniform("u", u)], self.parameters)

    def pdf(self, wm: ArrayLike) -> NDArray[Any]:
        r"""Density of the normals that `sample` draws, in 1/sr.

        :math:`D(\omega_m) \cos\theta_m` unless the class samples another distribution, as `Ward` does.

        Parameters
        ----------
        wm : array_like, shape (..., 3)
            Unit normals.

        Returns
        -------
        ndarray, shape (...)
            Probability density, 1/sr; 0 below the horizon.

        Raises
        ------
        ValueError
            If wm does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.GGX(0.5).pdf([0, 0, 1]):.4f}")
        1.2732
        """
        return _over_normals(_sampled_density(drawn_from(type(self))))([vectors("wm", wm)], self.parameters)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(map(shown, self.shown))})"

    @property
    def shown(self) -> tuple[float, ...]:
        return tuple(self.parameters)


class Stretched(Distribution):
    """A distribution of one shape whose slopes are stretched by alpha_x along x and alpha_y along y.

    Parameters
    ----------
    alpha_x : array_like
        Roughness along x, dimensionless, from 1e-11 to 1e11; a number, or an array that broadcasts with the directions.
    alpha_y : array_like, optional
        Roughness along y; by default that along x.

    Raises
    ------
    ValueError
        If a roughness is outside that range.
    """

    alpha: tuple[float, float]

    def __init__(self, alpha_x: ArrayLike, alpha_y: ArrayLike | None = None) -> None:
        along = each(roughness, "alpha_x", alpha_x)
        across = along if alpha_y is None else each(roughness, "alpha_y", alpha_y)
        self.alpha_x, self.alpha_y = together(alpha_x=along, alpha_y=across)
        self.parameters = Alphas(self.alpha_x, self.alpha_y)
        self.alpha = self.slope_scale = (self.alpha_x, self.alpha_y)
        self.isotropic = bool(np.all(self.alpha_x == self.alpha_y))


def alpha_of(ndf: Distribution) -> tuple[float, float]:
    """Its roughness; a ValueError if it has none."""
    if ndf.alpha is None:
        raise ValueError(f"{ndf!r} has no roughness: its attribute alpha must be the two numbers (alpha_x, alpha_y)")
    return ndf.alpha


DECADES, PER_DECADE, PER_DECADE_FINE = (
    (-9, 4),
    4,
    32,
)  # of slopes on the grids, along either axis; the finer grid is for when facets are missing
ANGLES = 2000  # along either axis, on the last grid, if facets are still missing
NORM_TOLERANCE = 0.5  # deviation of the norm from 1 up to which a grid is good enough
SPREAD_FACTOR = 2.0  # the scale over the median of |slope|: near 1.73 for GGX, 2.10 for Beckmann
TAIL_FRACTION, TAIL_FACTOR = 0.02, 4.0  # hardly any facets exceed this factor times the slope that this fraction exceeds


def spread(normals: Callable[[np.ndarray], np.ndarray]) -> tuple[float, float]:
    """How far the slopes of a distribution spread along x and y: twice the median of their size.

    normals: a function of unit normals (n, 3) -> (n,) in 1/sr. It is evaluated on a grid of slopes of all sizes, uniform in
    their logarithms; if that misses facets on a finer one, and then on one uniform in angles. ValueError if it is 0 on all
    grids, or not finite.
    """
    return _quantiles(normals, 0.5, SPREAD_FACTOR)


def extent(normals: Callable[[np.ndarray], np.ndarray]) -> tuple[float, float]:
    """Slopes along x and y that hardly any facets exceed, by the same grids."""
    return _quantiles(normals, TAIL_FRACTION, TAIL_FACTOR)


def _quantiles(normals: Callable[[np.ndarray], np.ndarray], fraction: float, factor: float) -> tuple[float, float]:
    """A factor times the slopes along x and y that a fraction of the facets exceeds."""
    total, quantiles = 0.0, (0.0, 0.0)
    for sizes, steps in _grids():
        norm, candidates = _quantiles_on_grid(normals, sizes, steps, fraction)
        if not norm < inf:
            raise ValueError(f"a distribution of normals must have a finite norm above 0, got about {norm:.3g}")
        total, quantiles = (norm, candidates) if norm > total else (total, quantiles)
        if abs(norm - 1) < NORM_TOLERANCE:
            break
    if not total > 0:
        raise ValueError(f"a distribution of normals must have a finite norm above 0, got about {total:.3g}")
    first, second = (float(f"{factor * slope:.6g}") for slope in quantiles)  # alike if they differ by rounding
    return first, second


def _grids() -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Sizes of slopes and the steps between them."""
    for count in (PER_DECADE, PER_DECADE_FINE):
        sizes = np.logspace(*DECADES, count * (DECADES[1] - DECADES[0]) + 1)
        yield sizes, sizes * (log(10) / count)
    angles = (np.arange(ANGLES // 2) + 0.5) / ANGLES * pi
    yield np.tan(angles), pi / ANGLES / np.cos(angles) ** 2


def _quantiles_on_grid(
    normals: Callable[[np.ndarray], np.ndarray], sizes: np.ndarray, steps: np.ndarray, part: float
) -> tuple[float, Any]:
    """The norm over slopes of these sizes, and the size along each axis that a part of the facets exceeds."""
    signed = np.concatenate([-sizes, sizes])
    x, y = (axis.reshape(-1) for axis in np.meshgrid(signed, signed, indexing="ij"))
    z = 1 / np.sqrt(1 + x * x + y * y)
    density = np.asarray(normals(np.stack([-x * z, -y * z, z], axis=-1))) * (z * z) ** 2
    square = density.reshape(2, len(sizes), 2, len(sizes)).sum(axis=(0, 2)) * np.outer(steps, steps)
    total = float(square.sum())
    if not 0 < total < inf:
        return total, (0.0, 0.0)
    return total, [float(np.interp(1 - part, np.cumsum(square.sum(axis=k)) / total, sizes)) for k in (1, 0)]


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
        return D((-x * z, -y * z, z), p) * (z * z * z * z)

    return slope_density


@cache
def _sampler(slopes: Callable[..., Pair]) -> Batch:
    def normal(u: Pair, p: Any) -> Vector:
        slope_x, slope_y = slopes(u, p)
        z = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        return -slope_x * z, -slope_y * z, z

    return Batch(normal, [2], 3)


def drawn_from(kind: type[Distribution]) -> Callable[..., float]:
    """The kernel of the distribution of normals whose slopes a sampler draws: D itself unless the class says otherwise."""
    if kind.sampled_kernel is not None:
        return kind.sampled_kernel
    return kind.kernel if kind.sample_density is None else _of_slopes(kind.sample_density)


@cache
def _of_slopes(density: Callable[..., float]) -> Callable[..., float]:
    def normals(wm: Vector, p: Any) -> float:
        x, y, z = wm
        if not z > 0.0:
            return 0.0
        value = density(-x / z, -y / z, p)
        return value / (z * z) / (z * z) if value > 0.0 else 0.0

    return normals


def excess_over_drawn(kind: type[Distribution]) -> Callable[..., float]:
    """The kernel of D over the distribution whose slopes are drawn; 0 where the latter is too small for a number."""
    if kind.excess_kernel is not None:
        return kind.excess_kernel
    return _one if drawn_from(kind) is kind.kernel else _excess(kind.kernel, drawn_from(kind))


def _one(wm: Vector, p: Any) -> float:
    return 1.0


@cache
def _excess(D: Callable[..., float], drawn: Callable[..., float]) -> Callable[..., float]:
    def excess(wm: Vector, p: Any) -> float:
        likely = drawn(wm, p)
        return D(wm, p) / likely if likely > 0.0 else 0.0

    return excess


@cache
def _sampled_density(drawn: Callable[..., float]) -> Callable[..., float]:
    """The density of normals whose slopes have the distribution that belongs to these normals."""

    def sampled_density(wm: Vector, p: Any) -> float:
        return drawn(wm, p) * wm[2] if wm[2] > 0.0 else 0.0

    return sampled_density


def around(radius: float, u: float) -> Pair:
    """The point at a distance from the origin and an azimuth of 2 pi u."""
    return radius * cos(2.0 * pi * u), radius * sin(2.0 * pi * u)


# --- helpers for the files of distributions ------------------------------------------------------------------------


@cache
def lambda_batch(kernel: Callable[..., float]) -> Batch:
    """A kernel of Lambda over arrays of directions (..., 3)."""

    def above(w: Vector, p: Any) -> float:
        return kernel(w, p) if w[2] > HORIZON else inf

    return Batch(above, [3])


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
