"""Computes what the figure `measured_normals` shows: which slopes fill the view, on surfaces and in models."""

import sys

import numpy as np
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.compare import apart, noise, normals_of
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")
DEGREES = 80.0
MODELS = {"v_cavity": VCavity, "smith": Smith}


def along(alpha: float, slopes: np.ndarray, model) -> np.ndarray:
    """Share of the view per slope along it, in units of alpha: both models' G1 depend on no other slope."""
    theta = np.radians(DEGREES)
    G1 = model.G1(spherical(theta), spherical(np.arctan(alpha * slopes), np.pi))
    return G1 * np.maximum(1 - alpha * slopes * np.tan(theta), 0) * np.exp(-(slopes**2)) / np.sqrt(np.pi)


def panel(entry: str) -> dict:
    plan, alpha, found = CAMPAIGN[entry].plan, CAMPAIGN[entry].family.alpha_x, read(entry)
    view, edges = THETA_O.index(DEGREES), CAMPAIGN[entry].plan.slope_edges
    wo, fine = np.asarray(plan.views)[view], np.linspace(edges[0], edges[-1], 301)
    share = estimate(found["seen"][:, view], found["seen"][:, view].sum(axis=-1, keepdims=True))
    models = {name: make(Beckmann(alpha)) for name, make in MODELS.items()}
    distance = [apart(found["normals"][:, view], normals_of(model, wo, plan)) for model in models.values()]
    return {
        "edges": edges,
        "fine": fine,
        "all": np.exp(-(fine**2)) / np.sqrt(np.pi),
        "seen": share.value / np.diff(edges),
        "error": share.error / np.diff(edges),
        **{name: along(alpha, fine, model) for name, model in models.items()},
        "distance": np.array(distance),
        "noise": noise(found["normals"][:, view]),
    }


def compute() -> dict:
    panels = [panel(entry) for entry in ENTRIES]
    data = {name: np.array([one[name] for one in panels]) for name in panels[0]}
    alpha = [CAMPAIGN[entry].family.alpha_x for entry in ENTRIES]
    return rounded({"alpha": alpha, "degrees": DEGREES, **data}, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
