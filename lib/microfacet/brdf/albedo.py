"""The albedo of mirror facets: the fraction of light that they reflect, and a bound of its error.

The integral goes over the slopes whose mirror direction lies above the horizon. They fill a disc, |slope|^2 + 2 tan theta_o
(slope along the view) < 1, which is taken in polar coordinates around the upright facet, in slopes divided by the
distribution's scales. What is not smooth lies on known curves. Along a ray it is met at roots of polynomials, where the ray is
cut: total reflection, creases of V-cavities, equal masking of light and viewer, light from the zenith, which a rough surface
masks least. Over the angle, the ray along the disc's edge, the narrow axis of unequal roughness, and the plane of the view are
ends of panels; panels are halved until the error is small.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import atan, inf, sqrt, tan
from typing import Any, NamedTuple

import numpy as np

from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Count, Pair, Vector
from microfacet.directions import as_vectors
from microfacet.material.fresnel import Conductor, Dielectric, Fresnel
from microfacet.visibility.masking import G2_of_facet, Masking, no_Lambda
from microfacet.visibility.smith import G2_BY_CORRELATION, Lambda_of
from microfacet.visibility.unphysical import Implicit, Kelemen, SchlickSmith
from microfacet.visibility.v_cavity import VCavity

# --- one ray ----------------------------------------------------------------------------------------------------------

LEVELS = 7  # rules of 13, 25, 49, ... nodes, each with the nodes of the one before
T_MAX = 3.0  # where the rule is truncated, at an error of 2e-14 of a bounded integrand


def tanh_sinh() -> tuple[tuple[float, ...], tuple[float, ...], tuple[int, ...]]:
    """Nodes and weights on (0, 1), dense at both ends, level after level, and the index at which each begins. takahasi1974."""
    nodes, weights, starts = [], [], [0]
    for level in range(LEVELS):
        step = 0.5 / 2**level
        count = round(T_MAX / step)
        t = step * (np.arange(-count, count + 1) if level == 0 else np.arange(-count + 1, count, 2))
        x = 1 / (1 + np.exp(-np.pi * np.sinh(t)))
        nodes.append(x)
        weights.append(step * x * (1 - x) * np.pi * np.cosh(t))
        starts.append(starts[-1] + len(t))
    return tuple(map(float, np.concatenate(nodes))), tuple(map(float, np.concatenate(weights))), tuple(starts)


TANH_SINH_NODES, TANH_SINH_WEIGHTS, TANH_SINH_STARTS = tanh_sinh()
RAY_TOLERANCE = 1e-8  # relative error of the integral along a ray above which the next rule follows
NOTHING = 1e-300
HALVINGS = 64


def root_between(low: float, high: float, a: float, b: float, c: float, d: float) -> float:
    """Where a + b r + c r^2 + d r^3 changes its sign between two points; infinite if it does not."""
    below = a + low * (b + low * (c + low * d))
    above = a + high * (b + high * (c + high * d))
    if not (low < high and (below < 0.0) != (above < 0.0)):
        return inf
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if (a + middle * (b + middle * (c + middle * d)) < 0.0) == (below < 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def quadratic(a: float, b: float, c: float) -> tuple[float, float]:
    """The roots of a + b r + c r^2 without cancellation; infinite or NaN where there are none."""
    discriminant = b * b - 4.0 * a * c
    if discriminant < 0.0:
        return inf, inf
    q = -0.5 * (b + (sqrt(discriminant) if b >= 0.0 else -sqrt(discriminant)))
    return (a / q if q != 0.0 else inf), (q / c if c != 0.0 else inf)


class AlbedoParameters(NamedTuple):
    """Parameters of distribution, masking and reflectance, and of the quadrature over slopes.

    reach: the largest slope in units of the slope scale. critical: the square of the critical cosine. first, levels: index of
    the first rule along a ray that may be the last one, and the number of rules. bright: see `bright_light`.
    """

    ndf: Any
    model: Any
    fresnel: Any
    scale_x: float
    scale_y: float
    reach: float
    critical: float
    first: int
    levels: int
    bright: int


class Ray(NamedTuple):
    """A ray in slope space. dx, dy: slopes per radius. lean: slope towards the view over cot theta_o, per radius. square:
    dx^2 + dy^2. rim: the radius at the edge of the disc of facets that reflect light from above the horizon."""

    dx: float
    dy: float
    lean: float
    square: float
    rim: float


def cavity_creases(ray: Ray, wo: Vector, p: AlbedoParameters) -> Any:
    """Where 2 m_z o_z = o.m, where 2 m_z i_z = o.m, and where o_z = i_z."""
    lean, square = ray.lean, ray.square
    shadowed = root_between(0.0, ray.rim, -1.0, 3.0 * lean, 3.0 * square, -lean * square)
    return (-1.0 / lean if lean != 0.0 else inf), -lean / square, shadowed, inf, inf


def bright_light(ray: Ray, wo: Vector, p: AlbedoParameters) -> Any:
    """Where rough surfaces mask light least: where the ray comes nearest to the facet that reflects the zenith, and, for
    unequal roughness, where light comes along the axis of the smaller. Of these p.bright counts none (0), the first (1) or
    all (2)."""
    (ox, oy, oz), lean, square = wo, ray.lean, ray.square
    wide = p.scale_y > p.scale_x
    d, t = (ray.dy, oy / oz) if wide else (ray.dx, ox / oz)
    first, second = quadratic(t, 2.0 * d, t * square - 2.0 * lean * d)
    zenith = -lean * oz / ((1.0 + oz) * square)
    unequal = p.bright > 1
    return zenith if p.bright > 0 else inf, first if unequal else inf, second if unequal else inf, inf, inf


def equals(ray: Ray, wo: Vector, p: AlbedoParameters) -> Any:
    """Where light comes along the axis of the smaller roughness, and where Smith's Lambda of light and viewer is equal."""
    _, first, second, _, _ = bright_light(ray, wo, p)
    lean, square, rim = ray.lean, ray.square, ray.rim
    tx, ty = p.scale_x * wo[0] / wo[2], p.scale_y * wo[1] / wo[2]
    px, py = -2.0 * p.scale_x * ray.dx, -2.0 * p.scale_y * ray.dy
    qx, qy = -lean * px - tx * square, -lean * py - ty * square
    tt = tx * tx + ty * ty
    a = 4.0 * lean * tt - 2.0 * (tx * px + ty * py)
    b = px * px + py * py - 2.0 * (tx * qx + ty * qy) - tt * (4.0 * lean * lean - 2.0 * square)
    c = 2.0 * (px * qx + py * qy) - 4.0 * tt * lean * square
    e = qx * qx + qy * qy - tt * square * square
    extremum_1, extremum_2 = quadratic(b, 2.0 * c, 3.0 * e)
    low, high = min(extremum_1, extremum_2), max(extremum_1, extremum_2)
    low = min(max(low, 0.0), rim) if low < inf else 0.0
    high = min(max(high, low), rim) if high < inf else rim
    one, two = root_between(0.0, low, a, b, c, e), root_between(low, high, a, b, c, e)
    return first, second, one, two, root_between(high, rim, a, b, c, e)


@cache
def light_rule(
    D: Callable[..., float], Lambda: Callable[..., float], G2: Callable[..., float], F: Callable[..., float]
) -> Callable[..., float]:
    """The light that facets of one slope reflect to the viewer, per angle of their ray and angle of the radius."""

    def light(r: float, ray: Ray, Lambda_o: float, wo: Vector, p: AlbedoParameters) -> float:
        front_facing, above_horizon = 1.0 - r * ray.lean, (1.0 - r / ray.rim) * (1.0 + r * ray.square * ray.rim)
        if not (front_facing > 0.0 and above_horizon > 0.0):
            return 0.0
        (ox, oy, oz), mz = wo, 1.0 / sqrt(1.0 + r * r * ray.square)
        mx, my = -r * ray.dx * mz, -r * ray.dy * mz
        cosine = min(oz * mz * front_facing, 1.0)
        wi = (2.0 * cosine * mx - ox, 2.0 * cosine * my - oy, min(oz * mz * mz * above_horizon, 1.0))
        wm = (mx, my, mz)
        visibility = G2(Lambda_o, Lambda(wi, p), wo, wi, wm, p)
        density = D(wm, p.ndf) * ((mz * mz) * (mz * mz))
        return F(cosine, p.fresnel) * visibility * front_facing * density * r * (1.0 + r * r)

    return light


@cache
def piece_rule(*parts: Callable[..., float]) -> Callable[..., Pair]:
    """The integral along a ray between two cuts, where the radius is the tangent of an angle, and its error.

    Nodes are added until two rules agree. before: the integral up to the beginning of the piece.
    """
    light = light_rule(*parts)

    def piece(start: float, stop: float, before: float, ray: Ray, Lambda_o: float, wo: Vector, p: AlbedoParameters) -> Pair:
        rule, error = 0.0, 0.0
        for level in range(p.levels):
            coarse, rule = rule, 0.5 * rule
            for k in range(TANH_SINH_STARTS[level], TANH_SINH_STARTS[level + 1]):
                r = tan(start + (stop - start) * TANH_SINH_NODES[k])
                rule += (stop - start) * TANH_SINH_WEIGHTS[k] * light(r, ray, Lambda_o, wo, p)
            error = abs(rule - coarse)
            if level >= p.first and error <= RAY_TOLERANCE * (before + rule):
                break
        return rule, error

    return piece


@cache
def ray_rule(cuts: Callable[..., Any], Lambda: Callable[..., float], *parts: Callable[..., Any]) -> Callable[..., Any]:
    """The integral along one ray per its angle, and its error."""
    piece = piece_rule(*parts)

    def along(azimuth: Pair, wo: Vector, p: AlbedoParameters) -> Pair:
        (ox, oy, oz), dx, dy = wo, p.scale_x * azimuth[0], p.scale_y * azimuth[1]
        lean, square = (dx * ox + dy * oy) / oz, dx * dx + dy * dy
        root = sqrt(lean * lean + square)
        rim = 1.0 / (lean + root) if lean >= 0.0 else (root - lean) / square
        ray, Lambda_o = Ray(dx, dy, lean, square, rim), Lambda(wo, p)
        one, two, three, four, five = cuts(ray, wo, p)
        back, forth = quadratic(oz * oz - p.critical, -2.0 * oz * oz * lean, oz * oz * lean * lean - p.critical * square)
        last = atan(min(rim, p.reach))
        total, error, start = 0.0, 0.0, 0.0
        while start < last:
            stop = last
            for cut in (one, two, three, four, five, back, forth):
                angle = atan(cut) if cut > 0.0 else 0.0
                if start < angle < stop:
                    stop = angle
            part, off = piece(start, stop, total, ray, Lambda_o, wo, p)
            total, error, start = total + part, error + off, stop
        return total * p.scale_x * p.scale_y, error * p.scale_x * p.scale_y

    return along


@cache
def ray_batch(*kernels: Callable[..., Any]) -> Batch:
    """Rays (n, 2), unit vectors of the slopes' plane over the scales, and views (n, 3): integrals and errors (n, 2)."""
    return Batch(ray_rule(*kernels), [2, 3], 2)


# --- all rays ---------------------------------------------------------------------------------------------------------

# abscissae and weights of Kronrod's rule of 15 nodes, and the weights of Gauss's rule of 7 within it. piessens1983
_HALF = np.array(
    [
        *(0.991455371120812639, 0.949107912342758525, 0.864864423359769073, 0.741531185599394440),
        *(0.586087235467691130, 0.405845151377397167, 0.207784955007898468, 0.0),
    ]
)
_KRONROD = np.array(
    [
        *(0.022935322010529225, 0.063092092629978553, 0.104790010322250184, 0.140653259715525919),
        *(0.169004726639267903, 0.190350578064785410, 0.204432940075298892, 0.209482141084727828),
    ]
)
_GAUSS = np.zeros(8)
_GAUSS[1::2] = 0.129484966168869693, 0.279705391489276668, 0.381830050505118945, 0.417959183673469388
KRONROD_NODES = np.concatenate([-_HALF, _HALF[-2::-1]])
KRONROD, GAUSS = (np.concatenate([half, half[-2::-1]]) for half in (_KRONROD, _GAUSS))
CHANGE = 1e-5  # angle within which the integrand changes beside a ray at which the cuts change
NARROWEST = 1e-15  # smallest angle within which the integrand may change
TOLERANCE = 1e-8  # absolute error of an albedo to which panels are refined
ROUNDS = 60
TOGETHER = 256  # views at once
ROUNDING = 1e-13  # of a sum of some 10^4 terms


class Panels(NamedTuple):
    """Panels over the azimuth of rays. view: index of the view. ray: where the panel begins. far: its signed angle. width: the
    angle within which the integrand changes. low, high: ends of its coordinate.

    The angle from that ray is the width times the hyperbolic sine of the coordinate.
    """

    view: np.ndarray
    ray: np.ndarray
    far: np.ndarray
    width: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def subset(self, chosen: Any) -> Panels:
        return Panels(*(field[chosen] for field in self))

    def halves(self) -> Panels:
        middle = (self.low + self.high) / 2
        lower, upper = self._replace(high=middle), self._replace(low=middle)
        return Panels(*(np.concatenate(both) for both in zip(lower, upper, strict=True)))

    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors (n, 15, 2) and the angle per coordinate (n, 15)."""
        half = ((self.high - self.low) / 2)[:, None]
        t = ((self.low + self.high) / 2)[:, None] + half * KRONROD_NODES
        angle = self.width[:, None] * np.sinh(t) * np.sign(self.far)[:, None]
        c, s = np.cos(angle), np.sin(angle)
        u, v = self.ray[:, :1], self.ray[:, 1:]
        return np.stack([c * u - s * v, s * u + c * v], axis=-1), half * self.width[:, None] * np.cosh(t)


def cosines_of_changes(z: np.ndarray, square: float, cavity: bool) -> np.ndarray:
    """Cosines (n, m) of azimuths, relative to the view's, at which the cuts of a ray change; not in [-1, 1] where none does.

    At these the ray touches the cone of total reflection, first on one side, then on the other; it leaves that cone at the edge
    of the disc; or creases of V-cavities meet each other or that edge. square: of the critical cosine.
    """
    sine = np.sqrt((1 - z) * (1 + z))
    with np.errstate(divide="ignore", invalid="ignore"):
        touching = np.sqrt(square - z * z) / sine
        grazing = (2 * square - 1) / sine  # cosine of the azimuth of light at the horizon, where it just meets the cone
        leaving = -(sine + grazing) / np.sqrt(sine**2 + 2 * sine * grazing + 1)
        steep = z / sine
        cosines = [touching, -touching, np.where(abs(grazing) <= 1, leaving, np.nan)]
        return np.stack([*cosines, *([steep, -steep, -steep / np.sqrt(3)] if cavity else [])], axis=-1)


def rays_of_changes(views: np.ndarray, scale: tuple[float, float], cosines: np.ndarray, side: float) -> np.ndarray:
    """The rays (n, m, 2) at these azimuths on one side of the view, 1 or -1; NaN where there is none."""
    x, y = views[:, :1], views[:, 1:2]
    with np.errstate(invalid="ignore"):
        sines = side * np.sqrt((1 - cosines) * (1 + cosines))
        return _unit(np.stack([(cosines * x - sines * y) / scale[0], (sines * x + cosines * y) / scale[1]], axis=-1))


def special_rays(
    views: np.ndarray, scale: tuple[float, float], mirrored: bool, changes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rays (n, m, 2) near which the integral along a ray may change fast, sorted, and the angles within which it does: (n, m).

    They are the ray along the edge of the disc, the ray to the facet that reflects the zenith, the axis of the smaller alpha,
    and the rays at which the cuts change, given by the cosines of their azimuths. mirrored: whether the integrand is symmetric
    about the plane of incidence, so that one side suffices.
    """
    x, y, z = views.T
    towards = np.stack([scale[0] * x, scale[1] * y], axis=-1)
    level = ~towards.any(axis=1)
    towards[level] = [1.0, 0.0]
    across = np.stack([-towards[:, 1], towards[:, 0]], axis=-1)
    plane = np.stack([scale[1] * x, scale[0] * y], axis=-1)  # of the view, divided by the scales
    plane[level] = [1.0, 0.0]
    with np.errstate(divide="ignore", over="ignore"):
        edge = z * np.hypot(scale[0] * across[:, 0], scale[1] * across[:, 1]) / (towards**2).sum(axis=1)
        tip = np.hypot(plane[:, 1] / scale[0] ** 2, plane[:, 0] / scale[1] ** 2)
        tip *= (1 + z) * scale[0] * scale[1] / (plane**2).sum(axis=1)
    edge[level], tip[level] = 1.0, 1.0
    narrow, wide = ([1.0, 0.0], [0.0, 1.0]) if scale[0] < scale[1] else ([0.0, 1.0], [1.0, 0.0])
    one = np.ones(len(views))
    if mirrored:
        rays, widths = np.stack([towards, across, -towards], axis=1), np.stack([one, edge, tip], axis=1)
    else:
        rays = np.stack([across, plane, *(np.broadcast_to(axis, plane.shape) for axis in (narrow, wide))], axis=1)
        widths = np.stack([edge, tip, one * min(scale) / max(scale), one], axis=1)
        rays, widths = np.concatenate([rays, -rays], axis=1), np.concatenate([widths, widths], axis=1)
    beside = [rays_of_changes(views, scale, changes, side) for side in ((1,) if mirrored else (1, -1))]
    rays = np.concatenate([_unit(rays), *beside], axis=1)
    missing = ~np.isfinite(rays).all(axis=-1)
    rays[missing] = np.broadcast_to(rays[:, :1], rays.shape)[missing]
    widths = np.concatenate([widths, *(np.full(part.shape[:2], CHANGE) for part in beside)], axis=1)
    widths[missing] = np.broadcast_to(widths[:, :1], widths.shape)[missing]
    return _in_order(rays, widths, _unit(towards[:, None]) if mirrored else None)


def _in_order(rays: np.ndarray, widths: np.ndarray, start: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Sorted by angle: over half a circle from the start, or over a whole circle, whose last ray is the first."""
    u, v = rays[..., 0], rays[..., 1]
    if start is None:
        order = np.argsort(np.arctan2(v, u), axis=1)
        order = np.concatenate([order, order[:, :1]], axis=1)
    else:
        a, b = start[..., 0], start[..., 1]
        order = np.argsort(abs(np.arctan2(a * v - b * u, a * u + b * v)), axis=1)
    return np.take_along_axis(rays, order[..., None], axis=1), np.take_along_axis(widths, order, axis=1)


def _unit(rays: np.ndarray) -> np.ndarray:
    return np.asarray(rays / np.hypot(rays[..., 0], rays[..., 1])[..., None])


def narrowed(widths: np.ndarray, angles: np.ndarray, mirrored: bool) -> np.ndarray:
    """Widths limited so that none exceeds the sum of a neighbour's width and the angle to it.

    angles: between neighbours. If not mirrored, the last ray is the first."""
    result, count = widths.copy(), angles.shape[1]
    for _ in range(1 if mirrored else 2):
        if not mirrored:
            result[:, 0] = result[:, -1] = np.minimum(result[:, 0], result[:, -1])
        for k in range(count):
            np.minimum(result[:, k + 1], result[:, k] + angles[:, k], out=result[:, k + 1])
        for k in range(count, 0, -1):
            np.minimum(result[:, k - 1], result[:, k] + angles[:, k - 1], out=result[:, k - 1])
    return result


def first_panels(views: np.ndarray, scale: tuple[float, float], mirrored: bool, halvings: int, changes: np.ndarray) -> Panels:
    """Panels from each special ray to the middle between it and its neighbours."""
    rays, widths = special_rays(views, scale, mirrored, changes)
    a, b = rays[:, :-1], rays[:, 1:]
    half_angles = np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(axis=-1)) / 2
    widths = narrowed(widths, 2 * abs(half_angles), mirrored)
    view = np.broadcast_to(np.arange(len(views))[:, None], half_angles.shape)
    distinct = np.concatenate([(half_angles > 0).ravel()] * 2)
    view = np.concatenate([view.ravel()] * 2)[distinct]
    far = np.concatenate([half_angles.ravel(), -half_angles.ravel()])[distinct]
    width = np.concatenate([widths[:, :-1].ravel(), widths[:, 1:].ravel()])[distinct].clip(NARROWEST, 1)
    ray = np.concatenate([a.reshape(-1, 2), b.reshape(-1, 2)])[distinct]
    panels = Panels(view, ray, far, width, np.zeros(len(far)), np.arcsinh(abs(far) / width))
    for _ in range(halvings):
        panels = panels.halves()
    return panels


class Sums(NamedTuple):
    """For each panel its integral, the error of the rule over the angle, which refinement reduces, and that of the rays."""

    value: np.ndarray
    error: np.ndarray
    within: np.ndarray


def summed(batch: Batch, parameters: Any, views: np.ndarray, panels: Panels, power: float) -> Sums:
    """By the Gauss-Kronrod rule, with QUADPACK's estimate of the error if the power is 1.5; errors of the rays are added up."""
    rays, jacobian = panels.rays()
    values, errors = np.moveaxis(batch([rays, views[panels.view][:, None]], parameters), -1, 0) * jacobian
    value, within = values @ KRONROD, errors @ KRONROD
    difference = abs(values @ (KRONROD - GAUSS))
    variation = abs(values - value[:, None] / 2) @ KRONROD + NOTHING
    return Sums(value, variation * np.minimum(1, 2000 * difference / variation) ** power, within)


# --- all views --------------------------------------------------------------------------------------------------------


class Effort(NamedTuple):
    """Settings of the quadrature, which depend on how much is known of a model.

    levels: of rules along a ray, the first that may be the last, and their number. power: of the difference of two rules over
    the angle, 1.5 for functions that are smooth between cuts. halvings: of the first panels. most: number of rays of one view
    after which the refinement ends. safety: factor from the sum of estimated errors to the bound, chosen so that the bound
    holds in random cases.
    """

    levels: tuple[int, int]
    power: float
    halvings: int
    most: int
    safety: float


KNOWN = Effort((2, LEVELS), 1.5, 1, 30000, 30.0)
UNKNOWN = Effort((2, 5), 1.0, 1, 3000, 3.0)


class Reflected(NamedTuple):
    """Fractions of light that are reflected, and bounds of their errors, for views (..., 3), by kernels and their parameters.

    mirrored: whether the integrand is symmetric about the plane of incidence.
    """

    kernels: tuple[Callable[..., Any], ...]
    parameters: AlbedoParameters
    effort: Effort
    mirrored: bool

    def __call__(self, wo: Any) -> tuple[Any, Any]:
        wo = as_vectors("wo", wo)
        views = wo.reshape(-1, 3).astype(np.float64)
        above = np.flatnonzero(views[:, 2] > 0)
        results = np.zeros((2, len(views)))
        for k in range(0, len(above), TOGETHER):
            chunk = above[k : k + TOGETHER]
            results[:, chunk] = self._over_rays(views[chunk])
        results[1] += (ROUNDING + np.finfo(wo.dtype).eps) * results[0]
        value, error = results.astype(wo.dtype).reshape(2, *wo.shape[:-1])
        return value[()], error[()]

    def _over_rays(self, views: np.ndarray) -> np.ndarray:
        """Values and errors (2, n): panels are halved until their errors add up to the tolerance."""
        batch, count, effort = ray_batch(*self.kernels), len(views), self.effort
        scale = (self.parameters.scale_x, self.parameters.scale_y)
        changes = cosines_of_changes(views[:, 2], self.parameters.critical, self.kernels[0] is cavity_creases)
        panels = first_panels(views, scale, self.mirrored, effort.halvings, changes)
        sums = summed(batch, self.parameters, views, panels, effort.power)
        rays = len(KRONROD_NODES) * np.bincount(panels.view, minlength=count)
        for _ in range(ROUNDS):
            goal = TOLERANCE * np.bincount(panels.view, sums.value, count) / np.bincount(panels.view, minlength=count)
            split = (sums.error > goal[panels.view]) & (rays < effort.most)[panels.view]
            if not split.any():
                break
            children = panels.subset(split).halves()
            child_sums = summed(batch, self.parameters, views, children, effort.power)
            rays += len(KRONROD_NODES) * np.bincount(children.view, minlength=count)
            panels, sums = _joined(panels.subset(~split), children), _joined(Sums(*(a[~split] for a in sums)), child_sums)
        value, error, within = (np.bincount(panels.view, part, count) for part in sums)
        return (2 if self.mirrored else 1) * np.stack([value, self.effort.safety * (error + within)])


def _joined(first: Any, second: Any) -> Any:
    return type(first)(*(np.concatenate(both) for both in zip(first, second, strict=True)))


BY_AZIMUTH = tuple(G2_of_facet(G2_BY_CORRELATION[name]) for name in ("direction", "height-direction"))
CAVITIES = G2_of_facet(VCavity.G2_kernel)
MODELS = (
    *map(G2_of_facet, G2_BY_CORRELATION.values()),
    *(G2_of_facet(kind.G2_kernel) for kind in (VCavity, Implicit, Kelemen, SchlickSmith)),
)
INDICES = (Dielectric.kernel, Conductor.kernel)
ROUGH = 0.5  # slope scale from which on light from the zenith is shadowed so much less than other light that a ray is cut there
UNEQUAL = 2.0  # ratio of slope scales, likewise for light along the axis of the smaller one
NEVER = 4.0  # square of a cosine that does not occur


def reflected_fraction(model: Masking, fresnel: Fresnel) -> Reflected:
    """The same result for equal models. The settings depend on the kernels, not on the class: a subclass may change them."""
    ndf, kind = model.ndf, type(fresnel)
    parts = (type(ndf).kernel, model.Lambda_kernel, model.G2_of_facet, kind.kernel)
    familiar, masked = type(ndf).regular, model.G2_of_facet in MODELS and Lambda_as_usual(model)
    effort = KNOWN if familiar and masked and kind.regular else UNKNOWN
    (first, levels), (scale_x, scale_y) = map(Count, effort.levels), ndf.slope_scale
    rule = (scale_x, scale_y, ndf.reach, critical(fresnel), first, levels, Count(bright(ndf.slope_scale)))
    parameters = AlbedoParameters(model.parameters.ndf, model.parameters.model, fresnel.parameters, *rule)
    return Reflected((cuts_of(model), model.Lambda_kernel, *parts), parameters, effort, ndf.isotropic and familiar and masked)


def Lambda_as_usual(model: Masking) -> bool:
    """Whether Lambda is that of one of the library's models: none, or Smith's."""
    return model.Lambda_kernel in (no_Lambda, Lambda_of(model.ndf))


def cuts_of(model: Masking) -> Callable[..., float]:
    """The kernel of the radii at which a ray is cut."""
    if model.G2_of_facet is CAVITIES:
        return cavity_creases
    return equals if model.G2_of_facet in BY_AZIMUTH else bright_light


def bright(scale: tuple[float, float]) -> int:
    """Which cuts of `bright_light` matter: 0 none, 1 the zenith, 2 all."""
    low, high = sorted(scale)
    return 2 if high > UNEQUAL * low else int(high > ROUGH)


def critical(fresnel: Fresnel) -> float:
    """The square of the cosine beyond which reflection is total, or would be but for absorption."""
    index, absorption = (*fresnel.parameters, 0.0)[:2] if type(fresnel).kernel in INDICES else (2.0, 0.0)
    square = 1 - (index - absorption) * (index + absorption)
    return square if 0 < square < 1 else NEVER
