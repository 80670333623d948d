"""Arithmetic that keeps the digits a plain formula loses: error-free sums and products, and exponentials of squares.

Kernels of plain floats (see microfacet.kernels). Source: dekker1971.
"""

from math import exp, pi

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


def turn(u: float) -> tuple[float, float]:
    """Cosine and sine of the share u, in [0, 1], of a full turn, to an ulp or two and without a branch or a call.

    The nearest quarter turn is taken off exactly; for the rest, at most an eighth, Taylor's series suffice.
    """
    quarters = (1.0 if u >= 0.125 else 0.0) + (1.0 if u >= 0.375 else 0.0)
    quarters += (1.0 if u >= 0.625 else 0.0) + (1.0 if u >= 0.875 else 0.0)
    x = (2.0 * pi) * (u - 0.25 * quarters)
    s = x * x
    odd = 1.0 / 1307674368000.0
    odd = 1.0 / 6227020800.0 - s * odd
    odd = 1.0 / 39916800.0 - s * odd
    odd = 1.0 / 362880.0 - s * odd
    odd = 1.0 / 5040.0 - s * odd
    odd = 1.0 / 120.0 - s * odd
    odd = 1.0 / 6.0 - s * odd
    sine = x - x * (s * odd)
    even = 1.0 / 20922789888000.0
    even = 1.0 / 87178291200.0 - s * even
    even = 1.0 / 479001600.0 - s * even
    even = 1.0 / 3628800.0 - s * even
    even = 1.0 / 40320.0 - s * even
    even = 1.0 / 720.0 - s * even
    even = 1.0 / 24.0 - s * even
    cosine = 1.0 - s * (0.5 - s * even)
    crossed = abs(abs(quarters - 2.0) - 1.0) < 0.5
    along = sine if crossed else cosine
    aside = cosine if crossed else sine
    along = -along if abs(quarters - 1.5) < 1.0 else along
    aside = -aside if abs(quarters - 2.5) < 1.0 else aside
    return along, aside
