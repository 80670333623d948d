"""The definition of a method, and helpers that the rivals of all quantities share."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from microfacet.compiler import processors
from microfacet.compiler.batch import Batch
from microfacet.directions import spherical

ALPHA = (0.3, 0.5)
LONG = np.longdouble


@dataclass(frozen=True)
class Method:
    """One way to compute a quantity.

    prepare: from a size to a call without arguments, which is timed. error: from a size to an error, by a reference of
    higher precision. sizes: those that are timed; for arrays, the last is charted. code: functions, modules and batches that
    are timed. each: whether the time is one per value. kind: methods compete with others of their kind only.
    """

    label: str
    prepare: Callable[[int], Callable[[], Any]]
    error: Callable[[int], float]
    sizes: tuple[int, ...]
    code: tuple[Any, ...]
    each: bool = True
    kind: str = ""

    @property
    def fingerprint(self) -> str:
        """Changes when the code that is timed does."""
        return hashlib.sha256("\n".join(map(_text, self.code)).encode()).hexdigest()[:16]


def _text(thing: Any) -> str:
    if isinstance(thing, Batch):
        return thing.text(np.float64) + inspect.getsource(Batch) + inspect.getsource(processors.spread)
    return inspect.getsource(thing)


def worst(values: Any, exact: Any) -> float:
    """Largest relative error."""
    return float(np.max(np.abs(np.asarray(values, LONG) / np.asarray(exact, LONG) - 1)))


def directions(count: int, seed: int, real: type = np.float64) -> np.ndarray:
    """Directions of the upper hemisphere, uniform in solid angle, none within a thousandth of the horizon."""
    u = np.random.default_rng(seed).random((2, count))
    return spherical(np.arccos(0.001 + 0.999 * u[0]), 2 * np.pi * u[1]).astype(real)


def uniform(count: int, seed: int, real: type = np.float64) -> np.ndarray:
    """Pairs of numbers in [0, 1), shape (count, 2)."""
    return np.minimum(np.random.default_rng(seed).random((count, 2)).astype(real), np.nextafter(real(1), real(0)))
