"""Computes what the figure `enough_map` shows: errors of all candidates over roughness, and which is the cheapest within."""

import sys
from pathlib import Path

import microfacet as mf
import numpy as np
from microfacet.enough import cost
from microfacet.enough.candidates import COMPENSATIONS, Candidate, maskings
from microfacet.enough.choice import MEASURES, cheapest_first
from microfacet.enough.comparison import Comparison
from microfacet.enough.scene import Scene
from report.datafile import rounded, store

ALPHA = np.geomspace(0.05, 1, 8)
THETA = (0.0, 80.0)
RECORD = Path("records/benchmarks.json")
METAL = mf.Conductor(0.2, 3.9)  # close to silver in green light, as in the figure `spheres`
GLASS = mf.Dielectric(1.5)
SURFACES, WALKS = 12, 1 << 17
NORMALS = ("ggx", "beckmann")


def complete(normals: str, compensation: str) -> Candidate:
    """Nothing is simplified but, perhaps, what happens after the first bounce."""
    return Candidate(normals, "height", "exact", False, compensation, False)


def glass() -> np.ndarray:
    """What is sure to be no less than the error of a picture of glass by one bounce of GGX, for each roughness."""
    scenes = [Scene(alpha, THETA, normals="ggx", fresnel=GLASS) for alpha in ALPHA]
    return np.array([Comparison(one, SURFACES, WALKS).measured(complete("ggx", "none"), "picture").most for one in scenes])


def errors(normals: str, order: list[Candidate]) -> tuple[np.ndarray, np.ndarray]:
    """What is sure to be no less than the error, and the bound in it: (measures, roughnesses, candidates)."""
    most, bound = np.zeros((2, len(MEASURES), len(ALPHA), len(order)))
    for k, alpha in enumerate(ALPHA):
        comparison = Comparison(Scene(alpha, THETA, normals=normals, fresnel=METAL), SURFACES, WALKS)
        for m, measure in enumerate(MEASURES):
            found = [comparison.measured(one, measure) for one in order]
            most[m, k], bound[m, k] = [one.most for one in found], [one.error.bound for one in found]
    return most, bound


def compute() -> dict:
    costs = cost.recorded(RECORD)
    data: dict = {"alpha": ALPHA, "theta": THETA, "measures": np.array(list(MEASURES))}
    for normals in NORMALS:
        order = [one for one, _ in cheapest_first(Scene(ALPHA[0], THETA, normals=normals, fresnel=METAL), costs)]
        most, bound = errors(normals, order)
        data |= {
            f"{normals}_maskings": np.array([maskings()[one.masking][0] for one in order]),
            f"{normals}_words": np.array([one.label for one in order]),
            f"{normals}_complete": np.array([order.index(complete(normals, one)) for one in COMPENSATIONS]),
            f"{normals}_most": most,
            f"{normals}_bound": bound,
        }
    return rounded(data | {"timed": np.array(bool(costs)), "glass_picture": glass()}, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
