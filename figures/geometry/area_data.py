"""Computes what the figure `area` shows: the area of a microsurface from closed forms, by quadrature, and on surfaces."""

import sys
from functools import cache

import numpy as np
from microfacet.directions import spherical
from microfacet.geometry import beckmann, ggx
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.geometry.roughness import SlopeScale
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField
from microfacet.surface.measure import estimate
from microfacet.validation.equations import ABOVE
from microfacet.visibility.masking import no_Lambda
from microfacet.visibility.quadrature import VisibleParameters, visible_integral
from report.datafile import rounded, store

CHECKED = np.linspace(0.1, 1.0, 10)
MADE = np.linspace(0.2, 1.0, 5)
SURFACES = 8
SHOWN = 0.5


@cache
def facets(normals):
    """The integrand D; from straight above, all facets are seen."""

    def facets(Lambda_o, wo, wm, p):
        return normals(wm, p.ndf)

    return facets


def made(alpha: float) -> tuple[float, float]:
    """Area of all facets of Gaussian surfaces, per area of the plane, and its standard error over surfaces."""
    family = GaussianField(256, alpha, correlation=12, root=34)
    slopes = np.array([HeightField(family.spectral(k)).slopes for k in range(SURFACES)])
    area = estimate(np.sqrt(1 + (slopes**2).sum(axis=-1)).mean(axis=-1))
    return float(area.value), float(area.error)


def measured(ndf) -> tuple[float, float]:
    """Area by quadrature, and its difference from a coarser rule."""
    batch = visible_integral(no_Lambda, facets(type(ndf).kernel), type(ndf).kernel)
    sums = batch([ABOVE], VisibleParameters(ndf.parameters, (), SlopeScale(*ndf.slope_scale)))
    return sums[0], abs(sums[0] - sums[1])


def compute() -> dict:
    alpha, theta = np.linspace(0.01, 0.999, 150), np.linspace(0, np.pi / 2, 181)
    surfaces = np.array([made(a) for a in MADE]).T
    data = {
        "alpha": alpha,
        "checked": CHECKED,
        "made": MADE,
        "theta": np.degrees(theta),
        "shown": SHOWN,
        "made_area": surfaces[0],
        "made_error": surfaces[1],
    }
    for name, module, family in (("beckmann", beckmann, Beckmann), ("ggx", ggx, GGX)):
        found = np.array([measured(family(a)) for a in CHECKED])
        data[name] = module.area.kernel(alpha)
        data[f"{name}_checked"] = found[:, 0]
        apart = np.abs(found[:-1, 0] / np.array([float(module.area.exact(a)) for a in CHECKED[:-1]]) - 1)
        data[f"{name}_apart"] = 10.0 ** np.ceil(np.log10(apart.max() + 1e-13))
        data[f"{name}_density"] = 2 * np.pi * np.sin(theta) * family(SHOWN).D(spherical(theta)) * np.pi / 180
    return rounded(data)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
