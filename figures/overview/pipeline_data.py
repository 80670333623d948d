"""Computes what the figure `pipeline` shows: the stages of one polyline, the sums to be checked and the final lobe."""

import sys

import numpy as np
from microfacet.surface.profile import Profile, angle, direction, mirror
from report.datafile import store
from report.example import example

THETA_O = np.radians(50.0)
SURFACES = 1200


def lobe(wo: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Share of the view that ``wo`` leaves in each bin of angles, over many polylines, per radian."""
    total = np.zeros(len(bounds) - 1)
    for seed in range(SURFACES):
        surface = Profile.gaussian(alpha=0.4, facets=64, waves=8, seed=seed)
        wi = mirror(wo, surface.normals)
        free = surface.visible(wo).both(surface.escaping(wi))
        total += np.histogram(angle(wi), bounds, weights=free.projected(wo))[0]
    return total / SURFACES / wo[1] / np.diff(bounds)


def compute() -> dict:
    wo, surface = direction(THETA_O), example()
    seen, wi = surface.visible(wo), mirror(wo, surface.normals)
    free = seen.both(surface.escaping(wi))
    bounds = np.linspace(-np.pi / 2, np.pi / 2, 37)
    sums = np.array(
        [
            surface.whole.projected(direction(0.0)).sum(),
            seen.projected(wo).sum(),
            seen.projected(wi).sum() / wo[1],
            free.projected(wo).sum() / wo[1],
        ]
    )
    conserved = np.abs(sums[:3] - [1, np.cos(THETA_O), 1]) < 1e-12
    back = surface.escaping(np.broadcast_to(wo, wi.shape)).both(surface.escaping(wi))
    classic = np.all(free.projected(wo) >= 0), np.allclose(free.projected(wo), back.projected(wi)), sums[3] <= 1
    return {
        "wo": wo,
        "x": surface.x,
        "z": surface.z,
        "ends": seen.ends,
        "middle": seen.middle[seen.fraction > 0],
        "ways": np.stack([np.broadcast_to(wo, wi.shape), wi])[:, seen.fraction > 0],
        "theta": (bounds[1:] + bounds[:-1]) / 2,
        "lobe": lobe(wo, bounds),
        "sums": sums,
        "holds": np.append(conserved, sums[3] <= 1),
        "classic": np.array(classic),
    }


if __name__ == "__main__":
    store(sys.argv[1], **compute())
