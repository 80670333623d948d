"""Computes what the figure `shadowing` shows: which part of the seen surface can send its reflection away."""

import sys

import numpy as np
from microfacet.surface.profile import Pieces, direction, mirror
from report.datafile import store
from report.example import example, percentages

RAYS = 40


def equal_rays(seen: Pieces, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Facet and place on it of RAYS rays towards ``wo`` that all stand for the same part of the view."""
    reach = np.append(0.0, np.cumsum(seen.projected(wo)))
    screen = reach[-1] * (np.arange(RAYS) + 0.5) / RAYS
    facet = np.searchsorted(reach, screen, side="right") - 1
    within = (screen - reach[facet]) / (reach[facet + 1] - reach[facet])
    return facet, seen.start[facet] + within * seen.fraction[facet]


def compute() -> dict:
    wo, surface = direction(np.radians(60.0)), example()
    seen, wi = surface.visible(wo), mirror(wo, surface.normals)
    free = seen.both(surface.escaping(wi))
    blocked = seen.without(free)
    facet, place = equal_rays(seen, wo)
    origin = np.stack([surface.x[facet], surface.z[facet]], axis=-1) + place[:, None] * surface.edges[facet]
    shares = [free.projected(wo).sum(), sum(part.projected(wo).sum() for part in blocked)]
    return {
        "wo": wo,
        "x": surface.x,
        "z": surface.z,
        "free": free.ends,
        "blocked": np.concatenate([part.ends for part in blocked]),
        "origin": origin,
        "wi": wi[facet],
        "length": np.array([surface.hit(k, o, wi[k]) for k, o in zip(facet, origin, strict=True)]),
        "shares": np.array(shares) / wo[1],
        "percent": percentages(shares),
    }


if __name__ == "__main__":
    store(sys.argv[1], **compute())
