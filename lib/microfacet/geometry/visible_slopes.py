"""The slopes of a visible Beckmann facet from uniform numbers: distributions inverted without a branch and without a loop.

Seen along (s, z) - s across the surface's normal, z along it, s + z = 1 - Gaussian slopes of unit roughness have the visible
density (z - s x) exp(-x^2), for x below z/s; those across the view have the density exp(-x^2). A guess good to a few percent
is made in r = sqrt(-log u), which takes up both ends: x falls from z/s in proportion to r where u is next to 1, and tends to
-r where u is next to 0. One step of the fifth order, and in double precision one more of the third, leave rounding.
Sources: heitzdeon2014 for the distribution, householder1970 for the steps, giles2012 for r in the inverse error function.
"""

from __future__ import annotations

from math import sqrt

from microfacet.compiler.kernels import ByPrecision
from microfacet.special_functions import FINE, SQRT_PI, exponential_within, logarithm_about, scaled_erfc

LEAST = ByPrecision(double=1e-30, single=1e-13)  # lower bound of a fraction: no random number but 0 is smaller
LARGEST_EDGE = 8.5  # slope of the edge of visibility from which on the hidden area is below rounding
NOTHING = 1e-18
STEP_CENTRE = ByPrecision(double=1.45, single=0.0)  # next to the edge of visibility rounding dominates: there a step may
STEP_LIMIT = ByPrecision(double=2.35, single=0.6)  # change the distance from it by -0.9 to 3.8 times, or by 0.6


def edge_factor(c: float) -> float:
    """exp(-c^2/2) at the slope of the edge of visibility."""
    return exponential_within(-0.5 * c * c)


def visible_area(s: float, z: float, c: float, e: float) -> float:
    """Projected area of all slopes up to the edge c = z/s; e = `edge_factor(c)`. Exceeds z by the hidden area."""
    return z + 0.5 * (e * e) * (s / SQRT_PI - z * scaled_erfc(c))


def guess(s: float, z: float, c: float, e: float, u: float) -> tuple[float, float]:
    """A slope near the u-quantile of the visible area, and z - s x: its distance from the edge, free of cancellation.

    With r = sqrt(-log u) and y = x + r, a least-squares polynomial in log(r + edge) and s, weighted by what the
    steps leave, z - s x vanishes with r.
    """
    r = sqrt(max(-logarithm_about(u), NOTHING))
    edge = 0.5 * e * s
    near = 1.0 / (r + edge)
    v = logarithm_about(r + edge)
    v2 = v * v
    a = (0.761222394 - 0.3517625 * v) + ((0.0277609078 + 0.00422625958 * v) + 0.000136772312 * v2) * v2
    b = (0.358587446 - 0.154531967 * v) + (-0.0329608041 - 0.00223058132 * v) * v2
    d = (-3.35123198 + 1.46267549 * v) - 0.0106407571 * v2
    far = (0.243868783 - 0.951222505 * v) + 1.5466286 * s
    s2 = s * s
    y = (a + b * s) + (d + far * s) * s2
    return (c * edge - r * (r - y)) * near, r * near * (z + s * (r - y))


def excess(x: float, s: float, z: float, target: float) -> float:
    """sqrt(pi) exp(x^2) times the visible area below x less the target: relative in the lower tail, absolute elsewhere."""
    half = 0.5 * z * scaled_erfc(abs(x))
    lower = x < 0.0
    part = -target if lower else z - target
    return SQRT_PI * (part * exponential_within(x * x) + (half if lower else -half)) + 0.5 * s


def step_or_none(step: float, s: float, distance: float) -> float:
    """The step, or 0 where it would leave the neighbourhood of the guess: there rounding dominates, and the guess suffices."""
    return step if abs(s * step - STEP_CENTRE * distance) < STEP_LIMIT * distance else 0.0


def fifth_order(f: float, x: float, d: float, s: float) -> float:
    """Householder's step from the excess f at x; d = z - s x and all further derivatives come with the first."""
    square = x * x
    d2 = -(s + 2.0 * x * d)
    d3 = 4.0 * s * x - 2.0 * d + 4.0 * square * d
    d4 = 6.0 * s - 12.0 * s * square + 12.0 * x * d - 8.0 * x * square * d
    dd = d * d
    ff = f * f
    top = 6.0 * dd * d - 6.0 * f * d * d2 + ff * d3
    low = 24.0 * dd * dd - 36.0 * f * dd * d2 + 8.0 * ff * d * d3 + 6.0 * ff * d2 * d2 - ff * f * d4
    return 4.0 * f * top / low


def third_order(f: float, x: float, d: float, s: float) -> float:
    """Halley's step."""
    return 2.0 * f * d / (2.0 * d * d + f * (s + 2.0 * x * d))


def visible_gaussian_slope(s: float, z: float, u: float) -> float:
    """The slope along the view below which a fraction u in [0, 1) of the visible area lies; s + z = 1, s > 0, z > 0."""
    fraction = max(u, LEAST)
    c = min(z / s, LARGEST_EDGE)
    e = edge_factor(c)
    target = fraction * visible_area(s, z, c, e)
    x, d = guess(s, z, c, e, fraction)
    step = step_or_none(fifth_order(excess(x, s, z, target), x, d, s), s, d)
    x -= step
    d += s * step
    if FINE > 0.0:
        x -= step_or_none(third_order(excess(x, s, z, target), x, d, s), s, d)
    return x


def gaussian_slope(u: float) -> float:
    """The slope across the view below which a fraction u lies: the inverse error function, by the nearer tail."""
    upper = u > 0.5
    fraction = max(1.0 - u if upper else u, LEAST)
    r = sqrt(max(-logarithm_about(4.0 * fraction * (1.0 - fraction)), 0.0))
    r2 = r * r
    r4 = r2 * r2
    top = (0.8862269932262403 - 0.5624152271100655 * r) + (0.47503627571700524 - 0.1746607877075301 * r) * r2
    top += ((0.0788099984313004 - 0.014779616626660665 * r) + (0.004725627860242335 - 0.0004591980588989206 * r) * r2) * r4
    low = (1.0 - 0.6346105765241615 * r) + (0.27411241936853326 - 0.030278070066402908 * r) * r2
    low += ((0.00205633225431649 + 0.0032857248020552463 * r) + (-0.00035285254165031587 + 0.0003024912445035215 * r) * r2) * r4
    x = (2.0 * fraction - 1.0) * (top + 0.0003048861151459679 * (r4 * r4)) / low
    if FINE > 0.0:
        x -= third_order(excess(x, 0.0, 1.0, fraction), x, 1.0, 0.0)
    return -x if upper else x
