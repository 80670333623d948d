"""Computes what the figure `visible_normals` shows: the share of each bin of normals, before and after visibility."""

import sys

import numpy as np
from microfacet.surface.profile import direction
from report.datafile import store
from report.example import example, percentages


def compute() -> dict:
    wo, surface = direction(np.radians(60.0)), example()
    bounds = np.radians([-60, -36, -12, 12, 36, 60])
    bins = surface.bins(bounds)
    seen = surface.visible(wo)
    data = {"wo": wo, "x": surface.x, "z": surface.z, "bins": bins, "bounds": bounds, "normals": surface.normals}
    for name, part, share in (("all", surface.whole, surface.lengths), ("seen", seen, seen.projected(wo))):
        percent = percentages(share)
        data |= {f"{name}_ends": part.ends, f"{name}_middle": part.middle, f"{name}_percent": percent}
        data |= {f"{name}_bin_percent": np.bincount(bins, percent, minlength=5).astype(int)}
    return data


if __name__ == "__main__":
    store(sys.argv[1], **compute())
