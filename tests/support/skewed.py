"""A distribution of normals without opposite facets: V-cavities must fail on it, Smith must not.

Slopes are a mixture of two Gaussians side by side along x, with mean 0, as the slopes of any surface have.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, pi
from typing import ClassVar, NamedTuple

from microfacet.geometry.slopes import Distribution


class Lobes(NamedTuple):
    alpha: float
    shift: float
    share: float


def skewed(wm: tuple[float, float, float], p: Lobes) -> float:
    x, y, z = wm
    if not z > 0.0:
        return 0.0
    alpha, shift, share = p
    slope_x, slope_y = -x / z / alpha, -y / z / alpha
    here, there = slope_x + (1.0 - share) * shift, slope_x - share * shift
    gaussians = share * exp(-here * here) + (1.0 - share) * exp(-there * there)
    return gaussians * exp(-slope_y * slope_y) / (pi * alpha * alpha * ((z * z) * (z * z)))


class Skewed(Distribution):
    """share of the facets lean one way a little, the others the other way a lot; shift apart, in units of alpha."""

    kernel: ClassVar[Callable[..., float]] = staticmethod(skewed)

    def __init__(self, alpha: float, shift: float, share: float) -> None:
        self.parameters, self.slope_scale = Lobes(alpha, shift, share), (alpha * (1 + shift), alpha)


SKEWED = Skewed(0.3, 2.0, 0.8)
