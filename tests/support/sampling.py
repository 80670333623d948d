"""Does a sampler have the density it claims? Two tests: a chi-square over cells, and the density's own Jacobian.

The Jacobian test is pointwise and exact to rounding: a map of the unit square has the density 1/|d direction/d u|. With a
density that integrates to 1 it leaves nothing for chance to hide; the chi-square is the one that also sees single precision.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from around import gauss
from scipy.stats import chi2

Sampler = Callable[[np.ndarray], np.ndarray]
Density = Callable[[np.ndarray], np.ndarray]


def density_times_area(sample: Sampler, density: Density, u: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """density(m(u)) |dm/du1 x dm/du2| by central differences: 1 where the sampler has this density."""
    slopes = []
    for axis in np.eye(2) * step:
        far, near = sample(u + axis), sample(u - axis)
        wide = (sample(u + 2 * axis) - sample(u - 2 * axis)) / (4 * step)
        slopes.append((4 * (far - near) / (2 * step) - wide) / 3)
    return density(sample(u)) * np.linalg.norm(np.cross(*slopes), axis=-1)


class SlopeCells:
    """Cells over normals: unstretched slopes q along the view, up to the edge of visibility, and r across.

    Cells are even in atan q and in atan(r/sqrt(1 + q^2)), in which the tails of GGX are smooth.
    """

    def __init__(self, wo: np.ndarray, scale: tuple[float, float], count: int = 24) -> None:
        self.scale, self.count = np.asarray(scale), count
        seen = self.scale * wo[:2]
        length = np.hypot(*seen)
        self.along = seen / length if length > 0 else np.array([1.0, 0.0])
        edge = np.arctan2(wo[2], length)
        self.edges = np.linspace(-np.pi / 2, edge, count + 1), np.linspace(-np.pi / 2, np.pi / 2, count + 1)

    def counts(self, m: np.ndarray) -> np.ndarray:
        m = m.astype(np.float64)
        x, y = -m[:, 0] / m[:, 2] / self.scale[0], -m[:, 1] / m[:, 2] / self.scale[1]
        c, s = self.along
        q, r = c * x + s * y, c * y - s * x
        return np.histogram2d(np.arctan(q), np.arctan(r / np.sqrt(1 + q * q)), bins=self.edges)[0]

    def shares(self, density: Density, nodes: int = 6) -> np.ndarray:
        """The density's integral over each cell."""
        t, w = gauss(nodes)
        points = [(e[:-1, None] + np.diff(e)[:, None] * t).ravel() for e in self.edges]
        weights = [(np.diff(e)[:, None] * w).ravel() for e in self.edges]
        q, turn = np.meshgrid(*map(np.tan, points), indexing="ij")
        r = turn * np.sqrt(1 + q * q)
        c, s = self.along
        x, y = self.scale[0] * (c * q - s * r), self.scale[1] * (s * q + c * r)
        z = 1 / np.sqrt(1 + x * x + y * y)
        area = self.scale.prod() * (1 + q**2) ** 1.5 * (1 + turn**2) * z**3
        values = density(np.stack([-x * z, -y * z, z], axis=-1)) * area * np.outer(*weights)
        return values.reshape(self.count, nodes, self.count, nodes).sum(axis=(1, 3))


def chance(counts: np.ndarray, expected: np.ndarray, least: float = 10.0) -> float:
    """The p-value of counts against expectations; cells that expect few are taken together."""
    counts, expected = counts.ravel(), expected.ravel()
    large = expected >= least
    counts = np.append(counts[large], counts[~large].sum())
    expected = np.append(expected[large], expected[~large].sum())
    keep = expected > 0
    if counts[~keep].any():
        return 0.0
    counts, expected = counts[keep], expected[keep]
    return float(chi2.sf(np.sum((counts - expected) ** 2 / expected), len(counts) - 1))


def agreement(normals: np.ndarray, density: Density, wo: np.ndarray, scale: tuple[float, float]) -> float:
    """The smallest p-value of both axes and of all cells together, times three for having looked three times.

    0 if the density lacks a part, or has one where no normal was drawn.
    """
    cells = SlopeCells(wo, scale)
    counts, expected = cells.counts(normals), len(normals) * cells.shares(density)
    if abs(expected.sum() / len(normals) - 1) > 1e-3:
        return 0.0
    assert counts.sum() == len(normals), "normals that the viewer cannot see"
    looks = [(counts, expected), (counts.sum(0), expected.sum(0)), (counts.sum(1), expected.sum(1))]
    return min(1.0, 3 * min(chance(*look) for look in looks))
