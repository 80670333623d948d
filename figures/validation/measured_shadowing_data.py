"""Computes what the figure `measured_shadowing` shows: the lit share of what is seen, over azimuth."""

import sys

import numpy as np
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.compare import illuminated_fraction
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import CORRELATIONS, Smith
from microfacet.visibility.v_cavity import VCavity
from report.campaign import CAMPAIGN, read
from report.datafile import rounded, store

ENTRIES = ("azimuths_04", "azimuths_07", "azimuths_10")
DEGREES = 60.0  # of the view
UP = np.array([0.0, 0.0, 1.0])


def smith(alpha: float, theta_i: float, azimuth: np.ndarray) -> np.ndarray:
    """G2/G1 of each form, the same for all facets that are turned to both."""
    wo, wi = spherical(np.radians(DEGREES)), spherical(theta_i, azimuth)
    forms = [Smith(Beckmann(alpha), form) for form in CORRELATIONS]
    return np.array([model.G2(wo, wi, UP) / model.G1(wo, UP) for model in forms])


def cavity(alpha: float, theta_i: float, azimuth: np.ndarray) -> np.ndarray:
    wo, model = spherical(np.radians(DEGREES)), VCavity(Beckmann(alpha))
    return np.array([illuminated_fraction(model, wo, spherical(theta_i, phi)) for phi in azimuth])


def compute() -> dict:
    theta_i, azimuth = (np.array(axis) for axis in CAMPAIGN[ENTRIES[0]].plan.lights)
    alpha = [CAMPAIGN[entry].family.alpha_x for entry in ENTRIES]
    found = [read(entry) for entry in ENTRIES]
    lit = [estimate(one["lit"][:, 0], one["facing"][:, 0]) for one in found]
    return rounded(
        {
            "alpha": alpha,
            "degrees": DEGREES,
            "theta_i": np.degrees(theta_i),
            "azimuth": np.degrees(azimuth),
            "forms": list(CORRELATIONS),
            "lit": np.array([one.value for one in lit]),
            "error": np.array([one.error for one in lit]),
            "smith": np.array([[smith(a, theta, azimuth) for theta in theta_i] for a in alpha]),
            "v_cavity": np.array([[cavity(a, theta, azimuth) for theta in theta_i] for a in alpha]),
        },
        digits=5,
    )


if __name__ == "__main__":
    store(sys.argv[1], **compute())
