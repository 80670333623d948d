"""Samples of second facets of random walks, for walks that continue after their first bounce only.

On smooth surfaces hardly any walk continues, so that a sample of all walks would hold none of these. The height of their second
facet has a closed form. The direction is drawn by stratified sampling over all reflections off visible facets, with a number of
walks per stratum in proportion to its contribution. heitz2016, dupuy2023.
"""

from __future__ import annotations

from math import log1p
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microfacet.geometry.ggx import GGX
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.slopes import alpha_of
from microfacet.geometry.visible_normals import unstretched
from microfacet.visibility.smith import Smith

Array = NDArray[np.float64]
RINGS, SECTORS = 64, 16  # parts of the cap of mirror directions
TRIALS = 24  # in each stratum, to estimate its contribution
UNIFORM_FRACTION = 0.2  # of the walks are spread evenly over all strata


class Onward(NamedTuple):
    """Rays (n, 3) after their first bounce that meet a second facet; its height (n,), as the fraction of the surface that is
    lower; the cosine (n,) at the first facet; and weights (n,), whose mean is the probability to continue."""

    direction: Array
    height: Array
    cosine: Array
    weight: Array


class SecondFacets:
    """The second facets of walks from one view wo (3,) above the horizon."""

    def __init__(self, model: Smith, wo: Array) -> None:
        self.model, self.wo = model, np.asarray(wo, float)
        self.steep = min(alpha_of(model.ndf)) ** 2  # of the cap, about this much mirrors light down
        self.above = float(self._hidden(self.wo[None])[0])
        cell = np.repeat(np.arange(RINGS * SECTORS), TRIALS)
        onward = self._mirrored(cell, np.random.default_rng(0).random((2, cell.size)))[2]
        fraction = np.sqrt((onward.reshape(-1, TRIALS) ** 2).mean(axis=1))
        uniform = np.full(fraction.size, 1 / fraction.size)
        self.fraction = UNIFORM_FRACTION * uniform + (1 - UNIFORM_FRACTION) * (
            fraction / fraction.sum() if fraction.sum() > 0 else uniform
        )

    def draw(self, count: int, rng: np.random.Generator) -> Onward:
        """A number of rays, distributed over the strata by their fractions, each rounded to a whole number."""
        ends = np.cumsum(self.fraction)
        cell = np.searchsorted(ends / ends[-1], (np.arange(count) + rng.random()) / count, "right")
        direction, cosine, onward = self._mirrored(cell, rng.random((2, count)))
        first, second = 1 - rng.random((2, count))
        height = first ** (1 / (1 + self.above))
        down = direction[:, 2] <= 0
        height[down] *= second[down] ** (1 / (1 + self._hidden(direction[down])))
        return Onward(direction, height, cosine, onward / (self.fraction[cell] * self.fraction.size))

    def _mirrored(self, cell: NDArray[np.int64], u: Array) -> tuple[Array, Array, Array]:
        """Directions and cosines at points of the cells, and the probability to continue there, times the measure of a cell.

        The rings grow in equal ratios away from the steepest facets.
        """
        ring, sector = np.divmod(cell, SECTORS)
        span = log1p(1 / self.steep)
        steep = self.steep * np.expm1(span * (ring + u[0]) / RINGS)
        wm = self._normals((sector + u[1]) / SECTORS, steep)
        cosine = np.maximum(wm @ self.wo, 0.0)
        wi = 2 * cosine[:, None] * wm - self.wo
        wi /= np.linalg.norm(wi, axis=1, keepdims=True)
        return wi, cosine, self._density_over_ggx(wm) * self._chance_to_continue(wi) * (steep + self.steep) * span

    def _normals(self, u1: Array, steep: Array) -> Array:
        """Visible normals of GGX for two uniform numbers, the second given as its distance from 1. dupuy2023."""
        alpha = alpha_of(self.model.ndf)
        ox, oy, oz = map(float, self.wo)
        x, y, z = unstretched((ox, oy, oz), Alphas(*alpha))
        above = steep * (1 + z)
        radius = np.sqrt((above + (x * x + y * y) / (1 + z)) * ((1 - steep) * (1 + z)))
        angle = 2 * np.pi * u1
        wm = np.stack([alpha[0] * (radius * np.cos(angle) + x), alpha[1] * (radius * np.sin(angle) + y), above], axis=-1)
        normals: Array = wm / np.linalg.norm(wm, axis=1, keepdims=True)
        return normals

    def _density_over_ggx(self, wm: Array) -> Array:
        """The density of visible normals relative to that of GGX of the same roughness."""
        if type(self.model.ndf).kernel is GGX.kernel:
            return np.ones(len(wm))
        ggx = Smith(GGX(*alpha_of(self.model.ndf))).D_visible(self.wo, wm)
        visible = self.model.D_visible(self.wo, wm)
        ratio: Array = np.divide(visible, ggx, out=np.zeros(len(wm)), where=ggx > 0)
        return ratio

    def _chance_to_continue(self, wi: Array) -> Array:
        """The probability that a ray meets a second facet: 1 on its way down, Lambda_i/(1 + Lambda_o + Lambda_i) up."""
        hidden = self._hidden(wi)
        chance: Array = np.where(wi[:, 2] > 0, hidden / (1 + self.above + hidden), 1.0)
        return chance

    def _hidden(self, wi: Array) -> Array:
        """Lambda of a direction or of its opposite, whichever is above the horizon; the height is bounded away from 0."""
        upward = np.column_stack([wi[:, :2], np.maximum(abs(wi[:, 2]), 1e-150)])
        hidden: Array = self.model.Lambda(upward)
        return hidden
