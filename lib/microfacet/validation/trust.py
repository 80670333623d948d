"""How many digits of the library are right, and where: every quantity against 50 digits, over roughness and angle.

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

from microfacet.geometry import beckmann, ggx
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution
from microfacet.kernels import Batch
from microfacet.statement import DIGITS
from microfacet.visibility import smith

Array = NDArray[Any]
Maker = Callable[[float], Distribution]
Exact = Callable[..., mpmath.mpf]

ALPHA = np.logspace(-8, 3, 34)
TANGENT = np.logspace(-8, 8, 41)
AZIMUTH = np.radians(35)
PRECISIONS = (np.float64, np.float32)
MOST: dict[Any, float] = {np.float64: 16.0, np.float32: 7.5}  # digits that a precision can hold
FAMILIES: dict[type, Any] = {GGX: ggx, Beckmann: beckmann}


def directions(real: type, tangent: Array = TANGENT) -> Array:
    """Unit vectors (n, 3) at these tangents of the polar angle, rounded to the precision."""
    sine, cosine = tangent / np.sqrt(1 + tangent**2), 1 / np.sqrt(1 + tangent**2)
    return np.stack([sine * np.cos(AZIMUTH), sine * np.sin(AZIMUTH), cosine], axis=-1).astype(real)


def rounded(alpha: float, real: type) -> float:
    """The roughness that a kernel of this precision sees."""
    return float(real(alpha))


# --- what is compared -------------------------------------------------------------------------------------------------


def digits(value: Array, exact: list[mpmath.mpf], real: type) -> Array:
    """Decimal digits that are right, from 0 to as many as the precision has; NaN where it cannot hold the exact value."""
    found = [_digits(float(v), e, real) for v, e in zip(np.ravel(value), exact, strict=True)]
    return np.reshape(found, np.shape(value))


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
    return mpmath.mpf(FAMILIES[type(ndf)].D.exact(*map(_wide, m), *ndf.parameters))


def _wide(number: Any) -> Any:
    return number if isinstance(number, mpmath.mpf) else float(number)


def exact_Lambda(ndf: Distribution, wo: Array) -> mpmath.mpf:
    return mpmath.mpf(FAMILIES[type(ndf)].Lambda.exact(smith.a_o.exact(*map(float, wo), *ndf.parameters)))


@cache
def _Lambda(kernel: Callable[..., float]) -> Batch:
    return Batch(kernel, [3])


def Lambda(ndf: Distribution, wo: Array) -> Array:
    """Smith's Lambda for directions (n, 3), by the kernel that every model calls."""
    closed = type(ndf).closed_Lambda
    assert closed is not None
    return np.asarray(_Lambda(closed)([wo], ndf.parameters))


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


def library_map(quantity: str, kind: type, real: type) -> Array:
    """Digits of the library's own kernel."""
    return map_of(QUANTITIES[quantity][0], quantity, kind, real)
