"""Directions as arrays: making them, checking them, reflecting them. Unit vectors, last axis 3, z is up, angles in radians.

One rule holds wherever the library takes a direction, for views, lights and normals: the square v.v of its length must be 1 to
within `UNIT`, which leaves room for the rounding of single precision and of a few operations in it. Such a vector is used as it
is, any other is refused by a ValueError that gives its length and its place. The zero vector, which a sampler returns for what
is lost, is taken as well: its results are 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

_PRECISIONS = (np.dtype(np.float64), np.dtype(np.float32))
UNIT = 2e-5  # how far v.v of a direction may be from 1
COSINE = UNIT / 2  # how far beyond 0 and 1 a cosine between two directions may be
ALPHA_LIMITS = (1e-11, 1e11)  # within, D, masking, densities and samples are numbers in both precisions; at 1e12 not all are


def spherical(theta: ArrayLike, phi: ArrayLike = 0.0) -> NDArray[Any]:
    """Convert polar angle and azimuth to unit vectors.

    Parameters
    ----------
    theta : array_like
        Polar angle from z, radians.
    phi : array_like, optional
        Azimuth from x towards y, radians; by default 0. Shapes broadcast.

    Returns
    -------
    ndarray, shape (..., 3)
        Unit vectors, in double precision.

    Examples
    --------
    >>> from math import pi
    >>> import microfacet as mf
    >>> print(mf.spherical(pi / 3, pi / 2).round(4))
    [0.    0.866 0.5  ]
    """
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


class Argument(NamedTuple):
    """An array of floats from a caller: its name, and the kind of its numbers: "finite", a "fraction" in [0, 1), or in each
    row a "direction".

    It is checked when it is read: row by row in the loop of a kernel, or by `checked` in a pass of its own.
    """

    name: str
    array: np.ndarray
    kind: str

    def checked(self) -> np.ndarray:
        """The array if all its numbers are valid; else a ValueError that names the argument and an invalid number."""
        array, name = self.array, self.name
        flat = array.reshape(-1)
        with np.errstate(over="ignore"):
            suspect = not math.isfinite(float(np.dot(flat, flat)))
        if suspect and not np.isfinite(array).all():
            at = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
            raise ValueError(f"{name} must be finite, got {array[at]}" + (f" at index {at}" if at else ""))
        if self.kind == "fraction" and array.size and not (array.min() >= 0 and array.max() < 1):
            raise ValueError(f"{name} must lie in [0, 1), got {array.min()} to {array.max()}")
        if self.kind == "direction":
            _unit(name, array)
        return array


def _unit(name: str, array: np.ndarray) -> None:
    """ValueError that names the first row that is neither a unit vector nor 0."""
    with np.errstate(over="ignore"):
        square = np.einsum("...k,...k->...", array, array)
    if (off := (np.abs(square - 1) > UNIT) & (square > 0)).any():
        at = tuple(int(k) for k in np.argwhere(off)[0])
        place = f" at index {at}" if at else ""
        raise ValueError(f"{name} must hold unit vectors, got one of length {math.hypot(*array[at]):.9g}{place}: normalise it")


def vectors(name: str, values: Any) -> Argument:
    """The argument as an array (..., 3) of floats, directions once checked; another shape is a ValueError that names it."""
    return _rows(name, values, 3, "direction")


def points(name: str, values: Any) -> Argument:
    """The argument as an array (..., 3) of floats, finite once checked; another shape is a ValueError that names it."""
    return _rows(name, values, 3, "finite")


def _rows(name: str, values: Any, width: int, kind: str) -> Argument:
    array = floats(name, values, width)
    if array.ndim == 0 or array.shape[-1] != width:
        raise ValueError(f"{name} must have shape (..., {width}), got shape {array.shape}")
    return Argument(name, array, kind)


def numbers(name: str, values: Any) -> Argument:
    """The argument as an array of floats of any shape, finite once checked."""
    return Argument(name, floats(name, values), "finite")


def uniform(name: str, values: Any) -> Argument:
    """The argument as an array (..., 2) of floats, in [0, 1) once checked."""
    return _rows(name, values, 2, "fraction")


def as_vectors(name: str, values: Any) -> np.ndarray:
    """The argument as an array (..., 3) of directions; anything else is a ValueError that names it."""
    return vectors(name, values).checked()


def as_points(name: str, values: Any) -> np.ndarray:
    """The argument as an array (..., 3) of finite floats; anything else is a ValueError that names it."""
    return points(name, values).checked()


def cosines(name: str, values: Any) -> np.ndarray:
    """The argument as an array of cosines in [0, 1], of any shape.

    Directions are unit vectors to within `UNIT`, their products cosines to within `COSINE`: what is beyond 0 or 1 by no more
    counts as 0 or 1, what is farther out is a ValueError that names it.
    """
    array = numbers(name, values).checked()
    if array.size and not (array.min() >= -COSINE and array.max() <= 1 + COSINE):
        raise ValueError(f"{name} must lie in [0, 1], got {array.min()} to {array.max()}")
    return np.clip(array, 0, 1)


def as_uniform(name: str, values: Any) -> np.ndarray:
    """The argument as an array (..., 2) of numbers in [0, 1)."""
    return uniform(name, values).checked()


def floats(name: str, values: Any, width: int = 0) -> np.ndarray:
    """Real numbers in single or double precision; text, complex numbers and masked elements are none."""
    try:
        array = _unmasked(values)
        if array.dtype in _PRECISIONS:
            return array
        if array.dtype.kind not in "biufO" or values is None:  # NumPy would make NaN of None
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError):
        shape = f" of shape (..., {width})" if width else ""
        raise ValueError(f"{name} must be an array of numbers{shape}, got {values!r}") from None


def _unmasked(values: Any) -> np.ndarray:
    """The argument as an array; TypeError if an element is masked."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise TypeError
    return np.asarray(values)


def positive(name: str, value: Any) -> float:
    """The argument as a finite float above 0; anything else is a ValueError that names it."""
    try:
        number = real_number(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number above 0, got {value!r}") from None
    if not 0 < number < math.inf:
        raise ValueError(f"{name} must be a finite number above 0, got {number}")
    return number


def within(name: str, value: Any, limits: tuple[float, float]) -> float:
    """The argument as a float between the limits, both above 0; anything else is a ValueError that names it."""
    number, (low, high) = positive(name, value), limits
    if not low <= number <= high:
        raise ValueError(f"{name} must lie between {low:g} and {high:g}, got {number:g}")
    return number


def roughness(name: str, value: Any) -> float:
    """The argument as a float within `ALPHA_LIMITS`; anything else is a ValueError that names it."""
    return within(name, value, ALPHA_LIMITS)


def whole(name: str, value: Any, least: int) -> int:
    """The argument as a whole number that is large enough; anything else is a ValueError that names it."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {value!r}")
    return int(value)


def one_of(name: str, value: Any, known: Iterable[str]) -> str:
    """The argument if it is one of the known words; anything else is a ValueError that names it and them."""
    words = tuple(known)
    if not (isinstance(value, str) and value in words):
        raise ValueError(f"{name} must be one of {', '.join(words)}, got {value!r}")
    return value


def real_number(value: Any) -> float:
    """One real number, infinite if too large for a float; TypeError or ValueError for text, truth values and arrays."""
    array = _unmasked(value)
    if array.ndim or array.dtype.kind not in "iufO":
        raise TypeError
    try:
        return float(array[()])
    except OverflowError:
        return math.inf


def reflect(wo: ArrayLike, wm: ArrayLike) -> NDArray[Any]:
    r"""Mirror a direction at a microfacet.

    .. math:: \omega_i = 2 (\omega_o \cdot \omega_m) \, \omega_m - \omega_o

    Statement ``material.reflection.mirror``.

    Parameters
    ----------
    wo : array_like, shape (..., 3)
        Directions, unit vectors.
    wm : array_like, shape (..., 3)
        Microfacet normals, unit vectors; shapes broadcast.

    Returns
    -------
    ndarray, shape (..., 3)
        Mirrored directions, unit vectors.

    Raises
    ------
    ValueError
        If an argument does not hold unit vectors.

    Examples
    --------
    >>> import microfacet as mf
    >>> print(mf.reflect([0.6, 0.0, 0.8], [0, 0, 1]))
    [-0.6  0.   0.8]
    """
    wo, wm = as_vectors("wo", wo), as_vectors("wm", wm)
    return np.asarray(2 * np.sum(wo * wm, axis=-1, keepdims=True) * wm - wo)


def half_vector(wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
    r"""Half vector: the normal of the microfacet that mirrors one direction into the other.

    .. math:: \omega_h = \frac{\omega_o + \omega_i}{\left| \omega_o + \omega_i \right|}

    Statement ``material.reflection.half_vector``.

    Parameters
    ----------
    wo : array_like, shape (..., 3)
        View directions, unit vectors.
    wi : array_like, shape (..., 3)
        Light directions, unit vectors; shapes broadcast.

    Returns
    -------
    ndarray, shape (..., 3)
        Unit vectors; the zero vector where the directions are opposite.

    Raises
    ------
    ValueError
        If an argument does not hold unit vectors.

    Examples
    --------
    >>> import microfacet as mf
    >>> print(mf.half_vector([0.6, 0.0, 0.8], [0.0, 0.6, 0.8]).round(4))
    [0.3313 0.3313 0.8835]
    """
    total = as_vectors("wo", wo) + as_vectors("wi", wi)
    length = np.linalg.norm(total, axis=-1, keepdims=True)
    return np.asarray(np.divide(total, length, out=np.zeros_like(total), where=length > 0))
