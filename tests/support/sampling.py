"""The density of a sampler by its own Jacobian, pointwise and exact to rounding.

A map of the unit square has the density 1/|d direction/d u|. With a density that integrates to 1 this leaves nothing for
chance to hide; the chi-square of microfacet.validation.chi_square is the test that also sees single precision.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Sampler = Callable[[np.ndarray], np.ndarray]
Density = Callable[[np.ndarray], np.ndarray]


def density_times_area(sample: Sampler, density: Density, u: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """density(m(u)) |dm/du1 x dm/du2| by central differences: 1 where the sampler has this density."""
    slopes = []
    for axis in np.eye(2) * step:
        far, near = sample(u + axis), sample(u - axis)
        wide = (sample(u + 2 * axis) - sample(u - 2 * axis)) / (4 * step)
        slopes.append((4 * (far - near) / (2 * step) - wide) / 3)
    return density(sample(u)) * np.linalg.norm(np.cross(*slopes), axis=-1)
