"""Where walks that go on after their first bounce meet their second facet: drawn with the chance to go on, and no others.

On smooth surfaces hardly any walk goes on, and a sample of all of them would hold none. Of those that do, the height of the
second facet has a closed form; the direction is drawn from all that facets seen from wo may give, evenly in small parts of
them each of which has its share of the walks that go on. heitz2016, dupuy2023.
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
TRIALS = 24  # in each part, to find its share
EVERYWHERE = 0.2  # of the walks are spread over all parts, whatever the trials say


class Onward(NamedTuple):
    """Rays (n, 3) that were mirrored once and meet a facet again; its height (n,), as the share of the surface that is lower;
    the cosine (n,) at the first facet; and weights (n,), whose mean is the chance to go on."""

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
        share = np.sqrt((onward.reshape(-1, TRIALS) ** 2).mean(axis=1))
        even = np.full(share.size, 1 / share.size)
        self.share = EVERYWHERE * even + (1 - EVERYWHERE) * (share / share.sum() if share.sum() > 0 else even)

    def draw(self, count: int, rng: np.random.Generator) -> Onward:
        """So many rays, each part with as many as its share to the nearest whole number."""
        ends = np.cumsum(self.share)
        cell = np.searchsorted(ends / ends[-1], (np.arange(count) + rng.random()) / count, "right")
        direction, cosine, onward = self._mirrored(cell, rng.random((2, count)))
        first, second = 1 - rng.random((2, count))
        height = first ** (1 / (1 + self.above))
        down = direction[:, 2] <= 0
        height[down] *= second[down] ** (1 / (1 + self._hidden(direction[down])))
        return Onward(direction, height, cosine, onward / (self.share[cell] * self.share.size))

    def _mirrored(self, cell: NDArray[np.int64], u: Array) -> tuple[Array, Array, Array]:
        """Directions and cosines at places of the cells, and the chance to go on from there, times what a cell has of the cap.

        The rings grow in equal ratios away from the steepest facets.
        """
        ring, sector = np.divmod(cell, SECTORS)
        span = log1p(1 / self.steep)
        steep = self.steep * np.expm1(span * (ring + u[0]) / RINGS)
        wm = self._normals((sector + u[1]) / SECTORS, steep)
        cosine = np.maximum(wm @ self.wo, 0.0)
        wi = 2 * cosine[:, None] * wm - self.wo
        wi /= np.linalg.norm(wi, axis=1, keepdims=True)
        return wi, cosine, self._seen(wm) * self._onward(wi) * (steep + self.steep) * span

    def _normals(self, turn: Array, steep: Array) -> Array:
        """Normals of GGX that the view sees, for even numbers: its last is kept as its distance from 1. dupuy2023."""
        alpha = alpha_of(self.model.ndf)
        ox, oy, oz = map(float, self.wo)
        x, y, z = unstretched((ox, oy, oz), Alphas(*alpha))
        above = steep * (1 + z)
        radius = np.sqrt((above + (x * x + y * y) / (1 + z)) * ((1 - steep) * (1 + z)))
        angle = 2 * np.pi * turn
        wm = np.stack([alpha[0] * (radius * np.cos(angle) + x), alpha[1] * (radius * np.sin(angle) + y), above], axis=-1)
        normals: Array = wm / np.linalg.norm(wm, axis=1, keepdims=True)
        return normals

    def _seen(self, wm: Array) -> Array:
        """How much more often the view sees these normals than it would those of GGX of the same roughness."""
        if type(self.model.ndf).kernel is GGX.kernel:
            return np.ones(len(wm))
        ggx = Smith(GGX(*alpha_of(self.model.ndf))).D_visible(self.wo, wm)
        seen = self.model.D_visible(self.wo, wm)
        more: Array = np.divide(seen, ggx, out=np.zeros(len(wm)), where=ggx > 0)
        return more

    def _onward(self, wi: Array) -> Array:
        """The chance of a ray mirrored once to meet a facet again: 1 on its way down, Lambda_i/(1 + Lambda_o + Lambda_i) up."""
        hidden = self._hidden(wi)
        on: Array = np.where(wi[:, 2] > 0, hidden / (1 + self.above + hidden), 1.0)
        return on

    def _hidden(self, wi: Array) -> Array:
        """Lambda of a direction or of its opposite, and of none nearer to the horizon than a float can be."""
        up = np.column_stack([wi[:, :2], np.maximum(abs(wi[:, 2]), 1e-150)])
        hidden: Array = self.model.Lambda(up)
        return hidden
