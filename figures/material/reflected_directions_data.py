"""Computes what the figure `reflected_directions` shows: shares of the visible parts and of the beams they reflect."""

import sys

import numpy as np
from microfacet.surface.profile import direction, mirror
from report.datafile import store
from report.example import example, percentages


def compute() -> dict:
    wo, surface = direction(np.radians(60.0)), example()
    seen, wi = surface.visible(wo), mirror(wo, surface.normals)
    return {
        "wo": wo,
        "wi": wi,
        "x": surface.x,
        "z": surface.z,
        "ends": seen.ends,
        "middle": seen.middle,
        "normals": surface.normals,
        "seen": seen.projected(wo) / wo[1],
        "reflected": seen.projected(wi) / wo[1],
        "seen_percent": percentages(seen.projected(wo)),
        "reflected_percent": percentages(seen.projected(wi)),
    }


if __name__ == "__main__":
    store(sys.argv[1], **compute())
