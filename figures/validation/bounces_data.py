"""Computes what the figure `bounces` shows: after how many reflections light leaves, on surfaces and in models of one."""

import sys

import numpy as np
from microfacet.brdf.specular import Microfacet
from microfacet.datafile import rounded, store
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.campaign import CAMPAIGN, THETA_O, read
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")


def compute() -> dict:
    fine = np.linspace(0, THETA_O[-1], 41)
    wo = spherical(np.radians(fine))
    ndfs = [Beckmann(CAMPAIGN[entry].family.alpha_x) for entry in ENTRIES]
    left = [estimate(read(entry)["escaped"]) for entry in ENTRIES]
    return rounded(
        {
            "alpha": [ndf.alpha_x for ndf in ndfs],
            "theta_o": THETA_O,
            "fine": fine,
            "share": np.array([one.value for one in left]),
            "error": np.array([one.error for one in left]),
            "smith": np.array([Microfacet(Smith(ndf)).albedo(wo) for ndf in ndfs]),
            "v_cavity": np.array([Microfacet(VCavity(ndf)).albedo(wo) for ndf in ndfs]),
        },
        digits=5,
    )


if __name__ == "__main__":
    store(sys.argv[1], **compute())
