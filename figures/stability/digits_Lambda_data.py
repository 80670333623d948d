"""Computes what the figure `digits_Lambda` shows: right digits of Smith's Lambda, by the closed forms and by the library."""

import sys

import numpy as np
from faulty import beckmann_Lambda_erf, beckmann_Lambda_erfc, ggx_Lambda_difference, walter_Lambda
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.validation.accuracy import ALPHA, PRECISIONS, TANGENT, Lambda, digits, directions, exact_Lambda, map_of
from report.datafile import rounded, store

MAPS = {
    "ggx_root": (GGX, ggx_Lambda_difference),
    "ggx_library": (GGX, Lambda),
    "beckmann_erf": (Beckmann, beckmann_Lambda_erf),
    "beckmann_library": (Beckmann, Lambda),
}
CURVES = {**MAPS, "beckmann_erfc": (Beckmann, beckmann_Lambda_erfc), "beckmann_walter": (Beckmann, walter_Lambda)}
SLOPES = {GGX: np.logspace(-2, 8, 181), Beckmann: np.geomspace(0.05, 26, 181)}  # a = 1/(alpha tan theta)
FEW = 3  # digits, below which a value has failed


def curve(kind, method, real) -> np.ndarray:
    """Right digits over a, at alpha = 1."""
    views, ndf = directions(real, 1 / SLOPES[kind]), kind(1.0)
    return digits(method(ndf, views), [exact_Lambda(ndf, wo) for wo in views], real)


def compute() -> dict:
    data = {"alpha": ALPHA, "tangent": TANGENT, "few": FEW, "ggx_a": SLOPES[GGX], "beckmann_a": SLOPES[Beckmann]}
    for real in PRECISIONS:
        with np.errstate(all="ignore"):
            for name, (kind, method) in MAPS.items():
                data[f"{name}_{real.__name__}"] = map_of(method, "Lambda", kind, real)
            for name, (kind, method) in CURVES.items():
                found = curve(kind, method, real)
                case = f"{name}_{real.__name__}"
                data |= {f"{case}_curve": found, f"{case}_worst": np.nanmin(found)}
                data[f"{case}_from"] = SLOPES[kind][found < FEW].min(initial=np.inf)
    return rounded(data, digits=3)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
