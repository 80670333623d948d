"""An exponential that can be vectorized: it replaces `exp` of `math` in kernels without a loop."""

from __future__ import annotations

from math import ldexp

import numpy as np

from microfacet.compiler.kernels import ByPrecision

SMALLEST, GREATEST = ByPrecision(-750.0, -110.0), ByPrecision(720.0, 92.0)  # exp is 0 below, infinite above
ROUNDER = ByPrecision(6755399441055744.0, 12582912.0)  # 1.5 x 2^52, 1.5 x 2^23: adding it rounds to an integer
PER_LN2 = 1.4426950408889634
LN2_HIGH = ByPrecision(0.6931471803691238, 0.693359375)  # short enough for its product with an exponent to be exact
LN2_LOW = ByPrecision(1.9082149292705877e-10, -0.00021219444005469057)


def power_of_two(k: float) -> float:
    """2^k for an integer k within the exponents of normal numbers."""
    return ldexp(1.0, int(k))


_BITS = "def unnamed(k):\n    return np.int{0}((np.int{0}(k) + np.int{0}({1})) << np.int{0}({2})).view(np.float{0})"
power_of_two.__compiled__ = {np.float64: _BITS.format(64, 1023, 52), np.float32: _BITS.format(32, 127, 23)}  # type: ignore[attr-defined]


def near_zero(r: float) -> float:
    """exp(r) - 1 for |r| below 0.35, where Taylor's series to r^13/13! suffices."""
    p = 1.0 / 6227020800.0
    p = p * r + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    return (p * r) * r + r


def exponential(x: float) -> float:
    """exp(x) to an ulp without a branch or a call: it replaces `exp` in a kernel without a loop of its own.

    x = k ln 2 + r with |r| below 0.35; 2^k in two factors, for subnormal results.
    """
    x = SMALLEST if x < SMALLEST else x
    x = GREATEST if x > GREATEST else x
    k = (x * PER_LN2 + ROUNDER) - ROUNDER
    p = near_zero((x - k * LN2_HIGH) - k * LN2_LOW)
    half = (0.5 * k + ROUNDER) - ROUNDER
    return ((1.0 + p) * power_of_two(half)) * power_of_two(k - half)


def one_minus_exp(x: float) -> float:
    """1 - exp(-x) for x at least 0, to a few ulps, likewise without a branch or a call."""
    x = -min(x, 64.0)  # from 37 on it is 1
    k = (x * PER_LN2 + ROUNDER) - ROUNDER
    scale = power_of_two(k)
    return (1.0 - scale) - scale * near_zero((x - k * LN2_HIGH) - k * LN2_LOW)
