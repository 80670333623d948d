"""Does a sampler of normals have the density it claims? Counts in cells against the density's integrals over them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Density = Callable[[Array], Array]


class SlopeCells:
    """Cells over normals: unstretched slopes q along the view, up to the edge of visibility, and r across.

    Cells are even in atan q and in atan(r/sqrt(1 + q^2)), in which the tails of GGX are smooth. wo: the view (3,);
    scale: the slope scales (alpha_x, alpha_y).
    """

    def __init__(self, wo: Array, scale: tuple[float, float], count: int = 24) -> None:
        self.scale, self.count = np.asarray(scale), count
        stretched = self.scale * wo[:2]
        length = np.hypot(*stretched)
        self.along = stretched / length if length > 0 else np.array([1.0, 0.0])
        edge = np.arctan2(wo[2], length)
        self.edges = np.linspace(-np.pi / 2, edge, count + 1), np.linspace(-np.pi / 2, np.pi / 2, count + 1)

    def counts(self, normals: Array) -> Array:
        """How many of the normals (n, 3) lie in each cell."""
        m = normals.astype(np.float64)
        x, y = -m[:, 0] / m[:, 2] / self.scale[0], -m[:, 1] / m[:, 2] / self.scale[1]
        c, s = self.along
        q, r = c * x + s * y, c * y - s * x
        counts: Array = np.histogram2d(np.arctan(q), np.arctan(r / np.sqrt(1 + q * q)), bins=self.edges)[0]
        return counts

    def integrals(self, density: Density, nodes: int = 6) -> Array:
        """The density's integral over each cell, by Gauss and Legendre's rule."""
        t, w = np.polynomial.legendre.leggauss(nodes)
        points = [(e[:-1, None] + np.diff(e)[:, None] * (t + 1) / 2).ravel() for e in self.edges]
        weights = [(np.diff(e)[:, None] * w / 2).ravel() for e in self.edges]
        q, ratio = np.meshgrid(*map(np.tan, points), indexing="ij")
        r = ratio * np.sqrt(1 + q * q)
        c, s = self.along
        x, y = self.scale[0] * (c * q - s * r), self.scale[1] * (s * q + c * r)
        z = 1 / np.sqrt(1 + x * x + y * y)
        area = self.scale.prod() * (1 + q**2) ** 1.5 * (1 + ratio**2) * z**3
        values = density(np.stack([-x * z, -y * z, z], axis=-1)) * area * np.outer(*weights)
        integrals: Array = values.reshape(self.count, nodes, self.count, nodes).sum(axis=(1, 3))
        return integrals


def p_value_of_counts(counts: Array, expected: Array, least: float = 10.0) -> float:
    """The p-value of Pearson's chi-square test; cells that expect fewer than `least` are merged into one."""
    from scipy.special import chdtrc  # imported here: every statement of the library loads this module, few test samples

    counts, expected = counts.ravel(), expected.ravel()
    large = expected >= least
    counts = np.append(counts[large], counts[~large].sum())
    expected = np.append(expected[large], expected[~large].sum())
    keep = expected > 0
    if counts[~keep].any():
        return 0.0
    counts, expected = counts[keep], expected[keep]
    return float(chdtrc(len(counts) - 1, np.sum((counts - expected) ** 2 / expected)))


def p_value(normals: Array, density: Density, wo: Array, scale: tuple[float, float]) -> float:
    """The p-value of the hypothesis that normals (n, 3) were drawn with this density, per solid angle.

    It is the smallest of three tests, along the view, across it and of all cells together, times three: Bonferroni's
    correction. 0 if the density does not integrate to 1 over the cells, or a normal lies where the viewer cannot see it.
    """
    cells = SlopeCells(wo, scale)
    counts, expected = cells.counts(normals), len(normals) * cells.integrals(density)
    below = normals[:, 2] < 0  # whose slope is that of the normal opposite to it
    if below.any() or abs(expected.sum() / len(normals) - 1) > 1e-3 or counts.sum() != len(normals):
        return 0.0
    tests = [(counts, expected), (counts.sum(0), expected.sum(0)), (counts.sum(1), expected.sum(1))]
    return min(1.0, 3 * min(p_value_of_counts(*test) for test in tests))
