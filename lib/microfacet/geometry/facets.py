"""Samples of the facet that a ray meets, from above or from below, in proportion to the projected areas of facets.

For random walks within Smith's model. Sources: dupuy2023 for the spherical cap; for Beckmann's slopes, by rejection, the bounds
are given here.
"""

from __future__ import annotations

from math import cos, exp, log, pi, sin, sqrt

from microfacet.compiler.kernels import Pair, Vector
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.visible_normals import STRAIGHT, unstretched
from microfacet.special_functions import SQRT_PI
from microfacet.streams import drawn

TRIES = 300  # how often a slope is drawn before giving up
FLAT = 1e200  # the cotangent of a vertical direction


def ggx_facet(v: Vector, u: Pair, key: int, at: int, p: Alphas) -> Vector:
    """A facet of GGX that faces a direction above the horizon or below: mirror directions fill a cap uniformly. dupuy2023."""
    (u1, u2), alpha_x, alpha_y = u, p.alpha_x, p.alpha_y
    x, y, z = unstretched(v, p)
    rise = 1.0 + z if z > 0.0 else (x * x + y * y) / (1.0 - z)
    fall = 1.0 - z if z < 0.0 else (x * x + y * y) / (1.0 + z)
    above = (1.0 - u2) * rise
    radius = sqrt((above + fall) * (u2 * rise))
    mx, my = alpha_x * (radius * cos(2.0 * pi * u1) + x), alpha_y * (radius * sin(2.0 * pi * u1) + y)
    scale = 1.0 / sqrt(mx * mx + my * my + above * above)
    return scale * mx, scale * my, scale * above


def gaussian_excess(c: float, key: int, at: int) -> float:
    """y > 0 with density in proportion to y exp(-y^2 - 2 c y), c >= 0: by rejection from either of its two factors."""
    y = 0.0
    for k in range(TRIES):
        chance, other, third = drawn(key, at + 3 * k), drawn(key, at + 3 * k + 1), drawn(key, at + 3 * k + 2)
        if c < 0.75:
            y = sqrt(-log(chance))
            if third < exp(-2.0 * c * y):
                return y
        else:
            y = -log(chance * other) / (2.0 * c)
            if third < exp(-y * y):
                return y
    return y


def gaussian_seen(c: float, key: int, at: int) -> float:
    """x below c > 0 with density in proportion to (c - x) exp(-x^2): from a bound, (c + |x|) exp(-x^2), by rejection."""
    x = 0.0
    for k in range(TRIES):
        chance, other, third = drawn(key, at + 3 * k), drawn(key, at + 3 * k + 1), drawn(key, at + 3 * k + 2)
        radius = sqrt(-log(chance))
        if third * (SQRT_PI * c + 1.0) < 1.0:  # |x| exp(-x^2), else c exp(-x^2)
            x = radius if other < 0.5 else -radius
            rest = 2.0 * other - (0.0 if other < 0.5 else 1.0)
        else:
            x = radius * cos(pi * other)
            rest = (third * (SQRT_PI * c + 1.0) - 1.0) / (SQRT_PI * c)
        if rest * (c + abs(x)) < c - x:
            return x
    return x


def beckmann_facet(v: Vector, u: Pair, key: int, at: int, p: Alphas) -> Vector:
    """A facet of Beckmann that faces a direction above the horizon or below, in proportion to what it shows."""
    (u1, u2), alpha_x, alpha_y = u, p.alpha_x, p.alpha_y
    x, y, z = unstretched(v, p)
    length = sqrt(x * x + y * y)
    c, s = (x / length, y / length) if length > STRAIGHT else (1.0, 0.0)
    steep = z / length if length > STRAIGHT else FLAT
    along = gaussian_seen(steep, key, at) if steep > 0.0 else steep - gaussian_excess(-steep, key, at)
    across = sqrt(-log(1.0 - u1)) * cos(2.0 * pi * u2)
    slope_x, slope_y = alpha_x * (c * along - s * across), alpha_y * (s * along + c * across)
    mz = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return -slope_x * mz, -slope_y * mz, mz
