"""Computes what the figure `anisotropic_normals` shows: maps of D, and the projected area over both roughnesses."""

import sys

import numpy as np
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.geometry.ward import Ward
from microfacet.validation.equations import ABOVE, TOLERANCE, decide, residual
from microfacet.visibility.v_cavity import VCavity
from report.datafile import rounded, store

ALPHAS = (0.6, 0.2)
TRIED = np.arange(1, 17) / 16
RADIUS = np.linspace(0, 1, 81) ** 0.75
PHI = np.linspace(0, 2 * np.pi, 145)


def disc() -> np.ndarray:
    """Normals over the hemisphere, shape (azimuths, radii, 3); the rim lies on the horizon."""
    phi, radius = np.meshgrid(PHI, np.minimum(RADIUS, 0.9999), indexing="ij")
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1 - radius**2)], axis=-1)


def compute() -> dict:
    normals = disc()
    data = {"alphas": ALPHAS, "tried": TRIED, "x": normals[..., 0], "y": normals[..., 1]}
    for name, family in (("beckmann", Beckmann), ("ggx", GGX), ("ward", Ward)):
        data[name] = np.maximum(family(*ALPHAS).D(normals), 1e-12)
        pairs = [[residual(VCavity(family(x, y)), "projected_area", ABOVE) for x in TRIED] for y in TRIED]
        values, bounds = np.moveaxis(np.array(pairs)[..., 0], -1, 0)
        data[f"{name}_area"] = np.round(1 + values, 9)
        data[f"{name}_keeps"] = np.abs(values) + bounds <= TOLERANCE
        data[f"{name}_worst"] = 10.0 ** np.ceil(np.log10(np.max(np.abs(values) + bounds)))
        data[f"{name}_verdict"] = decide(values, bounds, TOLERANCE)
    return rounded(data, digits=6)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
