"""Computes what the figure `measured_distances` shows: how far each model's lobe and albedo are from the measured ones.

Kept with it for the report's text: the same for stretched surfaces, and for surfaces made of Gabor noise.
"""

import sys

import numpy as np
from microfacet.brdf.microfacet import Microfacet
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.compare import apart, coarse, folded, lobe_of, models, noise
from microfacet.surface.measure import estimate
from report.campaign import CAMPAIGN, GABOR_THETA_O, STRETCHED_VIEWS, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10", "stretched", "gabor_07")
BINS = (3, 2)  # so many bins of polar angle and of azimuth are one here


def compare(entry: str) -> dict:
    """One family of surfaces from all its views, which come first in every array; then models."""
    family, plan, found = CAMPAIGN[entry].family, CAMPAIGN[entry].plan, read(entry)
    ndf = Beckmann(family.alpha_x, family.alpha_y)
    names, candidates = list(models(ndf)), models(ndf).values()
    even = family.alpha_x == family.alpha_y
    lobes = coarse(folded(found["lobe"][:, :, 0]) if even else found["lobe"][:, :, 0], *BINS)
    views = np.asarray(plan.views)
    model_lobes = [[coarse(lobe_of(model, wo, plan), *BINS) for model in candidates] for wo in views]
    distance = [[apart(lobes[:, v], model) for model in row] for v, row in enumerate(model_lobes)]
    return {
        "names": names,
        "distance": np.array(distance),
        "noise": np.array([noise(lobes[:, v]) for v in range(len(views))]),
        "albedo": np.array(estimate(found["escaped"][:, :, 0])).T,
        "model_albedo": np.array([[Microfacet(model).albedo(wo) for model in candidates] for wo in views]),
        "bounces": np.moveaxis(np.array(estimate(found["escaped"])), 0, -1),
        "area": np.array(estimate(found["seen"].sum(axis=-1) / views[:, 2])).T,
        "surfaces": len(found["surface"]),
    }


def compute() -> dict:
    isotropic = [compare(entry) for entry in ENTRIES[:3]]
    data = {name: np.array([one[name] for one in isotropic]) for name in isotropic[0]}
    for name in ("stretched", "gabor"):
        data |= {f"{name}_{key}": values for key, values in compare(next(e for e in ENTRIES if name in e)).items()}
    views = {"theta_o": THETA_O, "stretched_views": STRETCHED_VIEWS, "gabor_theta_o": GABOR_THETA_O}
    alpha = [CAMPAIGN[entry].family.alpha_x for entry in ENTRIES[:3]]
    return rounded({"alpha": alpha, "entries": ENTRIES[:3], **views, **data}, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
