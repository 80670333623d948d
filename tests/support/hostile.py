"""Distributions of slopes that a validation with few views, few nodes or one scale would misjudge, all of one kernel."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from dataclasses import astuple, dataclass, fields
from math import atan2, cos, exp, hypot, pi
from typing import Any, ClassVar

from microfacet.geometry.slopes import Distribution
from scipy.special import i0e


def hostile(wm: tuple[float, float, float], p: Any) -> float:
    x, y, z = wm
    if not z > 0.0:
        return 0.0
    share, x1, y1, width1, x2, y2, width2, depth, fold, turn, notch, narrow, towards, heavy, factor = p
    slope_x, slope_y = -x / z, -y / z
    here = ((slope_x - x1) * (slope_x - x1) + (slope_y - y1) * (slope_y - y1)) / (width1 * width1)
    there = ((slope_x - x2) * (slope_x - x2) + (slope_y - y2) * (slope_y - y2)) / (width2 * width2)
    if heavy > 0.5:
        here, there = 1.0 / ((1.0 + here) * (1.0 + here)), 1.0 / ((1.0 + there) * (1.0 + there))
    else:
        here, there = exp(-here), exp(-there)
    lobes = share * here / (width1 * width1) + (1.0 - share) * there / (width2 * width2)
    if depth != 0.0 or notch != 0.0:
        angle = atan2(slope_y, slope_x)
        aside = (1.0 - cos(2.0 * (angle - towards))) / (narrow * narrow)
        lobes *= 1.0 + depth * cos(fold * (angle - turn)) - notch * exp(-aside)
    return factor * lobes / (pi * ((z * z) * (z * z)))


@dataclass(frozen=True)
class Shape:
    """Two lobes: share of the first, centre and width of each; or, around the origin, ripples and two opposite notches.

    heavy: tails as of GGX, otherwise as of Beckmann. factor: what it is scaled by.
    """

    share: float = 1.0
    x1: float = 0.0
    y1: float = 0.0
    width1: float = 0.3
    x2: float = 0.0
    y2: float = 0.0
    width2: float = 0.3
    depth: float = 0.0
    fold: float = 3.0
    turn: float = 0.0
    notch: float = 0.0
    narrow: float = 0.1
    towards: float = 0.0
    heavy: float = 0.0
    factor: float = 1.0


Numbers = namedtuple("Numbers", [field.name for field in fields(Shape)])


class Hostile(Distribution):
    """Facets of such a shape; with a notch they still project to the whole surface."""

    kernel: ClassVar[Callable[..., float]] = staticmethod(hostile)

    def __init__(self, shape: Shape) -> None:
        self.shape = shape
        cut = 1 - shape.notch * i0e(1 / shape.narrow**2)  # exp(-k) I0(k) is the mean of exp(k (cos - 1)) over the turn
        self.parameters = Numbers(*astuple(shape)[:-1], shape.factor / float(cut))

    def __repr__(self) -> str:
        changed = {k: v for k, v in vars(self.shape).items() if v != getattr(Shape(), k)}
        return f"Hostile({', '.join(f'{k}={v:.4g}' for k, v in changed.items())})"


def balanced(share: float, distance: float, azimuth: float, widths: tuple[float, float], heavy: float = 0.0) -> Shape:
    """Two lobes whose slopes have mean 0: the first at a distance from the origin, the other opposite to it."""
    away = -distance * share / (1 - share)
    c, s = cos(azimuth), cos(azimuth - pi / 2)
    return Shape(share, distance * c, distance * s, widths[0], away * c, away * s, widths[1], heavy=heavy)


def leaning(distance: float, azimuth: float, width: float, heavy: float) -> Shape:
    """One lobe, shifted: a surface over a tilted plane."""
    c, s = cos(azimuth), cos(azimuth - pi / 2)
    return Shape(x1=distance * c, y1=distance * s, width1=width, heavy=heavy)


def lean(shape: Shape) -> float:
    """The length of the mean slope."""
    other = 1 - shape.share
    return hypot(shape.share * shape.x1 + other * shape.x2, shape.share * shape.y1 + other * shape.y2)
