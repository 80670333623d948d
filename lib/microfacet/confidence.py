"""How far a mean of independent draws may be from what it estimates, given what was drawn.

A standard error is no bound. It is small where what matters was hardly ever drawn, and from few parts it is itself a guess.
The bounds here hold but for odds of `ODDS` each: of many independent draws, because no draw is larger than some number
(audibert2009); of few parts, each a mean itself, because they scatter evenly (Student's t).
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np

ODDS = 1e-5
_LOG = math.log(3 / ODDS)
RARE = 3 * _LOG  # draws that may have been missed altogether


class Estimate(NamedTuple):
    """A mean over random walks or random surfaces and its error: a bound, or where that is said its standard error."""

    value: Any
    error: Any


@cache
def student(parts: int) -> float:
    """How many standard errors a mean of so many parts, at least 2, is off at most."""
    from scipy.special import stdtrit

    return float(-stdtrit(parts - 1, ODDS / 2))


def mean_bound(variance: Any, largest: Any, count: Any) -> Any:
    """How far the mean of so many draws of this variance is off at most, if all lie between 0 and `largest`. audibert2009."""
    return np.sqrt(2 * _LOG * variance / count) + RARE * largest / count
