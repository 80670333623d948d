"""Computes what the figure `projection` shows: every facet's length and its projection onto the plane."""

import sys

from microfacet.surface.profile import direction
from report.datafile import store
from report.example import example, percentages


def compute() -> dict:
    surface = example()
    projected = surface.whole.projected(direction(0.0))
    return {
        "x": surface.x,
        "z": surface.z,
        "ends": surface.whole.ends,
        "middle": surface.whole.middle,
        "normals": surface.normals,
        "area": surface.lengths.sum(),
        "projected": projected,
        "thousandths": percentages(projected, total=1000),
    }


if __name__ == "__main__":
    store(sys.argv[1], **compute())
