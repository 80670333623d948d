"""An order of rays that suits the cache."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microfacet.compiler.cache import compiled
from microfacet.surface.lanes import Array, Integers

_jit: Any = compiled(nogil=True, error_model="numpy")
TILE = 5  # binary logarithm of the side, in cells, of the tiles by which rays are sorted


@_jit
def by_tile(o: Array, d: Array, highest: float, size: int) -> Integers:  # pragma: no cover - compiled
    """Numbers of the rays, sorted by the tile over which each enters the surface's range of heights; stable."""
    tiles = max(size >> TILE, 1)
    key = np.empty(len(o), np.int32)
    count = np.zeros(tiles * tiles + 1, np.int64)
    for k in range(len(o)):
        t = max((highest - o[k, 2]) / d[k, 2], 0.0) if o[k, 2] > highest and d[k, 2] < 0 else 0.0
        i = math.floor(o[k, 0] + t * d[k, 0]) & (size - 1)
        j = math.floor(o[k, 1] + t * d[k, 1]) & (size - 1)
        key[k] = (i >> TILE) * tiles + (j >> TILE)
        count[key[k] + 1] += 1
    for k in range(tiles * tiles):
        count[k + 1] += count[k]
    order = np.empty(len(o), np.int64)
    for k in range(len(o)):
        order[count[key[k]]] = k
        count[key[k]] += 1
    return order
