"""Matt facets: each scatters evenly what it gets, and the rough surface does not."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import exp, log, sqrt
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.albedo import GAUSS, KRONROD, PLACES
from microfacet.brdf.base import BRDF
from microfacet.brdf.cosine_table import CosineTable
from microfacet.directions import as_vectors, positive, spherical
from microfacet.geometry.slopes import P22_at_m, normals_from_slopes, normals_integral, solid_angle
from microfacet.kernels import Batch, Pair, Vector
from microfacet.notation import G1, G2, P22, chi, mu_i, mu_o, phi, phi_i, raw, theta_i, theta_o, wm, x, y
from microfacet.statement import Equation
from microfacet.visibility.masking import Masking

# --- statements -------------------------------------------------------------------------------------------------------

shown_o, shown_i = raw("shown_o", "v_o", nonnegative=True), raw("shown_i", "v_i", nonnegative=True)
over_normals = normals_integral(
    r"\left\langle \omega_o, \omega_m \right\rangle \left\langle \omega_i, \omega_m \right\rangle"
    r" G_2(\omega_o, \omega_i, \omega_m) D(\omega_m)"
)
sigma = sp.Symbol("sigma", positive=True)
matt = raw("rho_matt", r"\rho(\omega_o, \omega_i)")
lit = raw("light_of_a_facet", r"\int_{\Omega} \frac{1}{\pi} \left\langle \omega_i, \omega_m \right\rangle \, d\omega_i")


def _slope_steps(it: Equation) -> list[Any]:
    """Of each product of directions comes a cosine of the facet and one of the plane: with D and solid angle, one is left."""
    density = normals_from_slopes.equals.doit().subs(chi(sp.cos(wm.theta)), 1)
    cosine = sp.cos(wm.theta)
    inside = (shown_o * mu_o * cosine) * (shown_i * mu_i * cosine) * G2 * density * solid_angle.equals / (sp.pi * mu_o * mu_i)
    (whole,) = it.equals.atoms(sp.Integral)
    prefactors = it.equals.xreplace({whole: 1}) * whole.function.subs(P22(x, y), P22_at_m)
    return [inside - prefactors, it.means - over_normals / (sp.pi * mu_o * mu_i)]


def _furnace_steps(it: Equation) -> list[Any]:
    """A facet sends on what it gets; with G2 at most G1, what it is seen of bounds the sum, and that is the second equation."""
    seen, kept = sp.symbols("seen kept", positive=True)
    gone = G1 * seen - (G1 / (1 + kept)) * seen
    return [sp.Integer(0 if sp.factor(gone).is_nonnegative else 1), it.equals - lambert.equals]


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
        symbol=raw("rho_flat", r"\lim_{\alpha \to 0} \rho(\omega_o, \omega_i)"),
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
        symbol=raw("matt_albedo", r"\int_{\Omega} \rho(\omega_o, \omega_i) \cos \theta_i \, d\omega_i"),
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
    """Two numbers that depend on sigma, once more: the one falls from 1 to 1/2, the other rises from 0 to 0.45."""
    level = (1 + sp.Rational(33, 100) / (sigma**2 + sp.Rational(33, 100))) / 2
    rise = sp.Rational(45, 100) * (1 - sp.Rational(9, 100) / (sigma**2 + sp.Rational(9, 100)))
    turn, steep, flat_ = sp.symbols("turn steep flat", positive=True)
    put = {sp.Max(0, sp.cos(phi)): turn, sp.sin(sp.Max(theta_o, theta_i)): steep, sp.tan(sp.Min(theta_o, theta_i)): flat_}
    return [it.equals.subs(put) - (level + rise * turn * steep * flat_) / sp.pi]


# --- kernels ----------------------------------------------------------------------------------------------------------

ROUNDING = 1e-13  # of a sum of some 10^4 terms
SMALL = 0.01  # of the radius up to which facets count: what changes within less hardly counts
SPAN = 2.5  # logarithm of the radius that one piece of a ray extends over at most
AGREE = 1e-6  # of a ray's integral, by which two rules may differ on a piece
SHORTEST, PIECES = 1e-3, 200
NEVER = 1e-30  # slope over that of an edge on: less changes nothing
ENDED, FARTHEST = 1e-10, 7.0  # a piece of so little of the integral ends a ray, beyond that logarithm of the radius
ABSCISSAE, BY_KRONROD, BY_GAUSS = (tuple(map(float, part)) for part in (PLACES, KRONROD, GAUSS))


class MattParameters(NamedTuple):
    """Those of distribution and masking; the slope scale, and its multiple beyond which hardly any slopes lie."""

    ndf: Any
    model: Any
    scale_x: float
    scale_y: float
    reach: float


class Ray(NamedTuple):
    """Slopes along which light is summed, for a view and a light direction: how slopes change along it; the slope over that at
    which a facet is edge on, for either direction; Lambda of both, and they."""

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
    """What is integrated over unstretched slopes, at a radius along a ray."""

    def light(r: float, ray: Ray, p: MattParameters) -> float:
        shown, shone = 1.0 - r * ray.lean_o, 1.0 - r * ray.lean_i
        if not (shown > 0.0 and shone > 0.0):
            return 0.0
        x, y = r * ray.dx, r * ray.dy
        mz = 1.0 / sqrt(1.0 + x * x + y * y)
        wm = (-x * mz, -y * mz, mz)
        om, im = mz * ray.wo[2] * shown, mz * ray.wi[2] * shone
        both = G2(ray.Lambda_o, ray.Lambda_i, om, im, ray.wo, ray.wi, wm, p)
        return both * shown * shone * mz * D(wm, p.ndf) * ((mz * mz) * (mz * mz))

    return light


@cache
def piece_rule(D: Callable[..., float], G2: Callable[..., float]) -> Callable[..., Pair]:
    """The integral along a piece of a ray by Kronrod's rule, and how far Gauss's differs; in the radius if `even`, else in its
    logarithm."""
    light = light_rule(D, G2)

    def piece(start: float, stop: float, even: bool, ray: Ray, p: MattParameters) -> Pair:
        half, middle = 0.5 * (stop - start), 0.5 * (stop + start)
        fine, coarse = 0.0, 0.0
        for k in range(15):
            at = middle + half * ABSCISSAE[k]
            r = at if even else exp(at)
            value = half * r * light(r, ray, p)
            if not even:
                value *= r
            fine += BY_KRONROD[k] * value
            coarse += BY_GAUSS[k] * value
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

    The first piece is even in the radius, the others are in its logarithm. One ends where a ray leaves what is seen or lit, and
    where a slope is as steep the other way, from which on V-cavities mask. Pieces are halved while both rules differ.
    lean_o, lean_i: the slope along the ray over that at which a facet is seen edge on.
    """
    piece = piece_rule(D, G2)

    def along(
        turn: Pair, lean_o: float, lean_i: float, Lambda_o: float, Lambda_i: float, wo: Vector, wi: Vector, p: MattParameters
    ) -> Pair:
        dx, dy = p.scale_x * turn[0], p.scale_y * turn[1]
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
    """Rays (n, 2), what they lean towards both directions, Lambda of these, and they: integrals and errors (n, 2)."""
    return Batch(ray_rule(D, G2), [2, 1, 1, 1, 1, 3, 3], 2)


@cache
def Lambda_batch(Lambda: Callable[..., float]) -> Batch:
    return Batch(Lambda, [3])


# --- all rays of a pair of directions ---------------------------------------------------------------------------------

TOLERANCE = 3e-7  # of a value, to which panels are halved
ROUNDS, TOGETHER = 50, 256  # of halving; pairs at once
NARROW, THIN = 1e-3, 1e-3  # angles beside an edge that still count; of the angle between both edges
WIDE = 0.3  # if things change within a larger angle, one panel lies between two rays
ALIKE = 1e-6  # two edges that differ by so little are one
SAFETY = 5.0, 2.0  # of the differences of rules over the angle, where what changes is not where panels end, and along rays


class Panels(NamedTuple):
    """Of each panel its pair, the ray it begins at, what that leans towards both directions, how that changes, and the angle.

    ray: (n, 2). lean, turned: (n, 2), of the ray and of the one at a right angle to it. The angle from the ray is `width`, with
    a sign, times the hyperbolic sine of a coordinate from low to high.
    """

    pair: np.ndarray
    ray: np.ndarray
    lean: np.ndarray
    turned: np.ndarray
    width: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def taken(self, chosen: Any) -> Panels:
        return Panels(*(field[chosen] for field in self))

    def halves(self) -> Panels:
        middle = (self.low + self.high) / 2
        lower, upper = self._replace(high=middle), self._replace(low=middle)
        return Panels(*(np.concatenate(both) for both in zip(lower, upper, strict=True)))

    def rays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unit vectors and leans (n, 15, 2), and the angle per coordinate (n, 15)."""
        half = ((self.high - self.low) / 2)[:, None]
        t = ((self.low + self.high) / 2)[:, None] + half * PLACES
        turn = (self.width[:, None] * np.sinh(t))[..., None]
        c, s = np.cos(turn), np.sin(turn)
        across = np.stack([-self.ray[:, 1], self.ray[:, 0]], axis=-1)
        rays, leans = (c * a[:, None] + s * b[:, None] for a, b in ((self.ray, across), (self.lean, self.turned)))
        return rays, leans, half * abs(self.width)[:, None] * np.cosh(t)


def edges(o: np.ndarray, i: np.ndarray, scale: tuple[float, float]) -> tuple[np.ndarray, ...]:
    """Of pairs (n, 3) what a slope leans towards each, its vectors q (n, 2, 2), their products (n, 2, 2), and their cross
    product (n,), with more digits than both directions' are, which decide where both graze opposite to each other."""
    q = np.stack([np.array(scale) * (w[:, :2] / w[:, 2:]) for w in (o, i)], axis=1)
    a, b = (w.astype(np.longdouble) for w in (o, i))
    cross = scale[0] * scale[1] * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / (a[:, 2] * b[:, 2])
    return q, q @ q.swapaxes(1, 2), cross.astype(float)


def first_panels(o: np.ndarray, i: np.ndarray, scale: tuple[float, float]) -> Panels:
    """Panels between the rays along both edges, of what is seen and of what is lit, and that to the place where these cross.

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
    apart = np.concatenate([between, np.pi - between.sum(axis=1, keepdims=True)], axis=1)
    after[:, 2] *= -1
    ab, after, apart = np.concatenate([ab, -ab], axis=1), np.concatenate([after, -after], axis=1), np.tile(apart, 2)
    largest = np.maximum(size.max(axis=1), 1e-300)
    opposite = np.arctan2(abs(cross), -dots[:, 0, 1])
    width = np.maximum(1 / largest, np.minimum(NARROW, THIN * opposite)).clip(1e-15, 1)
    width = np.broadcast_to(width[:, None], apart.shape)
    wide = width > WIDE
    rows = [(ab, apart, wide, 1.0), (ab, apart / 2, ~wide, 1.0), (after, apart / 2, ~wide, -1.0)]
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
    turned = -np.stack([a * dots[pair, 0, k] + b * dots[pair, 1, k] for k in (0, 1)], axis=-1) / length
    width, far = width[pair, line], far[pair, line]
    return Panels(pair, ray, lean, turned, sign * width, np.zeros(len(pair)), np.arcsinh(far / width))


# --- the model --------------------------------------------------------------------------------------------------------

HEIGHTS, TURNS = 20, 32  # light directions over which an albedo is summed
FEWER = ((14, 24), (17, 28))  # two coarser rules, since one may agree by chance
HOPEFUL = 3.0  # times what they differ by: the error of any rule that gets better at least as its nodes get closer


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (nodes + 1) / 2, weights / 2


def light_directions(heights: int, turns: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) and weights of a sum over the hemisphere with the cosine: even in azimuth, Gauss in the cosine."""
    nodes, weights = gauss(heights)
    z, azimuth = np.meshgrid(nodes, 2 * np.pi * (np.arange(turns) + 0.5) / turns, indexing="ij")
    weight = np.repeat(weights * nodes, turns) * 2 * np.pi / turns
    return spherical(np.arccos(z), azimuth).reshape(-1, 3), weight


EVEN = CosineTable()


class Diffuse(BRDF):
    """The BRDF of matt facets over a model of masking and shadowing, by quadrature. oren1994; heitz2014.

    albedo: the share of light that a facet scatters, in (0, 1]. Light that meets a second facet is not followed. Values have
    six digits at least, and the errors told are bounds, of distributions that change, in slopes over their scale, over no less
    than a tenth of a slope's size along it and across it.
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
        """The BRDF, 1/sr, shapes (..., 3) -> (...); 0 if either direction is below the horizon. oren1994."""
        return self.evaluate_with_error(wo, wi)[0]

    def evaluate_with_error(self, wo: ArrayLike, wi: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """The BRDF, and a bound of its error, from how far two rules differ and from rounding."""
        o, i = np.broadcast_arrays(as_vectors("wo", wo), as_vectors("wi", wi))
        dtype, shape = np.result_type(o, i), o.shape[:-1]
        o, i = (w.reshape(-1, 3).astype(np.float64) for w in (o, i))
        above = np.flatnonzero((o[:, 2] > 0) & (i[:, 2] > 0))
        both = np.zeros((2, len(o)))
        for k in range(0, len(above), TOGETHER):
            some = above[k : k + TOGETHER]
            both[:, some] = self._over_rays(o[some], i[some])
        both *= self.facet_albedo
        both[1] += (ROUNDING + np.finfo(dtype).eps) * both[0]
        value, error = both.astype(dtype).reshape(2, *shape)
        return value[()], error[()]

    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        """Light directions with density cos theta_i/pi, shapes (..., 3) and (..., 2) -> (..., 3), for u in [0, 1); the zero
        vector where wo is below the horizon. What a sample weighs is pi times the BRDF, which varies little."""
        return EVEN.sample(wo, u)

    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """Density of `sample`, 1/sr, shapes (..., 3) -> (...); 0 if either direction is below the horizon."""
        return EVEN.pdf(wo, wi)

    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """The albedo by quadrature over the hemisphere, and a bound of its error, from coarser rules, from the errors of the
        BRDF, and from rounding; shapes (..., 3) -> (...)."""
        views = as_vectors("wo", wo)
        wide = views.astype(np.float64)
        sums = []
        for heights, turns in ((HEIGHTS, TURNS), *FEWER):
            wi, weight = light_directions(heights, turns)
            value, error = self.evaluate_with_error(wide[..., None, :], wi)
            sums.append((value @ weight, error @ weight))
        (value, within), *fewer = sums
        apart = np.maximum(*(abs(value - other) for other, _ in fewer))
        bound = HOPEFUL * apart + within + (ROUNDING + np.finfo(views.dtype).eps) * value
        return value.astype(views.dtype)[()], bound.astype(views.dtype)[()]

    def _over_rays(self, o: np.ndarray, i: np.ndarray) -> np.ndarray:
        """Values and errors (2, n): panels are halved until these add up to the tolerance."""
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
            children = panels.taken(split).halves()
            found = self._summed(children, o, i, known)
            panels = Panels(*(np.concatenate(both) for both in zip(panels.taken(~split), children, strict=True)))
            sums = np.concatenate([sums[:, ~split], found], axis=1)
        value, apart, within = (np.bincount(panels.pair, part, count) for part in sums)
        return scale[0] * scale[1] / np.pi * np.stack([value, SAFETY[0] * apart + SAFETY[1] * within])

    def _summed(self, panels: Panels, o: np.ndarray, i: np.ndarray, known: list[Any]) -> np.ndarray:
        """Of each panel its integral, the error of the rule over the angle, which halves may lessen, and that of the rays."""
        rays, leans, turned = panels.rays()
        pair = panels.pair[:, None]
        arrays = [rays, leans[..., 0], leans[..., 1], *(part[pair] for part in (*known, o, i))]
        parameters = MattParameters(*self.model.parameters, *self.model.ndf.slope_scale, self.model.ndf.reach)
        values, errors = np.moveaxis(self._batch(arrays, parameters), -1, 0) * turned
        return np.stack([values @ KRONROD, abs(values @ (KRONROD - GAUSS)), errors @ KRONROD])

    def __repr__(self) -> str:
        return f"Diffuse({self.model!r}, {self.facet_albedo:g})"
