"""Computes what the figure `measured_masking` shows: the seen share of facets by their slope, on surfaces and in models."""

import sys

import numpy as np
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")
DEGREES = (60.0, 80.0)
LEAST = 2e-3  # bins with less of the area turned to the viewer are left out


def facets(alpha: float, slopes: np.ndarray) -> np.ndarray:
    """Normals of facets with these slopes along x, in units of alpha, and none across."""
    return spherical(np.arctan(alpha * slopes), np.pi)


def panel(entry: str, degrees: float) -> dict:
    plan, alpha, found = CAMPAIGN[entry].plan, CAMPAIGN[entry].family.alpha_x, read(entry)
    view, wo, edges = THETA_O.index(degrees), spherical(np.radians(degrees)), plan.slope_edges
    seen, faced = found["seen"][:, view], found["faced"][:, view]
    G1, all_G1 = estimate(seen, faced), estimate(seen.sum(axis=-1), faced.sum(axis=-1))
    enough = faced.mean(axis=0) > LEAST * faced.mean(axis=0).sum()
    fine = np.linspace(edges[0], min(edges[-1], 1 / (alpha * np.tan(np.radians(degrees)))), 201)[:-1]
    return {
        "slope": (edges[1:] + edges[:-1]) / 2,
        "G1": np.where(enough, G1.value, np.nan),
        "error": np.where(enough, G1.error, np.nan),
        "fine": fine,
        "smith": Smith(Beckmann(alpha)).G1(wo, facets(alpha, fine)),
        "v_cavity": VCavity(Beckmann(alpha)).G1(wo, facets(alpha, fine)),
        "mean": np.array(all_G1),
    }


def area_seen(entry: str) -> np.ndarray:
    """Seen area over cos theta_o, less 1, for every view: value and standard error."""
    seen = read(entry)["seen"].sum(axis=-1) / np.asarray(CAMPAIGN[entry].plan.views)[:, 2]
    return np.array(estimate(seen)) - [[1], [0]]


def compute() -> dict:
    rows = [[panel(entry, degrees) for entry in ENTRIES] for degrees in DEGREES]
    data = {name: np.array([[one[name] for one in row] for row in rows]) for name in rows[0][0]}
    alpha = [CAMPAIGN[entry].family.alpha_x for entry in ENTRIES]
    area = np.array([area_seen(entry) for entry in ENTRIES])
    return rounded({"alpha": alpha, "degrees": DEGREES, "theta_o": THETA_O, "area": area, **data}, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
