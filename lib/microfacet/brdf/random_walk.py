"""All bounces within Smith's model: light walks at random between facets whose heights and normals are independent.

A ray at a height meets facets at the rate that Smith's Lambda gives, of those that face it, and is mirrored by one of
them, until it leaves. The first bounce is the height-correlated BRDF; all of them lose nothing but what facets keep.
Heights are given by u, the fraction of the surface that lies lower, so that their distribution drops out. heitz2016.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import expm1, log1p
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.base import BRDF
from microfacet.brdf.later_bounces import SecondFacets
from microfacet.brdf.specular import BRDFParameters, D_h, Microfacet, added, divided, mu
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Count, Pair, Vector
from microfacet.confidence import Estimate, mean_bound
from microfacet.directions import as_uniform, as_vectors, whole
from microfacet.geometry import ggx
from microfacet.geometry.facets import ggx_facet
from microfacet.geometry.ggx import GGX
from microfacet.material.fresnel import Fresnel, Mirror
from microfacet.statements import enclosures
from microfacet.statements.notation import F, Lambda_i, Lambda_o, a, chi, om, printed_symbol, u, v
from microfacet.statements.statement import Equation
from microfacet.streams import drawn, stream
from microfacet.visibility import shadowing
from microfacet.visibility.smith import G1 as smith_masking
from microfacet.visibility.smith import Smith, survival

# --- statements ---------------------------------------------------------------------------------------------------

reached = printed_symbol("u_reached", r"u'", positive=True)
chance = printed_symbol("xi", r"\xi", positive=True)
visible_area = printed_symbol(
    "A_shown", r"A^{\pm}", positive=True
)  # projected area of the facets turned to a ray, from above or below
LAMBDAS = [(0.0, 0.0), (0.25, 0.5), (1.0, 30.0)]  # of the view and of the light
HEIGHT_POINTS = [(0.5, 0.25, 0.3), (1.0, 1e-3, 0.0), (0.1, 0.09, 40.0)]  # u, u', Lambda


def _free_steps(it: Equation, passed: Equation) -> list[Any]:
    """A chance of passing that is drawn evenly is the one of getting as far as stated."""
    return [sp.expand_log(sp.log(passed.equals.doit().subs(reached, it.equals.doit())) - sp.log(chance), force=True)]


def _first_steps(it: Equation) -> list[Any]:
    """The density of heights is what is lost on the way down from the top; and the quotient of both functions of Smith."""
    density = sp.diff(down.equals.doit().subs(u, 1), reached).subs(reached, u)
    (whole,) = it.means.atoms(sp.Integral)
    quotient = shadowing.height.equals.doit() / smith_masking.equals.doit().subs(chi(om), 1)
    return [sp.simplify(density * u**Lambda_i - whole.function.doit()), it.means - it.equals, quotient - it.equals]


with sp.evaluate(False):
    down = Equation(
        key="brdf.walk.down",
        title="the chance that a ray on its way down passes from one height to another",
        symbol=printed_symbol("passes_down", r"s_{-}(u, u')"),
        means=sp.exp(-sp.Integral((1 + Lambda_o) / v, (v, reached, u))),
        equals=(reached / u) ** (1 + Lambda_o),
        over={u: (0.01, 1), reached: (0.01, 1), Lambda_o: (0, 10)},
        within=(32, 32),
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (u, reached, Lambda_o), HEIGHT_POINTS),
        slides=(73, 74, 75),
        cite="heitz2016",
        note="A ray down meets the facets turned up to it, one going up those turned away from its origin. "
        "The power multiplies its base's rounding by up to 11, and its exponent's by up to 51: hence more than 8 ulps.",
    )
    up = Equation(
        key="brdf.walk.up",
        title="the chance that a ray on its way up passes from one height to another",
        symbol=printed_symbol("passes_up", r"s_{+}(u, u')"),
        means=sp.exp(-sp.Integral(Lambda_o / v, (v, u, reached))),
        equals=(u / reached) ** Lambda_o,
        over={u: (0.01, 1), reached: (0.01, 1), Lambda_o: (0, 10)},
        within=(16, 16),
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (u, reached, Lambda_o), HEIGHT_POINTS),
        slides=(73, 74, 75),
        cite="heitz2016",
        note="At u' = 1 the ray has left, and this is the chance that the facet is seen. "
        "The power multiplies the rounding of its base by up to 10: hence more than 8 ulps.",
    )
    step_down = Equation(
        key="brdf.walk.step_down",
        title="the height at which a ray on its way down meets a facet, for a random number",
        symbol=reached,
        equals=u * chance ** (1 / (1 + Lambda_o)),
        over={u: (1e-6, 1), chance: (1e-6, 1), Lambda_o: (0, 1e4)},
        proof=lambda it: _free_steps(it, down),
        proved_by="sympy: the chance to get as far is the random number",
        slides=(73, 74, 75),
        cite="heitz2016",
    )
    step_up = Equation(
        key="brdf.walk.step_up",
        title="the same for a ray on its way up, which has left where this is 1 or more",
        symbol=reached,
        equals=u * chance ** (-1 / Lambda_o),
        over={u: (1e-6, 1), chance: (0.01, 1), Lambda_o: (0.5, 1e4)},
        proof=lambda it: _free_steps(it, up),
        proved_by="sympy: the chance to get as far is the random number",
        slides=(73, 74, 75),
        cite="heitz2016",
    )
    first = Equation(
        key="brdf.walk.first",
        title="of the light that was mirrored once, so much leaves",
        symbol=printed_symbol("leaves_first", r"\frac{G_2(\omega_o, \omega_i, \omega_m)}{G_1(\omega_o, \omega_m)}"),
        means=sp.Integral((1 + Lambda_o) * u**Lambda_o * u**Lambda_i, (u, 0, 1)),
        equals=(1 + Lambda_o) / (1 + Lambda_o + Lambda_i),
        over={Lambda_o: (0, 100), Lambda_i: (0, 100)},
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (Lambda_o, Lambda_i), LAMBDAS),
        proof=lambda it: _first_steps(it),
        proved_by="sympy: the density of heights on the way down, the chance to leave from there, their integral",
        slides=(73, 74, 75),
        cite="heitz2016",
    )
    phase = Equation(
        key="brdf.walk.phase",
        title="density of the directions into which a ray is mirrored",
        symbol=printed_symbol("p_mirrored", r"p_{\omega_o}(\omega_i)"),
        means=F * om * D_h / (4 * visible_area * om),
        equals=F * D_h / (4 * visible_area),
        over={F: (0.01, 1), D_h: (1e-6, 1e6), visible_area: (1e-8, 1), om: (1e-8, 1)},
        proved_by="sympy: the density of facets met, times what a solid angle of normals is per one of light",
        slides=(73, 74, 75),
        cite="heitz2016",
        note="For a ray from above A+ is all that it can see, for one from below, whose cosine is negative, A- is.",
    )
    cap = Equation(
        key="brdf.walk.cap",
        title="the same for GGX of alpha = 1 and a ray that comes from below: evenly over a cap",
        symbol=printed_symbol("p_cap", r"p_{\omega_o}(\omega_i)"),
        means=1 / (2 * sp.pi * mu * (-1 + sp.sqrt(1 + (1 - mu**2) / mu**2))),
        equals=1 / (2 * sp.pi * (1 - mu)),
        over={mu: (0.01, 0.9)},
        proof=lambda it: _cap_steps(it),
        proved_by="sympy: D = 1/pi and Lambda of GGX put in; the cap's area",
        slides=(73, 74, 75),
        cite="heitz2016; dupuy2023",
        note="mu is the cosine to the downward normal; light leaves into the cap whose cosines are above mu.",
    )


def _cap_steps(it: Equation) -> list[Any]:
    """Of perfect mirrors, D = 1/pi on the upper hemisphere; other roughnesses are this one stretched."""
    lam = ggx.Lambda.equals.doit().subs(a, mu / sp.sqrt(1 - mu**2))
    turned_away = phase.equals.doit().subs({F: 1, D_h: 1 / sp.pi, visible_area: mu * lam})
    area = sp.integrate(2 * sp.pi, (sp.Symbol("z"), mu, 1))
    return [
        sp.simplify(turned_away - it.equals.doit()),
        sp.simplify(it.means.doit() - it.equals.doit()),
        area * it.equals.doit() - 1,
    ]


# --- the walk -------------------------------------------------------------------------------------------------------------

STRIDE = 1024  # random numbers set aside for a bounce
LONGEST = 1000  # bounces after which a walk is given up; its light counts as under way
stated_down, stated_up, stated_phase, stated_survival = step_down.scalar, step_up.scalar, phase.scalar, survival.scalar


class WalkParameters(NamedTuple):
    """Those of the BRDF, and which walks are made: from the first on, and not the last."""

    ndf: Any
    model: Any
    fresnel: Any
    first: int
    last: int


Ended = tuple[float, float, float, float, float]  # a direction, a weight, and the number of bounces


def mirrored(w: Vector, wm: Vector) -> tuple[Vector, float]:
    """Where a ray along w goes from a facet that it meets, and the cosine between its origin and the facet's normal."""
    cosine = -(w[0] * wm[0] + w[1] * wm[1] + w[2] * wm[2])
    return (w[0] + 2.0 * cosine * wm[0], w[1] + 2.0 * cosine * wm[1], w[2] + 2.0 * cosine * wm[2]), cosine


def opposite(w: Vector) -> Vector:
    return -w[0], -w[1], -w[2]


@cache
def next_height(Lambda: Callable[..., float]) -> Callable[..., float]:
    """The height at which a ray from height u along w meets a facet; 1 or more if it leaves."""

    def height(u: float, w: Vector, chance: float, p: BRDFParameters) -> float:
        if not w[2] > 0.0:
            return stated_down(u, chance, Lambda(w, p))
        Lambda_w = Lambda(w, p)
        return stated_up(u, chance, Lambda_w) if Lambda_w > 0.0 else 2.0

    return height


@cache
def following(Lambda: Callable[..., float], facet: Callable[..., Any], fresnel: Callable[..., float]) -> Callable[..., Any]:
    """Where a walk ends that meets a facet at height u along w, with what weight, after how many bounces."""
    height = next_height(Lambda)

    def followed(w: Vector, u: float, start: Pair, p: BRDFParameters) -> Ended:
        key = stream(start[0], start[1], 0)
        weight = 1.0
        for bounce in range(LONGEST):
            at = STRIDE * bounce
            wm = facet(opposite(w), (drawn(key, at + 1), drawn(key, at + 2)), key, at + 3, p.ndf)
            w, cosine = mirrored(w, wm)
            weight *= fresnel(min(max(cosine, 0.0), 1.0), p.fresnel)
            u = height(u, w, drawn(key, at + STRIDE), p)
            if w[2] > 0.0 and not u < 1.0:
                return w[0], w[1], w[2], weight, bounce + 1.0
        return 0.0, 0.0, 0.0, weight, LONGEST * 1.0

    return followed


@cache
def walk(Lambda: Callable[..., float], facet: Callable[..., Any], fresnel: Callable[..., float]) -> Batch:
    """Where a walk from wo ends, with what weight, after how many bounces: (..., 3), (..., 2) -> (..., 5)."""
    height, followed = next_height(Lambda), following(Lambda, facet, fresnel)

    def walked(wo: Vector, start: Pair, p: BRDFParameters) -> Ended:
        if not wo[2] > 0.0:
            return 0.0, 0.0, 0.0, 0.0, 0.0
        u = height(1.0, opposite(wo), drawn(stream(start[0], start[1], 0), 0), p)
        return followed(opposite(wo), u, start, p)

    return Batch(walked, [3, 2], 5)


@cache
def onward(Lambda: Callable[..., float], facet: Callable[..., Any], fresnel: Callable[..., float]) -> Batch:
    """The same for a walk that meets a facet at a height along a direction: (..., 3), (...), (..., 2) -> (..., 5)."""
    return Batch(following(Lambda, facet, fresnel), [3, 1, 2], 5)


@cache
def steeper(D: Callable[..., float], Lambda: Callable[..., float]) -> Callable[..., tuple[Vector, float]]:
    """A facet that faces a direction above the horizon, steep ones more often, and how much less each of them counts.

    They are drawn as facets of GGX, of which more are steep than of any other distribution here.
    """
    ggx_D, ggx_Lambda = GGX.kernel, GGX.closed_Lambda

    def drawn_steep(w: Vector, u: Pair, p: BRDFParameters) -> tuple[Vector, float]:
        alpha = min(p.ndf.alpha_x, p.ndf.alpha_y)
        steep = alpha * alpha
        span = log1p(1.0 / steep)
        rest = steep * expm1(span * u[1])
        wm = ggx_facet(w, (u[0], max(1.0 - rest, 0.0)), 0, 0, p.ndf)
        often = ggx_D(wm, p.ndf) / (1.0 + ggx_Lambda(w, p.ndf))
        wanted = D(wm, p.ndf) / (1.0 + Lambda(w, p))
        return wm, (rest + steep) * span * (wanted / often if often > 0.0 else 0.0)

    return drawn_steep


@cache
def connecting(D: Callable[..., float], Lambda: Callable[..., float], fresnel: Callable[..., float]) -> Callable[..., float]:
    """What the facet that a ray along w meets at height u sends to wi, as a BRDF."""

    def sends(w: Vector, wi: Vector, u: float, Lambda_i: float, p: BRDFParameters) -> float:
        h, length = added(opposite(w), wi)
        if not h[2] > 0.0:
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        Lambda_w = Lambda(w, p)
        area = -w[2] * (1.0 + Lambda_w) if w[2] < 0.0 else w[2] * Lambda_w
        return stated_phase(fresnel(cosine, p.fresnel), D(wh, p.ndf), area, cosine) * stated_survival(Lambda_i, u) / wi[2]

    return sends


@cache
def going_on(
    D: Callable[..., float], Lambda: Callable[..., float], facet: Callable[..., Any], fresnel: Callable[..., float]
) -> Callable[..., float]:
    """The contribution to wi of all later facets of a walk from wo that continues after its first bounce.

    It is weighted by the probability to continue.
    """
    height, sends, first_facet = next_height(Lambda), connecting(D, Lambda, fresnel), steeper(D, Lambda)

    def later(wo: Vector, wi: Vector, u: float, Lambda_i: float, key: int, p: BRDFParameters) -> float:
        w, Lambda_o = opposite(wo), Lambda(wo, p)
        weight, several = 1.0, 0.0
        for bounce in range(LONGEST):
            at = STRIDE * bounce
            if bounce == 0:
                wm, weight = first_facet(wo, (drawn(key, 1), drawn(key, 2)), p)
            else:
                wm = facet(opposite(w), (drawn(key, at + 1), drawn(key, at + 2)), key, at + 3, p.ndf)
            w, cosine = mirrored(w, wm)
            weight *= fresnel(min(max(cosine, 0.0), 1.0), p.fresnel)
            chance = drawn(key, at + STRIDE)
            if bounce == 0 and w[2] > 0.0:
                Lambda_w = Lambda(w, p)
                weight *= 1.0 / (1.0 + (1.0 + Lambda_o) / Lambda_w) if Lambda_w > 0.0 else 0.0
                u = chance ** (1.0 / (1.0 + Lambda_o))
            else:
                u = height(u, w, chance, p)
            if (w[2] > 0.0 and not u < 1.0) or not weight > 0.0:
                return several
            several += weight * sends(w, wi, u, Lambda_i, p)
        return several

    return later


@cache
def connections(
    D: Callable[..., float], Lambda: Callable[..., float], facet: Callable[..., Any], fresnel: Callable[..., float]
) -> Batch:
    """What walks from wo send to wi from each facet they meet, as a BRDF: (..., 3), (..., 3), (..., 2) -> (..., 5).

    Sums over the walks of the first bounce and of all later ones, of the squares of these, and the most that one walk sends
    later.
    """
    height, sends, later = next_height(Lambda), connecting(D, Lambda, fresnel), going_on(D, Lambda, facet, fresnel)

    def sent(wo: Vector, wi: Vector, start: Pair, p: WalkParameters) -> tuple[float, float, float, float, float]:
        once, often, once_squared, often_squared, most = 0.0, 0.0, 0.0, 0.0, 0.0
        if not (wo[2] > 0.0 and wi[2] > 0.0):
            return once, often, once_squared, often_squared, most
        Lambda_i = Lambda(wi, p)
        for number in range(p.first, p.last):
            key = stream(start[0], start[1], number)
            u = height(1.0, opposite(wo), drawn(key, 0), p)
            single = sends(opposite(wo), wi, u, Lambda_i, p)
            several = later(wo, wi, u, Lambda_i, key, p)
            once += single
            often += several
            once_squared += single * single
            often_squared += several * several
            most = max(most, several)
        return once, often, once_squared, often_squared, most

    return Batch(sent, [3, 3, 2], 5)


# --- the model --------------------------------------------------------------------------------------------------------

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
