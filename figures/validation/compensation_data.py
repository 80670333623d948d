"""Computes what the figure `compensation` shows: how far one bounce, and what makes up for later ones, are from all of them."""

import sys

import numpy as np
from microfacet.brdf.compensation import FORMS, Compensated
from microfacet.brdf.microfacet import Microfacet
from microfacet.brdf.random_walk import RandomWalk
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.material.fresnel import Schlick
from microfacet.surface.compare import binned, coarse, folded, misplaced, walked
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import Smith
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")
BINS = (3, 2)  # so many bins of polar angle and of azimuth are one here
WALKS = 1 << 20
ALPHAS, F0 = (0.25, 0.5, 1.0), (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
NODES, EACH = 8, 1 << 16  # of the rule over angles; walks at each


def distances(entry: str) -> np.ndarray:
    """Light in the wrong place for each view and model, and its standard error: one bounce, both forms, walks."""
    plan, ndf = CAMPAIGN[entry].plan, Beckmann(CAMPAIGN[entry].family.alpha_x)
    lobes = coarse(folded(read(entry)["lobe"].sum(axis=2)), *BINS)
    once, walk = Microfacet(Smith(ndf)), RandomWalk(Smith(ndf))
    brdfs = [once, *(Compensated(once, form) for form in FORMS)]
    rows = []
    for v, wo in enumerate(np.asarray(plan.views)):
        models = [*(binned(brdf, wo, plan) for brdf in brdfs), folded(walked(walk, wo, plan, WALKS))]
        rows.append([misplaced(lobes[:, v], coarse(light, *BINS)) for light in models])
    return np.array(rows)


def noise(entry: str) -> np.ndarray:
    """What the scatter between surfaces alone would show, for each view."""
    error = estimate(coarse(folded(read(entry)["lobe"].sum(axis=2)), *BINS)).error
    return np.asarray(0.5 * np.sqrt(2 / np.pi) * error.sum(axis=(-2, -1)))


def forward(entry: str) -> np.ndarray:
    """Of the light that leaves surfaces after the first bounce, the share that goes on, away from the viewer, for each view."""
    later = read(entry)["lobe"][:, :, 1].mean(axis=(0, 2))
    turn = CAMPAIGN[entry].plan.lobe_edges[1]
    on = abs(turn[1:] + turn[:-1]) > np.pi
    return np.asarray(later[:, on].sum(axis=-1) / later.sum(axis=-1))


def reflected(alpha: float, f0: float) -> np.ndarray:
    """Of light from everywhere, what metals of this F0 reflect: one bounce, both forms, walks, and the walks' error."""
    x, weigh = np.polynomial.legendre.leggauss(NODES)
    cosine = (x + 1) / 2
    wo, share = spherical(np.arccos(cosine)), weigh * cosine
    once = Microfacet(Smith(GGX(alpha)), Schlick(f0))
    walk = RandomWalk(Smith(GGX(alpha)), Schlick(f0)).albedo_with_error(wo, EACH)
    forms = [share @ Compensated(once, form).albedo(wo) for form in FORMS]
    return np.array([share @ once.albedo(wo), *forms, share @ walk.value, share @ walk.error])


def compute() -> dict:
    return rounded(
        {
            "alpha": [CAMPAIGN[entry].family.alpha_x for entry in ENTRIES],
            "theta_o": THETA_O,
            "names": ["one bounce", "lobe added", "scaled", "random walk"],
            "distance": np.array([distances(entry) for entry in ENTRIES]),
            "noise": np.array([noise(entry) for entry in ENTRIES]),
            "forward": np.array([forward(entry) for entry in ENTRIES]),
            "metal_alpha": ALPHAS,
            "F0": F0,
            "metal": np.array([[reflected(alpha, f0) for f0 in F0] for alpha in ALPHAS]),
        },
        digits=5,
    )


if __name__ == "__main__":
    store(sys.argv[1], **compute())
