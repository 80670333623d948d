"""The BRDF of light that bounces on the microsurface any number of times."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.base import BRDF
from microfacet.brdf.later_bounces import SecondFacets
from microfacet.brdf.microfacet import Microfacet
from microfacet.brdf.walk import LONGEST, WalkParameters, connections, onward, walk
from microfacet.compiler.kernels import Count
from microfacet.confidence import Estimate, mean_bound
from microfacet.directions import as_uniform, as_vectors, whole
from microfacet.material.fresnel import Fresnel, Mirror
from microfacet.visibility.smith import Smith

AT_ONCE = 1 << 17  # walks held in memory
IN_A_ROW = 4096  # walks from one view to one light that are not interrupted: some hundredths of a second


class Walks(NamedTuple):
    """Where light leaves (..., 3), what it weighs (...), the product of all reflectances, and after how many bounces (...)."""

    wi: Any
    weight: Any
    bounces: Any


class Bounces(NamedTuple):
    """Shares of the light by the number of bounces: (..., n) for 1 to n of them, with standard errors.

    more, more_error: what leaves later (...). under_way: what had not left after `LONGEST` bounces (...).
    """

    value: Any
    error: Any
    more: Any
    more_error: Any
    under_way: Any


class Later(NamedTuple):
    """Walks that went on after the first bounce: where they left (n, 3), 0 if they are still under way; what was left of their
    light (n,); their bounces (n,); and their weights (n,), whose mean is the fraction of all walks that continue."""

    wi: Any
    weight: Any
    bounces: Any
    counts: Any

    def light(self, lossless: bool) -> tuple[float, float, float]:
        """The fraction of their light that left, a bound of its error, and the fraction that is still under way.

        lossless: whether facets absorb nothing, so that all light that is not under way has left. Else it is a quotient of two
        means, and its error that of what each walk adds to it.
        """
        total = self.counts.sum()
        if not total > 0:
            return 0.0, 1.0, 0.0
        left = self.wi[:, 2] > 0
        gone, under_way = (float((self.counts * self.weight)[which].sum() / total) for which in (left, ~left))
        if lossless:
            return gone, 0.0, under_way
        counts = len(left) * self.counts / total
        each = counts * (np.where(left, self.weight, 0.0) - gone)
        return gone, float(mean_bound(np.mean(each**2), counts.max(), len(left))), under_way


class RandomWalk(BRDF):
    r"""BRDF of mirror-like microfacets for light that bounces any number of times, by random walks.

    Exact for Smith's height-correlated model: the heights and normals that light meets do not depend on each other. Results
    are means over random walks; they depend on the seed, not on the number of threads. What a microfacet does not reflect is
    lost.

    Parameters
    ----------
    model : Smith
        Height-correlated model over GGX or Beckmann, with numbers for parameters.
    fresnel : Fresnel, optional
        Reflectance of a microfacet; by default 1.

    Raises
    ------
    ValueError
        For another model.

    References
    ----------
    heitz2016.

    Examples
    --------
    >>> import microfacet as mf
    >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
    >>> value, error = brdf.albedo_with_error([0.6, 0.0, 0.8], walks=1024)
    >>> bool(abs(value - 1) <= error)  # no light is lost
    True
    """

    def __init__(self, model: Smith, fresnel: Fresnel | None = None) -> None:
        facet = getattr(type(getattr(model, "ndf", None)), "facet_kernel", None)
        if not isinstance(model, Smith) or model.correlation != "height" or facet is None:
            raise ValueError(f"model must be Smith(GGX(...)) or Smith(Beckmann(...)), height-correlated, got {model!r}")
        self.single = Microfacet(model, fresnel)
        self.single.require_numbers("RandomWalk")
        self.model, self.fresnel = model, self.single.fresnel
        self.parameters = self.single.parameters
        self._kernels = (model.Lambda_kernel, facet, type(self.fresnel).kernel)

    def walk(self, wo: ArrayLike, u: ArrayLike) -> Walks:
        """Walk light from wo until it leaves the surface.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        u : array_like, shape (..., 2)
            Uniform numbers in [0, 1); each pair names a walk. Shapes broadcast.

        Returns
        -------
        wi : ndarray, shape (..., 3)
            Directions in which light leaves; the zero vector where wo is below the horizon, or where light has not left.
        weight : ndarray, shape (...)
            Product of all reflectances; 0 where wi is the zero vector.
        bounces : ndarray of int, shape (...)
            Number of bounces.

        Raises
        ------
        ValueError
            If wo does not hold unit vectors, or if u is outside [0, 1).

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> wi, weight, bounces = brdf.walk([0.6, 0.0, 0.8], [0.5, 0.25])
        >>> print(weight, bounces >= 1)
        1.0 True
        """
        wo, u = as_vectors("wo", wo), as_uniform("u", u)
        walked = self._walked(wo, u)
        left = walked[..., 2] > 0
        real = np.float32 if wo.dtype == u.dtype == np.float32 else np.float64
        wi, weight = np.where(left[..., None], walked[..., :3], 0.0), np.where(left, walked[..., 3], 0.0)
        return Walks(wi.astype(real), weight.astype(real), walked[..., 4].astype(np.int64))

    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        return self.walk(wo, u).wi

    def evaluate(self, wo: ArrayLike, wi: ArrayLike, walks: int = 256, seed: int = 0) -> NDArray[Any]:
        """Value of the BRDF, in 1/sr, without the cosine of the light; an estimate.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        ndarray, shape (...)
            BRDF, 1/sr, as `evaluate_with_error` has it; 0 if either direction is below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> once = mf.Microfacet(brdf.model).evaluate([0.6, 0.0, 0.8], [0, 0, 1])
        >>> bool(brdf.evaluate([0.6, 0.0, 0.8], [0, 0, 1]) > once)
        True
        """
        return self.evaluate_with_error(wo, wi, walks, seed).value

    def evaluate_with_error(self, wo: ArrayLike, wi: ArrayLike, walks: int = 256, seed: int = 0) -> Estimate:
        """Value of the BRDF, in 1/sr, and a bound of its error.

        The first bounce is exact, later ones are a mean over walks from wo.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        value : ndarray, shape (...)
            BRDF, 1/sr; 0 if either direction is below the horizon.
        error : ndarray, shape (...)
            Bound of its error, absolute, that fails with odds of 1e-5 if no walk sends much more to wi than the one that
            sends most did: five standard errors and 38 times the part of this walk in the mean.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> value, error = brdf.evaluate_with_error([0.6, 0.0, 0.8], [0, 0, 1])
        >>> bool(0 < error < value)
        True
        """
        once = self.single.evaluate(wo, wi)
        sums, count = self._connected(wo, wi, walks, seed), whole("walks", walks, 2)
        error = mean_bound(_scatter(sums, count)[..., 1] ** 2 * count, sums[..., 4], count)
        return Estimate(once + sums[..., 1].astype(once.dtype), error.astype(once.dtype))

    def pdf(self, wo: ArrayLike, wi: ArrayLike, walks: int = 256, seed: int = 0) -> NDArray[Any]:
        """Density of the light directions that `sample` draws, in 1/sr; an estimate.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        ndarray, shape (...)
            Probability density, 1/sr, as `pdf_with_error` has it.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> bool(brdf.pdf([0.6, 0.0, 0.8], [0, 0, 1]) > 0)
        True
        """
        return self.pdf_with_error(wo, wi, walks, seed).value

    def pdf_with_error(self, wo: ArrayLike, wi: ArrayLike, walks: int = 256, seed: int = 0) -> Estimate:
        """Density of the light directions that `sample` draws, in 1/sr, and a bound of its error.

        It is the BRDF of F = 1 times the cosine of the light.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        value : ndarray, shape (...)
            Probability density, 1/sr.
        error : ndarray, shape (...)
            Bound of its error, absolute, as that of `evaluate_with_error`.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> density, error = brdf.pdf_with_error([0.6, 0.0, 0.8], [0, 0, 1])
        >>> bool(0 < error < density)
        True
        """
        mirrors = self if isinstance(self.fresnel, Mirror) else RandomWalk(self.model)
        estimate, cosine = mirrors.evaluate_with_error(wo, wi, walks, seed), np.maximum(as_vectors("wi", wi)[..., 2], 0)
        return Estimate(estimate.value * cosine, estimate.error * cosine)

    def connections(self, wo: ArrayLike, wi: ArrayLike, walks: int = 256, seed: int = 0) -> tuple[Estimate, Estimate]:
        """First bounce and later ones apart, both as means over walks.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        first : Estimate
            BRDF of the first bounce, 1/sr, and its standard error, which is too small where hardly any walk sends light to wi.
        later : Estimate
            The same of all later bounces.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> first, later = brdf.connections([0.6, 0.0, 0.8], [0, 0, 1])
        >>> bool(first.value > later.value)
        False
        """
        sums = self._connected(wo, wi, walks, seed)
        error = _scatter(sums, whole("walks", walks, 2))
        return Estimate(sums[..., 0], error[..., 0]), Estimate(sums[..., 1], error[..., 1])

    def _connected(self, wo: Any, wi: Any, walks: int, seed: int) -> Any:
        wo, wi, count = as_vectors("wo", wo), as_vectors("wi", wi), whole("walks", walks, 2)
        shape = np.broadcast_shapes(wo.shape[:-1], wi.shape[:-1])
        u = np.random.default_rng(whole("seed", seed, 0)).random((*shape, 2))
        rule = connections(type(self.model.ndf).kernel, *self._kernels)
        arrays, sums = [wo.astype(float), wi.astype(float), u], np.zeros((*shape, 5))
        for start in range(0, count, IN_A_ROW):
            walks_made = Count(start), Count(min(start + IN_A_ROW, count))
            part = rule(arrays, WalkParameters(*self.parameters, *walks_made))
            sums[..., :4] += part[..., :4]
            sums[..., 4] = np.maximum(sums[..., 4], part[..., 4])
        return sums / [count, count, count, count, 1]

    def albedo(self, wo: ArrayLike, walks: int = 65536, seed: int = 0) -> NDArray[Any]:
        """Directional albedo: the fraction of the light from wo that is reflected; an estimate.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Directions, unit vectors.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        ndarray, shape (...)
            Fraction, as `albedo_with_error` has it; 0 below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> bool(brdf.albedo([0.6, 0.0, 0.8], walks=256) > mf.Microfacet(brdf.model).albedo([0.6, 0.0, 0.8]))
        True
        """
        return self.albedo_with_error(wo, walks, seed).value

    def albedo_with_error(self, wo: ArrayLike, walks: int = 65536, seed: int = 0) -> Estimate:
        """Directional albedo, and a bound of its error.

        The first bounce is by quadrature, later ones by walks that all continue after it.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Directions, unit vectors.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        value : ndarray, shape (...)
            Albedo; 0 below the horizon.
        error : ndarray, shape (...)
            Bound of its error, absolute, that fails with odds of 1e-5. Light still under way when a walk is given up is not
            in the value but in the error.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> value, error = brdf.albedo_with_error([0.6, 0.0, 0.8], walks=256)
        >>> bool(abs(value - 1) <= error)
        True
        """
        wo, count, seed = as_vectors("wo", wo).astype(float), whole("walks", walks, 2), whole("seed", seed, 0)
        once, error = self.single.albedo_with_error(wo)
        on, on_error = self.going_on(wo)
        later_light, lossless = np.zeros((3, *wo.shape[:-1])), isinstance(self.fresnel, Mirror)
        for at in np.ndindex(wo.shape[:-1]):
            if wo[(*at, 2)] > 0:
                later_light[(slice(None), *at)] = self.later(wo[at], count, seed).light(lossless)
        return Estimate(once + on * later_light[0], error + on_error + on * np.minimum(later_light[1] + later_light[2], 1))

    def going_on(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Fraction of the walks that meet a second microfacet, and a bound of its error.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Directions, unit vectors.

        Returns
        -------
        value : ndarray, shape (...)
            Fraction in [0, 1]; 0 below the horizon.
        error : ndarray, shape (...)
            Bound of its error, absolute.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> print(f"{brdf.going_on([0.6, 0.0, 0.8])[0]:.4f}")
        0.5397
        """
        once, error = Microfacet(self.model).albedo_with_error(wo)
        return np.where(as_vectors("wo", wo)[..., 2] > 0, np.clip(1 - once, 0, 1), 0.0), error

    def later(self, wo: ArrayLike, walks: int, seed: Any = 0) -> Later:
        """Walk light that meets a second microfacet, from one view.

        Parameters
        ----------
        wo : array_like, shape (3,)
            View direction above the horizon, a unit vector.
        walks : int
            Number of random walks, at least 1.
        seed : int, optional
            Seed of their random numbers, from 0.

        Returns
        -------
        Later
            Where light left, its weight, its bounces, and how much each walk counts.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> bool((brdf.later([0.6, 0.0, 0.8], 16).bounces >= 2).all())
        True
        """
        rng = np.random.default_rng(seed)
        start = SecondFacets(self.model, as_vectors("wo", wo).astype(float)).draw(whole("walks", walks, 1), rng)
        walked = onward(*self._kernels)([start.direction, start.height, rng.random((walks, 2))], self.parameters)
        return Later(
            walked[:, :3], self.fresnel.F(start.cosine) * walked[:, 3], walked[:, 4].astype(np.int64) + 1, start.weight
        )

    def albedo_by_bounce(self, wo: ArrayLike, walks: int = 65536, seed: int = 0, orders: int = 6) -> Bounces:
        """Fractions of the light that leaves after one bounce, two, and so on.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Directions, unit vectors.
        walks : int, optional
            Number of random walks, at least 2.
        seed : int, optional
            Seed of their random numbers, from 0.
        orders : int, optional
            Largest number of bounces that is counted apart, at least 1.

        Returns
        -------
        Bounces
            Fractions (..., orders) with standard errors, what leaves later, and what has not left.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if walks or seed is outside its range.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.RandomWalk(mf.Smith(mf.GGX(0.8)))
        >>> fractions = brdf.albedo_by_bounce([0.6, 0.0, 0.8], walks=1024).value
        >>> bool(fractions[0] > fractions[1] > fractions[2])
        True
        """
        left, later = self._sums(wo, walks, seed, whole("orders", orders, 1))
        value, error = _mean(*left, walks)
        mean, scatter = _mean(*later, walks)
        return Bounces(value, error, mean[..., 0], scatter[..., 0], mean[..., 1])

    def _sums(self, wo: Any, walks: int, seed: int, orders: int) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Sums over walks of weights and of their squares: by bounces up to `orders`; of more, and of what is under way."""
        wo, count, seed = as_vectors("wo", wo).astype(float), whole("walks", walks, 2), whole("seed", seed, 0)
        rows = wo.reshape(-1, 3)
        sums = np.zeros((2, len(rows), orders + 3))
        step = max(1, AT_ONCE // max(len(rows), 1))
        for block, start in enumerate(range(0, count, step)):
            u = np.random.default_rng([seed, block]).random((len(rows), min(step, count - start), 2))
            walked = self._walked(rows[:, None], u)
            order = np.minimum(walked[..., 4].astype(np.int64), orders + 1)
            order[walked[..., 4] >= LONGEST] = orders + 2
            for row in range(len(rows)):
                for power in (1, 2):
                    sums[power - 1, row] += np.bincount(order[row], walked[row, :, 3] ** power, orders + 3)
        by_order = sums.reshape(2, *wo.shape[:-1], orders + 3)
        one, two = slice(1, orders + 1), slice(orders + 1, orders + 3)
        return (by_order[0][..., one], by_order[1][..., one]), (by_order[0][..., two], by_order[1][..., two])

    def _walked(self, wo: Any, u: Any) -> Any:
        return walk(*self._kernels)([wo.astype(float), u.astype(float)], self.parameters)

    def __repr__(self) -> str:
        return f"RandomWalk({self.model!r}, {self.fresnel!r})"


def _scatter(means: Any, walks: int) -> Any:
    """Standard errors of the means over walks that `connections` gives, from those of squares, (..., 2)."""
    return np.sqrt(np.maximum(means[..., 2:4] - means[..., :2] ** 2, 0) / (walks - 1))


def _mean(total: Any, squares: Any, walks: int) -> tuple[Any, Any]:
    """The mean and its standard error, from sums over walks."""
    mean = total / walks
    return mean, np.sqrt(np.maximum(squares / walks - mean**2, 0) / (walks - 1))
