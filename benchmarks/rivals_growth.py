"""How the cost of one thing grows with its size, beside the power that is expected."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from microfacet.directions import spherical
from microfacet.statements import balls
from microfacet.surface import gaussian, height_field, lanes, planes, tiles
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField

from benchmarks.method import Method, directions
from benchmarks.rivals_brdf import BRDF, brdf_library
from benchmarks.rivals_integral import enclosed

TRACER = (height_field, lanes, planes, tiles)
VALUES = tuple(10**k for k in range(2, 9))
GRIDS = tuple(2**k for k in range(8, 14))
DIGITS = (4, 8, 12, 16, 24, 32, 40, 50)
RAYS = 2**18
TILE = 10**6  # different values; longer arrays repeat them
BYTES_A_VALUE, BYTES_A_NODE = 60, 60  # arrays that are held at once


class Expected(NamedTuple):
    """The power of the size with which time should grow from `first` on, and why."""

    power: float
    first: int
    why: str


EXPECTED = {
    "values": Expected(1.0, 10**5, "each value costs the same"),
    "surfaces": Expected(2.0, 512, "nodes, times a logarithm"),
    "rays": Expected(0.0, 256, "a ray ends near where it began"),
    "digits": Expected(1.0, 4, "nodes of the rule; products are short"),
}


def room_for(size: int, each: int) -> None:
    """MemoryError if so many values of so many bytes would not fit."""
    free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if size * each > 0.8 * free:
        raise MemoryError(f"it takes {size * each / 2**30:.1f} GiB of {free / 2**30:.1f}")


def values(size: int) -> Callable[[], Any]:
    room_for(size, BYTES_A_VALUE)
    repeats = (max(1, size // TILE), 1)
    wo, wi = (np.tile(directions(min(size, TILE), seed), repeats) for seed in (1, 2))
    return lambda: brdf_library(wo, wi)


def field(size: int) -> GaussianField:
    return GaussianField(size, 0.7, root=21)


def surfaces(size: int) -> Callable[[], Any]:
    room_for(size * size, BYTES_A_NODE)
    return lambda: field(size).spectral(0)


@cache
def surface(size: int) -> HeightField:
    return HeightField(field(size).spectral(0))


def rays(size: int) -> Callable[[], Any]:
    """Rays from above, over the whole surface."""
    room_for(size * size, BYTES_A_NODE)
    known, places = surface(size), np.random.default_rng(3).random((RAYS, 2)) * size
    origins = np.column_stack([places, np.full(RAYS, known.highest)])
    return lambda: known.trace(origins, -spherical(np.radians(60.0), 0.3))


def digits(count: int) -> Callable[[], Any]:
    return lambda: enclosed(count)


def nothing(size: int) -> float:
    return np.nan


METHODS = {
    "values": Method("values of the BRDF", values, nothing, VALUES, (BRDF.evaluation[0],)),
    "surfaces": Method("surfaces made, by their side", surfaces, nothing, GRIDS, (gaussian,), each=False),
    "rays": Method(f"{RAYS} rays, by the surface's side", rays, nothing, GRIDS, TRACER, each=False),
    "digits": Method(
        "proved digits of an integral", lambda n: lambda: enclosed(n), nothing, DIGITS, (enclosed, balls), each=False
    ),
}
