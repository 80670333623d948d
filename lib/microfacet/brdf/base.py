"""What every BRDF gives, so that a renderer, a test or a figure can take any of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.directions import as_vectors
from microfacet.model import Model


class BRDF(Model, ABC):
    """A BRDF with a sampler of light directions.

    A subclass gives `evaluate`, `sample`, `pdf` and `albedo_with_error`; `weight` and `albedo` follow. Directions are unit
    vectors (..., 3) that point away from the surface, z up; shapes broadcast, and results have the shape without the last axis.
    These hold for every BRDF: `evaluate` and `pdf` are 0 below the horizon and, above it, 0 in the same places; `pdf` is the
    density of `sample`; the mean of `weight` over samples is `albedo`.
    Results of a BRDF that is a mean over random walks are estimates from a fixed seed, the same at each call; its methods
    `evaluate_with_error`, `pdf_with_error` and `albedo_with_error` tell how far they may be off.
    """

    @abstractmethod
    def evaluate(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """The BRDF, 1/sr, shapes (..., 3) -> (...); 0 if either direction is below the horizon."""

    @abstractmethod
    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        """Light directions with density `pdf`, shapes (..., 3) and (..., 2) -> (..., 3), for u in [0, 1).

        Some may go below the horizon, where the BRDF is 0: they count as lost. The zero vector where wo is below it.
        """

    @abstractmethod
    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """Density of `sample`, 1/sr, shapes (..., 3) -> (...)."""

    @abstractmethod
    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """The albedo, and a bound of its error, shapes (..., 3) -> (...), (...)."""

    def weight(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """What a sample weighs: the BRDF times cos theta_i over `pdf`, shapes (..., 3) -> (...); 0 where that is 0."""
        wo, wi = as_vectors("wo", wo), as_vectors("wi", wi)
        value, density = self.evaluate(wo, wi) * np.maximum(wi[..., 2], 0), self.pdf(wo, wi)
        return np.divide(value, density, out=np.zeros_like(value), where=density > 0)[()]

    def albedo(self, wo: ArrayLike) -> NDArray[Any]:
        """Share of light from wo that is reflected, shapes (..., 3) -> (...); 0 below the horizon."""
        return self.albedo_with_error(wo)[0]
