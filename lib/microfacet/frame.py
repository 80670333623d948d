"""Frames: from the directions of a scene to those of the library, with z along the normal and x along the tangent."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microfacet.directions import numbers
from microfacet.model import Model

PARALLEL = 16  # epsilons: a sine below is rounding


class Frame(Model):
    """Orthonormal, right-handed frame at a point of a surface: x along the tangent, z along the normal.

    Parameters
    ----------
    normal : array_like, shape (..., 3)
        Surface normals of any length above 0.
    tangent : array_like, shape (..., 3), optional
        Tangents of any length above 0; the part at right angles to the normal counts (Gram-Schmidt). By default x and y
        are any two such directions, continuous except where the normal's z changes sign. Shapes broadcast.

    Attributes
    ----------
    x, y, z : ndarray, shape (..., 3)
        The axes, unit vectors.

    Raises
    ------
    ValueError
        Where a vector is zero, or where tangent and normal are parallel.

    References
    ----------
    duff2017.

    Examples
    --------
    >>> import microfacet as mf
    >>> frame = mf.Frame([0, 1, 0], [0, 0, 1])
    >>> print(frame.to_local([0.0, 0.8, 0.6]))
    [0.6 0.  0.8]
    """

    def __init__(self, normal: Any, tangent: Any = None) -> None:
        self.z = _unit("normal", normal)
        self.x = _any_tangent(self.z) if tangent is None else _across("tangent", _unit("tangent", tangent), self.z)
        self.y = np.cross(self.z, self.x)

    def to_local(self, w: ArrayLike) -> np.ndarray:
        """Convert directions of the scene to the frame, in which the library takes them.

        Parameters
        ----------
        w : array_like, shape (..., 3)
            Directions in the coordinates of the scene.

        Returns
        -------
        ndarray, shape (..., 3)
            Components along x, y and z.

        Raises
        ------
        ValueError
            If w has another shape or is not finite.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(mf.Frame([0, 1, 0], [0, 0, 1]).to_local([0.0, 0.8, 0.6]))
        [0.6 0.  0.8]
        """
        w = _vectors("w", w)
        return np.stack(np.broadcast_arrays(*(np.sum(w * axis, axis=-1) for axis in (self.x, self.y, self.z))), axis=-1)

    def to_world(self, w: ArrayLike) -> np.ndarray:
        """Convert directions of the frame to the scene; the inverse of `to_local`.

        Parameters
        ----------
        w : array_like, shape (..., 3)
            Components along x, y and z.

        Returns
        -------
        ndarray, shape (..., 3)
            Directions in the coordinates of the scene.

        Raises
        ------
        ValueError
            If w has another shape or is not finite.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(mf.Frame([0, 1, 0], [0, 0, 1]).to_world([0.6, 0.0, 0.8]))
        [0.  0.8 0.6]
        """
        w = _vectors("w", w)
        return np.asarray(w[..., :1] * self.x + w[..., 1:2] * self.y + w[..., 2:] * self.z)

    def rotated(self, angle: ArrayLike) -> Frame:
        """Rotate the frame about its normal, x towards y.

        Parameters
        ----------
        angle : array_like
            Angle, radians.

        Returns
        -------
        Frame
            The rotated frame.

        Raises
        ------
        ValueError
            If an angle is not finite.

        Examples
        --------
        >>> from math import pi
        >>> import microfacet as mf
        >>> print(mf.Frame([0, 0, 1], [1, 0, 0]).rotated(pi / 2).x.round(4))
        [0. 1. 0.]
        """
        angle = numbers("angle", angle).checked().astype(self.x.dtype)[..., None]
        return Frame(self.z, np.cos(angle) * self.x + np.sin(angle) * self.y)


def _vectors(name: str, values: Any) -> np.ndarray:
    array = numbers(name, values).checked()
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} must have shape (..., 3), got shape {array.shape}")
    return array


def _unit(name: str, values: Any) -> np.ndarray:
    """The vectors over their lengths; the largest component is divided out first, so that squares are numbers."""
    array = _vectors(name, values)
    largest = abs(array).max(axis=-1, keepdims=True, initial=0)
    if not (largest > 0).all():
        raise ValueError(f"{name} must not be the zero vector, got {array[(largest == 0)[..., 0]][0]}")
    scaled = array / largest
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def _across(name: str, tangent: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """What is left of a unit vector at right angles to the normal, as a unit vector; twice, for what rounding leaves."""
    rest = tangent - np.sum(tangent * normal, axis=-1, keepdims=True) * normal
    length = np.linalg.norm(rest, axis=-1, keepdims=True)
    if not (length > PARALLEL * np.finfo(rest.dtype).eps).all():
        raise ValueError(f"{name} must not be parallel to the normal, got a sine of {length.min():.2g} between them")
    rest = rest / length
    rest = rest - np.sum(rest * normal, axis=-1, keepdims=True) * normal
    return np.asarray(rest / np.linalg.norm(rest, axis=-1, keepdims=True))


def _any_tangent(z: np.ndarray) -> np.ndarray:
    sign = np.copysign(z.dtype.type(1), z[..., 2])
    a = -1 / (sign + z[..., 2])
    return np.stack([1 + sign * z[..., 0] ** 2 * a, sign * z[..., 0] * z[..., 1] * a, -sign * z[..., 0]], axis=-1)
