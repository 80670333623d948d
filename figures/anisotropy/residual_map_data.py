"""Computes what the figure `residual_map` shows: how far anisotropic models are from the validation equations, by view."""

import sys

import numpy as np
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX, ggx_Lambda
from microfacet.validation.equations import TOLERANCE, decide, residuals
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity
from report.datafile import rounded, store

ALPHAS, FLOOR = (0.1, 0.6), 1e-10
ROUGHNESS = (0.05, 0.1, 0.25, 0.5, 1.0)
THETA, PHI = np.linspace(0, 88, 12), np.linspace(0, 90, 21)


def mean_Lambda(w, p):
    """GGX's Lambda with one mean roughness for all azimuths: wrong, and here to be found out."""
    x, y, z = w
    return ggx_Lambda(abs(z) / ((p.ndf.alpha_x * p.ndf.alpha_y) ** 0.5 * max((x * x + y * y) ** 0.5, 1e-300)))


class MeanRoughness(Smith):
    """Smith's model with the roughness sqrt(alpha_x alpha_y) in its masking function."""

    def __init__(self, ndf: GGX) -> None:
        super().__init__(ndf)
        self.Lambda_kernel = mean_Lambda


MODELS = {"smith": Smith(GGX(*ALPHAS)), "v_cavity": VCavity(GGX(*ALPHAS)), "mean": MeanRoughness(GGX(*ALPHAS))}


def farthest(model, views) -> tuple[np.ndarray, str]:
    """Largest residual of the four equations at each view, and the verdict on them all."""
    values, bounds = (np.array(part) for part in zip(*residuals(model, views).values(), strict=True))
    return np.max(np.abs(values) + bounds, axis=0), decide(values, bounds, TOLERANCE)


def compute() -> dict:
    theta, phi = np.meshgrid(THETA, PHI, indexing="ij")
    views = spherical(np.radians(theta), np.radians(phi)).reshape(-1, 3)
    data = {"alphas": ALPHAS, "theta": THETA, "phi": PHI, "floor": FLOOR}
    for name, model in MODELS.items():
        apart, data[f"{name}_verdict"] = farthest(model, views)
        data[name] = np.maximum(apart, FLOOR).reshape(theta.shape)
    few = spherical(*np.radians(np.meshgrid([0, 30, 60, 85], [0, 20, 45, 90]))).reshape(-1, 3)
    pairs = [(x, y) for x in ROUGHNESS for y in ROUGHNESS]
    found = [farthest(m(d(*pair)), few) for pair in pairs for m in (Smith, VCavity) for d in (Beckmann, GGX)]
    data["tried"], data["views"] = len(found), len(few)
    data["holding"] = sum(verdict == "holds" for _, verdict in found)
    data["worst"] = 10.0 ** np.ceil(np.log10(max(apart.max() for apart, _ in found)))
    return rounded(data, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
