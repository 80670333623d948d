"""Rays against one surface, from above and from facets, as they come and sorted by tiles; on record beside Embree's.

Embree is a guest (yardsticks.py): same triangles, same rays, same order, as many processes as the library has threads.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
from microfacet.directions import reflect, spherical
from microfacet.surface import height_field, lanes, planes, tiles
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField

from benchmarks.method import Method

TRACER = (height_field, lanes, planes, tiles)
SIDE, ALPHA, VIEW, TILE = 1024, 0.7, np.radians(60.0), 64
RAYS = (10**6,)
KINDS = {"primary": "from above", "reflected": "reflected", "shadow": "back to the viewer"}
ORDERS = {"unsorted": "as they come", "sorted": "by tiles"}
TASKS = {f"{kind}_{order}": f"{came}, {sort}" for kind, came in KINDS.items() for order, sort in ORDERS.items()}


@cache
def surface() -> HeightField:
    return HeightField(GaussianField(SIDE, ALPHA, root=21).spectral(0))


@cache
def rays(task: str, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Origins, directions, and the facets that rays start on if they do: of one view, where it looks."""
    kind, order = task.split("_")
    field, places = surface(), np.random.default_rng(1).uniform(0, SIDE, (count, 2))
    if order == "sorted":
        places = places[np.lexsort((places // TILE).T)]
    origins, wo = np.column_stack([places, np.full(count, field.highest)]), spherical(VIEW, 0.3)
    views = np.broadcast_to(wo, (count, 3)).copy()
    if kind == "primary":
        return origins, -views, None
    hits = field.trace(origins, -views)
    seen = field.points(origins, -views, hits.distance)
    return seen, views if kind == "shadow" else reflect(views, field.normals(hits.facet)), hits.facet


def prepare(task: str, count: int) -> Callable[[], Any]:
    asked = rays(task, count)
    return lambda: surface().trace(*asked)


def false(task: str, count: int) -> float:
    """The share of wrong verdicts where the right one is known: views from above meet the surface, what is seen sees back."""
    if task.startswith("reflected"):
        return np.nan
    return float(np.mean(surface().escapes(*rays(task, count)) != task.startswith("shadow")))


METHODS = {
    task: Method(f"rays {words}, this library", partial(prepare, task), partial(false, task), RAYS, TRACER)
    for task, words in TASKS.items()
}
