"""Computes what the figure `microsurface` shows: the shared profile, its normals and its length."""

import sys

from report.datafile import store
from report.example import example


def compute() -> dict:
    surface = example()
    return {
        "x": surface.x,
        "z": surface.z,
        "middle": surface.whole.middle,
        "normals": surface.normals,
        "length": surface.lengths.sum(),
    }


if __name__ == "__main__":
    store(sys.argv[1], **compute())
