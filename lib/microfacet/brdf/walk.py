"""The walk within Smith's model, its statements and kernels: light moves between facets of independent heights and normals.

A ray at a height meets facets at the rate that Smith's Lambda gives, of those that face it, and is mirrored by one of
them, until it leaves. The first bounce is the height-correlated BRDF; all of them lose nothing but what facets keep.
Heights are given by u, the fraction of the surface that lies lower, so that their distribution drops out. heitz2016.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import expm1, log1p
from typing import Any, NamedTuple

import sympy as sp

from microfacet.brdf.reflectance import BRDFParameters, D_h, added, divided, mu
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Pair, Vector
from microfacet.geometry import ggx
from microfacet.geometry.facets import ggx_facet
from microfacet.geometry.ggx import GGX
from microfacet.statements import enclosures
from microfacet.statements.notation import F, Lambda_i, Lambda_o, a, chi, om, printed_symbol, u, v
from microfacet.statements.statement import Equation
from microfacet.streams import drawn, stream
from microfacet.visibility import shadowing
from microfacet.visibility.smith import G1 as smith_masking
from microfacet.visibility.smith import survival

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
        within=(64, 64),
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
