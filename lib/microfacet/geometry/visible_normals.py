"""Sampling visible normals, for Smith's model over GGX and Beckmann.

Both unstretch the view direction to unit roughness, sample there, and stretch the normal back. Sources: heitzdeon2014 for
Beckmann's slopes (inverted in microfacet.geometry.visible_slopes), dupuy2023 for the spherical cap.
"""

from __future__ import annotations

from math import sqrt

from microfacet.arithmetic import cosine_and_sine
from microfacet.compiler.kernels import ByPrecision, Pair, Vector
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.visible_slopes import NOTHING, gaussian_slope, visible_gaussian_slope

HORIZON = ByPrecision(double=1.5e-154, single=1.1e-19)  # the square of a lower height loses digits: it counts as 0
EDGE = ByPrecision(double=8 * 2.0**-52, single=8 * 2.0**-23)  # bound of the rounding error of a cosine, relative to its terms
NONE = ByPrecision(double=1e-300, single=1e-37)  # in place of a square that is 0
STRAIGHT = ByPrecision(double=1e-150, single=1e-18)  # below this sine its square loses digits, and azimuth has no effect


def unstretched(w: Vector, p: Alphas) -> Vector:
    """The corresponding unit direction over the surface unstretched to unit roughness."""
    x, y, z = p.alpha_x * w[0], p.alpha_y * w[1], w[2]
    scale = 1.0 / sqrt(x * x + y * y + z * z)
    return scale * x, scale * y, scale * z


def lacking(x: float, y: float, z: float) -> float:
    """What must be added to these terms of the cosine between view and normal for it to be above 0 in spite of rounding.

    The normal of a facet seen edge-on is a difference of nearly equal numbers, so rounding may make it back-facing. A change of
    the uniform numbers by their rounding error leads from there to a facet that is just visible.
    """
    return max(EDGE * (abs(x) + abs(y) + abs(z)) - (x + y + z), 0.0)


def sample_ggx(wo: Vector, u: Pair, p: Alphas) -> Vector:
    """A visible normal of GGX: mirror directions fill a spherical cap uniformly.

    The height on the cap is stored as its distance from the lower rim, which avoids cancellation. The unstretched view need not
    have unit length: everything scales with it until the normal is normalised.
    """
    (ox, oy, oz), (u1, u2), alpha_x, alpha_y = wo, u, p.alpha_x, p.alpha_y
    x, y, z = alpha_x * ox, alpha_y * oy, oz if oz > HORIZON else 1.0
    square = x * x + y * y
    height = z + sqrt(square + z * z)
    above = (1.0 - u2) * height
    radius = sqrt(u2 * (above * height + square))
    c, s = cosine_and_sine(u1)
    hx = radius * c + x
    hy = radius * s + y
    towards = lacking(x * hx, y * hy, z * above) / max(square, NONE)
    hx = alpha_x * (hx + towards * x)
    hy = alpha_y * (hy + towards * y)
    scale = (1.0 if oz > HORIZON else 0.0) / sqrt(hx * hx + hy * hy + above * above)
    return scale * hx, scale * hy, scale * above


def sample_beckmann(wo: Vector, u: Pair, p: Alphas) -> Vector:
    """A visible normal of Beckmann: the slope along the view by its visible area, the slope across independently."""
    (ox, oy, oz), (u1, u2), alpha_x, alpha_y = wo, u, p.alpha_x, p.alpha_y
    vx, vy = alpha_x * ox, alpha_y * oy
    vz = oz if oz > HORIZON else 1.0
    vs = sqrt(vx * vx + vy * vy)
    inclined = vs > STRAIGHT
    inverse = 1.0 / (vs if inclined else 1.0)
    c = vx * inverse if inclined else 1.0
    s = vy * inverse if inclined else 0.0
    inverse_sum = 1.0 / (vs + vz)
    across = gaussian_slope(u2)
    along = visible_gaussian_slope(max(vs * inverse_sum, NOTHING), vz * inverse_sum, u1)
    slope_x = alpha_x * (c * along - s * across)
    slope_y = alpha_y * (s * along + c * across)
    towards = lacking(-ox * slope_x, -oy * slope_y, vz) * inverse
    slope_x -= alpha_x * c * towards
    slope_y -= alpha_y * s * towards
    z = (1.0 if oz > HORIZON else 0.0) / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return -slope_x * z, -slope_y * z, z
