"""Computes what the figure `furnace` shows: what a surface in even light sends to each view, by five masking functions."""

import sys

import microfacet as mf
import numpy as np
from microfacet.validation.equations import residual
from report.datafile import rounded, store

ALPHA = 0.5
THETA = np.radians(np.append(np.arange(0, 89, 1.0), [89.0, 89.5, 89.9]))
MODELS = {
    "Smith": mf.Smith,
    "V-cavities": mf.VCavity,
    "Schlick-Smith": mf.SchlickSmith,
    "Kelemen": mf.Kelemen,
    "Implicit": mf.Implicit,
}


def compute() -> dict:
    wo = mf.spherical(THETA)
    models = [make(mf.GGX(ALPHA)) for make in MODELS.values()]
    weak = np.array([1 + residual(model, "weak_furnace", wo)[0] for model in models])
    once = np.array([mf.Microfacet(model).albedo(wo) for model in models])
    names = {"name": np.array(list(MODELS)), "alpha": np.array(ALPHA)}
    return rounded({"theta": THETA, "light": np.stack([weak, once])}, digits=9) | names


if __name__ == "__main__":
    store(sys.argv[1], **compute())
