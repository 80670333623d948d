"""Matt facets: each scatters evenly what it gets, and the rough surface does not."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import exp, log, sqrt
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.albedo import GAUSS, KRONROD, KRONROD_NODES
from microfacet.brdf.base import BRDF
from microfacet.brdf.cosine_table import CosineTable
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Pair, Vector
from microfacet.directions import as_vectors, positive, spherical
from microfacet.geometry.slopes import P22_at_m, normals_from_slopes, normals_integral, solid_angle
from microfacet.statements.notation import G1, G2, P22, chi, mu_i, mu_o, phi, phi_i, printed_symbol, theta_i, theta_o, wm, x, y
from microfacet.statements.statement import Equation
from microfacet.visibility.masking import Masking

# --- statements -------------------------------------------------------------------------------------------------------

shown_o, shown_i = printed_symbol("shown_o", "v_o", nonnegative=True), printed_symbol("shown_i", "v_i", nonnegative=True)
over_normals = normals_integral(
    r"\left\langle \omega_o, \omega_m \right\rangle \left\langle \omega_i, \omega_m \right\rangle"
    r" G_2(\omega_o, \omega_i, \omega_m) D(\omega_m)"
)
sigma = sp.Symbol("sigma", positive=True)
matt = printed_symbol("rho_matt", r"\rho(\omega_o, \omega_i)")
lit = printed_symbol(
    "light_of_a_facet", r"\int_{\Omega} \frac{1}{\pi} \left\langle \omega_i, \omega_m \right\rangle \, d\omega_i"
)


def _slope_steps(it: Equation) -> list[Any]:
    """Of each product of directions comes a cosine of the facet and one of the plane: with D and solid angle, one is left."""
    density = normals_from_slopes.equals.doit().subs(chi(sp.cos(wm.theta)), 1)
    cosine = sp.cos(wm.theta)
    inside = (shown_o * mu_o * cosine) * (shown_i * mu_i * cosine) * G2 * density * solid_angle.equals / (sp.pi * mu_o * mu_i)
    (whole,) = it.equals.atoms(sp.Integral)
    prefactors = it.equals.xreplace({whole: 1}) * whole.function.subs(P22(x, y), P22_at_m)
    return [inside - prefactors, it.means - over_normals / (sp.pi * mu_o * mu_i)]


def _furnace_steps(it: Equation) -> list[Any]:
    """A facet scatters all its light. Since G2 is at most G1, the visible area bounds the sum: the second equation."""
    visible, Lambda = sp.symbols("visible Lambda", positive=True)
    difference = G1 * visible - (G1 / (1 + Lambda)) * visible
    return [sp.Integer(0 if sp.factor(difference).is_nonnegative else 1), it.equals - lambert.equals]


def _ring(rho: Any) -> sp.Expr:
    """What comes from all azimuths at one angle to the facet's normal: rho times the cosine, per angle."""
    return sp.integrate(rho * sp.cos(theta_i) * sp.sin(theta_i), (phi_i, 0, 2 * sp.pi))


with sp.evaluate(False):
    rho = Equation(
        key="brdf.diffuse.rho",
        title="the BRDF of matt facets",
        symbol=matt,
        means=over_normals / (sp.pi * mu_o * mu_i),
        equals=sp.Integral(G2 * shown_o * shown_i * sp.cos(wm.theta) * P22(x, y), (x, -sp.oo, sp.oo), (y, -sp.oo, sp.oo))
        / sp.pi,
        proof=_slope_steps,
        proved_by="sympy: the integrand in slopes",
        slides=(20,),
        cite="oren1994; heitz2014",
        note="v_o is 1 - (x_o x + y_o y)/z_o where that is positive, otherwise 0; v_i likewise. Facets keep no light.",
    )
    flat = Equation(
        key="brdf.diffuse.flat",
        title="without roughness matt facets are a matt plane",
        symbol=printed_symbol("rho_flat", r"\lim_{\alpha \to 0} \rho(\omega_o, \omega_i)"),
        equals=1 / sp.pi,
        proof=lambda it: _flat_steps(it),
        proved_by="sympy: the integrand at slope 0, where nothing is hidden",
        slides=(20,),
        cite="oren1994",
    )
    lambert = Equation(
        key="brdf.diffuse.lambert",
        title="a matt facet sends on all that it gets",
        symbol=lit,
        means=sp.Integral(2 * sp.cos(theta_i) * sp.sin(theta_i), (theta_i, 0, sp.pi / 2)),
        equals=sp.Integer(1),
        proof=lambda it: [_ring(1 / sp.pi) - it.means.function.doit(), it.means.doit() - it.equals],
        proved_by="sympy: the BRDF of a matt facet is 1/pi in every direction; then the integral",
        slides=(20,),
        cite="oren1994",
    )
    energy = Equation(
        key="brdf.diffuse.energy",
        title="no more light leaves matt facets than arrives",
        symbol=printed_symbol("matt_albedo", r"\int_{\Omega} \rho(\omega_o, \omega_i) \cos \theta_i \, d\omega_i"),
        equals=sp.Integer(1),
        relation=r"\le",
        proof=_furnace_steps,
        proved_by="sympy: G2 is at most G1, and what is visible fills the view",
        slides=(20, 24, 51),
        cite="heitz2014",
    )
    oren_nayar = Equation(
        key="brdf.diffuse.oren_nayar",
        title="Oren and Nayar's fit for matt V-cavities",
        symbol=matt,
        equals=(
            1
            - sigma**2 / (2 * (sigma**2 + sp.Rational(33, 100)))
            + sp.Rational(45, 100)
            * sigma**2
            / (sigma**2 + sp.Rational(9, 100))
            * sp.Max(0, sp.cos(phi))
            * sp.sin(sp.Max(theta_o, theta_i))
            * sp.tan(sp.Min(theta_o, theta_i))
        )
        / sp.pi,
        relation=r"\approx",
        proof=lambda it: _fit_steps(it),
        proved_by="sympy: the same with both quotients divided out",
        over={theta_o: (0.001, 1.5), theta_i: (0.001, 1.5), phi: (0, 1.5), sigma: (0.001, 1)},
        slides=(20,),
        cite="oren1994",
        note="sigma is the standard deviation of the facets' angle, phi the difference of the azimuths.",
    )


def _flat_steps(it: Equation) -> list[Any]:
    (whole,) = rho.equals.atoms(sp.Integral)
    level = {shown_o: 1, shown_i: 1, G2: 1, P22(x, y): 1, sp.cos(wm.theta): 1}
    return [it.equals - rho.equals.xreplace({whole: 1}).doit() * whole.function.subs(level)]


def _fit_steps(it: Equation) -> list[Any]:
    """Both coefficients as functions of sigma, in another form: one falls from 1 to 1/2, the other rises from 0 to 0.45."""
    level = (1 + sp.Rational(33, 100) / (sigma**2 + sp.Rational(33, 100))) / 2
    rise = sp.Rational(45, 100) * (1 - sp.Rational(9, 100) / (sigma**2 + sp.Rational(9, 100)))
    relative_azimuth, grazing_sine, grazing_tangent = sp.symbols("relative_azimuth grazing_sine grazing_tangent", positive=True)
    put = {
        sp.Max(0, sp.cos(phi)): relative_azimuth,
        sp.sin(sp.Max(theta_o, theta_i)): grazing_sine,
        sp.tan(sp.Min(theta_o, theta_i)): grazing_tangent,
    }
    return [it.equals.subs(put) - (level + rise * relative_azimuth * grazing_sine * grazing_tangent) / sp.pi]


# --- kernels ----------------------------------------------------------------------------------------------------------

ROUNDING = 1e-13  # of a sum of some 10^4 terms
SMALL = 0.01  # of the radius up to which facets matter: changes within less are negligible
SPAN = 2.5  # largest length of a piece of a ray, in the logarithm of the radius
AGREE = 1e-6  # largest difference of two rules on a piece, relative to the integral along the ray
SHORTEST, PIECES = 1e-3, 200
NEVER = 1e-30  # lower bound of a slope relative to that of a facet seen edge-on; less has no effect
ENDED, FARTHEST = 1e-10, 7.0  # beyond FARTHEST in the logarithm of the radius, a relative contribution of ENDED ends a ray
KRONROD_ABSCISSAE, KRONROD_WEIGHTS, GAUSS_WEIGHTS = (tuple(map(float, part)) for part in (KRONROD_NODES, KRONROD, GAUSS))


class MattParameters(NamedTuple):
    """Parameters of distribution and masking; the slope scale, and its multiple beyond which hardly any slopes lie."""

    ndf: Any
    model: Any
    scale_x: float
    scale_y: float
    reach: float


class Ray(NamedTuple):
    """A ray in slope space, for a view and a light direction. dx, dy: slopes per radius. lean_o, lean_i: slope towards each
    direction, relative to that of a facet seen edge-on, per radius."""

    dx: float
    dy: float
    lean_o: float
    lean_i: float
    Lambda_o: float
    Lambda_i: float
    wo: Vector
    wi: Vector


@cache
def light_rule(D: Callable[..., float], G2: Callable[..., float]) -> Callable[..., float]:
    """The integrand over unstretched slopes, at a radius along a ray."""

    def light(r: float, ray: Ray, p: MattParameters) -> float:
        facing_o, facing_i = 1.0 - r * ray.lean_o, 1.0 - r * ray.lean_i
        if not (facing_o > 0.0 and facing_i > 0.0):
            return 0.0
        x, y = r * ray.dx, r * ray.dy
        mz = 1.0 / sqrt(1.0 + x * x + y * y)
        wm = (-x * mz, -y * mz, mz)
        om, im = mz * ray.wo[2] * facing_o, mz * ray.wi[2] * facing_i
        visibility = G2(ray.Lambda_o, ray.Lambda_i, om, im, ray.wo, ray.wi, wm, p)
        return visibility * facing_o * facing_i * mz * D(wm, p.ndf) * ((mz * mz) * (mz * mz))

    return light


@cache
def piece_rule(D: Callable[..., float], G2: Callable[..., float]) -> Callable[..., Pair]:
    """The integral along a piece of a ray by Kronrod's rule, and the difference from Gauss's; in the radius if `even`, else in
    its logarithm."""
    light = light_rule(D, G2)

    def piece(start: float, stop: float, even: bool, ray: Ray, p: MattParameters) -> Pair:
        half, middle = 0.5 * (stop - start), 0.5 * (stop + start)
        fine, coarse = 0.0, 0.0
        for k in range(15):
            at = middle + half * KRONROD_ABSCISSAE[k]
            r = at if even else exp(at)
            value = half * r * light(r, ray, p)
            if not even:
                value *= r
            fine += KRONROD_WEIGHTS[k] * value
            coarse += GAUSS_WEIGHTS[k] * value
        return fine, abs(fine - coarse)

    return piece


def next_end(start: float, span: float, one: float, two: float, last: float) -> float:
    """Where a piece ends: at the next of three places, or after its span."""
    stop = min(start + span, last)
    if start < one < stop:
        stop = one
    return two if start < two < stop else stop


@cache
def ray_rule(D: Callable[..., float], G2: Callable[..., float]) -> Callable[..., Pair]:
    """The integral along one ray per its angle, and its error.

    The variable of the first piece is the radius, that of the others its logarithm. Pieces end where the ray leaves the facets
    that are visible or lit, and at the opposite slopes, from which on V-cavities mask. They are halved while both rules differ.
    lean_o, lean_i: the slope along the ray relative to that of a facet seen edge-on.
    """
    piece = piece_rule(D, G2)

    def along(
        azimuth: Pair, lean_o: float, lean_i: float, Lambda_o: float, Lambda_i: float, wo: Vector, wi: Vector, p: MattParameters
    ) -> Pair:
        dx, dy = p.scale_x * azimuth[0], p.scale_y * azimuth[1]
        ray = Ray(dx, dy, lean_o, lean_i, Lambda_o, Lambda_i, wo, wi)
        steepest, backward = max(lean_o, lean_i), max(-lean_o, -lean_i)
        end = min(1.0 / steepest, p.reach) if steepest > 0.0 else p.reach
        one, two, last = -log(max(abs(lean_o), NEVER)), -log(max(abs(lean_i), NEVER)), log(end)
        first = 0.5 * min(1.0, end) * max(SMALL, 1.0 / max(sqrt(dx * dx + dy * dy), backward, 1.0))
        total, error = piece(0.0, first, True, ray, p)
        start, span, part = log(first), SPAN, total
        for _ in range(PIECES):
            if start >= last or (start > FARTHEST and part <= ENDED * total):
                break
            stop = next_end(start, span, one, two, last)
            part, off = piece(start, stop, False, ray, p)
            if off > AGREE * (total + part) and stop - start > SHORTEST:
                span, part = 0.5 * (stop - start), total
            else:
                total, error, start, span = total + part, error + off, stop, min(SPAN, 2.0 * span)
        return total, error + (abs(part) if start < last else 0.0)

    return along


@cache
def ray_batch(D: Callable[..., float], G2: Callable[..., float]) -> Batch:
    """Rays (n, 2), their leans towards both directions, Lambda of both, and the directions: integrals and errors (n, 2)."""
    return Batch(ray_rule(D, G2), [2, 1, 1, 1, 1, 3, 3], 2)


@cache
def Lambda_batch(Lambda: Callable[..., float]) -> Batch:
    return Batch(Lambda, [3])


# --- all rays of a pair of directions ---------------------------------------------------------------------------------

TOLERANCE = 3e-7  # relative error to which panels are refined
ROUNDS, TOGETHER = 50, 256  # of halving; pairs at once
NARROW, THIN = 1e-3, 1e-3  # smallest relevant angle beside an edge: absolute, and relative to the angle between both edges
WIDE = 0.3  # if the integrand changes within a larger angle, a single panel lies between two rays
ALIKE = 1e-6  # relative difference below which two edges are one
SAFETY = 5.0, 2.0  # factors of the estimated errors: of the rule over the angle, which may miss a kink, and of those along rays


class Panels(NamedTuple):
    """Panels over the azimuth of rays. pair: index of the pair of directions. ray: (n, 2), where the panel begins. lean,
    lean_across: (n, 2), of the ray and of the one at a right angle to it, towards both directions. The angle from the ray is
    `width`, with a sign, times the hyperbolic sine of a coordinate from low to high.
    """

    pair: np.ndarray
    ray: np.ndarray
    lean: np.ndarray
    lean_across: np.ndarray
    width: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def subset(self, chosen: Any) -> Panels:
        return Panels(*(field[chosen] for field in self))

    def halves(self) -> Panels:
        middle = (self.low + self.high) / 2
        lower, upper = self._replace(high=middle), self._replace(low=middle)
        return Panels(*(np.concatenate(both) for both in zip(lower, upper, strict=True)))

    def rays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unit vectors and leans (n, 15, 2), and the angle per coordinate (n, 15)."""
        half = ((self.high - self.low) / 2)[:, None]
        t = ((self.low + self.high) / 2)[:, None] + half * KRONROD_NODES
        angle = (self.width[:, None] * np.sinh(t))[..., None]
        c, s = np.cos(angle), np.sin(angle)
        across = np.stack([-self.ray[:, 1], self.ray[:, 0]], axis=-1)
        rays, leans = (c * a[:, None] + s * b[:, None] for a, b in ((self.ray, across), (self.lean, self.lean_across)))
        return rays, leans, half * abs(self.width)[:, None] * np.cosh(t)


def edges(o: np.ndarray, i: np.ndarray, scale: tuple[float, float]) -> tuple[np.ndarray, ...]:
    """For pairs of directions (n, 3): the vectors q of their leans (n, 2, 2), their dot products (n, 2, 2), and their cross
    product (n,), in extended precision, which matters where both directions graze from opposite sides."""
    q = np.stack([np.array(scale) * (w[:, :2] / w[:, 2:]) for w in (o, i)], axis=1)
    a, b = (w.astype(np.longdouble) for w in (o, i))
    cross = scale[0] * scale[1] * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / (a[:, 2] * b[:, 2])
    return q, q @ q.swapaxes(1, 2), cross.astype(float)


def first_panels(o: np.ndarray, i: np.ndarray, scale: tuple[float, float]) -> Panels:
    """Panels between the rays along both edges, of visible and of lit facets, and the ray to the point where these cross.

    Each of these rays is at a right angle to a vector w = a q_o + b q_i.
    """
    q, dots, cross = edges(o, i, scale)
    size = np.sqrt(dots[:, [0, 1], [0, 1]])
    ab = np.tile(np.array([[1.0, 0.0], [0.0, 1.0], [1.0, -1.0]]), (len(o), 1, 1))
    ab[size[:, 0] == 0] = [0.0, 1.0]
    ab[size[:, 1] == 0] = [1.0, 0.0]
    alike = np.hypot(*(q[:, 0] - q[:, 1]).T) <= ALIKE * size.max(axis=1)
    ab[alike, 2] = ab[alike, 0]
    first = ab[:, :1]
    ab = ab * np.where(_dot(first, ab, dots) < 0, -1.0, 1.0)[..., None]  # lines on one side of the first
    beta = np.arctan2(_cross(first, ab, cross), _dot(first, ab, dots))
    ab = np.take_along_axis(ab, np.argsort(beta, axis=1)[..., None], axis=1)
    after = np.roll(ab, -1, axis=1)
    between = np.maximum(np.arctan2(_cross(ab, after, cross), _dot(ab, after, dots))[:, :2], 0)
    angles = np.concatenate([between, np.pi - between.sum(axis=1, keepdims=True)], axis=1)
    after[:, 2] *= -1
    ab, after, angles = np.concatenate([ab, -ab], axis=1), np.concatenate([after, -after], axis=1), np.tile(angles, 2)
    largest = np.maximum(size.max(axis=1), 1e-300)
    opposite = np.arctan2(abs(cross), -dots[:, 0, 1])
    width = np.maximum(1 / largest, np.minimum(NARROW, THIN * opposite)).clip(1e-15, 1)
    width = np.broadcast_to(width[:, None], angles.shape)
    wide = width > WIDE
    rows = [(ab, angles, wide, 1.0), (ab, angles / 2, ~wide, 1.0), (after, angles / 2, ~wide, -1.0)]
    parts = [_panels(*row, width, q, dots, cross) for row in rows]
    return Panels(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))


def _dot(a: np.ndarray, b: np.ndarray, dots: np.ndarray) -> np.ndarray:
    return np.asarray(((a @ dots) * b).sum(axis=-1))


def _cross(a: np.ndarray, b: np.ndarray, cross: np.ndarray) -> np.ndarray:
    return np.asarray((a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) * cross[:, None])


def _panels(
    ab: np.ndarray, far: np.ndarray, chosen: np.ndarray, sign: float, width: np.ndarray, *of_pairs: np.ndarray
) -> Panels:
    """Panels (m,) from rays at right angles to w, those chosen, as far as an angle on one side."""
    q, dots, cross = of_pairs
    pair, line = np.nonzero(chosen & (far > 0))
    a, b = ab[pair, line].T
    w = a[:, None] * q[pair, 0] + b[:, None] * q[pair, 1]
    w[(w == 0).all(axis=1)] = [0.0, -1.0]
    length = np.hypot(*w.T)[:, None]
    ray = np.stack([-w[:, 1], w[:, 0]], axis=-1) / length
    lean = np.stack([-b * cross[pair], a * cross[pair]], axis=-1) / length
    lean_across = -np.stack([a * dots[pair, 0, k] + b * dots[pair, 1, k] for k in (0, 1)], axis=-1) / length
    width, far = width[pair, line], far[pair, line]
    return Panels(pair, ray, lean, lean_across, sign * width, np.zeros(len(pair)), np.arcsinh(far / width))


# --- the model --------------------------------------------------------------------------------------------------------

ALBEDO_COSINES, ALBEDO_AZIMUTHS = 20, 32  # light directions over which an albedo is summed
COARSER_RULES = ((14, 24), (17, 28))  # two, since one may agree by chance
SAFETY_OF_ALBEDO = 3.0  # factor from their difference to the error of any rule that converges at least linearly


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (nodes + 1) / 2, weights / 2


def light_directions(cosines: int, azimuths: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) and weights of a sum over the hemisphere with the cosine: even in azimuth, Gauss in the cosine."""
    nodes, weights = gauss(cosines)
    z, azimuth = np.meshgrid(nodes, 2 * np.pi * (np.arange(azimuths) + 0.5) / azimuths, indexing="ij")
    weight = np.repeat(weights * nodes, azimuths) * 2 * np.pi / azimuths
    return spherical(np.arccos(z), azimuth).reshape(-1, 3), weight


EVEN = CosineTable()


class Diffuse(BRDF):
    r"""BRDF of matt microfacets, by quadrature, for light that bounces once.

    .. math:: \rho(\omega_o, \omega_i) = \frac{1}{\cos\theta_o \cos\theta_i} \int_{\Omega} \frac{a}{\pi}
              \left\langle \omega_o, \omega_m \right\rangle \left\langle \omega_i, \omega_m \right\rangle
              G_2(\omega_o, \omega_i, \omega_m) \, D(\omega_m) \, d\omega_m

    with the albedo a of a microfacet. Values have at least six digits if D, as a function of slopes over their scale, changes
    over no less than a tenth of a slope's size. Samples are drawn in proportion to the cosine.

    Parameters
    ----------
    model : Masking
        Model of masking and shadowing, with numbers for parameters.
    albedo : float, optional
        Fraction of the light that a microfacet scatters, in (0, 1].

    Raises
    ------
    ValueError
        If an argument is of another kind, or albedo outside its range.

    References
    ----------
    oren1994; heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> brdf = mf.Diffuse(mf.Smith(mf.GGX(0.5)))
    >>> print(f"{brdf.evaluate([0.6, 0.0, 0.8], [0.6, 0.0, 0.8]):.4f} {brdf.evaluate([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
    0.2885 0.2163
    """

    def __init__(self, model: Masking, albedo: float = 1.0) -> None:
        if not isinstance(model, Masking):
            raise ValueError(f"model must be a model of masking such as Smith(GGX(0.3)), got {model!r}")
        model.require_numbers("Diffuse")
        if positive("albedo", albedo) > 1:
            raise ValueError(f"albedo must lie in (0, 1], got {albedo}")
        self.model, self.facet_albedo = model, float(albedo)
        self._batch = ray_batch(type(model.ndf).kernel, model.G2_kernel)

    def evaluate(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        return self.evaluate_with_error(wo, wi)[0]

    def evaluate_with_error(self, wo: ArrayLike, wi: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Value of the BRDF, in 1/sr, and a bound of its error.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        value : ndarray, shape (...)
            BRDF, 1/sr; 0 if either direction is below the horizon.
        error : ndarray, shape (...)
            Bound of its error, absolute, from the difference of two rules and from rounding.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> value, error = mf.Diffuse(mf.Smith(mf.GGX(0.5))).evaluate_with_error([0.6, 0.0, 0.8], [0, 0, 1])
        >>> print(f"{value:.5f}", error < 1e-6 * value)
        0.25645 True
        """
        o, i = np.broadcast_arrays(as_vectors("wo", wo), as_vectors("wi", wi))
        dtype, shape = np.result_type(o, i), o.shape[:-1]
        o, i = (w.reshape(-1, 3).astype(np.float64) for w in (o, i))
        above = np.flatnonzero((o[:, 2] > 0) & (i[:, 2] > 0))
        results = np.zeros((2, len(o)))
        for k in range(0, len(above), TOGETHER):
            chunk = above[k : k + TOGETHER]
            results[:, chunk] = self._over_rays(o[chunk], i[chunk])
        results *= self.facet_albedo
        results[1] += (ROUNDING + np.finfo(dtype).eps) * results[0]
        value, error = results.astype(dtype).reshape(2, *shape)
        return value[()], error[()]

    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        # By the cosine: the weight is pi times the BRDF, which varies little.
        return EVEN.sample(wo, u)

    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        return EVEN.pdf(wo, wi)

    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        # By quadrature over the hemisphere; the error is from coarser rules, from the errors of the BRDF, and from rounding.
        views = as_vectors("wo", wo)
        double = views.astype(np.float64)
        sums = []
        for cosines, azimuths in ((ALBEDO_COSINES, ALBEDO_AZIMUTHS), *COARSER_RULES):
            wi, weight = light_directions(cosines, azimuths)
            value, error = self.evaluate_with_error(double[..., None, :], wi)
            sums.append((value @ weight, error @ weight))
        (value, within), *fewer = sums
        difference = np.maximum(*(abs(value - other) for other, _ in fewer))
        bound = SAFETY_OF_ALBEDO * difference + within + (ROUNDING + np.finfo(views.dtype).eps) * value
        return value.astype(views.dtype)[()], bound.astype(views.dtype)[()]

    def _over_rays(self, o: np.ndarray, i: np.ndarray) -> np.ndarray:
        """Values and errors (2, n): panels are halved until their errors add up to the tolerance."""
        count, scale = len(o), self.model.ndf.slope_scale
        Lambda = Lambda_batch(self.model.Lambda_kernel)
        known = [Lambda([w], self.model.parameters) for w in (o, i)]
        panels = first_panels(o, i, scale)
        sums = self._summed(panels, o, i, known)
        for _ in range(ROUNDS):
            value, error = (np.bincount(panels.pair, part, count) for part in sums[:2])
            goal = TOLERANCE * value / np.bincount(panels.pair, minlength=count)
            split = (sums[1] > goal[panels.pair]) & (error > TOLERANCE * value)[panels.pair]
            if not split.any():
                break
            children = panels.subset(split).halves()
            child_sums = self._summed(children, o, i, known)
            panels = Panels(*(np.concatenate(both) for both in zip(panels.subset(~split), children, strict=True)))
            sums = np.concatenate([sums[:, ~split], child_sums], axis=1)
        value, difference, within = (np.bincount(panels.pair, part, count) for part in sums)
        return scale[0] * scale[1] / np.pi * np.stack([value, SAFETY[0] * difference + SAFETY[1] * within])

    def _summed(self, panels: Panels, o: np.ndarray, i: np.ndarray, known: list[Any]) -> np.ndarray:
        """For each panel its integral, the error of the rule over the angle, which refinement reduces, and that of the rays."""
        rays, leans, jacobian = panels.rays()
        pair = panels.pair[:, None]
        arrays = [rays, leans[..., 0], leans[..., 1], *(part[pair] for part in (*known, o, i))]
        parameters = MattParameters(*self.model.parameters, *self.model.ndf.slope_scale, self.model.ndf.reach)
        values, errors = np.moveaxis(self._batch(arrays, parameters), -1, 0) * jacobian
        return np.stack([values @ KRONROD, abs(values @ (KRONROD - GAUSS)), errors @ KRONROD])

    def __repr__(self) -> str:
        return f"Diffuse({self.model!r}, {self.facet_albedo:g})"
