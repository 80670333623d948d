"""Sampling the normals that a viewer sees, for Smith's model over GGX and Beckmann.

Both unstretch the view direction to unit roughness, sample there, and stretch the normal back. Sources: heitzdeon2014 for
Beckmann's slopes (inverted in microfacet.geometry.visible_slopes), dupuy2023 for the spherical cap.
"""

from __future__ import annotations

from math import sqrt

from microfacet.arithmetic import turn
from microfacet.geometry import visible_slopes
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.visible_slopes import NOTHING, gaussian_slope, visible_gaussian_slope
from microfacet.kernels import ByPrecision, Pair, Vector

HORIZON = ByPrecision(double=1.5e-154, single=1.1e-19)  # the square of a lower height loses digits: it counts as 0
EDGE = ByPrecision(double=8 * 2.0**-52, single=8 * 2.0**-23)  # of the sum of a cosine's terms, what rounding may change
NONE = ByPrecision(double=1e-300, single=1e-37)  # in place of a square that is 0
SQRT_PI = visible_slopes.SQRT_PI
STRAIGHT = ByPrecision(double=1e-150, single=1e-18)  # below this sine its square loses digits, and azimuth has no effect


def unstretched(w: Vector, p: Alphas) -> Vector:
    """The unit direction that a surface of unit roughness sees this direction as."""
    x, y, z = p.alpha_x * w[0], p.alpha_y * w[1], w[2]
    scale = 1.0 / sqrt(x * x + y * y + z * z)
    return scale * x, scale * y, scale * z


def lacking(x: float, y: float, z: float) -> float:
    """What must be added to these terms of the cosine between view and normal for it to be above 0 however it is rounded.

    A facet on edge has a normal that is a difference of near numbers, so that rounding may turn it away from the viewer. A
    change of the uniform numbers by their rounding leads from there to a facet that is just seen.
    """
    return max(EDGE * (abs(x) + abs(y) + abs(z)) - (x + y + z), 0.0)


def sample_ggx(wo: Vector, u: Pair, p: Alphas) -> Vector:
    """A visible normal of GGX: mirror directions fill a spherical cap uniformly.

    The height on the cap is kept as its distance from the lower rim, so that no difference of near numbers is taken. The
    unstretched view need not have unit length: all else is longer by as much, until the normal is.
    """
    (ox, oy, oz), (u1, u2), alpha_x, alpha_y = wo, u, p.alpha_x, p.alpha_y
    x, y, z = alpha_x * ox, alpha_y * oy, oz if oz > HORIZON else 1.0
    square = x * x + y * y
    height = z + sqrt(square + z * z)
    above = (1.0 - u2) * height
    radius = sqrt(u2 * (above * height + square))
    c, s = turn(u1)
    hx = radius * c + x
    hy = radius * s + y
    towards = lacking(x * hx, y * hy, z * above) / max(square, NONE)
    hx = alpha_x * (hx + towards * x)
    hy = alpha_y * (hy + towards * y)
    scale = (1.0 if oz > HORIZON else 0.0) / sqrt(hx * hx + hy * hy + above * above)
    return scale * hx, scale * hy, scale * above


def sample_beckmann(wo: Vector, u: Pair, p: Alphas) -> Vector:
    """A visible normal of Beckmann: the slope along the view from its visible share, the slope across independent."""
    (ox, oy, oz), (u1, u2), alpha_x, alpha_y = wo, u, p.alpha_x, p.alpha_y
    vx, vy = alpha_x * ox, alpha_y * oy
    vz = oz if oz > HORIZON else 1.0
    vs = sqrt(vx * vx + vy * vy)
    inclined = vs > STRAIGHT
    inverse = 1.0 / (vs if inclined else 1.0)
    c = vx * inverse if inclined else 1.0
    s = vy * inverse if inclined else 0.0
    share = 1.0 / (vs + vz)
    across = gaussian_slope(u2)
    along = visible_gaussian_slope(max(vs * share, NOTHING), vz * share, u1)
    slope_x = alpha_x * (c * along - s * across)
    slope_y = alpha_y * (s * along + c * across)
    towards = lacking(-ox * slope_x, -oy * slope_y, vz) * inverse
    slope_x -= alpha_x * c * towards
    slope_y -= alpha_y * s * towards
    z = (1.0 if oz > HORIZON else 0.0) / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return -slope_x * z, -slope_y * z, z
