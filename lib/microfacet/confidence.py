"""Bounds of the error of a mean of independent draws, from the draws themselves.

A standard error is not a bound. It is small if rare large values were not drawn, and from few batches it is itself a rough
estimate. Each bound here fails with probability `ODDS` at most: for many independent draws, because no draw exceeds some number
(audibert2009); for few batches, each a mean itself, because these are normally distributed (Student's t).
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np

ODDS = 1e-5
_LOG = math.log(3 / ODDS)
RARE = 3 * _LOG  # number of draws that may have been missed altogether


class Estimate(NamedTuple):
    """A mean over random walks or random surfaces and its error: a bound, or where that is said its standard error."""

    value: Any
    error: Any


@cache
def student(parts: int) -> float:
    """Bound of the error of a mean of at least 2 batches, in standard errors."""
    from scipy.special import stdtrit

    return float(-stdtrit(parts - 1, ODDS / 2))


def mean_bound(variance: Any, largest: Any, count: Any) -> Any:
    """Bound of the error of a mean of `count` draws with this variance, all between 0 and `largest`. audibert2009."""
    return np.sqrt(2 * _LOG * variance / count) + RARE * largest / count
