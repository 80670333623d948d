"""The BRDF of mirror-like microfacets, for light that bounces once."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.albedo import Reflected, reflected_fraction
from microfacet.brdf.base import BRDF
from microfacet.brdf.reflectance import (
    BRDFParameters,
    LobeParameters,
    evaluation,
    joined_evaluation,
    normals_mirror,
    normals_pdf,
    normals_weight,
    visible_mirror,
    visible_pdf,
    visible_weight,
)
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Parameters
from microfacet.directions import as_vectors, uniform, vectors
from microfacet.geometry.slopes import drawn_from, excess_over_drawn
from microfacet.material.fresnel import Fresnel, Mirror
from microfacet.parameters import Parametric, together
from microfacet.visibility.masking import Masking
from microfacet.visibility.smith import Smith


class Microfacet(Parametric, BRDF):
    r"""BRDF of mirror-like microfacets, for light that bounces once.

    .. math:: \rho(\omega_o, \omega_i) = \frac{F(\omega_o, \omega_h) \, G_2(\omega_o, \omega_i, \omega_h) \, D(\omega_h)}
              {4 \cos\theta_o \cos\theta_i}

    with the half vector :math:`\omega_h`; statement ``brdf.microfacet.rho``. Parameters that are arrays broadcast with the
    directions: a roughness per pixel or, with directions (..., 1, 3), an index per colour channel.

    Parameters
    ----------
    model : Masking
        Model of masking and shadowing, with its distribution of normals.
    fresnel : Fresnel, optional
        Reflectance of a microfacet; by default 1.

    Raises
    ------
    ValueError
        If an argument is of another kind, or if the shapes of their parameters do not broadcast.

    References
    ----------
    cook1982; walter2007; heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
    >>> print(f"{brdf.evaluate([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
    3.8459
    """

    parameters: BRDFParameters

    def __init__(self, model: Masking, fresnel: Fresnel | None = None) -> None:
        if not isinstance(model, Masking):
            raise ValueError(f"model must be a model of masking such as Smith(GGX(0.3)), got {model!r}")
        if not (fresnel is None or isinstance(fresnel, Fresnel)):
            raise ValueError(f"fresnel must be None, Dielectric, Conductor or Schlick, got {fresnel!r}")
        self.model, self.fresnel = together(model=model, fresnel=Mirror() if fresnel is None else fresnel)
        self.parameters = BRDFParameters(*model.parameters, self.fresnel.parameters)

    @cached_property
    def evaluation(self) -> tuple[Batch, Parameters]:
        """The loop of `evaluate`, in one fraction where the distribution has it, else part by part; and its parameters."""
        model, F = self.model, type(self.fresnel).kernel
        joined = model.ndf.smith_lobe if isinstance(model, Smith) and model.correlation == "height" else None
        if joined is None:
            return evaluation(type(model.ndf).kernel, model.Lambda_kernel, model.G2_kernel, F), self.parameters
        lobe, parameters = joined
        return joined_evaluation(lobe, F), LobeParameters(parameters, self.fresnel.parameters)

    def evaluate(self, wo: ArrayLike, wi: ArrayLike, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Value of the BRDF, in 1/sr, without the cosine of the light.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        out : ndarray, optional
            Array of the result's shape and precision to fill and return; its contents are undefined after an error.

        Returns
        -------
        ndarray, shape (...)
            BRDF, 1/sr; 0 if either direction is below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if out does not fit.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(f"{brdf.evaluate([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        3.8459
        """
        batch, parameters = self.evaluation
        return batch([vectors("wo", wo), vectors("wi", wi)], parameters, out)

    def sample(self, wo: ArrayLike, u: ArrayLike, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Draw light directions with density `pdf`.

        By visible normals where the model can sample them, otherwise by all normals. Some directions are below the
        horizon, where the BRDF is 0: they are lost and must be kept in the mean. The reflectance plays no part.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        u : array_like, shape (..., 2)
            Uniform numbers in [0, 1); shapes broadcast.
        out : ndarray, optional
            Array of the result's shape and precision to fill and return; its contents are undefined after an error.

        Returns
        -------
        ndarray, shape (..., 3)
            Light directions, unit vectors; the zero vector where wo is below the horizon.

        Raises
        ------
        ValueError
            If neither model nor distribution has a sampler, if wo does not hold unit vectors, or if u is outside [0, 1).

        References
        ----------
        heitzdeon2014; dupuy2023.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(brdf.sample([0.6, 0.0, 0.8], [0.5, 0.25]).round(4))
        [-0.7848  0.      0.6197]
        """
        sampler, slopes = self.model.sampler, type(self.model.ndf).sample_kernel
        if sampler is None and slopes is None:
            raise ValueError(f"{self!r} has no sampler: the class of its distribution must name a sample_kernel")
        rule = normals_mirror(slopes) if sampler is None else visible_mirror(sampler)
        return rule([vectors("wo", wo), uniform("u", u)], self.model.parameters, out)

    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        r"""Density of the light directions that `sample` draws, over the whole sphere, in 1/sr.

        .. math:: p_{\omega_o}(\omega_i) = \frac{G_1(\omega_o, \omega_h) \, D(\omega_h)}{4 \cos\theta_o}

        where visible normals are sampled; statement ``material.reflection.density``. Above the horizon it is 0 where
        `evaluate` is and nowhere else, up to numbers too small for the precision and to F = 0.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Probability density, 1/sr; above 0 also for some directions below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        References
        ----------
        walter2007; heitzdeon2014.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(f"{brdf.pdf([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        3.2748
        """
        model, ndf = self.model, type(self.model.ndf)
        visible = model.sampler is not None
        rule = visible_pdf(ndf.kernel, model.Lambda_kernel, model.G1_kernel) if visible else normals_pdf(drawn_from(ndf))
        return rule([vectors("wo", wo), vectors("wi", wi)], model.parameters)

    def weight(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        r"""Weight of a sample: the BRDF times the cosine of the light over `pdf`.

        .. math:: \frac{\rho(\omega_o, \omega_i) \cos\theta_i}{p_{\omega_o}(\omega_i)}
                  = \frac{F(\omega_o, \omega_h) \, G_2(\omega_o, \omega_i, \omega_h)}{G_1(\omega_o, \omega_h)}

        where visible normals are sampled, which is in [0, 1]; statement ``brdf.microfacet.weight``. D has cancelled, so the
        weight is right also where BRDF and density are too large or too small for numbers.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Weight, dimensionless; 0 if either direction is below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        References
        ----------
        heitzdeon2014.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> wo = [0.6, 0.0, 0.8]
        >>> print(f"{brdf.weight(wo, brdf.sample(wo, [0.5, 0.25])):.4f}")
        0.9185
        """
        model, F = self.model, type(self.fresnel).kernel
        if model.sampler is None:
            rule = normals_weight(excess_over_drawn(type(model.ndf)), model.Lambda_kernel, model.G2_kernel, F)
        else:
            rule = visible_weight(model.Lambda_kernel, model.G1_kernel, model.G2_kernel, F)
        return rule([vectors("wo", wo), vectors("wi", wi)], self.parameters)

    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Directional albedo, and a bound of its error.

        By quadrature, some milliseconds for each set of parameters. The error is some 1e-9 of the albedo for
        isotropic mirrors, and larger where the integrand has kinks.

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
            If wo does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> value, error = brdf.albedo_with_error([0.6, 0.0, 0.8])
        >>> print(f"{value:.6f}", error < 1e-6)
        0.863457 True
        """
        return self._each_albedo(wo) if self.batch_shape else self.reflected(wo)

    def _each_albedo(self, wo: Any) -> tuple[np.ndarray, np.ndarray]:
        views = as_vectors("wo", wo)
        shape = np.broadcast_shapes(views.shape[:-1], self.batch_shape)
        values, errors = np.empty((2, *shape), views.dtype)
        views = np.broadcast_to(views, (*shape, 3))
        places, which = self.distinct()
        which = np.broadcast_to(which, shape).ravel()
        order = np.argsort(which, kind="stable")
        ends = np.searchsorted(which[order], np.arange(len(places) + 1))
        for place, chosen in zip(places, np.split(order, ends[1:-1]), strict=True):
            at = np.unravel_index(chosen, shape)
            values[at], errors[at] = self.at(*place).reflected(views[at])
        return values, errors

    @property
    def reflected(self) -> Reflected:
        """`albedo_with_error` as a function that is equal for equal models, of numbers for parameters."""
        self.require_numbers("an albedo by quadrature")
        return reflected_fraction(self.model, self.fresnel)

    def __repr__(self) -> str:
        return f"Microfacet({self.model!r}, {self.fresnel!r})"
