"""Computes what the figure `alpha_o` shows: roughness along a direction, and masking that follows from it."""

import sys

import numpy as np
from microfacet.compiler.batch import Batch
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.geometry.roughness import SlopeScale
from microfacet.visibility.masking import ModelParameters
from microfacet.visibility.smith import Smith, alpha_o, quadrature_Lambda
from report.datafile import rounded, store

ALPHAS = (0.2, 0.6)
DEGREES, SHOWN = 75.0, 35.0
UP = np.array([0.0, 0.0, 1.0])


def by_quadrature(ndf, views):
    """Smith's G1 with Lambda integrated over the half-plane of hidden slopes of the stretched distribution."""
    Lambda = Batch(quadrature_Lambda(type(ndf).kernel), [3])
    return 1 / (1 + Lambda([views], ModelParameters(ndf.parameters, SlopeScale(*ndf.slope_scale))))


def compute() -> dict:
    phi = np.linspace(0, 360, 145)
    turn = np.radians(phi)
    views = spherical(np.radians(DEGREES), turn)
    along = alpha_o.kernel(*views.T, *ALPHAS)
    data = {"alphas": ALPHAS, "degrees": DEGREES, "shown": SHOWN, "phi": phi, "alpha_o": along}
    data["at"] = alpha_o.kernel(*spherical(np.radians(DEGREES), np.radians(SHOWN)), *ALPHAS)
    few = np.arange(0, 73, 6)
    for name, family in (("beckmann", Beckmann), ("ggx", GGX)):
        data[name] = np.array([Smith(family(a)).G1(view, UP) for a, view in zip(along, views, strict=True)])
        data[f"{name}_mean"] = Smith(family(np.sqrt(np.prod(ALPHAS)))).G1(views[0], UP)
        data[f"{name}_quadrature"] = by_quadrature(family(*ALPHAS), views[few])
        apart = np.abs(data[f"{name}_quadrature"] / data[name][few] - 1).max()
        data[f"{name}_apart"] = 10.0 ** np.ceil(np.log10(apart + 1e-14))
    return rounded({**data, "quadrature_phi": phi[few]})


if __name__ == "__main__":
    store(sys.argv[1], **compute())
