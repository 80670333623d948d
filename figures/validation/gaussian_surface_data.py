"""Computes what the figure `gaussian_surface` shows: a surface of Gabor noise, some rays on it, and the lobes of many rays."""

import sys

import numpy as np
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.compare import coarse, folded, lobe_of
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField
from microfacet.surface.lanes import ESCAPED
from microfacet.visibility.smith import Smith
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_07",)
DEGREES = 60.0
BINS = (3, 2)
FAMILY = GaussianField(256, CAMPAIGN["lobes_07"].family.alpha_x, root=59)
PATCH = 96  # cells, along either side
RAYS = ((20, 6), (60, 16), (34, 34), (78, 44), (22, 62), (52, 72))  # at which cell each is aimed: the middle of its first facet
FAR, BOUNCES = 22.0, 6


def path(surface: HeightField, cell: tuple[int, int]) -> np.ndarray:
    """The corners of a ray's way (BOUNCES + 2, 3), from FAR before its first hit to FAR behind its last; then nan."""
    way = spherical(np.radians(DEGREES))  # the viewer is on the left
    way = np.array([way[0], 0.0, -way[2]])
    aim = np.add(cell, (2 / 3, 1 / 3))
    _, height = surface.locate(*aim)
    place = np.array([*aim, float(height)]) - way * (surface.highest - float(height)) / -way[2] * 1.001
    corners, facet = np.full((BOUNCES + 2, 3), np.nan), None
    for k in range(BOUNCES + 1):
        hits = surface.trace(place, way, facet)
        if k == 0:
            corners[0] = place + (hits.distance[0] - FAR) * way
        if hits.facet[0] == ESCAPED:
            corners[k + 1] = place + FAR * way
            break
        place, facet = place + hits.distance[0] * way, hits.facet
        wm = surface.normals(hits.facet)[0]
        way = way - 2 * (way @ wm) * wm
        corners[k + 1] = place
    return corners


def compute() -> dict:
    heights = FAMILY.gabor(0)
    surface = HeightField(heights)
    entry, view = CAMPAIGN["lobes_07"], THETA_O.index(DEGREES)
    wo, plan = np.asarray(entry.plan.views)[view], entry.plan
    found, angles = read("lobes_07"), coarse(plan.solid_angle, *BINS)
    measured = coarse(folded(found["lobe"][:, view, 0]), *BINS).mean(axis=0)
    theta, phi = (edges[::step] for edges, step in zip(plan.lobe_edges, BINS, strict=True))
    return rounded(
        {
            "alpha": FAMILY.alpha_x,
            "degrees": DEGREES,
            "heights": heights[: PATCH + 1, : PATCH + 1],
            "paths": np.array([path(surface, aim) for aim in RAYS]),
            "theta": theta,
            "phi": phi,
            "measured": measured / angles,
            "smith": coarse(lobe_of(Smith(Beckmann(FAMILY.alpha_x)), wo, plan), *BINS) / angles,
            "rays": float(plan.side**2 * len(found["surface"])),
            "surfaces": len(found["surface"]),
        },
        digits=5,
    )


if __name__ == "__main__":
    store(sys.argv[1], **compute())
