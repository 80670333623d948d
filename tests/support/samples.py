"""Directions and models that several tests share: every kernel takes a second to compile, so they keep to few."""

from __future__ import annotations

import microfacet as mf
import numpy as np
from microfacet.directions import spherical

UP = np.array([0.0, 0.0, 1.0])
LAST = 1 - 2.0**-53  # the largest double below 1
LAST_SINGLE = np.float32(1 - 2.0**-24)

ISOTROPIC = [mf.GGX(0.4), mf.Beckmann(0.4), mf.NormalizedBlinnPhong(8.0)]
ANISOTROPIC = [mf.GGX(0.5, 0.2), mf.Beckmann(0.2, 0.5)]
NORMALISED = ISOTROPIC + ANISOTROPIC
STRETCHED = (mf.GGX, mf.Beckmann, mf.Ward)


def uniform(count: int, seed: int = 0, real: type = np.float64) -> np.ndarray:
    """Numbers (count, 2) in [0, 1)."""
    return np.random.default_rng(seed).random((count, 2), real)


def hemisphere(count: int, seed: int = 0) -> np.ndarray:
    """Directions (count, 3), uniform over the upper hemisphere."""
    u = uniform(count, seed)
    return spherical(np.arccos(1 - u[:, 0]), 2 * np.pi * u[:, 1])


def sphere(count: int, seed: int = 0) -> np.ndarray:
    """Directions (count, 3), uniform over the sphere."""
    u = uniform(count, seed)
    return spherical(np.arccos(1 - 2 * u[:, 0]), 2 * np.pi * u[:, 1])


def views(*degrees: float, azimuth: float = 35.0) -> np.ndarray:
    return spherical(np.radians(degrees), np.radians(azimuth))
