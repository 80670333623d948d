"""A hundred million rays: does what is seen see back? Prints false verdicts so far; not a test, it takes minutes.

    python tests/surface/many_rays.py

From random directions onto surfaces of three roughnesses, and from where they hit back again. A ray that leaks through an
edge is lost or sees what does not see it; one that hits its own facet, or a neighbour that it should pass, does not get back.
"""

from __future__ import annotations

import math

import numpy as np
from microfacet.directions import spherical
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField

SURFACES, RAYS = 50, 1_000_000
ALPHAS = (0.4, 0.7, 1.0)


def false_verdicts(k: int) -> tuple[int, int]:
    """Rays on surface k that are lost on the way down, and those that do not get back."""
    field, rng = HeightField(GaussianField(1024, ALPHAS[k % 3], root=k).spectral(0)), np.random.default_rng(k)
    wo = spherical(math.radians(rng.uniform(0, 85)), rng.uniform(0, 2 * math.pi))
    origins = np.column_stack([rng.uniform(0, field.size, (RAYS, 2)), np.full(RAYS, field.highest)])
    hits = field.trace(origins, -wo)
    back = field.escapes(field.points(origins, -wo, hits.distance), wo, hits.facet)
    return int((hits.facet < 0).sum()), int((~back).sum())


if __name__ == "__main__":
    lost = wrong = 0
    for k in range(SURFACES):
        here = false_verdicts(k)
        lost, wrong = lost + here[0], wrong + here[1]
        print(f"{2 * RAYS * (k + 1):.0e} rays: {lost} lost, {wrong} do not get back", flush=True)
