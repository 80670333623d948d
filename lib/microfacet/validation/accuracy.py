"""Correct digits of every quantity of the library, over roughness and angle, against references of 50 digits (matt facets:
30).

Views are spaced evenly in the logarithm of the tangent, from 1e-8 above the pole to 1e-8 above the horizon, at one azimuth;
roughnesses from 1e-8 to 1e3. References take directions and roughnesses as the binary numbers they are, of either precision.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution
from microfacet.statements.reference import DIGITS
from microfacet.visibility import smith

Array = NDArray[Any]
Maker = Callable[[float], Distribution]
Exact = Callable[..., mpmath.mpf]

ALPHA = np.logspace(-8, 3, 34)
TANGENT = np.logspace(-8, 8, 41)
AZIMUTH = np.radians(35)
PRECISIONS = (np.float64, np.float32)
MOST: dict[Any, float] = {np.float64: 16.0, np.float32: 7.5}  # digits that a precision can hold


def directions(real: type, tangent: Array = TANGENT, azimuth: float = AZIMUTH) -> Array:
    """Unit vectors (n, 3) at these tangents of the polar angle, rounded to the precision."""
    sine, cosine = tangent / np.sqrt(1 + tangent**2), 1 / np.sqrt(1 + tangent**2)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=-1).astype(real)


def rounded(alpha: float, real: type) -> float:
    """The roughness that a kernel of this precision gets."""
    return float(real(alpha))


# --- what is compared -------------------------------------------------------------------------------------------------


def digits(value: Array, exact: list[mpmath.mpf], real: type) -> Array:
    """Correct decimal digits, from 0 to as many as the precision has; NaN where it cannot hold the exact value."""
    correct = [_digits(float(v), e, real) for v, e in zip(np.ravel(value), exact, strict=True)]
    return np.reshape(correct, np.shape(value))


def _digits(value: float, exact: mpmath.mpf, real: type) -> float:
    limits = np.finfo(real)
    if not float(limits.tiny) < abs(exact) < float(limits.max):
        return np.nan
    if not np.isfinite(value):
        return 0.0
    with mpmath.workdps(DIGITS):
        error = float(abs(mpmath.mpf(value) / exact - 1))
    return float(min(max(-np.log10(error), 0.0), MOST[real])) if error else MOST[real]


def exact_D(ndf: Distribution, m: Any) -> mpmath.mpf:
    """D at a normal of floats or of numbers with more digits."""
    return mpmath.mpf(type(ndf).statements["D"].exact(*map(_wide, m), *ndf.parameters))


def _wide(number: Any) -> Any:
    return number if isinstance(number, mpmath.mpf) else float(number)


def exact_Lambda(ndf: Distribution, wo: Array) -> mpmath.mpf:
    return mpmath.mpf(type(ndf).statements["Lambda"].exact(smith.a_o.exact(*map(float, wo), *ndf.parameters)))


def Lambda(ndf: Distribution, wo: Array) -> Array:
    """Smith's Lambda for directions (n, 3), by the kernel that every model calls."""
    return np.asarray(ndf.Lambda(wo))


def D(ndf: Distribution, m: Array) -> Array:
    return np.asarray(ndf.D(m))


QUANTITIES: dict[str, tuple[Callable[[Distribution, Array], Array], Callable[[Distribution, Array], mpmath.mpf]]] = {
    "D": (D, exact_D),
    "Lambda": (Lambda, exact_Lambda),
}


@cache
def exact_map(quantity: str, kind: type, real: type) -> list[list[mpmath.mpf]]:
    """The reference over roughness (rows) and angle, for directions of this precision."""
    exact = QUANTITIES[quantity][1]
    return [[exact(kind(rounded(alpha, real)), w) for w in directions(real)] for alpha in ALPHA]


def map_of(method: Callable[[Distribution, Array], Array], quantity: str, kind: type, real: type) -> Array:
    """Digits of a method (ndf, directions) -> values over roughness (rows) and angle."""
    views = directions(real)
    rows = zip(ALPHA, exact_map(quantity, kind, real), strict=True)
    return np.array([digits(method(kind(rounded(alpha, real)), views), exact, real) for alpha, exact in rows])


# --- references for models ----------------------------------------------------------------------------------------------


def half(wo: Array, wi: Array) -> list[mpmath.mpf]:
    """The unit vector along wo + wi."""
    total = [mpmath.mpf(float(a)) + mpmath.mpf(float(b)) for a, b in zip(wo, wi, strict=True)]
    length = mpmath.sqrt(sum(c * c for c in total))
    return [c / length for c in total]


def exact_rho(ndf: Distribution, wo: Array, wi: Array) -> mpmath.mpf:
    """The BRDF for F = 1, correlated by height."""
    with mpmath.workdps(DIGITS):
        joint = 1 / (1 + exact_Lambda(ndf, wo) + exact_Lambda(ndf, wi))
        return exact_D(ndf, half(wo, wi)) * joint / (4 * mpmath.mpf(float(wo[2])) * mpmath.mpf(float(wi[2])))


def exact_pdf(ndf: Distribution, wo: Array, wi: Array) -> mpmath.mpf:
    """The density of light directions from visible normals."""
    with mpmath.workdps(DIGITS):
        return exact_D(ndf, half(wo, wi)) / (1 + exact_Lambda(ndf, wo)) / (4 * mpmath.mpf(float(wo[2])))


def exact_G1(ndf: Distribution, wo: Array) -> mpmath.mpf:
    with mpmath.workdps(DIGITS):
        return 1 / (1 + exact_Lambda(ndf, wo))


# --- samplers: the uniform numbers that give a normal -------------------------------------------------------------------


def _unstretched(ndf: Distribution, w: Array, power: int) -> list[mpmath.mpf]:
    """A direction (power 1) or a normal (-1) on the surface of unit roughness, of unit length, to 50 digits."""
    scales = [mpmath.mpf(alpha) ** power for alpha in ndf.parameters] + [mpmath.mpf(1)]
    moved = [scale * mpmath.mpf(float(c)) for scale, c in zip(scales, w, strict=True)]
    length = mpmath.sqrt(sum(c * c for c in moved))
    return [c / length for c in moved]


def _ggx_numbers(v: list[mpmath.mpf], h: list[mpmath.mpf]) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Mirrored at the normal, the view falls on a spherical cap: the azimuth there, and the height."""
    twice = 2 * sum(a * b for a, b in zip(v, h, strict=True))
    x, y = (twice * b - a for a, b in zip(v[:2], h[:2], strict=True))
    return mpmath.atan2(y, x) / (2 * mpmath.pi) % 1, 1 - twice * h[2] / (1 + v[2])


def _beckmann_numbers(v: list[mpmath.mpf], h: list[mpmath.mpf]) -> tuple[mpmath.mpf, mpmath.mpf]:
    """The fraction of the visible area with a lower slope along the view, and that with a lower slope across it."""
    sine = mpmath.hypot(v[0], v[1])
    x, y = -h[0] / h[2], -h[1] / h[2]
    along, across = (v[0] * x + v[1] * y) / sine, (v[0] * y - v[1] * x) / sine

    def visible_below(q: mpmath.mpf) -> mpmath.mpf:
        return v[2] * mpmath.erfc(-q) / 2 + sine * mpmath.exp(-q * q) / (2 * mpmath.sqrt(mpmath.pi))

    return visible_below(along) / visible_below(v[2] / sine), mpmath.erfc(-across) / 2


NUMBERS: dict[type, Callable[..., tuple[mpmath.mpf, mpmath.mpf]]] = {GGX: _ggx_numbers, Beckmann: _beckmann_numbers}


def numbers_back(ndf: Distribution, wo: Array, u: Array, m: Array) -> float:
    """Correct digits of the uniform numbers u, recovered from a visible normal; those of u[1] from the nearer of 0 and 1."""
    if not np.isfinite(m).all():
        return 0.0
    most = MOST[m.dtype.type]
    with mpmath.workdps(DIGITS):
        u1, u2 = (mpmath.mpf(float(one)) for one in u)
        first, second = NUMBERS[type(ndf)](_unstretched(ndf, wo, 1), _unstretched(ndf, m, -1))
        off = float(max(abs(first - u1), abs(second - u2) / min(u2, 1 - u2)))
    return float(min(max(-np.log10(off), 0), most)) if off else most
