"""Computes what the figure `facets_to_circle` shows: in which bin of the circle each facet's normal lies."""

import sys

import numpy as np
from report.datafile import store
from report.example import example, percentages


def compute() -> dict:
    surface = example(facets=36)
    bounds = np.radians([-60, -36, -12, 12, 36, 60])
    bins = surface.bins(bounds)
    earlier = np.tril(bins[:, None] == bins, -1)
    share = np.bincount(bins, surface.lengths)
    return {
        "x": surface.x,
        "z": surface.z,
        "middle": surface.whole.middle,
        "edges": surface.edges,
        "normals": surface.normals,
        "bounds": bounds,
        "bins": bins,
        "rank": earlier.sum(axis=1),
        "share": share,
        "percent": percentages(share),
    }


if __name__ == "__main__":
    store(sys.argv[1], **compute())
