"""Ways to draw a light direction and what it weighs: one sample of the sums that a renderer takes.

Each draws a facet's normal and mirrors the view by it. What it draws from is a density of normals; how far it is from that
density is found from the sampler itself, by difference quotients, whatever is inside it. All are compiled alike, in double
precision, and share the weight's formula, so that they differ in how they draw and in nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import atan, erf, erfc, exp, log, sqrt
from typing import Any

import microfacet as mf
import numpy as np
from microfacet.arithmetic import cosine_and_sine
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Pair, Vector
from microfacet.directions import spherical
from microfacet.geometry.slopes import Distribution
from microfacet.geometry.visible_normals import unstretched
from microfacet.visibility.masking import ModelParameters, dot

from benchmarks.method import ALPHA, Method, directions, uniform

SQRT_PI = 1.7724538509055161
STRAIGHT = 1e-9  # below this sine the view is taken to be vertical
ENOUGH, STEPS = 1e-5, 10  # the error of the share at which jakob2014 stops, and its largest number of steps

# --- normals: kernels of a view, two uniform numbers and a model's parameters -------------------------------------------------


def upright(slope_x: float, slope_y: float) -> Vector:
    z = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return -slope_x * z, -slope_y * z, z


def stretched_back(x: float, y: float, z: float, alpha_x: float, alpha_y: float) -> Vector:
    scale = 1.0 / sqrt(alpha_x * x * alpha_x * x + alpha_y * y * alpha_y * y + z * z)
    return scale * alpha_x * x, scale * alpha_y * y, scale * z


def turned_back(along: float, across: float, vx: float, vy: float, alpha_x: float, alpha_y: float) -> Vector:
    """The normal of slopes of unit roughness along and across the view."""
    vs = sqrt(vx * vx + vy * vy)
    c = vx / vs if vs > STRAIGHT else 1.0
    s = vy / vs if vs > STRAIGHT else 0.0
    return upright(alpha_x * (c * along - s * across), alpha_y * (s * along + c * across))


def ggx_normals(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
    """Normals by their area, whoever looks."""
    (u1, u2), alpha_x, alpha_y = u, p.ndf.alpha_x, p.ndf.alpha_y
    r = sqrt(u1 / (1.0 - u1))
    c, s = cosine_and_sine(u2)
    return upright(alpha_x * r * c, alpha_y * r * s)


def beckmann_normals(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
    (u1, u2), alpha_x, alpha_y = u, p.ndf.alpha_x, p.ndf.alpha_y
    r = sqrt(-log(1.0 - u1))
    c, s = cosine_and_sine(u2)
    return upright(alpha_x * r * c, alpha_y * r * s)


def heitz_d_eon(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
    """heitzdeon2014: the slope along the view in closed form, the one across by a rational fit."""
    (u1, u2), alpha_x, alpha_y = u, p.ndf.alpha_x, p.ndf.alpha_y
    vx, vy, vz = unstretched(wo, p.ndf)
    vs = sqrt(vx * vx + vy * vy)
    if vs < STRAIGHT:
        return ggx_normals(wo, u, p)
    tangent = vs / vz
    share = u1 * (1.0 + sqrt(1.0 + tangent * tangent)) - 1.0
    inverse = 1.0 / (share * share - 1.0)
    root = sqrt(max(tangent * tangent * inverse * inverse - (share * share - tangent * tangent) * inverse, 0.0))
    first, second = tangent * inverse - root, tangent * inverse + root
    along = first if share < 0.0 or second * tangent > 1.0 else second
    sign = 1.0 if u2 > 0.5 else -1.0
    v = 2.0 * abs(u2 - 0.5)
    above = v * (v * (v * 0.27385 - 0.73369) + 0.46341)
    across = sign * above / (v * (v * (v * 0.093073 + 0.309420) - 1.0) + 0.597999) * sqrt(1.0 + along * along)
    return turned_back(along, across, vx, vy, alpha_x, alpha_y)


def disk(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
    """heitz2018: a point of the disk that the viewer sees of a hemisphere."""
    (u1, u2), alpha_x, alpha_y = u, p.ndf.alpha_x, p.ndf.alpha_y
    vx, vy, vz = unstretched(wo, p.ndf)
    vs = sqrt(vx * vx + vy * vy)
    c = vx / vs if vs > STRAIGHT else 1.0
    s = vy / vs if vs > STRAIGHT else 0.0
    r = sqrt(u1)
    cosine, sine = cosine_and_sine(u2)
    first, half = r * cosine, 0.5 * (1.0 + vz)
    second = (1.0 - half) * sqrt(1.0 - first * first) + half * r * sine
    rest = 1.0 - first * first - second * second
    third = sqrt(rest if rest > 0.0 else 0.0)
    x, y = -s * first - vz * c * second + third * vx, c * first - vz * s * second + third * vy
    z = vs * second + third * vz
    return stretched_back(x, y, z if z > 0.0 else 0.0, alpha_x, alpha_y)


def bound(wo: Vector, alpha_x: float, alpha_y: float) -> float:
    """etotokuyoshi2023: what the cap's lower rim is multiplied by, so that less light is sent below the horizon."""
    a = alpha_x if alpha_x < alpha_y else alpha_y
    a = a if a < 1.0 else 1.0
    s = 1.0 + sqrt(wo[0] * wo[0] + wo[1] * wo[1])
    return (1.0 - a * a) * s * s / (s * s + a * a * wo[2] * wo[2])


def bounded(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
    """etotokuyoshi2023: a spherical cap without most of the part whose mirror directions lie below the horizon."""
    (u1, u2), alpha_x, alpha_y = u, p.ndf.alpha_x, p.ndf.alpha_y
    vx, vy, vz = unstretched(wo, p.ndf)
    rim = bound(wo, alpha_x, alpha_y) * vz
    below = u2 * (1.0 + rim)
    radius = sqrt(below * (2.0 - below))
    c, s = cosine_and_sine(u1)
    return stretched_back(radius * c + vx, radius * s + vy, (1.0 - below) + vz, alpha_x, alpha_y)


def inverse_erf(x: float) -> float:
    """giles2012: in single precision's accuracy, as renderers have it."""
    w = -log((1.0 - x) * (1.0 + x))
    if w < 5.0:
        w = w - 2.5
        p = 2.81022636e-08 * w + 3.43273939e-07
        p = ((p * w - 3.5233877e-06) * w - 4.39150654e-06) * w + 0.00021858087
        return x * ((((p * w - 0.00125372503) * w - 0.00417768164) * w + 0.246640727) * w + 1.50140941)
    w = sqrt(w) - 3.0
    p = -0.000200214257 * w + 0.000100950558
    p = ((p * w + 0.00134934322) * w - 0.00367342844) * w + 0.00573950773
    return x * ((((p * w - 0.0076224613) * w + 0.00943887047) * w + 1.00167406) * w + 2.83297682)


def slope_by_erf(vs: float, vz: float, theta: float, u: float) -> float:
    """jakob2014: Newton's steps for the error function of the slope along the view, until the share is right to 1e-5."""
    cot, tangent = vz / vs, vs / vz
    low, high = -1.0, erf(cot)
    norm = 1.0 / (2.0 - erfc(cot) + tangent * exp(-cot * cot) / SQRT_PI)
    fit = 1.0 + theta * (-0.876 + theta * (0.4265 - 0.0594 * theta))
    b = high - (1.0 + high) * exp(fit * log(1.0 - u))
    for _ in range(STEPS):
        if not (low <= b and b <= high):
            b = 0.5 * (low + high)
        slope = inverse_erf(b)
        excess = norm * (1.0 + b + tangent * exp(-slope * slope) / SQRT_PI) - u
        if abs(excess) < ENOUGH:
            return slope
        if excess > 0.0:
            high = b
        else:
            low = b
        b = b - excess / (norm * (1.0 - slope * tangent))
    return inverse_erf(b)


def jakob(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
    (u1, u2), alpha_x, alpha_y = u, p.ndf.alpha_x, p.ndf.alpha_y
    vx, vy, vz = unstretched(wo, p.ndf)
    vs = sqrt(vx * vx + vy * vy)
    if vs < STRAIGHT:
        return beckmann_normals(wo, u, p)
    along = slope_by_erf(vs, vz, atan(vs / vz), u1)
    return turned_back(along, inverse_erf(2.0 * u2 - 1.0), vx, vy, alpha_x, alpha_y)


# --- what a sample weighs ---------------------------------------------------------------------------------------------------


def by_area(cosine: float, wm: Vector, wo: Vector, Lambda_o: float, Lambda_i: float, p: ModelParameters) -> float:
    return cosine / (wo[2] * wm[2] * (1.0 + Lambda_o + Lambda_i))


def by_view(cosine: float, wm: Vector, wo: Vector, Lambda_o: float, Lambda_i: float, p: ModelParameters) -> float:
    return (1.0 + Lambda_o) / (1.0 + Lambda_o + Lambda_i)


def by_bound(cosine: float, wm: Vector, wo: Vector, Lambda_o: float, Lambda_i: float, p: ModelParameters) -> float:
    k = bound(wo, p.ndf.alpha_x, p.ndf.alpha_y)
    return (1.0 + k / (1.0 + 2.0 * Lambda_o)) * (0.5 + Lambda_o) / (1.0 + Lambda_o + Lambda_i)


@dataclass(frozen=True)
class Sampler:
    """A sampler of normals, its distribution, the weight of a sample, and the density that it should have."""

    label: str
    ndf: type[Distribution]
    draw: Callable[..., Vector]
    weigh: Callable[..., float]
    density: Callable[[mf.Smith, np.ndarray, np.ndarray], np.ndarray]

    def model(self, *alpha: float) -> mf.Smith:
        return mf.Smith(self.ndf(*alpha))


def area_density(model: mf.Smith, wo: np.ndarray, wm: np.ndarray) -> np.ndarray:
    return np.asarray(model.ndf.pdf(wm))


def visible_density(model: mf.Smith, wo: np.ndarray, wm: np.ndarray) -> np.ndarray:
    return np.asarray(model.D_visible(wo, wm))


def bounded_density(model: mf.Smith, wo: np.ndarray, wm: np.ndarray) -> np.ndarray:
    ax, ay = model.ndf.slope_scale
    k = np.array([bound(tuple(w), ax, ay) for w in wo.reshape(-1, 3).tolist()]).reshape(wo.shape[:-1])
    length = np.sqrt((ax * wo[..., 0]) ** 2 + (ay * wo[..., 1]) ** 2 + wo[..., 2] ** 2)
    return np.asarray(2 * np.sum(wo * wm, -1) * model.ndf.D(wm) / (k * wo[..., 2] + length))


def of_library(ndf: type[Distribution]) -> Callable[..., Vector]:
    """The library's own sampler of visible normals."""
    drawn = mf.Smith(ndf(*ALPHA)).sampler
    assert drawn is not None
    return drawn


SAMPLERS = {
    "normals": Sampler("all normals", mf.GGX, ggx_normals, by_area, area_density),
    "heitz_d_eon": Sampler("Heitz and d'Eon 2014", mf.GGX, heitz_d_eon, by_view, visible_density),
    "disk": Sampler("Heitz 2018", mf.GGX, disk, by_view, visible_density),
    "caps": Sampler("spherical caps 2023 (library)", mf.GGX, of_library(mf.GGX), by_view, visible_density),
    "bounded": Sampler("bounded caps 2023", mf.GGX, bounded, by_bound, bounded_density),
    "beckmann_normals": Sampler("all normals", mf.Beckmann, beckmann_normals, by_area, area_density),
    "beckmann_jakob": Sampler("Jakob 2014", mf.Beckmann, jakob, by_view, visible_density),
    "beckmann_library": Sampler("library", mf.Beckmann, of_library(mf.Beckmann), by_view, visible_density),
}


@cache
def estimate(draw: Callable[..., Vector], weigh: Callable[..., float], Lambda: Callable[..., float]) -> Callable[..., Any]:
    """The kernel of one sample: a light direction and its weight, 0 below the horizon."""

    def estimated(wo: Vector, u: Pair, p: ModelParameters) -> tuple[float, float, float, float]:
        wm = draw(wo, u, p)
        cosine = dot(wo, wm)
        wi = (2.0 * cosine * wm[0] - wo[0], 2.0 * cosine * wm[1] - wo[1], 2.0 * cosine * wm[2] - wo[2])
        if not (cosine > 0.0 and wi[2] > 0.0):
            return wi[0], wi[1], wi[2], 0.0
        return wi[0], wi[1], wi[2], weigh(cosine, wm, wo, Lambda(wo, p.ndf), Lambda(wi, p.ndf), p)

    return estimated


def kernel_of(sampler: Sampler) -> Callable[..., Any]:
    Lambda = sampler.ndf.closed_Lambda
    assert Lambda is not None
    return estimate(sampler.draw, sampler.weigh, Lambda)


@cache
def estimates(sampler: Sampler) -> Batch:
    """Light directions and weights (n, 4), from views (n, 3) and uniform numbers (n, 2)."""
    return Batch(kernel_of(sampler), [3, 2], 4)


@cache
def normals(sampler: Sampler) -> Batch:
    return Batch(sampler.draw, [3, 2], 3)


# --- how good it is ---------------------------------------------------------------------------------------------------------

VIEW_ANGLES = np.radians([20.0, 50.0, 75.0, 87.0])
CELLS = 48  # along each of the uniform numbers
STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
STEP = 1e-3  # of the distance to the nearer end


def apart(sampler: Sampler) -> float:
    """Largest total variation, over some views, between the sampled density and the one claimed.

    The sampled density is 1 / |dm/du1 x dm/du2|, by difference quotients, over the square of the uniform numbers.
    """
    u = np.stack(np.meshgrid(*2 * [(np.arange(CELLS) + 0.5) / CELLS]), -1).reshape(-1, 2)
    model, loop = sampler.model(*ALPHA), normals(sampler)
    return max(_apart(model, loop, sampler, spherical(theta, 0.3), u) for theta in VIEW_ANGLES)


def _apart(model: mf.Smith, loop: Batch, sampler: Sampler, wo: np.ndarray, u: np.ndarray) -> float:
    views, rates = np.broadcast_to(wo, (len(u), 3)), []
    for axis in np.eye(2):
        step = STEP * np.minimum(u, 1 - u) @ axis
        moved = [weight * loop([views, u + k * step[:, None] * axis], model.parameters) for k, weight in STENCIL]
        rates.append(np.sum(moved, axis=0) / step[:, None])
    solid_angle = np.linalg.norm(np.cross(*rates), axis=-1)
    claimed = sampler.density(model, views, loop([views, u], model.parameters))
    return float(np.mean(np.abs(claimed * solid_angle - 1)) / 2)


def variance(sampler: Sampler, alpha: float, theta: float, batches: int = 32, each: int = 2**12) -> tuple[float, float]:
    """Variance of one sample of the albedo, and its standard error, from independent batches."""
    model, u = sampler.model(alpha), uniform(batches * each, 11)
    views = np.broadcast_to(spherical(theta), (len(u), 3))
    weights = estimates(sampler)([views, u], model.parameters)[:, 3].reshape(batches, each)
    variances = weights.var(axis=1, ddof=1)
    return float(variances.mean()), float(variances.std(ddof=1) / np.sqrt(batches))


def _method(sampler: Sampler) -> Method:
    model = sampler.model(*ALPHA)

    def prepare(size: int) -> Callable[[], Any]:
        wo, u = directions(size, 5), uniform(size, 6)
        return lambda: estimates(sampler)([wo, u], model.parameters)

    kind = sampler.ndf.__name__
    return Method(f"{kind}, {sampler.label}", prepare, lambda size: apart(sampler), (10**6,), (estimates(sampler),), kind=kind)


METHODS = {name: _method(sampler) for name, sampler in SAMPLERS.items()}
