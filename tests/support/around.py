"""Integrals over normals, on the sphere, in polar coordinates around a direction: the library integrates over slopes.

Around wo the edges of what is seen are coordinate lines: gamma = 90 degrees parts the facets turned to the viewer from
those turned away, and the horizon is a known psi for each gamma.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np


class Patch(NamedTuple):
    """Directions (n, 3) with their weights in solid angle."""

    directions: np.ndarray
    weights: np.ndarray

    def sum(self, values: np.ndarray) -> float:
        return float(np.sum(self.weights * values))


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (nodes + 1) / 2, weights / 2


def _smooth(low: float, high: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes between low and high, quadratic at both ends, where the horizon meets gamma as a square root."""
    t, w = gauss(count)
    return low + (high - low) * t * t * (3 - 2 * t), (high - low) * w * 6 * t * (1 - t)


def _frame(wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two axes across wo, the first towards the zenith."""
    sine = np.hypot(wo[0], wo[1])
    first = np.array([1.0, 0.0, 0.0]) if sine == 0 else (np.array([0, 0, 1]) - wo[2] * wo) / sine
    return first, np.cross(wo, first)


def _patch(wo: np.ndarray, low: float, high: float, count: int) -> Patch:
    """Normals above the horizon with low < gamma < high."""
    sine = np.hypot(wo[0], wo[1])
    gamma, across = _smooth(low, high, count)
    with np.errstate(divide="ignore"):
        reach = np.arccos(np.clip(-wo[2] / (sine * np.tan(gamma)) if sine > 0 else -np.inf, -1, 1)) * np.ones(count)
    t, along = gauss(count)
    psi = reach[:, None] * (2 * t - 1)
    first, second = _frame(wo)
    tangent = np.cos(psi)[..., None] * first + np.sin(psi)[..., None] * second
    m = np.cos(gamma)[:, None, None] * wo + np.sin(gamma)[:, None, None] * tangent
    weights = (across * np.sin(gamma) * 2 * reach)[:, None] * along
    above = m[..., 2] > 0
    return Patch(m[above], weights[above])


def _joined(patches: Iterator[Patch]) -> Patch:
    return Patch(*map(np.concatenate, zip(*patches, strict=True)))


def turned_to(wo: np.ndarray, count: int = 64) -> Patch:
    """The normals above the horizon with wo.wm > 0."""
    theta = np.arctan2(np.hypot(wo[0], wo[1]), wo[2])
    edges = [0.0, *([theta] if 0 < theta < np.pi / 2 - theta else []), np.pi / 2 - theta, np.pi / 2]
    return _joined(_patch(wo, a, b, count) for a, b in pairwise(edges) if b > a)


def turned_away(wo: np.ndarray, count: int = 64) -> Patch:
    """The normals above the horizon with wo.wm < 0."""
    theta = np.arctan2(np.hypot(wo[0], wo[1]), wo[2])
    return _patch(wo, np.pi / 2, np.pi / 2 + theta, count)


def reflected(wo: np.ndarray, density: Callable[[np.ndarray], np.ndarray], count: int = 64) -> float:
    """The integral over the whole sphere of a density of light directions that is 0 where no facet joins them to wo.

    In polar coordinates around wo light has twice the half vector's angle: sin(2 gamma) d(2 gamma) = 4 cos gamma sin gamma.
    """
    m, weights = turned_to(wo, count)
    cosine = m @ wo
    wi = 2 * cosine[:, None] * m - wo
    return float(np.sum(weights * 4 * cosine * density(wi)))


def whole_hemisphere(scale: float, count: int = 100, turns: int = 400) -> Patch:
    """All normals above the horizon: the tangent of the polar angle mapped by its scale, azimuth evenly spaced."""
    t, w = gauss(count)
    theta = np.arctan(scale * np.tan(t * np.pi / 2))
    jacobian = np.pi / 2 * scale / (np.cos(t * np.pi / 2) ** 2 + (scale * np.sin(t * np.pi / 2)) ** 2)
    phi = 2 * np.pi * (np.arange(turns) + 0.5) / turns
    theta, phi = np.meshgrid(theta, phi, indexing="ij")
    m = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    weights = (w * jacobian)[:, None] * np.sin(theta) * 2 * np.pi / turns
    return Patch(m.reshape(-1, 3), weights.reshape(-1))
