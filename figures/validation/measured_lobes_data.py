"""Computes what the figure `measured_lobes` shows: lobes of two models and of surfaces, and their distances."""

import sys

import numpy as np
from microfacet.brdf.microfacet import Microfacet
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.compare import apart, coarse, folded, lobe_of, noise
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")
DEGREES = 60.0
BINS = (3, 2)  # so many bins of polar angle and of azimuth are one here


def column(entry: str) -> dict:
    """One roughness: lobes as BRDF times cosine, albedos, distances; models first, the measured one last."""
    family, plan = CAMPAIGN[entry].family, CAMPAIGN[entry].plan
    view, ndf = THETA_O.index(DEGREES), Beckmann(family.alpha_x)
    wo, found = np.asarray(plan.views)[view], read(entry)
    measured = coarse(folded(found["lobe"][:, view, 0]), *BINS)
    both = VCavity(ndf), Smith(ndf)
    lobes = [coarse(lobe_of(model, wo, plan), *BINS) for model in both]
    albedo = estimate(found["escaped"][:, view, 0])
    distances = [apart(measured, lobe) for lobe in lobes]
    return {
        "lobe": np.array([*lobes, measured.mean(axis=0)]) / coarse(plan.solid_angle, *BINS),
        "albedo": np.array([*(Microfacet(model).albedo(wo) for model in both), albedo.value]),
        "albedo_error": albedo.error,
        "distance": np.array([d.value for d in distances]),
        "distance_error": np.array([d.error for d in distances]),
        "noise": noise(measured),
        "surfaces": len(measured),
    }


def compute() -> dict:
    theta, phi = (edges[::step] for edges, step in zip(CAMPAIGN[ENTRIES[0]].plan.lobe_edges, BINS, strict=True))
    columns = [column(entry) for entry in ENTRIES]
    data = {name: np.array([one[name] for one in columns]) for name in columns[0]}
    alpha = [CAMPAIGN[entry].family.alpha_x for entry in ENTRIES]
    return rounded({"alpha": alpha, "degrees": DEGREES, "theta": theta, "phi": phi, **data}, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
