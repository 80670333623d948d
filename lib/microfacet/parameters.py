"""Parameters of models: numbers, or arrays of numbers that broadcast with the directions, such as a roughness per pixel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

import numpy as np

from microfacet.directions import floats
from microfacet.model import Model, arguments

Check = Callable[[str, Any], float]


def each(check: Check, name: str, value: Any) -> Any:
    """check(name, value) for a number; for an array, a copy in its own precision, all numbers of which passed the check.

    check: raises a ValueError for NaN and for numbers outside an interval, which may exclude 0. So it suffices to check the
    extremes on either side of 0.
    """
    if np.ndim(value) == 0:
        return check(name, value)
    array = floats(name, value).copy()
    if np.asarray(value).dtype == bool:
        check(name, True)
    for number in _extremes(array):
        check(name, number)
    array.flags.writeable = False
    return array


def _extremes(array: np.ndarray) -> list[float]:
    """The least and the largest number, also of those above 0; NaN if there is one."""
    above = array[array > 0]
    return [float(part) for some in (array, above) if some.size for part in (some.min(), some.max())]


def double(value: Any) -> Any:
    """A parameter in double precision, where others are to be computed from it."""
    return float(value) if np.ndim(value) == 0 else np.asarray(value, np.float64)


def together(**parameters: Any) -> tuple[Any, ...]:
    """The parameters, if their shapes broadcast; else a ValueError that names them."""
    shapes = {name: _shape(value) for name, value in parameters.items()}
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        stated = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise ValueError(f"the shapes of parameters must broadcast, got {stated}") from None
    return tuple(parameters.values())


class Parametric(Model):
    """A model with parameters: numbers, or arrays that broadcast with the directions. Its arguments are parameters and models.

    parameters: the last argument of its kernels, nested tuples of numbers and arrays.
    """

    parameters: tuple[Any, ...]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape to which the parameters that are arrays broadcast; () if all are numbers."""
        return np.broadcast_shapes(*(array.shape for array in _arrays(self.parameters)))

    def at(self, *index: int) -> Self:
        """Model at one place of `batch_shape`, with numbers for parameters.

        Parameters
        ----------
        *index : int
            An index for each axis of `batch_shape`.

        Returns
        -------
        Self
            A model of the same class.

        Raises
        ------
        IndexError
            For a place outside, or another number of indices.

        Examples
        --------
        >>> import microfacet as mf
        >>> mf.Smith(mf.GGX([0.1, 0.2, 0.4])).at(1)
        Smith(GGX(0.2, 0.2))
        """
        whole = np.empty(self.batch_shape, [])[index]  # an IndexError names the axis
        if np.ndim(whole):
            raise IndexError(f"an index for each axis of {self.batch_shape} is needed, got {index}")
        bound = arguments(self)
        for name, value in bound.arguments.items():
            bound.arguments[name] = _at(value, self.batch_shape, index)
        return type(self)(*bound.args, **bound.kwargs)

    def distinct(self) -> tuple[list[tuple[int, ...]], np.ndarray]:
        """Distinct sets of parameters, for work that is done once for each.

        Returns
        -------
        places : list of tuple of int
            A place for each set that differs from all others, for `at`.
        which : ndarray of int, shape batch_shape
            For each place the index of its set.

        Examples
        --------
        >>> import microfacet as mf
        >>> mf.GGX([0.1, 0.2, 0.1]).distinct()
        ([(0,), (1,)], array([0, 1, 0]))
        """
        rows = [np.broadcast_to(array, self.batch_shape).ravel() for array in _arrays(self.parameters)]
        _, first, which = np.unique(np.stack(rows, axis=1), axis=0, return_index=True, return_inverse=True)
        places = zip(*np.unravel_index(first, self.batch_shape), strict=True)
        return [tuple(map(int, place)) for place in places], which.reshape(self.batch_shape)

    def require_numbers(self, what: str) -> None:
        """Refuse parameters that are arrays.

        Parameters
        ----------
        what : str
            What needs numbers, for the message.

        Raises
        ------
        ValueError
            If a parameter is an array.

        Examples
        --------
        >>> import microfacet as mf
        >>> mf.GGX(0.3).require_numbers("my quadrature")
        """
        if self.batch_shape:
            given = f"{self!r} of shape {self.batch_shape}, of which `at` gives one"
            raise ValueError(f"{what} takes numbers for parameters, got {given}")


def _arrays(parameters: Any) -> list[np.ndarray]:
    if isinstance(parameters, tuple):
        return [array for part in parameters for array in _arrays(part)]
    return [parameters] if isinstance(parameters, np.ndarray) else []


def _shape(value: Any) -> tuple[int, ...]:
    return value.batch_shape if isinstance(value, Parametric) else getattr(value, "shape", ())


def _at(value: Any, shape: tuple[int, ...], index: tuple[int, ...]) -> Any:
    """An argument at one place of a shape to which it broadcasts."""
    own = _shape(value)
    if not own:
        return value
    place = np.broadcast_to(np.arange(np.prod(own)).reshape(own), shape)[index]
    where = tuple(int(k) for k in np.unravel_index(place, own))
    return value.at(*where) if isinstance(value, Parametric) else float(value[where])


def shown(value: Any) -> str:
    """A parameter in the repr of a model: the number, or the range and the shape of an array."""
    if np.ndim(value) == 0:
        return f"{value:g}"
    return f"<{np.min(value):g} to {np.max(value):g}, {np.shape(value)}>" if np.size(value) else f"<{np.shape(value)}>"
