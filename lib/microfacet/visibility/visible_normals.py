"""Sampling the normals that a viewer sees, for Smith's model over GGX and Beckmann.

Both unstretch the view direction to unit roughness, sample there, and stretch the normal back. Sources: heitz2014b for
Beckmann's slopes, dupuy2023 for the spherical cap.
"""

from __future__ import annotations

from math import erfc, exp, sqrt
from typing import Any

from microfacet.arithmetic import turn
from microfacet.kernels import ByPrecision

SQRT_PI = 1.7724538509055161
LOWEST = -8.0  # slopes below have probability under 1e-28
STEPS = 60
CLOSE = ByPrecision(double=4e-16, single=2e-7)
STRAIGHT = ByPrecision(double=1e-150, single=1e-18)  # below this sine its square loses digits, and azimuth has no effect


def unstretched(x: float, y: float, z: float, alpha_x: float, alpha_y: float) -> tuple[float, float, float]:
    """The unit direction that a surface of unit roughness sees this direction as."""
    x, y = alpha_x * x, alpha_y * y
    scale = 1.0 / sqrt(x * x + y * y + z * z)
    return scale * x, scale * y, scale * z


def sample_ggx(ox: float, oy: float, oz: float, u1: float, u2: float, p: Any) -> tuple[float, float, float]:
    """A visible normal of GGX: mirror directions fill a spherical cap uniformly.

    The height on the cap is kept as its distance from the lower rim, so that no difference of near numbers is taken. The
    unstretched view need not have unit length: all else is longer by as much, until the normal is.
    """
    alpha_x, alpha_y = p[0]
    x, y, z = alpha_x * ox, alpha_y * oy, oz if oz > 0.0 else 1.0
    square = x * x + y * y
    height = z + sqrt(square + z * z)
    above = (1.0 - u2) * height
    radius = sqrt(u2 * (above * height + square))
    c, s = turn(u1)
    hx = alpha_x * (radius * c + x)
    hy = alpha_y * (radius * s + y)
    scale = (1.0 if oz > 0.0 else 0.0) / sqrt(hx * hx + hy * hy + above * above)
    return scale * hx, scale * hy, scale * above


def gaussian_share(x: float, vs: float, vz: float) -> float:
    """Projected area of the slopes below x, seen from (vs, vz), for Gaussian slopes of unit roughness."""
    return 0.5 * vz * erfc(-x) + 0.5 * vs * exp(-x * x) / SQRT_PI


def visible_gaussian_slope(vs: float, vz: float, u: float) -> float:
    """The slope along the view below which a share u of the visible area lies: Newton's steps kept in a bracket."""
    high = min(vz / vs, -LOWEST) if vs > 0.0 else -LOWEST
    low = LOWEST
    target = u * gaussian_share(high, vs, vz)
    x = min(0.5 * (low + high), 0.0) if u < 0.5 else 0.5 * high
    x = max(min(x, 1.0), -1.0) if high > -1.0 else x
    for _ in range(STEPS):
        excess = gaussian_share(x, vs, vz) - target
        if excess > 0.0:
            high = x
        else:
            low = x
        rate = (vz - vs * x) * exp(-x * x) / SQRT_PI
        step = x - excess / rate if rate > 0.0 else low
        if not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - x) <= CLOSE * (1.0 + abs(x)):
            return step
        x = step
    return x


def sample_beckmann(ox: float, oy: float, oz: float, u1: float, u2: float, p: Any) -> tuple[float, float, float]:
    """A visible normal of Beckmann: the slope along the view from its visible share, the slope across independent."""
    if not oz > 0.0:
        return 0.0, 0.0, 0.0
    alpha_x, alpha_y = p[0]
    vx, vy, vz = unstretched(ox, oy, oz, alpha_x, alpha_y)
    vs = sqrt(vx * vx + vy * vy)
    c = vx / vs if vs > STRAIGHT else 1.0
    s = vy / vs if vs > STRAIGHT else 0.0
    along = visible_gaussian_slope(vs, vz, u1)
    across = visible_gaussian_slope(0.0, 1.0, u2)
    slope_x = alpha_x * (c * along - s * across)
    slope_y = alpha_y * (s * along + c * across)
    z = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return -slope_x * z, -slope_y * z, z
