"""Directions and models that several tests share: every kernel takes a second to compile, so they keep to few."""

from __future__ import annotations

import microfacet as mf
import numpy as np
from microfacet.directions import spherical
from microfacet.families import families
from microfacet.geometry.slopes import Distribution, Stretched

UP = np.array([0.0, 0.0, 1.0])
LAST = 1 - 2.0**-53  # the largest double below 1
LAST_SINGLE = np.float32(1 - 2.0**-24)

FAMILIES = families(Distribution)
STRETCHED = tuple(kind for kind in FAMILIES if issubclass(kind, Stretched))
POWERS = tuple(kind for kind in FAMILIES if issubclass(kind, mf.BlinnPhong))


def is_normalised(kind: type[Distribution]) -> bool:
    """Whether its facets project to the surface, as it states; a family that states nothing has to."""
    stated = kind.statements.get("projected_area")
    return stated is None or stated.equals == 1


ISOTROPIC = [kind(8.0) if kind in POWERS else kind(0.4) for kind in FAMILIES if is_normalised(kind)]
TURNED = [(0.2, 0.5), (0.5, 0.2)]
ANISOTROPIC = [kind(*TURNED[k % 2]) for k, kind in enumerate(filter(is_normalised, STRETCHED))]
NORMALISED = ISOTROPIC + ANISOTROPIC


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
