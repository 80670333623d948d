"""Computes what the figure `digits_D` shows: right digits of D, by the cosine alone and by the library."""

import sys

import numpy as np
from faulty import beckmann_D_cosine, ggx_D_cosine
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.validation.accuracy import ALPHA, PRECISIONS, TANGENT, D, map_of
from report.datafile import rounded, store

METHODS = {"ggx": (GGX, ggx_D_cosine), "beckmann": (Beckmann, beckmann_D_cosine)}
FEW = 3  # digits, below which a value has failed


def sets_in(digits) -> float:
    """The largest roughness at which a facet within the lobe, its slope at most alpha, has failed; 0 if there is none."""
    failing = (digits < FEW) & (ALPHA[:, None] >= TANGENT)
    return ALPHA[failing.any(axis=1)].max(initial=0.0)


def compute() -> dict:
    data = {"alpha": ALPHA, "tangent": TANGENT, "few": FEW}
    for name, (kind, textbook) in METHODS.items():
        for real in PRECISIONS:
            for form, method in (("textbook", textbook), ("library", D)):
                with np.errstate(all="ignore"):
                    found = map_of(method, "D", kind, real)
                data[f"{name}_{form}_{real.__name__}"] = found
                data[f"{name}_{form}_{real.__name__}_worst"] = np.nanmin(found)
                data[f"{name}_{form}_{real.__name__}_from"] = sets_in(found)
    return rounded(data, digits=3)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
