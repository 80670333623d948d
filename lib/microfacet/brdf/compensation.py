"""The light of later bounces made up for without following it: from the albedo of the first bounce alone.

Either a lobe of its own is added, which depends on two cosines only and makes the albedo 1 for F = 1 (kulla2017), or the
first bounce's lobe is made brighter by as much as it lacks (turquin2019). Neither knows where later bounces go.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, lru_cache
from itertools import pairwise
from math import exp, pi, sqrt
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.albedo import ROUNDING, Reflected, critical, tanh_sinh
from microfacet.brdf.base import BRDF
from microfacet.brdf.cosine_table import LOWEST, CosineTable, starts
from microfacet.brdf.microfacet import Microfacet
from microfacet.brdf.reflectance import mu
from microfacet.compiler.batch import Batch
from microfacet.compiler.exponential import one_minus_exp
from microfacet.compiler.kernels import ByPrecision, Table, Vector
from microfacet.directions import as_uniform, as_vectors, vectors
from microfacet.geometry.visible_normals import HORIZON
from microfacet.material.fresnel import F0, Fresnel, c, schlick_F
from microfacet.statements import enclosures
from microfacet.statements.notation import printed_symbol
from microfacet.statements.statement import Equation
from microfacet.visibility.masking import over_pairs

FORMS = ("lobe", "scaled")

# --- statements -------------------------------------------------------------------------------------------------------

E_o = printed_symbol("E_o", r"E(\theta_o)", positive=True)
missing = printed_symbol("lacked", r"\int_{\Omega} (1 - E(\theta_i)) \cos\theta_i \, d\omega_i", positive=True)
E_mean, F_mean = printed_symbol("E_mean", r"\bar{E}", positive=True), printed_symbol("F_mean", r"\bar{F}", positive=True)
F_later = printed_symbol("F_later", r"F_{+}", positive=True)


def _lobe_steps(it: Equation) -> list[Any]:
    """What all light lacks, by the mean albedo: either is linear in E, so that powers of the cosine suffice."""
    n = sp.Symbol("n", positive=True)
    all_light = sp.integrate(sp.expand(2 * sp.pi * mu * (1 - mu**n)), (mu, 0, 1))
    mean = sp.integrate(2 * mu * mu**n, (mu, 0, 1))
    return [sp.simplify(all_light - it.where[missing].subs(E_mean, mean)), it.means.subs(it.where) - it.equals]


def _scale_steps(it: Equation) -> list[Any]:
    """At F0 = 1 the albedo becomes 1; it is linear in F0, and nothing is added to facets that are black."""
    scale = it.equals.doit()
    return [scale.subs(F0, 1) * E_o - 1, scale.subs(F0, 0) - 1, sp.diff(scale, F0, 2)]


with sp.evaluate(False):
    lobe = Equation(
        key="brdf.compensation.lobe",
        title="a lobe that holds what one bounce lacks",
        symbol=printed_symbol(
            "light_of_lobe",
            r"\int_{\Omega} \frac{(1 - E(\theta_o)) (1 - E(\theta_i))}{\pi (1 - \bar{E})} \cos\theta_i \, d\omega_i",
        ),
        means=(1 - E_o) * missing / (sp.pi * (1 - E_mean)),
        equals=1 - E_o,
        where={missing: sp.pi * (1 - E_mean)},
        over={E_o: (0.01, 0.99), E_mean: (0.01, 0.99)},
        proof=_lobe_steps,
        proved_by="sympy: the integral for every power of the cosine in place of E, and the mean albedo likewise",
        slides=(73, 74, 75),
        cite="kulla2017",
        note="E is the albedo of one bounce for F = 1, and its mean is taken over light from everywhere.",
    )
    bounces = Equation(
        key="brdf.compensation.bounces",
        title="what facets of mean reflectance leave of the light of all later bounces",
        symbol=F_later,
        means=F_mean**2 * E_mean + F_mean * (1 - E_mean) * F_later,
        equals=F_mean**2 * E_mean / (1 - F_mean * (1 - E_mean)),
        computed_as=F_mean**2 * E_mean / ((1 - F_mean) + F_mean * E_mean),
        where={F_later: F_mean**2 * E_mean / (1 - F_mean * (1 - E_mean))},
        over={F_mean: (0.01, 1), E_mean: (0.01, 1)},
        proved_by="sympy: one more bounce, of which the mean albedo leaves",
        slides=(73, 74, 75),
        cite="kulla2017",
    )
    scale = Equation(
        key="brdf.compensation.scale",
        title="by how much one bounce is made brighter instead",
        symbol=printed_symbol("k_scale", r"k(\theta_o)"),
        equals=1 + F0 * (1 - E_o) / E_o,
        over={F0: (0.01, 1), E_o: (0.01, 1)},
        proof=_scale_steps,
        proved_by="sympy: linear in F0, 1 for black facets, and 1 over the albedo for perfect mirrors",
        slides=(73, 74, 75),
        cite="turquin2019",
        note="Light and viewer may no longer change places.",
    )
    schlick_mean = Equation(
        key="brdf.compensation.schlick",
        title="mean of Schlick's reflectance over light from everywhere",
        symbol=F_mean,
        means=sp.Integral(2 * (F0 + (1 - F0) * (1 - c) ** 5) * c, (c, 0, 1)),
        equals=F0 + (1 - F0) / 21,
        over={F0: (0.01, 1)},
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (F0,), [(0.01,), (0.5,), (1.0,)]),
        proof=lambda it: _schlick_steps(it),
        proved_by="sympy: Schlick's reflectance put in, then the integral",
        slides=(73, 74, 75),
        cite="kulla2017",
    )


def _schlick_steps(it: Equation) -> list[Any]:
    (whole,) = it.means.atoms(sp.Integral)
    return [
        whole.function.doit() - 2 * schlick_F.equals.doit() * c,
        sp.integrate(sp.expand(whole.function), (c, 0, 1)) - it.equals,
    ]


# --- the albedo of the first bounce, tabulated ----------------------------------------------------------------------------

HEIGHT_TERMS, AZIMUTH_TERMS = 24, 8  # of the Chebyshev series in height and in azimuth
ROUGH = 4.0  # slope scale above which the albedo changes so fast near grazing that twice as many terms are needed
MEAN_NODES, AZIMUTHS = 128, 64  # of the quadrature for means
EXCESS = 1e-4  # by which the albedo may exceed 1 because of errors of its quadrature
LARGEST_ERROR = 0.03  # of the series: absolute, or relative to the albedo where that is a divisor
WRITTEN_OUT = 192  # terms of the series
INTERVALS = 256  # of cosines, to sample the lobe
LEAST_DENSITY = 0.1  # lower bound of the density with which the lobe is sampled, relative to its mean over cosines
LEAST = ByPrecision(double=1e-17, single=1e-8)  # above 0, so that the lobe is positive wherever it is sampled
BETWEEN = 3.0  # ratio of the largest error to that half way between nodes and at the ends


class CompensatedParameters(NamedTuple):
    """Parameters of the first bounce; the slope scale; the result of `_widths`; the coefficients of the series; a factor."""

    single: Any
    scale_x: float
    scale_y: float
    width: float
    upright: float
    table: tuple[float, ...]
    factor: float


@cache
def interpolation(height_terms: int, azimuth_terms: int) -> Callable[..., float]:
    """-ln E, which is never negative, by a series in the root of z/(z + k r), where r is the length of the unstretched
    horizontal part of the direction, and in the cosine of twice its azimuth. The series is multiplied by a factor that vanishes
    with the roughness, as its error does."""
    text = INTERPOLATION.format("\n".join(f"    {line}" for line in _clenshaw(height_terms, azimuth_terms)))
    scope: dict[str, Any] = {"sqrt": sqrt, "LEAST": LEAST, "HORIZON": HORIZON}
    exec(text, scope)
    made: FunctionType = scope["minus_log_albedo"]
    made.__source__ = text  # type: ignore[attr-defined]
    return made


INTERPOLATION = """\
def minus_log_albedo(w, p):
    x, y, z, table = w[0], w[1], max(w[2], HORIZON), p.table
    across, along = (p.scale_x * x) * (p.scale_x * x), (p.scale_y * y) * (p.scale_y * y)
    square = across + along
    r = sqrt(square)
    s = 2.0 * sqrt(z / (z + p.width * r)) - 1.0
    c = (across - along) / square if square > 0.0 else 0.0
{}
    leaning = r + p.upright * z
    return max(a1, LEAST) * (leaning / (z + leaning))
"""


def _clenshaw(height_terms: int, azimuth_terms: int) -> Iterator[str]:
    """Lines that add up the series from its last term on.

    Up to `WRITTEN_OUT` terms every step is written out: compiled code finds a number in a tuple at once only if its place is a
    constant, and steps without a loop are vectorized. More terms would take a minute to compile: they are in an array.
    """
    yield "a1, a2 = 0.0, 0.0"
    if height_terms * azimuth_terms > WRITTEN_OUT:
        yield f"for k in range({height_terms - 1}, 0, -1):"
        yield "    b1, b2 = 0.0, 0.0"
        yield f"    for j in range({azimuth_terms - 1}, 0, -1):"
        yield f"        b1, b2 = 2.0 * c * b1 - b2 + table[{azimuth_terms} * k + j], b1"
        yield f"    row = c * b1 - b2 + table[{azimuth_terms} * k]"
        yield "    a1, a2 = 2.0 * s * a1 - a2 + row, a1"
    for k in range(height_terms - 1 if height_terms * azimuth_terms <= WRITTEN_OUT else 0, -1, -1):
        yield "b1, b2 = 0.0, 0.0"
        for j in range(azimuth_terms - 1, 0, -1):
            yield f"b1, b2 = 2.0 * c * b1 - b2 + table[{k * azimuth_terms + j}], b1"
        yield f"row = c * b1 - b2 + table[{k * azimuth_terms}]"
        yield "a1, a2 = 2.0 * s * a1 - a2 + row, a1" if k > 0 else "a1 = s * a1 - a2 + row"


def _widths(alpha_x: float, alpha_y: float) -> tuple[float, float]:
    """The k of the series, and a length that keeps its factor above 0 at normal incidence: fitted for the smallest error."""
    roughness = sqrt(alpha_x * alpha_y)
    return 2 / (1 + roughness) ** 1.25, 4 * roughness


def _chebyshev(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes in (-1, 1), and the matrix from values at the nodes to coefficients."""
    angle = np.pi * (np.arange(count) + 0.5) / count
    to_coefficients = np.cos(np.outer(np.arange(count), angle)) * 2 / count
    to_coefficients[0] /= 2
    return np.cos(angle), to_coefficients


class AlbedoTable(NamedTuple):
    """The albedo E of one bounce for F = 1. mean, missing: cosine-weighted means of E and of 1 - E over the hemisphere. table:
    coefficients of -ln E. off, relative_off: bounds of the error of the series, from the differences between its nodes and the
    error of the quadrature. heights: means of 1 - E over azimuth in the intervals of a `CosineTable`, bounded from below."""

    mean: float
    missing: float
    table: tuple[float, ...]
    off: float
    relative_off: float
    heights: tuple[float, ...]


@lru_cache(maxsize=64)
def tabulated(reflected: Reflected, scale: tuple[float, float], height_terms: int, azimuth_terms: int) -> AlbedoTable:
    """Computed once for all reflectances over the same model. ValueError where E is above 1."""
    (s, to_coefficients_s), (w, to_coefficients_w) = _chebyshev(height_terms), _chebyshev(azimuth_terms)
    wo, leaning = _directions(s, w, scale)
    albedo, error = reflected(wo)
    if (albedo - error).max() > 1 + EXCESS:
        raise ValueError(
            f"a model that reflects more light than it gets cannot be compensated: its albedo is {albedo.max():.4g}"
        )
    albedo = np.clip(albedo, np.finfo(float).tiny, 1)
    table = to_coefficients_s @ (-np.log(albedo) * (1 + leaning) / leaning) @ to_coefficients_w.T
    minus_log_albedo = _minus_log_albedo(table, scale, _heights()[0])
    off, relative_off = _series_error(reflected, scale, table)
    missing = _mean(-np.expm1(-minus_log_albedo))
    by_height = np.maximum(
        -np.expm1(-_minus_log_albedo(table, scale, _middles())).mean(axis=1), LEAST_DENSITY * missing + LEAST
    )
    numbers = (tuple(map(float, part)) for part in (table.ravel(), by_height))
    return AlbedoTable(_mean(np.exp(-minus_log_albedo)), missing, next(numbers), off, relative_off, next(numbers))


def _directions(s: np.ndarray, w: np.ndarray, scale: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Views at which the variables of the series are s and w, and the length from which its factor follows."""
    k, upright = _widths(*scale)
    fraction = ((s[:, None] + 1) / 2) ** 2  # z/(z + k r)
    r, phi = (1 - fraction) / (k * fraction), np.arccos(w) / 2
    shadow = np.stack(np.broadcast_arrays(r * np.cos(phi) / scale[0], r * np.sin(phi) / scale[1], 1.0), axis=-1)
    return shadow / np.linalg.norm(shadow, axis=-1, keepdims=True), r + upright


def _series_error(reflected: Reflected, scale: tuple[float, float], table: np.ndarray) -> tuple[float, float]:
    """Absolute and relative error of the series, from views between and beyond its nodes, and from the quadrature's error."""
    height_terms, azimuth_terms = table.shape
    s, w = np.cos(np.pi * np.arange(height_terms) / height_terms), np.cos(np.pi * np.arange(azimuth_terms + 1) / azimuth_terms)
    wo, leaning = _directions(s, w, scale)
    albedo, error = reflected(wo)
    series = np.maximum(np.asarray(np.polynomial.chebyshev.chebgrid2d(s, w, table)), 0) * leaning / (1 + leaning)
    difference = abs(np.exp(-series) - albedo) + error
    return float(BETWEEN * difference.max()), float(BETWEEN * (difference / np.maximum(albedo, np.finfo(float).tiny)).max())


def _middles() -> np.ndarray:
    """The middle of each interval of a `CosineTable`, and the beginning of the last one."""
    ends = starts(INTERVALS)
    return np.append((ends[1:] + ends[:-1]) / 2, ends[-1])


def _minus_log_albedo(table: np.ndarray, scale: tuple[float, float], v: np.ndarray) -> np.ndarray:
    """The values of the series in directions where sqrt(-ln cos theta) is v, over azimuths."""
    v, phi = v[:, None], np.pi / 2 * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    tangent = np.sqrt(np.expm1(2 * v * v))
    across, along = (scale[0] * tangent * np.cos(phi)) ** 2, (scale[1] * tangent * np.sin(phi)) ** 2
    r, (k, upright) = np.sqrt(across + along), _widths(*scale)
    series = np.polynomial.chebyshev.chebval2d(2 / np.sqrt(1 + k * r) - 1, (across - along) / r**2, table)
    return np.asarray(np.maximum(series, 0) * ((r + upright) / (1 + r + upright)))


def _heights() -> tuple[np.ndarray, np.ndarray]:
    """Nodes in sqrt(-ln cos theta), and their weights in a cosine-weighted mean over the hemisphere.

    They resolve cosines of any size, as small roughness needs, and angles near 0."""
    x, weigh = np.polynomial.legendre.leggauss(MEAN_NODES)
    v = LOWEST * (x + 1) / 2
    weight = weigh * v * np.exp(-2 * v * v)
    return v, weight / weight.sum()


def _mean(values: np.ndarray) -> float:
    return float(_heights()[1] @ values.mean(axis=1))


def mean_reflectance(fresnel: Fresnel) -> tuple[float, float]:
    """The cosine-weighted mean over the hemisphere, and its error; split where reflection becomes total."""
    nodes, weights, starts = map(np.array, tanh_sinh())
    level = np.searchsorted(starts, np.arange(len(nodes)), side="right") - 1
    weights = weights / 2.0 ** (level.max() - level)  # a level's own are for the rule that ends with it
    square = critical(fresnel)
    ends = (0.0, sqrt(square), 1.0) if square < 1 else (0.0, 1.0)
    sums = np.zeros(2)
    for low, high in pairwise(ends):
        c = np.clip(low + (high - low) * nodes, 0, 1)
        terms = (high - low) * weights * 2 * c * fresnel.F(c)
        sums += terms.sum(), 2 * terms[level < level.max()].sum()
    return float(sums[0]), float(abs(sums[0] - sums[1]) + ROUNDING)


# --- the model --------------------------------------------------------------------------------------------------------


@cache
def compensated(single: Callable[..., float], form: str, height_terms: int, azimuth_terms: int) -> Batch:
    """The compiled BRDF. single: the kernel of the first bounce, which is 0 below the horizon.

    Nothing returns early: of a loop with such a branch around this many steps LLVM takes more than ten minutes to say whether
    it can be vectorized.
    """
    minus_log_albedo = interpolation(height_terms, azimuth_terms)

    def with_lobe(wo: Vector, wi: Vector, p: CompensatedParameters) -> float:
        above = 1.0 if min(wo[2], wi[2]) > 0.0 else 0.0
        missing_o, missing_i = one_minus_exp(minus_log_albedo(wo, p)), one_minus_exp(minus_log_albedo(wi, p))
        return single(wo, wi, p.single) + above * ((p.factor * missing_o) * missing_i)

    def scaled(wo: Vector, wi: Vector, p: CompensatedParameters) -> float:
        albedo = exp(-minus_log_albedo(wo, p))
        return single(wo, wi, p.single) * stated_scale(p.factor, albedo)

    return over_pairs(with_lobe if form == "lobe" else scaled)


stated_scale = scale.scalar


@cache
def series(height_terms: int, azimuth_terms: int) -> Batch:
    """-ln E of a direction, with the parameters of `compensated`."""
    minus_log_albedo = interpolation(height_terms, azimuth_terms)

    def dimmed(w: Vector, p: CompensatedParameters) -> float:
        return minus_log_albedo(w, p) if w[2] > 0.0 else 0.0

    return Batch(dimmed, [3])


class Compensated(BRDF):
    r"""BRDF of one bounce, with the energy of later bounces put back.

    With the albedo E of one bounce off perfect mirrors, its mean :math:`\bar{E}`, and a factor f that depends on the
    reflectance, the two forms are

    .. math:: \rho + f \, \frac{\left( 1 - E(\omega_o) \right) \left( 1 - E(\omega_i) \right)}{\pi \left( 1 - \bar{E} \right)}
              \quad \text{and} \quad \rho \left( 1 + F_0 \, \frac{1 - E(\omega_o)}{E(\omega_o)} \right).

    For F = 1 the albedo is 1. E comes from a series; the attribute ``off`` bounds its error, absolute for ``"lobe"``,
    relative for ``"scaled"``. How far either is from what later bounces really do is measured in the report, not bounded.

    Parameters
    ----------
    brdf : Microfacet
        BRDF of one bounce, with numbers for parameters.
    form : {"lobe", "scaled"}, optional
        Add a lobe (the first form, reciprocal), or scale the BRDF (the second, not reciprocal).

    Raises
    ------
    ValueError
        For another form, for a model that reflects more light than it gets, and where ``off`` is above 3 %.

    References
    ----------
    kulla2017 (lobe); turquin2019 (scaled).

    Examples
    --------
    >>> import microfacet as mf
    >>> once = mf.Microfacet(mf.Smith(mf.GGX(0.8)))
    >>> wo = [0.6, 0.0, 0.8]
    >>> print(f"{once.albedo(wo):.4f} {mf.Compensated(once).albedo(wo):.4f}")
    0.4603 1.0000
    """

    def __init__(self, brdf: Microfacet, form: str = "lobe") -> None:
        if not isinstance(brdf, Microfacet):
            raise ValueError(f"brdf must be a BRDF of one bounce such as Microfacet(Smith(GGX(0.3))), got {brdf!r}")
        brdf.require_numbers("Compensated")
        if form not in FORMS:
            raise ValueError(f"form must be one of {', '.join(FORMS)}, got {form!r}")
        self.brdf, self.form, self.model, self.fresnel = brdf, form, brdf.model, brdf.fresnel
        self.mirrors = Microfacet(brdf.model)
        alpha_x, alpha_y = brdf.model.ndf.slope_scale
        height_terms = HEIGHT_TERMS if max(alpha_x, alpha_y) <= ROUGH else 2 * HEIGHT_TERMS
        azimuth_terms = 1 if brdf.model.ndf.isotropic else AZIMUTH_TERMS
        entry = tabulated(self.mirrors.reflected, (alpha_x, alpha_y), height_terms, azimuth_terms)
        self.mean_albedo, missing, table = entry.mean, entry.missing, entry.table
        self.off = entry.off if form == "lobe" else entry.relative_off
        if self.off > LARGEST_ERROR:
            raise ValueError(f"the albedo of {brdf.model!r} is known to {100 * self.off:.2g} % only, too little for {form!r}")
        self._mean_F = mean_reflectance(brdf.fresnel)
        self.added, self.added_error = self._added(entry.off)
        self._factor = self.added / (pi * missing) if form == "lobe" and missing > 0 else self.added
        single, parameters = brdf.evaluation
        widths = _widths(alpha_x, alpha_y)
        coefficients = Table(table) if len(table) > WRITTEN_OUT else table
        self.parameters = CompensatedParameters(parameters, alpha_x, alpha_y, *widths, coefficients, self._factor)
        self._batch = compensated(single.function, form, height_terms, azimuth_terms)
        self._series, self._heights = series(height_terms, azimuth_terms), CosineTable(entry.heights)

    def _added(self, off: float) -> tuple[float, float]:
        """The fraction of the light of later bounces that facets do not absorb, and its error: by their mean reflectance, or by
        that at normal incidence. off: bound of the error of the mean albedo."""
        if self.form == "scaled":
            return float(self.fresnel.F(1.0)), 0.0
        F, error = self._mean_F
        least = max((1 - F) + F * self.mean_albedo, np.finfo(float).tiny)
        slopes = F * (2 - F) * self.mean_albedo / least**2 + F / least, F**2 * (1 - F) / least**2
        return float(bounces.scalar(F, self.mean_albedo)), slopes[0] * error + slopes[1] * off

    def evaluate(self, wo: ArrayLike, wi: ArrayLike, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Value of the BRDF, in 1/sr, without the cosine of the light.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        out : ndarray, optional
            Array of the result's shape and precision to fill and return; its contents are undefined after an error.

        Returns
        -------
        ndarray, shape (...)
            BRDF, 1/sr; 0 if either direction is below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if out does not fit.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Compensated(mf.Microfacet(mf.Smith(mf.GGX(0.8))))
        >>> print(f"{brdf.evaluate([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        0.3550
        """
        return self._batch([vectors("wo", wo), vectors("wi", wi)], self.parameters, out)

    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        # The first number of u chooses between both lobes, and what is left of it goes on: points of a sequence stay even.
        if self.form == "scaled":
            return self.brdf.sample(wo, u)
        wo, u = as_vectors("wo", wo), as_uniform("u", u)
        real = np.result_type(wo, u)
        chance, first = self._chance(wo), u[..., 0].astype(np.float64)
        of_lobe = first < chance
        with np.errstate(divide="ignore", invalid="ignore"):
            rest = np.where(of_lobe, first / chance, (first - chance) / (1 - chance))
        rest = np.clip(rest, 0, np.nextafter(real.type(1), real.type(0)))
        v = np.stack(np.broadcast_arrays(rest, u[..., 1]), axis=-1).astype(real)
        return np.where(of_lobe[..., None], self._heights.sample(wo, v), self.brdf.sample(wo.astype(real), v))

    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        single = self.brdf.pdf(wo, wi)
        if self.form == "scaled":
            return single
        chance = self._chance(wo)
        return (chance * self._heights.pdf(wo, wi) + (1 - chance) * single).astype(single.dtype)[()]

    def weight(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        # D does not occur in it where only one bounce has light, so it is right also where D is too large for a number.
        once = self.brdf.weight(wo, wi)
        if self.form == "scaled":
            return (once * stated_scale(self.added, np.exp(-self._minus_log_albedo(wo)))).astype(once.dtype)
        chance, single, lobe = self._chance(wo), self.brdf.pdf(wo, wi), self._heights.pdf(wo, wi)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            of_single = np.where(lobe > 0, 1 / (1 + lobe / single), 0.0)
        added = (
            np.pi
            * self._factor
            * np.expm1(-self._minus_log_albedo(wo))
            * np.expm1(-self._minus_log_albedo(wi))
            / self._heights.factor(wi)
        )
        light, density = ((1 - of_single) * a + of_single * b for a, b in ((added, once), (chance, 1 - chance)))
        light = np.where(lobe > 0, light, 0.0)
        return np.divide(light, density, out=np.zeros_like(light), where=density > 0).astype(once.dtype)[()]

    def _minus_log_albedo(self, w: ArrayLike) -> NDArray[Any]:
        """-ln E of one bounce of F = 1, by the series; 0 below the horizon."""
        return self._series([np.asarray(w, np.float64)], self.parameters)

    def _chance(self, wo: ArrayLike) -> NDArray[Any]:
        """The probability with which the lobe is sampled: its part of the albedo, by the means of F."""
        missing = -np.expm1(-self._minus_log_albedo(wo))
        lobe, single = self.added * missing, self._mean_F[0] * (1 - missing)
        return np.divide(lobe, lobe + single, out=np.zeros_like(lobe), where=lobe + single > 0)

    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        # The error is that of the quadratures and of the means; `evaluate` has the albedo from a series, with `off` more.
        (single, single_error), (mirror_albedo, mirror_error) = (
            self.brdf.albedo_with_error(wo),
            self.mirrors.albedo_with_error(wo),
        )
        above = mirror_albedo > 0
        missing = np.where(above, 1 - mirror_albedo, 0)
        if self.form == "lobe":
            error = single_error + self.added * mirror_error + self.added_error * abs(missing)
            return (single + self.added * missing)[()], np.where(above, error, 0)[()]
        divisor = np.where(above, mirror_albedo, 1)
        scale = stated_scale(self.added, divisor)
        return single * scale, scale * single_error + single * self.added * mirror_error / divisor**2

    def __repr__(self) -> str:
        return f"Compensated({self.brdf!r}, {self.form!r})"
