"""Models as users write them, and what is asked of a model in another process. A module, so that the other process finds it."""

from __future__ import annotations

from math import pi
from typing import Any

import microfacet as mf
import numpy as np
from microfacet.geometry.slopes import Distribution
from microfacet.material.fresnel import Fresnel

WO, WI = np.array([0.6, 0.0, 0.8]), np.array([-0.48, 0.36, 0.8])


def kernel_D(wm: tuple[float, float, float], p: Any) -> float:
    x, y, z = wm
    if not z > 0.0:
        return 0.0
    square = (x * x + y * y) / (p[0] * z) ** 2
    return 2.0 / (pi * p[0] ** 2 * z**4 * (1.0 + square) ** 3)


class Steep(Distribution):
    """A distribution whose maker keeps an array, and a function that cannot be pickled."""

    kernel = staticmethod(kernel_D)

    def __init__(self, alpha: float, label: str = "", *, samples: Any = (1.0, 2.0)) -> None:
        self.parameters = (alpha,)
        self.slope_scale = (alpha, alpha)
        self.samples = np.array(samples)
        self.shifted = lambda x: x + alpha


class Steeper(Steep):
    """A subclass with nothing of its own."""


class Named(mf.GGX):
    """A subclass with another constructor, whose attribute is not its argument."""

    def __init__(self, roughness: float) -> None:
        super().__init__(roughness**2)
        self.roughness = roughness**2


def kernel_linear(c: float, p: Any) -> float:
    return 1.0 - p[0] * c


class Linear(Fresnel):
    kernel = staticmethod(kernel_linear)

    def __init__(self, drop: float) -> None:
        self.parameters = (drop,)


def value(model: Any) -> float:
    """A number that depends on all of a model's kernels."""
    if hasattr(model, "evaluate"):
        found = model.evaluate(WO, WI)
        return float(getattr(found, "value", found))
    if hasattr(model, "G2"):
        return float(model.G2(WO, WI, [0, 0, 1]))
    return float(model.D(WO) if hasattr(model, "D") else model.F(0.8))


def same(model: Any) -> tuple[Any, float]:
    """The model sent back, and its number."""
    return model, value(model)
