"""A periodic height field, each cell of which is two triangles, and the rays that it is asked for.

The surface repeats a grid of n x n heights for ever; the unit of length is the grid's cell. Node (i, j) stands at x = i,
y = j. The diagonal from (i, j) to (i + 1, j + 1) cuts a cell into facets 2 (i n + j) and 2 (i n + j) + 1: the first has
x - i >= y - j. Triangles, not bilinear patches: a facet then has one normal, so that what is measured is compared with a
distribution of normals without a further model, and others can trace the same surface.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.compiler.processors import parallel_map
from microfacet.directions import as_points
from microfacet.surface.lanes import BASE, CHUNK, ESCAPED, REACH, STEP, TINY, Array, Integers, trace_rays
from microfacet.surface.planes import planes_above
from microfacet.surface.tiles import TILE, by_tile

SORT = 1 << 21  # rays that are put into order at once
SMALL = 512  # largest grid that fits the cache, so that rays need no order


class Hits(NamedTuple):
    """What rays meet: the facet's number, or ESCAPED or LOST; and how far away, in lengths of the direction (else inf)."""

    facet: Integers
    distance: Array


class HeightField:
    """A periodic surface of 2 n^2 facets, from heights of shape (n, n) in cells, n a power of two and at least 8.

    Heights are rounded to single precision first; the surface of these rounded heights is what everything here refers to.
    """

    def __init__(self, heights: ArrayLike) -> None:
        given = np.asarray(heights)
        if given.ndim != 2 or given.shape[0] != given.shape[1]:
            raise ValueError(f"heights must have shape (n, n), got {given.shape}")
        if given.shape[0] < 8 or given.shape[0] & (given.shape[0] - 1):
            raise ValueError(f"heights must have a power of two of at least 8 nodes per side, got {given.shape[0]}")
        if not np.isfinite(given).all():
            raise ValueError(f"heights must be finite, got {given[~np.isfinite(given)][0]}")
        if abs(given).max() > 1e30:
            raise ValueError(f"heights must be below 1e30 cells, got {abs(given).max()}")
        self.heights = np.array(given, np.float32, order="C")
        self.heights.flags.writeable = False
        self.size = len(self.heights)
        self.top = BASE + STEP * ((self.size.bit_length() - 1 - BASE) // STEP)
        self.planes = planes_above(self.heights, self.top)
        self.highest = float(self.heights.max())

    def trace(self, origins: ArrayLike, directions: ArrayLike, facets: ArrayLike | None = None) -> Hits:
        """The first facet that each ray meets: origins and directions (N, 3) or (3,), facets (N,).

        facets: the facet on which each ray starts and which it cannot meet again. It is named, not found: an origin may be
        off it by rounding. A direction that points into it meets it at distance 0. Without facets, or where one is below 0,
        the origin must be above the surface. Directions need not be unit vectors.
        """
        o, d = self._rays(origins, directions)
        own = self._own(facets, len(o))
        facet, distance = np.empty(len(o), np.int64), np.empty(len(o))
        field = (self.heights.reshape(-1), *self.planes, self.size.bit_length() - 1, self.top, self.highest)
        for first in range(0, len(o), SORT):
            part = slice(first, min(first + SORT, len(o)))
            order = self._order(o[part], d[part])
            rays = (o[part].reshape(-1), d[part].reshape(-1), own[part] if len(own) else own, order)
            count = part.stop - first
            jobs = [(*field, *rays, facet[part], distance[part], k, min(k + CHUNK, count)) for k in range(0, count, CHUNK)]
            if any(parallel_map(trace_rays, jobs)):
                self._refuse(int(np.argmin(facet[part])) + first, o, d, own)
        return Hits(facet, distance)

    def escapes(self, origins: ArrayLike, directions: ArrayLike, facets: ArrayLike | None = None) -> NDArray[np.bool_]:
        """Whether each ray leaves the surface, (N,); arguments as for `trace`. A ray that is LOST does not."""
        left: NDArray[np.bool_] = self.trace(origins, directions, facets).facet == ESCAPED
        return left

    def _rays(self, origins: ArrayLike, directions: ArrayLike) -> tuple[Array, Array]:
        given = np.asarray(origins, np.float64), np.asarray(directions, np.float64)
        if any(a.ndim not in (1, 2) or a.shape[-1] != 3 for a in given) or len({len(a) for a in given if a.ndim == 2}) > 1:
            raise ValueError(f"origins and directions must have shape (N, 3) or (3,), got {given[0].shape}, {given[1].shape}")
        shape = (max(len(a) if a.ndim == 2 else 1 for a in given), 3)
        o, d = (np.ascontiguousarray(np.broadcast_to(a, shape)) for a in given)
        return o, d

    def _refuse(self, at: int, o: Array, d: Array, own: Integers) -> NoReturn:
        """Say what is wrong with a ray that could not be traced."""
        as_points("origins", o), as_points("directions", d)
        if abs(o[at]).max() > REACH:
            raise ValueError(f"origins must lie within {REACH:g} cells, got {o[at]} at index {at}")
        if not TINY < abs(d[at]).max() < 1 / TINY:
            raise ValueError(f"directions must have a length between {TINY:g} and {1 / TINY:g}, got {d[at]} at index {at}")
        if own[at] >= 2 * self.size**2:
            raise ValueError(f"facets must be below {2 * self.size**2}, got {own[at]} at index {at}")
        raise ValueError(f"facets must hold the origins: facet {own[at]} does not hold {o[at]} of ray {at}")

    def _own(self, facets: ArrayLike | None, count: int) -> Integers:
        if facets is None:
            return np.empty(0, np.int64)
        given = np.asarray(facets)
        if given.shape != (count,) or given.dtype.kind not in "iu":
            raise ValueError(f"facets must be whole numbers of shape ({count},), got {given.dtype} of shape {given.shape}")
        return np.ascontiguousarray(given, np.int64)

    def _order(self, o: Array, d: Array) -> Integers:
        """An order of the rays that suits the cache; empty if theirs does already."""
        if self.size <= SMALL or len(o) < CHUNK:
            return np.empty(0, np.int64)
        pairs = np.linspace(0, len(o) - 2, 512).astype(int)
        if np.median(np.abs(o[pairs + 1, :2] - o[pairs, :2]).max(axis=1)) <= 2 << TILE:
            return np.empty(0, np.int64)
        return by_tile(o, d, self.highest, self.size)

    def locate(self, x: ArrayLike, y: ArrayLike) -> tuple[Integers, Array]:
        """The facet over or under each point (x, y), and the surface's height there; shapes broadcast."""
        xs, ys = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        if not (np.isfinite(xs).all() and np.isfinite(ys).all()):
            raise ValueError(f"x and y must be finite, got {xs[~(np.isfinite(xs) & np.isfinite(ys))]}")
        i, j = np.floor(xs), np.floor(ys)
        u, v = xs - i, ys - j
        near, far = i.astype(np.int64) % self.size, (i.astype(np.int64) + 1) % self.size
        left, right = j.astype(np.int64) % self.size, (j.astype(np.int64) + 1) % self.size
        upper = v > u
        z00, z11 = self.heights[near, left].astype(float), self.heights[far, right].astype(float)
        third = np.where(upper, self.heights[near, right], self.heights[far, left]).astype(float)
        along, across = np.where(upper, v, u), np.where(upper, u, v)
        height: Array = z00 + along * (third - z00) + across * (z11 - third)
        return 2 * (near * self.size + left) + upper, height

    @cached_property
    def slopes(self) -> Array:
        """Slope (along x, along y) of every facet, shape (2 n^2, 2), in the order of their numbers."""
        z = self.heights.astype(float)
        far, right = np.roll(z, -1, 0), np.roll(z, -1, 1)
        corner = np.roll(far, -1, 1)
        first, second = np.stack([far - z, corner - far], -1), np.stack([corner - right, right - z], -1)
        stacked: Array = np.stack([first, second], axis=2).reshape(-1, 2)
        return stacked

    def normals(self, facets: ArrayLike) -> Array:
        """Unit normals of facets, wm, shapes (...) -> (..., 3)."""
        slopes = self.slopes[np.asarray(facets)]
        length = np.sqrt(1 + np.sum(slopes**2, axis=-1))
        normals: Array = np.stack([-slopes[..., 0], -slopes[..., 1], np.ones_like(length)], axis=-1) / length[..., None]
        return normals

    def points(self, origins: ArrayLike, directions: ArrayLike, distance: ArrayLike) -> Array:
        """Where rays are after a finite distance, moved back into the first period: origins for the rays to follow."""
        points: Array = np.asarray(origins, float) + np.asarray(distance, float)[..., None] * np.asarray(directions, float)
        points[..., :2] -= self.size * np.floor(points[..., :2] / self.size)
        return points
