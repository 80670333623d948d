"""Ways to measure a surface: how large a surface, and how many rays, for the masking that tracing finds on it.

One surface gives one value of the mean masking; surfaces are independent, so that what is left after n of them is the
scatter between surfaces over the root of n. What decides is the scatter's square times the time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
from microfacet.directions import spherical
from microfacet.surface import gaussian, height_field, lanes, measure, planes, tiles
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.measure import Plan, shard

from benchmarks.method import Method

ALPHA, VIEW, CORRELATION = 0.7, np.radians(60.0), 16.0
GRIDS, SIDES = (128, 256, 512, 1024), (16, 32, 64, 128, 256)
SURFACES = 12  # from which the scatter is told


def field(size: int) -> GaussianField:
    return GaussianField(size, ALPHA, correlation=CORRELATION, root=21)


def plan(side: int) -> Plan:
    return Plan([spherical(VIEW, 0.3)], side=side, bounces=0)


@cache
def masking(size: int, side: int) -> np.ndarray:
    """The mean masking found on each of several surfaces."""
    found = shard(field(size), plan(side), 0, SURFACES)
    return np.asarray(found["seen"].sum(axis=(1, 2)) / found["faced"].sum(axis=(1, 2)))


def scatter(size: int, side: int) -> float:
    """Relative standard deviation between surfaces."""
    found = masking(size, side)
    return float(found.std(ddof=1) / found.mean())


def prepare(size: int, side: int) -> Callable[[], Any]:
    return lambda: shard(field(size), plan(side), 0, 1)


METHODS = {
    f"grid_{size}": Method(
        rf"{size} $\times$ {size} nodes",
        partial(prepare, size),
        partial(scatter, size),
        SIDES,
        (gaussian, measure, height_field, lanes, planes, tiles),
        each=False,
    )
    for size in GRIDS
}
