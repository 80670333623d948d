"""Arithmetic that keeps the digits a plain formula loses: error-free sums and products, and exponentials of squares.

Kernels of plain floats (see microfacet.kernels). Source: dekker1971.
"""

from collections.abc import Sequence
from math import exp

import numpy as np

from microfacet.kernels import ByPrecision

SPLIT = ByPrecision(double=134217729.0, single=4097.0)  # 2^27 + 1, 2^12 + 1: halves a significand
UNDERFLOWS = 64.0  # exp(-64^2) is 0 in double as in single precision
LARGEST = ByPrecision(double=1e308, single=3e38)  # bounds a factor that overflows where the exponential is 0


def two_product(a: float, b: float) -> tuple[float, float]:
    """The product of two floats and its rounding error, exactly."""
    product = a * b
    c = SPLIT * a
    a_high = c - (c - a)
    d = SPLIT * b
    b_high = d - (d - b)
    a_low = a - a_high
    b_low = b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def two_sum(a: float, b: float) -> tuple[float, float]:
    """The sum of two floats and its rounding error, exactly."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def exp_minus_square(a: float) -> float:
    """exp(-a^2) to an ulp or two: the rounding error of the square is carried along."""
    bounded = min(a, UNDERFLOWS)
    square, error = two_product(bounded, bounded)
    return exp(-square) * (1.0 - error)


def ratio(x: float, y: float, z: float) -> tuple[float, float]:
    """x/(y z) and what rounding left out of it, for |x/(y z)| below `UNDERFLOWS`; beyond, that bound."""
    product, missing = two_product(y, z)
    quotient = min(max(x / product, -UNDERFLOWS), UNDERFLOWS)
    back, lost = two_product(quotient, product)
    rest = ((x - back) - lost) - quotient * missing
    return quotient, (rest / product if abs(quotient) < UNDERFLOWS else 0.0)


def exp_minus_squares(x: float, y: float, alpha_x: float, alpha_y: float, z: float, factor: float) -> float:
    """factor exp(-((x/alpha_x)^2 + (y/alpha_y)^2)/z^2) to a few ulps; a large factor delays underflow."""
    p, p_rest = ratio(x, alpha_x, z)
    q, q_rest = ratio(y, alpha_y, z)
    p_square, p_error = two_product(p, p)
    q_square, q_error = two_product(q, q)
    total, error = two_sum(p_square, q_square)
    root = exp(-0.5 * total)
    return root * (root * min(factor, LARGEST)) * (1.0 - (error + p_error + q_error + 2.0 * (p * p_rest + q * q_rest)))


# sin(2 pi t)/t in powers of t^2 for |t| up to a quarter: relative error under 3e-19, in single precision 6e-9, before rounding
SINE = (
    6.283185307179586,
    -41.34170224039931,
    81.60524927593018,
    -76.70585973513714,
    42.05869284572465,
    -15.094605693659318,
    3.819261191136815,
    -0.7112784445783067,
    0.07545319021281638,
)
SINE_SINGLE = (6.2831854820251465, -41.341758728027344, 81.60794830322266, -76.70996856689453, 40.731327056884766)


def sine_per_turn(s: float) -> float:
    """sin(2 pi t)/t given s = t^2, t a share of a full turn, at most a quarter."""
    total = 0.0
    for coefficient in reversed(SINE):
        total = total * s + coefficient
    return total


def _horner(coefficients: Sequence[float]) -> str:
    """The text of a polynomial as a kernel without a loop."""
    nested = f"R({coefficients[-1]!r})"
    for coefficient in reversed(coefficients[:-1]):
        nested = f"({nested} * s + R({coefficient!r}))"
    return f"def unnamed(s):\n    return {nested}"


sine_per_turn.__compiled__ = {np.float64: _horner(SINE), np.float32: _horner(SINE_SINGLE)}  # type: ignore[attr-defined]


def turn(u: float) -> tuple[float, float]:
    """Cosine and sine of the share u, in [0, 1], of a full turn, to an ulp or two and without a branch or a call.

    The nearest half turn is taken off exactly. Of the rest the sine is a polynomial, the cosine that of what it lacks of a
    quarter turn: so both keep their digits where they are small.
    """
    half = 0.5 if u >= 0.25 else 0.0
    half = 1.0 if u >= 0.75 else half
    t = u - half
    lack = 0.25 - abs(t)
    lack, t = (-lack, -t) if half == 0.5 else (lack, t)
    return lack * sine_per_turn(lack * lack), t * sine_per_turn(t * t)
