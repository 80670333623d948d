"""The surface that the report's diagrams share, and percentages rounded to a sum of 100."""

from __future__ import annotations

import numpy as np
from microfacet.surface.profile import Profile
from numpy.typing import ArrayLike, NDArray

Integers = NDArray[np.int64]


def example(facets: int = 12) -> Profile:
    """The profile that the figures of the report share: one curve, cut into as many facets as a figure needs."""
    return Profile.gaussian(alpha=1.0, facets=facets, waves=5, seed=3312, jitter=0.6)


def percentages(fractions: ArrayLike, total: int = 100) -> Integers:
    """Whole numbers in proportion to ``fractions`` that add up to exactly ``total`` (largest remainders go up)."""
    fractions = np.asarray(fractions, dtype=float)
    if fractions.ndim != 1 or not np.all(np.isfinite(fractions)) or np.any(fractions < 0) or fractions.sum() <= 0:
        raise ValueError(f"fractions must be a row of finite numbers >= 0 with a positive sum, got {fractions!r}")
    exact = total * fractions / fractions.sum()
    whole: Integers = np.floor(exact + 1e-9).astype(np.int64)
    order = np.argsort(whole - exact, kind="stable")
    whole[order[: total - whole.sum()]] += 1
    return whole
