"""Light directions by their cosine alone: with a density that is tabulated over it, for BRDFs without a lobe to sample."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.directions import as_uniform, as_vectors

LOWEST = 5.3  # of sqrt(-ln cos theta): light below counts less than 1e-24


class CosineTable:
    """Directions whose density is cos theta_i/pi times a factor that is constant in each of some intervals of the cosine.

    The intervals are even in sqrt(-ln cos theta), which resolves cosines of any size: near the horizon too, where the last
    one ends. factors: of each interval, in proportion, above 0; by default one interval, with the density cos theta_i/pi.
    """

    def __init__(self, factors: ArrayLike = (1.0,)) -> None:
        given = np.asarray(factors, np.float64)
        self.squares = np.append(np.exp(-2 * starts(len(given)) ** 2), 0.0)  # of the cosines where intervals begin and end
        fractions = -np.diff(self.squares) * given
        self.factors, self.ends = given / fractions.sum(), np.cumsum(fractions) / fractions.sum()

    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        """Directions above the horizon, (..., 3) for u (..., 2) in [0, 1); the zero vector where wo is below the horizon."""
        wo, u = as_vectors("wo", wo), as_uniform("u", u)
        first, azimuth = u[..., 0].astype(np.float64), 2 * np.pi * u[..., 1].astype(np.float64)
        at = np.minimum(np.searchsorted(self.ends, first, side="right"), len(self.ends) - 1)
        left = self.ends[at] - first  # of the interval's fraction, which ends at the lower cosine
        square = np.minimum(self.squares[at + 1] + np.maximum(left, TINY) / self.factors[at], self.squares[at])
        radius = np.sqrt((1 - square).clip(0))
        wi = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(square)], axis=-1)
        return np.where(wo[..., 2:] > 0, wi, 0.0).astype(np.result_type(wo, u))

    def factor(self, wi: ArrayLike) -> NDArray[Any]:
        """The density over cos theta_i/pi, (..., 3) -> (...), of directions above the horizon."""
        cosine = np.asarray(wi, np.float64)[..., 2].clip(TINY, 1)
        at = np.sqrt(-np.log(cosine)) * ((len(self.factors) - 1) / LOWEST)
        return np.asarray(self.factors[np.minimum(at.astype(np.int64), len(self.factors) - 1)])

    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """Density of `sample`, 1/sr; 0 if either direction is below the horizon."""
        wo, wi = as_vectors("wo", wo), as_vectors("wi", wi)
        above = (wo[..., 2] > 0) & (wi[..., 2] > 0)
        return np.where(above, wi[..., 2] / np.pi * self.factor(wi), 0.0).astype(np.result_type(wo, wi))[()]


TINY = float(np.finfo(np.float64).tiny)


def starts(count: int) -> NDArray[Any]:
    """Values of sqrt(-ln cos theta) at which `count` intervals begin."""
    return np.linspace(0, LOWEST, count) if count > 1 else np.zeros(1)
