"""Arithmetic that keeps the digits a plain formula loses: error-free sums and products, and exponentials of squares.

Kernels of plain floats (see microfacet.compiler.kernels). Source: dekker1971.
"""

from collections.abc import Callable
from math import exp

import numpy as np

from microfacet.compiler.kernels import ByPrecision

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


def quotient_of_squares(x: float, y: float, z: float) -> tuple[float, float]:
    """(x^2 + y^2)/z^2 and what rounding left out of it."""
    x_square, x_lost = two_product(x, x)
    y_square, y_lost = two_product(y, y)
    total, lost = two_sum(x_square, y_square)
    square, z_lost = two_product(z, z)
    quotient = total / square
    back, missing = two_product(quotient, square)
    return quotient, (((total - back) - missing) + (lost + x_lost + y_lost) - quotient * z_lost) / square


STEEP = ByPrecision(double=400.0, single=50.0)  # a power with more than this left out of it is 0


def inverse_power(t: float, t_rest: float, power: float) -> float:
    """(1 + t + t_rest)^-power, t at least 0, to a few ulps: what rounding leaves out of 1 + t counts power times."""
    total, rest = two_sum(1.0, t)
    r = rest / total
    back, lost = two_product(r, total)
    r_rest = (((rest - back) - lost) + t_rest) / total - 0.5 * (r * r)
    exponent, left = two_product(power, r)
    return total ** (-power) * (exp(-max(exponent, -STEEP)) * max(1.0 - (left + power * r_rest), 0.0))


# For |t| up to an eighth, in powers of t^2: sin(2 pi t)/t after its first term 2 pi was rounded, to 4e-18 of it; and
# (cos(2 pi t) - 1)/t^2, to 4e-19 of the cosine. In single precision to 5e-9 and 5e-10.
TWO_PI = ByPrecision(double=6.283185307179586, single=6.2831854820251465)
SINE = (
    2.4492935982947064e-16,
    -41.34170224039967,
    81.6052492759642,
    -76.70585970764122,
    42.05868536335466,
    -15.093821101141923,
    3.7811902801641244,
)
SINE_SINGLE = (-1.7484555314695172e-07, -41.341670989990234, 81.59351348876953, -75.43458557128906)
COSINE = (
    -19.739208802178716,
    64.93939402266669,
    -85.45681720599832,
    60.24464122934585,
    -26.426241360832755,
    7.902640972464981,
    -1.6885272706150836,
)
COSINE_SINGLE = (-19.739208221435547, 64.93914794921875, -85.42432403564453, 58.60515213012695)


def _polynomial(double: tuple[float, ...], single: tuple[float, ...]) -> Callable[[float], float]:
    """A kernel without a loop, with fewer terms in single precision; in plain Python the double one."""

    def polynomial(s: float) -> float:
        total = 0.0
        for coefficient in reversed(double):
            total = total * s + coefficient
        return total

    polynomial.__compiled__ = {np.float64: _horner(double), np.float32: _horner(single)}  # type: ignore[attr-defined]
    return polynomial


def _horner(coefficients: tuple[float, ...]) -> str:
    nested = f"R({coefficients[-1]!r})"
    for coefficient in reversed(coefficients[:-1]):
        nested = f"({nested} * s + R({coefficient!r}))"
    return f"def unnamed(s):\n    return {nested}"


sine_rest, cosine_rest = _polynomial(SINE, SINE_SINGLE), _polynomial(COSINE, COSINE_SINGLE)


def cosine_and_sine(u: float) -> tuple[float, float]:
    """Cosine and sine of 2 pi u, u in [0, 1], each to a relative 2^-52 (2^-23), without a branch or a call.

    The nearest multiple of 1/2 is subtracted exactly. Of the remainder and its complement to 1/4, the smaller one is at most
    1/8: its sine and cosine are polynomials, and they are swapped if it is the complement.
    """
    half = 0.5 if u >= 0.25 else 0.0
    half = 1.0 if u >= 0.75 else half
    size = abs(u - half)
    lack = 0.25 - size
    t = min(size, lack)
    sine = t * (TWO_PI + sine_rest(t * t))
    cosine = 1.0 + (t * t) * cosine_rest(t * t)
    along = sine if lack < size else cosine
    aside = cosine if lack < size else sine
    return (-along if half == 0.5 else along), (-aside if u > 0.5 else aside)
