"""Computes what the figure `masking` shows: what a viewer sees of a flat, a fine and a magnified surface."""

import sys

import numpy as np
from microfacet.surface.profile import Profile, direction
from report.datafile import store
from report.example import example, percentages

THETA_O = np.radians(60.0)


def compute() -> dict:
    wo, surface = direction(THETA_O), example()
    views = {"flat": Profile(np.array([0.0, 1.0]), np.zeros(2)), "fine": surface.repeat(12), "zoom": surface}
    data = {"wo": wo, "cosine": np.cos(THETA_O), "degrees": np.degrees(THETA_O)}
    for name, view in views.items():
        seen = view.visible(wo)
        data |= {f"{name}_x": view.x, f"{name}_z": view.z, f"{name}_ends": seen.ends}
        data |= {f"{name}_projected": seen.projected(wo), f"{name}_G1": seen.fraction}
    data["thousandths"] = percentages(data["zoom_projected"], total=round(1000 * data["zoom_projected"].sum()))
    return data


if __name__ == "__main__":
    store(sys.argv[1], **compute())
