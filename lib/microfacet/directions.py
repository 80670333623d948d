"""Directions as arrays: making them, checking them, reflecting them. Unit vectors, last axis 3, z is up, angles in radians."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def spherical(theta: Any, phi: Any = 0.0) -> np.ndarray:
    """Unit vectors (..., 3) at polar angle theta and azimuth phi, radians."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def as_vectors(name: str, values: Any, width: int = 3) -> np.ndarray:
    """The argument as an array (..., width) of finite floats; anything else is a ValueError that names it."""
    array = _floats(name, values, f" of shape (..., {width})")
    if array.ndim == 0 or array.shape[-1] != width:
        raise ValueError(f"{name} must have shape (..., {width}), got shape {array.shape}")
    return _finite(name, array)


def as_numbers(name: str, values: Any) -> np.ndarray:
    """The argument as an array of finite floats, of any shape."""
    return _finite(name, _floats(name, values))


def _floats(name: str, values: Any, shape: str = "") -> np.ndarray:
    """Real numbers in single or double precision; text and complex numbers are none."""
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "biufO":
            raise TypeError
        return array if array.dtype in (np.float32, np.float64) else array.astype(np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be an array of numbers{shape}, got {values!r}") from None


def _finite(name: str, array: np.ndarray) -> np.ndarray:
    flat = array.reshape(-1)
    if not math.isfinite(float(np.dot(flat, flat))) and not np.isfinite(array).all():
        at = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name} must be finite, got {array[at]}" + (f" at index {at}" if at else ""))
    return array


def as_uniform(name: str, values: Any) -> np.ndarray:
    """The argument as an array (..., 2) of numbers in [0, 1)."""
    array = as_vectors(name, values, 2)
    if array.size and not (array.min() >= 0 and array.max() < 1):
        raise ValueError(f"{name} must lie in [0, 1), got {array.min()} to {array.max()}")
    return array


def positive(name: str, value: Any) -> float:
    """The argument as a finite float above 0; anything else is a ValueError that names it."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number above 0, got {value!r}") from None
    if not 0 < number < math.inf:
        raise ValueError(f"{name} must be a finite number above 0, got {number}")
    return number


def reflect(wo: Any, wm: Any) -> np.ndarray:
    """wo mirrored at the microfacet with normal wm: 2 (wo.wm) wm - wo; shapes (..., 3) broadcast."""
    wo, wm = as_vectors("wo", wo), as_vectors("wm", wm)
    return np.asarray(2 * np.sum(wo * wm, axis=-1, keepdims=True) * wm - wo)


def half_vector(wo: Any, wi: Any) -> np.ndarray:
    """(wo + wi)/|wo + wi|; where wi = -wo there is none, and the result is 0."""
    total = as_vectors("wo", wo) + as_vectors("wi", wi)
    length = np.linalg.norm(total, axis=-1, keepdims=True)
    return np.asarray(np.divide(total, length, out=np.zeros_like(total), where=length > 0))
