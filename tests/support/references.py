"""Formulae as the papers print them, in mpmath at 60 digits, written without a look at the library."""

from __future__ import annotations

from typing import Any

import mpmath as mp

DIGITS = 60


def _binary(value: Any) -> Any:
    return value if isinstance(value, mp.mpf) else mp.mpf(float(value))


def exactly(function: Any) -> Any:
    """The function at 60 digits, with floats taken as the binary numbers they are."""

    def evaluate(*values: float) -> Any:
        with mp.workdps(DIGITS):
            return +function(*map(_binary, values))

    return evaluate


def _tangent_squared(x: Any, y: Any, z: Any, alpha_x: Any, alpha_y: Any) -> Any:
    """tan^2 theta (cos^2 phi/ax^2 + sin^2 phi/ay^2)."""
    theta, phi = mp.atan2(mp.hypot(x, y), z), mp.atan2(y, x)
    return mp.tan(theta) ** 2 * ((mp.cos(phi) / alpha_x) ** 2 + (mp.sin(phi) / alpha_y) ** 2)


@exactly
def ggx_D(x: Any, y: Any, z: Any, alpha_x: Any, alpha_y: Any) -> Any:
    return 1 / (mp.pi * alpha_x * alpha_y * z**4 * (1 + _tangent_squared(x, y, z, alpha_x, alpha_y)) ** 2)


@exactly
def beckmann_D(x: Any, y: Any, z: Any, alpha_x: Any, alpha_y: Any) -> Any:
    return mp.exp(-_tangent_squared(x, y, z, alpha_x, alpha_y)) / (mp.pi * alpha_x * alpha_y * z**4)


@exactly
def ward_D(x: Any, y: Any, z: Any, alpha_x: Any, alpha_y: Any) -> Any:
    return mp.exp(-_tangent_squared(x, y, z, alpha_x, alpha_y)) / (mp.pi * alpha_x * alpha_y)


def _cosine(x: Any, y: Any, z: Any) -> Any:
    """Of the polar angle: rounding leaves a vector of not quite unit length."""
    return z / mp.sqrt(x * x + y * y + z * z)


@exactly
def blinn_phong_D(x: Any, y: Any, z: Any, n: Any) -> Any:
    return _cosine(x, y, z) ** n


@exactly
def normalized_blinn_phong_D(x: Any, y: Any, z: Any, n: Any) -> Any:
    return (n + 2) / (2 * mp.pi) * _cosine(x, y, z) ** n


@exactly
def a_of(x: Any, y: Any, z: Any, alpha_x: Any, alpha_y: Any) -> Any:
    """1/(alpha_o tan theta_o) with alpha_o^2 = cos^2 phi_o ax^2 + sin^2 phi_o ay^2."""
    theta, phi = mp.atan2(mp.hypot(x, y), z), mp.atan2(y, x)
    return 1 / (mp.sqrt((mp.cos(phi) * alpha_x) ** 2 + (mp.sin(phi) * alpha_y) ** 2) * mp.tan(theta))


def ggx_Lambda(a: Any) -> Any:
    with mp.workdps(DIGITS):
        return (-1 + mp.sqrt(1 + 1 / _binary(a) ** 2)) / 2


def beckmann_Lambda(a: Any) -> Any:
    """(erf(a) - 1)/2 + exp(-a^2)/(2 a sqrt(pi)): the two nearly cancel, so at twice the digits."""
    with mp.workdps(2 * DIGITS):
        a = _binary(a)
        return mp.exp(-(a**2)) / (2 * a * mp.sqrt(mp.pi)) - mp.erfc(a) / 2


def student_Lambda(cotangent: float, n: float) -> float:
    """1/cot * integral of (q - cot) P2(q) for the slopes of (n+2)/(2 pi) cos^n, P2 being itself integrated."""
    with mp.workdps(30):
        c, n = mp.mpf(cotangent), mp.mpf(n)
        shape = mp.quad(lambda t: mp.cos(t) ** (n + 2), [-mp.pi / 2, 0, mp.pi / 2])  # across, y = sqrt(1+q^2) tan t
        marginal = (n + 2) / (2 * mp.pi) * shape

        def moment(t: Any) -> Any:
            q = mp.tan(t)
            return (q - c) * marginal * (1 + q * q) ** (-(n + 3) / 2) * (1 + q * q)

        start = mp.atan(c)
        middle = min(start + 1 / mp.sqrt(n), (start + mp.pi / 2) / 2)
        return float(mp.quad(moment, [start, middle, mp.pi / 2]) / c)
