"""Short programs that the report prints, so that they can be copied: GGX in Smith's model, in stable form.

Plain Python on numbers; directions have components x, y, z. What is printed is this text, and tests run it against the library.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, hypot, pi, sin, sqrt
from typing import NamedTuple


class Vector(NamedTuple):
    x: float
    y: float
    z: float


Uniform = Callable[[], float]


def brdf(wo: Vector, wi: Vector, alpha_x: float, alpha_y: float) -> float:
    """GGX with Smith's height-correlated G2, for F = 1; multiply by F(wo.wh)."""
    if wo.z <= 0 or wi.z <= 0:
        return 0.0
    x, y, z = wo.x + wi.x, wo.y + wi.y, wo.z + wi.z  # the half vector, not normalised
    stretched = (x / alpha_x) ** 2 + (y / alpha_y) ** 2 + z * z
    reach_o = hypot(alpha_x * wo.x, alpha_y * wo.y, wo.z)
    reach_i = hypot(alpha_x * wi.x, alpha_y * wi.y, wi.z)
    shrunk = (x * x + y * y + z * z) / stretched
    return shrunk**2 / (2 * pi * alpha_x * alpha_y * (wo.z * reach_i + wi.z * reach_o))


def pdf(wo: Vector, wi: Vector, alpha_x: float, alpha_y: float) -> float:
    """Density of wi if its half vector is a visible normal."""
    x, y, z = wo.x + wi.x, wo.y + wi.y, wo.z + wi.z
    if wo.z <= 0 or z <= 0:
        return 0.0
    stretched = (x / alpha_x) ** 2 + (y / alpha_y) ** 2 + z * z
    reach_o = hypot(alpha_x * wo.x, alpha_y * wo.y, wo.z)
    shrunk = (x * x + y * y + z * z) / stretched
    return shrunk**2 / (2 * pi * alpha_x * alpha_y * (wo.z + reach_o))


def weight(wo: Vector, wi: Vector, alpha_x: float, alpha_y: float) -> float:
    """The BRDF times the cosine of the light over that density, for F = 1: G2/G1."""
    if wo.z <= 0 or wi.z <= 0:
        return 0.0
    reach_o = hypot(alpha_x * wo.x, alpha_y * wo.y, wo.z)
    reach_i = hypot(alpha_x * wi.x, alpha_y * wi.y, wi.z)
    return wi.z * (wo.z + reach_o) / (wo.z * reach_i + wi.z * reach_o)


def visible_normal(wo: Vector, u1: float, u2: float, alpha_x: float, alpha_y: float) -> Vector:
    """A normal drawn with the density of visible normals; wo may come from below."""
    x, y, z = alpha_x * wo.x, alpha_y * wo.y, wo.z
    length = hypot(x, y, z)
    x, y, z = x / length, y / length, z / length
    square = x * x + y * y
    height = 1 + z if z > 0 else square / (1 - z)  # of the cap, without cancellation
    above = (1 - u2) * height  # the cap's lower rim, not the middle of the sphere
    radius = sqrt(u2 * (above * height + square))
    x = alpha_x * (radius * cos(2 * pi * u1) + x)
    y = alpha_y * (radius * sin(2 * pi * u1) + y)
    length = hypot(x, y, above)
    return Vector(x / length, y / length, above / length)


def walk(wo: Vector, alpha_x: float, alpha_y: float, uniform: Uniform) -> tuple[Vector, int]:
    """Where light that comes in along wo leaves, and after how many bounces, for F = 1."""
    w, level, bounces = Vector(-wo.x, -wo.y, -wo.z), 1.0, 0
    while True:
        across = (alpha_x * w.x) ** 2 + (alpha_y * w.y) ** 2
        z = max(abs(w.z), 1e-300)
        Lambda = across / (2 * z * (z + sqrt(across + z * z)))
        chance = 1 - uniform()
        if w.z < 0:
            level *= chance ** (1 / (1 + Lambda))
        elif level**Lambda < chance:
            level /= chance ** (1 / Lambda)
        else:
            return w, bounces
        m = visible_normal(Vector(-w.x, -w.y, -w.z), uniform(), uniform(), alpha_x, alpha_y)
        cosine = w.x * m.x + w.y * m.y + w.z * m.z
        w = Vector(w.x - 2 * cosine * m.x, w.y - 2 * cosine * m.y, w.z - 2 * cosine * m.z)
        bounces += 1
