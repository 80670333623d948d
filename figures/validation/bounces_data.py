"""Computes what the figure `bounces` shows: after how many reflections light leaves, on surfaces and in models."""

import sys

import numpy as np
from microfacet.brdf.microfacet import Microfacet
from microfacet.brdf.random_walk import RandomWalk
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")
WALKS = 1 << 17  # from each view: their error is below that of the surfaces
ORDERS = 3  # told apart; what leaves later is one more


def measured(entry: str) -> tuple[np.ndarray, np.ndarray]:
    """Shares of the light by reflections, what leaves after more than `ORDERS` as one; with standard errors."""
    escaped = read(entry)["escaped"]
    found = estimate(np.concatenate([escaped[..., :ORDERS], escaped[..., ORDERS:].sum(axis=-1, keepdims=True)], axis=-1))
    return found.value, found.error


def walked(ndf: Beckmann, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same of Smith's surface."""
    left = RandomWalk(Smith(ndf)).albedo_by_bounce(wo, WALKS, orders=ORDERS)
    value, error = np.column_stack([left.value, left.more]), np.column_stack([left.error, left.more_error])
    assert not left.under_way.any()
    return value, error


def compute() -> dict:
    fine = np.linspace(0, THETA_O[-1], 33)
    wo, views = spherical(np.radians(fine)), spherical(np.radians(THETA_O))
    ndfs = [Beckmann(CAMPAIGN[entry].family.alpha_x) for entry in ENTRIES]
    found, walks = [measured(entry) for entry in ENTRIES], [walked(ndf, views) for ndf in ndfs]
    return rounded(
        {
            "alpha": [ndf.alpha_x for ndf in ndfs],
            "theta_o": THETA_O,
            "fine": fine,
            "share": np.array([read(entry)["escaped"].mean(axis=0) for entry in ENTRIES]),
            "by_order": np.array([value for value, _ in found]),
            "error": np.array([error for _, error in found]),
            "walk": np.array([value for value, _ in walks]),
            "walk_error": np.array([error for _, error in walks]),
            "walk_fine": np.array([walked(ndf, wo)[0] for ndf in ndfs]),
            "smith": np.array([Microfacet(Smith(ndf)).albedo(wo) for ndf in ndfs]),
            "v_cavity": np.array([Microfacet(VCavity(ndf)).albedo(wo) for ndf in ndfs]),
        },
        digits=5,
    )


if __name__ == "__main__":
    store(sys.argv[1], **compute())
