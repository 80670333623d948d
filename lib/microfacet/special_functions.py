"""Exponential, logarithm and error function that a compiler can vectorize.

No branch, no call, short chains of dependence; each within a stated range and to a stated error. Kernels of plain floats
(see microfacet.compiler.kernels). Source: schonfelder1978 for the error function.
"""

from math import factorial, frexp

import numpy as np

from microfacet.compiler.exponential import LN2_HIGH, LN2_LOW, PER_LN2, ROUNDER, power_of_two
from microfacet.compiler.kernels import ByPrecision

FINE = ByPrecision(double=1.0, single=0.0)  # known when a kernel is compiled: what depends on it costs nothing
LN2 = 0.6931471805599453
SQRT_PI = 1.7724538509055161
INVERSE_FACTORIALS = tuple(1.0 / factorial(k) for k in range(2, 14))


def exponential_within(x: float) -> float:
    """exp(x) to an ulp or two for |x| below 80: Taylor's series as four interleaved ones, no bounds to respect."""
    k = (x * PER_LN2 + ROUNDER) - ROUNDER
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    a = INVERSE_FACTORIALS[4]
    b = INVERSE_FACTORIALS[5]
    c = INVERSE_FACTORIALS[6]
    d = INVERSE_FACTORIALS[7]
    if FINE > 0.0:
        a = a + INVERSE_FACTORIALS[8] * r4
        b = b + INVERSE_FACTORIALS[9] * r4
        c = c + INVERSE_FACTORIALS[10] * r4
        d = d + INVERSE_FACTORIALS[11] * r4
    a = a * r4 + INVERSE_FACTORIALS[0]
    b = b * r4 + INVERSE_FACTORIALS[1]
    c = c * r4 + INVERSE_FACTORIALS[2]
    d = d * r4 + INVERSE_FACTORIALS[3]
    p = ((a + b * r) + (c + d * r) * r2) * r2 + r
    return (1.0 + p) * power_of_two(k)


ROOT_HALF = 0.7071067811865476


def significand(x: float) -> float:
    """The factor of a normal x > 0 beside a power of two, from sqrt(1/2) up to sqrt(2)."""
    m, _ = frexp(x)
    return 2.0 * m if m < ROOT_HALF else m


def exponent(x: float) -> float:
    """The power of two that `significand` leaves out."""
    m, k = frexp(x)
    return float(k - 1 if m < ROOT_HALF else k)


_HALVES = {64: (0x3FE6A09E667F3BCD, 52), 32: (0x3F3504F3, 23)}  # bits of sqrt(1/2), bits of a significand
_AS_BITS = "def unnamed(x):\n    i = np.float{0}(x).view(np.int{0})\n    return "
_FACTOR = _AS_BITS + "np.int{0}(i - ((i - np.int{0}({1})) & np.int{0}({2}))).view(np.float{0})"
_POWER = _AS_BITS + "R((i - np.int{0}({1})) >> np.int{0}({2}))"


def _by_bits(text: str, masked: bool) -> dict[type, str]:
    def written(bits: int) -> str:
        half, width = _HALVES[bits]
        return text.format(bits, half, -(1 << width) if masked else width)

    return {np.float64: written(64), np.float32: written(32)}


significand.__compiled__ = _by_bits(_FACTOR, True)  # type: ignore[attr-defined]
exponent.__compiled__ = _by_bits(_POWER, False)  # type: ignore[attr-defined]


def logarithm_about(x: float) -> float:
    """log(x) of a normal x > 0 to a relative 1e-7, also next to x = 1."""
    m = significand(x)
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    return exponent(x) * LN2 + 2.0 * s * ((1.0 + z * (1.0 / 3.0)) + (z * z) * (0.2 + z * (1.0 / 7.0)))


CENTRE = 3.5  # as in (x - CENTRE)/(x + CENTRE), in which the series is short
STRETCH, SHIFT = 175.0 / 18.0, 16.0 / 9.0  # take x from 0 to 9 to -1 to 1
SERIES = (  # of (x + CENTRE) erfcx(x), to 3e-17
    1.41517231301838,
    -1.0453084945938589,
    0.6162327844318695,
    -0.28838351741012497,
    0.10424220122570593,
    -0.027077739958359624,
    0.003980761431740857,
    0.00017098757270256614,
    -0.00021282058416044336,
    2.3956185351958258e-05,
    8.394199701720538e-06,
    -2.045209159290613e-06,
    -3.8050651723234995e-07,
    1.3684794413465073e-07,
    2.376827954980256e-08,
    -8.67589862925511e-09,
    -1.867925103757869e-09,
    4.973764970892839e-10,
    1.190171314580363e-10,
    -1.988209400150548e-11,
)
SHORT_SERIES = (  # to 2e-10
    1.415172313171824,
    -1.0453084949437021,
    0.6162327733262082,
    -0.2883835075544857,
    0.10424233174633589,
    -0.027077819482750138,
    0.003980198327833598,
    0.00017126376973668146,
    -0.00021171412744605227,
    2.348582660242475e-05,
    7.372940521954568e-06,
    -1.6524053276554025e-06,
)


def scaled_erfc(x: float) -> float:
    """exp(x^2) erfc(x) to a few ulps for x from 0 to 9: Chebyshev's series in a quotient, its powers collected."""
    r = 1.0 / (x + CENTRE)
    t = SHIFT - STRETCH * r
    t2 = t * t
    t4 = t2 * t2
    a = 0.0
    b = 0.0
    c = 0.0
    d = 0.0
    if FINE > 0.0:
        for k in range(16, -1, -4):
            a = a * t4 + SERIES[k]
            b = b * t4 + SERIES[k + 1]
            c = c * t4 + SERIES[k + 2]
            d = d * t4 + SERIES[k + 3]
    else:
        for k in range(8, -1, -4):
            a = a * t4 + SHORT_SERIES[k]
            b = b * t4 + SHORT_SERIES[k + 1]
            c = c * t4 + SHORT_SERIES[k + 2]
            d = d * t4 + SHORT_SERIES[k + 3]
    return ((a + b * t) + (c + d * t) * t2) * r
