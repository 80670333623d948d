"""Computes what the figure `energy_loss` shows: the share of light that one reflection gives up, with perfect mirrors."""

import sys

import microfacet as mf
import numpy as np
from microfacet.directions import spherical
from microfacet.surface.measure import estimate
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")
ALPHA = np.r_[0.02, np.arange(0.05, 1.001, 0.05)]
THETA = np.radians(np.r_[0:87:3, 86, 88, 89])
SHOWN = (0.1, 0.25, 0.5, 1.0)
NODES = 24
VIEWS = (0.0, 60.0)  # degrees


def lost(ndf: type, alpha: float, theta: np.ndarray) -> np.ndarray:
    brdf = mf.Microfacet(mf.Smith(ndf(alpha)))
    return 1 - brdf.albedo(spherical(theta, np.zeros_like(theta)))


def average(ndf: type, alpha: float) -> float:
    """Of the light that arrives equally from everywhere, which counts by its cosine."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    cosine = (nodes + 1) / 2
    return float((weights * cosine) @ lost(ndf, alpha, np.arccos(cosine)))


def compute() -> dict:
    data = {"alpha": ALPHA, "theta": np.degrees(THETA), "shown": np.array(SHOWN)}
    for name, ndf in (("ggx", mf.GGX), ("beckmann", mf.Beckmann)):
        views = np.radians(VIEWS)
        data[f"{name}_views"] = np.array([lost(ndf, alpha, views) for alpha in ALPHA]).T
        data[f"{name}_average"] = np.array([average(ndf, alpha) for alpha in ALPHA])
        data[f"{name}_angles"] = np.array([lost(ndf, alpha, THETA) for alpha in SHOWN])
    exact = mf.equations["brdf.microfacet.anchor"].kernel
    data["exact"] = 1 - np.array([exact(np.cos(theta)) for theta in THETA])
    data["exact_views"] = 1 - np.array([exact(np.cos(theta)) for theta in np.radians(VIEWS)])
    data["exact_average"] = np.array(1 - float(mf.equations["brdf.microfacet.anchor_average"].equals))
    found = [estimate(read(entry)["escaped"][:, [THETA_O.index(view) for view in VIEWS], 0]) for entry in ENTRIES]
    data["traced_alpha"] = np.array([CAMPAIGN[entry].family.alpha_x for entry in ENTRIES])
    data["traced"] = np.array([[1 - one.value, one.error] for one in found])
    return rounded(data, digits=7)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
