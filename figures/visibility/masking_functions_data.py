"""Computes what the figure `masking_functions` shows: how much of the view each masking function fills, over its angle."""

import sys

import numpy as np
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.validation.equations import TOLERANCE, decide, residual
from report.datafile import rounded, store
from report.tables import maskings

DISTRIBUTIONS = (Beckmann(0.4), GGX(1.0))
FLOOR = 1e-11  # above the quadrature's error for every curve here


def compute() -> dict:
    theta = np.append(np.linspace(0, 89, 90), 89.5)
    views = spherical(np.radians(theta))
    share, apart, verdict = [], [], []
    functions = maskings()
    for ndf in DISTRIBUTIONS:
        for make, _ in functions.values():
            values, bounds = residual(make(ndf), "visible_area", views)
            share.append(1 + values)
            apart.append(np.where(np.abs(values) > FLOOR, np.abs(values), FLOOR))
            verdict.append(decide(values, bounds, TOLERANCE))
    shape = (len(DISTRIBUTIONS), len(functions))
    curves = {name: np.reshape(found, (*shape, -1)) for name, found in (("share", share), ("apart", apart))}
    passing = np.reshape(verdict, shape)
    return rounded({"theta": theta, "floor": FLOOR, **curves, "names": list(functions), "verdict": passing})


if __name__ == "__main__":
    store(sys.argv[1], **compute())
