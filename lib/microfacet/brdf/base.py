"""What every BRDF gives, so that a renderer, a test or a figure can take any of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.directions import as_vectors
from microfacet.model import Model


class BRDF(Model, ABC):
    """Base class of the BRDFs, each with a sampler of light directions.

    A subclass gives `evaluate`, `sample`, `pdf` and `albedo_with_error`; `weight` and `albedo` follow. For every BRDF
    `evaluate` is 0 below the horizon, and above it 0 where `pdf` is; `pdf` is the density of `sample`; and the mean of
    `weight` over samples is `albedo`. A BRDF that is a mean over random walks gives estimates from a fixed seed, the same at
    each call, and bounds of their errors by methods whose names end in ``with_error``.

    References
    ----------
    heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> model = mf.Smith(mf.GGX(0.5))
    >>> brdfs = [mf.Microfacet(model), mf.Compensated(mf.Microfacet(model)), mf.Diffuse(model)]
    >>> for brdf in brdfs:
    ...     print(isinstance(brdf, mf.BRDF), f"{brdf.albedo([0.6, 0.0, 0.8]):.4f}")
    True 0.6820
    True 1.0000
    True 0.7720
    """

    @abstractmethod
    def evaluate(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """Value of the BRDF, in 1/sr, without the cosine of the light.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            BRDF, 1/sr; 0 if either direction is below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(f"{brdf.evaluate([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        3.8459
        """

    @abstractmethod
    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        """Draw light directions with density `pdf`.

        Some may be below the horizon, where the BRDF is 0: they are lost and must be kept in the mean.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        u : array_like, shape (..., 2)
            Uniform numbers in [0, 1); shapes broadcast.

        Returns
        -------
        ndarray, shape (..., 3)
            Light directions, unit vectors; the zero vector where wo is below the horizon.

        Raises
        ------
        ValueError
            If wo does not hold unit vectors, or if u is outside [0, 1).

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(brdf.sample([0.6, 0.0, 0.8], [0.5, 0.25]).round(4))
        [-0.7848  0.      0.6197]
        """

    @abstractmethod
    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """Density of the light directions that `sample` draws, in 1/sr.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Probability density, 1/sr.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(f"{brdf.pdf([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        3.2748
        """

    @abstractmethod
    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Directional albedo, and a bound of its error.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Directions, unit vectors.

        Returns
        -------
        value : ndarray, shape (...)
            Albedo; 0 below the horizon.
        error : ndarray, shape (...)
            Bound of its error, absolute.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> value, error = brdf.albedo_with_error([0.6, 0.0, 0.8])
        >>> print(f"{value:.6f}", error < 1e-6)
        0.863457 True
        """

    def weight(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        """Weight of a sample: the BRDF times the cosine of the light over `pdf`.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Weight, dimensionless; 0 where the density is.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Diffuse(mf.Smith(mf.GGX(0.5)))
        >>> print(f"{brdf.weight([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        0.6795
        """
        wo, wi = as_vectors("wo", wo), as_vectors("wi", wi)
        value, density = self.evaluate(wo, wi) * np.maximum(wi[..., 2], 0), self.pdf(wo, wi)
        return np.divide(value, density, out=np.zeros_like(value), where=density > 0)[()]

    def albedo(self, wo: ArrayLike) -> NDArray[Any]:
        r"""Directional albedo: the fraction of the light from wo that is reflected.

        .. math:: E(\omega_o) = \int_{\Omega} \rho(\omega_o, \omega_i) \cos\theta_i \, d\omega_i

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Directions, unit vectors.

        Returns
        -------
        ndarray, shape (...)
            Fraction in [0, 1] for a physical model; 0 below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(f"{brdf.albedo([0.6, 0.0, 0.8]):.6f}")
        0.863457
        """
        return self.albedo_with_error(wo)[0]
