"""Ways to draw visible normals for the same uniform numbers, in large arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import microfacet as mf
import numpy as np
from microfacet.compiler.batch import Batch
from microfacet.directions import spherical
from scipy import special

from benchmarks.method import ALPHA, LONG, Method, directions, uniform

SAMPLED = mf.Smith(mf.GGX(*ALPHA))
GAUSSIAN = mf.Smith(mf.Beckmann(*ALPHA))
SAMPLE_SIZES = (10**6, 4 * 10**6)


def caps_numpy(wo: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Spherical caps in whole arrays."""
    scale = np.array([*ALPHA, 1], wo.dtype)
    v = wo * scale
    v = v / np.sqrt(np.sum(v * v, -1))[:, None]
    above = (1 - u[:, 1]) * (1 + v[:, 2])
    radius = np.sqrt((above + (v[:, 0] ** 2 + v[:, 1] ** 2) / (1 + v[:, 2])) * u[:, 1] * (1 + v[:, 2]))
    turn = 2 * wo.dtype.type(_PI) * u[:, 0]
    m = np.stack([radius * np.cos(turn) + v[:, 0], radius * np.sin(turn) + v[:, 1], above], -1) * scale
    return np.asarray(m / np.sqrt(np.sum(m * m, -1))[:, None])


_PI = LONG("3.14159265358979323846264338327950288")


def library_samples(wo: np.ndarray, u: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    return np.asarray(SAMPLED.sample_visible(wo, u, out))


def gaussian_samples(wo: np.ndarray, u: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    return np.asarray(GAUSSIAN.sample_visible(wo, u, out))


def misplaced(wo: np.ndarray, u: np.ndarray, m: np.ndarray) -> float:
    """Largest distance of the visible share of Beckmann slopes along the view, below the one drawn, from its number."""
    seen = wo[:, :2] * ALPHA
    length = np.hypot(*seen.T)
    q, a = -np.sum(m[:, :2] / ALPHA * seen, -1) / length / m[:, 2], wo[:, 2] / length

    def share(x: np.ndarray) -> np.ndarray:
        return np.asarray(0.5 * a * special.erfc(-x) + 0.5 * np.exp(-x * x) / np.sqrt(np.pi))

    return float(np.max(np.abs(share(q) / share(a) - u[:, 0])))


def _gaussian_error(real: type) -> float:
    """Seen along x, from four angles."""
    theta = np.radians(np.repeat([10.0, 45.0, 80.0, 89.0], 100)).astype(real)
    u = np.stack([np.random.default_rng(5).uniform(0.001, 0.999, 400), np.full(400, 0.5)], -1).astype(real)
    wo = spherical(theta).astype(real)
    return misplaced(wo.astype(float), u.astype(float), np.asarray(gaussian_samples(wo, u), np.float64))


def _caps_error(method: Callable[..., Any], real: type) -> float:
    """Largest distance of a normal from where the same numbers send it in extended precision."""
    wo, u = directions(4000, 7, real), uniform(4000, 8, real)
    exact = caps_numpy(wo.astype(LONG), u.astype(LONG))
    return float(np.max(np.sqrt(np.sum((np.asarray(method(wo, u), LONG) - exact) ** 2, -1))))


def _samples(label: str, method: Callable[..., Any], real: type, error: Callable[[], float], code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        wo, u = directions(size, 5, real), uniform(size, 6, real)
        if method is caps_numpy:
            return lambda: method(wo, u)
        out = np.empty_like(wo)  # as the loops in C++ have it: fresh memory costs as much as a sample of GGX
        return lambda: method(wo, u, out)

    return Method(label, prepare, lambda size: error(), SAMPLE_SIZES, code, kind=label.split(",")[0])


def _loop_of(model: Any) -> Batch:
    from microfacet.visibility.masking import _sampling

    return _sampling(model.sampler)


METHODS = {
    "plain": _samples("GGX, NumPy, double", caps_numpy, np.float64, lambda: _caps_error(caps_numpy, np.float64), (caps_numpy,)),
    "library": _samples(
        "GGX, this library, double",
        library_samples,
        np.float64,
        lambda: _caps_error(library_samples, np.float64),
        (_loop_of(SAMPLED),),
    ),
    "library_single": _samples(
        "GGX, this library, single",
        library_samples,
        np.float32,
        lambda: _caps_error(library_samples, np.float32),
        (_loop_of(SAMPLED),),
    ),
    "beckmann": _samples(
        "Beckmann, this library, double",
        gaussian_samples,
        np.float64,
        lambda: _gaussian_error(np.float64),
        (_loop_of(GAUSSIAN),),
    ),
    "beckmann_single": _samples(
        "Beckmann, this library, single",
        gaussian_samples,
        np.float32,
        lambda: _gaussian_error(np.float32),
        (_loop_of(GAUSSIAN),),
    ),
}
