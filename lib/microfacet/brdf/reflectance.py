"""@"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import sqrt
from typing import Any, NamedTuple

import sympy as sp

from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import ByPrecision, Pair, Vector
from microfacet.geometry.visible_normals import HORIZON
from microfacet.material.reflection import half_vector, i_vector, o_vector, reflected, weak_furnace
from microfacet.statements import enclosures
from microfacet.statements.notation import G1, D, F, Lambda_i, Lambda_o, im, mu_i, mu_o, om, printed_symbol
from microfacet.statements.proofs import under_integral
from microfacet.statements.statement import Equation
from microfacet.visibility import shadowing, unphysical, v_cavity
from microfacet.visibility.masking import ModelParameters, dot, over_pairs

G1_h = printed_symbol("G1_h", r"G_1(\omega_o, \omega_h)", positive=True)
G2_h = printed_symbol("G2_h", r"G_2(\omega_o, \omega_i, \omega_h)", nonnegative=True)
D_h = printed_symbol("D_h", r"D(\omega_h)", nonnegative=True)
p_i = printed_symbol("p_light", r"p_{\omega_o}(\omega_i)", nonnegative=True)
rho_io = printed_symbol("rho_io", r"\rho(\omega_i, \omega_o)")
mu = sp.Symbol("mu", positive=True)
EDGE = sp.Rational(1, 10**15)  # of a cosine, below which an integrand is bounded in place of evaluated

# --- statements ---------------------------------------------------------------------------------------------------

with sp.evaluate(False):
    complete = Equation(
        key="brdf.microfacet.rho",
        title="the microfacet BRDF of Cook and Torrance",
        symbol=printed_symbol("rho", r"\rho(\omega_o, \omega_i)"),
        means=F * (G2_h / G1_h) * p_i / mu_i,
        equals=F * G2_h * D_h / (4 * mu_o * mu_i),
        where={p_i: G1_h * D_h / (4 * mu_o)},
        proved_by="sympy: the density of reflected directions put in",
        over={F: (0.01, 1), G2_h: (1e-6, 1), D_h: (1e-6, 1e6), mu_o: (1e-8, 1), mu_i: (1e-8, 1)},
        slides=(21, 22, 51, 52),
        cite="cook1982; walter2007",
    )
    weight = Equation(
        key="brdf.microfacet.weight",
        title="what a light direction from a visible normal weighs",
        symbol=printed_symbol("weight", r"\frac{\rho(\omega_o, \omega_i) \cos\theta_i}{p_{\omega_o}(\omega_i)}"),
        equals=F * G2_h / G1_h,
        proof=lambda it: [complete.equals.doit() * mu_i / reflected.equals.doit().subs({G1: G1_h, D: D_h}) - it.equals],
        proved_by="sympy: BRDF and density put in",
        slides=(42, 51),
        cite="heitzdeon2014",
        note="Between 0 and 1: no sample weighs much more than another.",
    )
    positivity = Equation(
        key="brdf.microfacet.positivity",
        title="a BRDF is never negative",
        symbol=printed_symbol("rho_positive", r"\rho(\omega_o, \omega_i)"),
        equals=sp.Integer(0),
        relation=r"\ge",
        proof=lambda it: [sp.Integer(0 if complete.equals.doit().is_nonnegative else 1), it.equals],
        proved_by="sympy: every factor is nonnegative",
        slides=(24, 51),
        cite="heitz2014",
    )
    reciprocity = Equation(
        key="brdf.microfacet.reciprocity",
        title="light and viewer may change places",
        symbol=printed_symbol("rho_oi", r"\rho(\omega_o, \omega_i)"),
        equals=rho_io,
        proof=lambda it: [*_reciprocity_steps(), it.equals - rho_io],
        proved_by="sympy: the half vector, F and D do not change, and neither does any G2 of this report",
        slides=(24, 51),
        cite="heitz2014",
    )
    energy = Equation(
        key="brdf.microfacet.energy",
        title="no more light leaves than arrives",
        symbol=printed_symbol("albedo", r"\int_{\Omega} \rho(\omega_o, \omega_i) \cos \theta_i \, d\omega_i"),
        equals=sp.Integer(1),
        relation=r"\le",
        proof=lambda it: [*_energy_steps(), it.equals - weak_furnace.equals],
        proved_by="sympy: F and G2/G1 are at most 1, so that the weak white furnace is an upper bound",
        slides=(24, 51),
        cite="heitz2014",
        note="For models that pass the weak white furnace. Wrong models may meet the bound as well.",
    )
    anchor = Equation(
        key="brdf.microfacet.anchor",
        title="albedo of GGX at alpha = 1, height-correlated, F = 1",
        symbol=printed_symbol("E_anchor", r"E(\theta_o)"),
        means=sp.Integral(mu / (mu + mu_o), (mu, 0, 1)),
        equals=1 - mu_o * sp.log(1 + 1 / mu_o),
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (mu_o,), [(1e-6,), (0.1,), (1.0,)]),
        over={mu_o: (1e-6, 1)},
        proof=lambda: _anchor_steps(),
        proved_by="sympy: Lambda and D at alpha = 1 put in, then the antiderivative",
        slides=(73, 74, 75),
        cite="heitz2014",
        note="What single scattering loses: nothing at grazing, most at normal incidence.",
    )

    average = Equation(
        key="brdf.microfacet.anchor_average",
        title="the same, averaged over all light",
        symbol=printed_symbol("E_average", r"2 \int_{0}^{1} E(\theta_o) \cos\theta_o \, d\cos\theta_o"),
        means=sp.Integral(2 * mu_o * (1 - mu_o * sp.log(1 + 1 / mu_o)), (mu_o, 0, 1)),
        equals=sp.Rational(4, 3) * (1 - sp.log(2)),
        enclosed=lambda it: enclosures.agreement(_average_from(it, EDGE), it.equals, (), [()]),
        proof=lambda it: _average_steps(it),
        proved_by="sympy: the antiderivative, checked by differentiation, between its limits",
        slides=(73, 74, 75),
        cite="heitz2014",
    )


def _average_from(it: Equation, edge: sp.Expr) -> sp.Expr:
    """Below the edge the integrand lies between 0 and 2 mu."""
    (whole,) = it.means.atoms(sp.Integral)
    return under_integral(it, sp.Integral(whole.function, (mu_o, edge, 1)) + enclosures.SHARE * edge**2)


def _average_steps(it: Equation) -> list[Any]:
    logarithms = mu_o**3 * sp.log(1 + 1 / mu_o) + mu_o**2 / 2 - mu_o + sp.log(1 + mu_o)
    antiderivative = mu_o**2 - sp.Rational(2, 3) * logarithms
    ends = antiderivative.subs(mu_o, 1) - sp.limit(antiderivative, mu_o, 0, "+")
    return [sp.diff(antiderivative, mu_o) - average.means.function.doit(), sp.expand(ends - it.equals.doit())]


def _swapped(form: Any) -> sp.Expr:
    """The form with light and viewer in each other's place."""
    swap = {mu_o: mu_i, mu_i: mu_o, om: im, im: om, Lambda_o: Lambda_i, Lambda_i: Lambda_o}
    return sp.sympify(form).doit().subs(swap, simultaneous=True)


def _reciprocity_steps() -> list[Any]:
    """The BRDF, the half vector, and every form of G2 that the report states."""
    smith = [shadowing.separable, shadowing.height, shadowing.direction, shadowing.height_direction]
    others = [v_cavity.G2, unphysical.implicit_G2, unphysical.kelemen_G2, unphysical.schlick_G2]
    forms = [one.equals.doit() for one in (complete, *smith, *others)]
    half = {o_vector: i_vector, i_vector: o_vector}
    vector = half_vector.equals.doit()
    return [vector - vector.subs(half, simultaneous=True), *(form - _swapped(form) for form in forms)]


def _energy_steps() -> list[Any]:
    """What the furnace counts, less what the BRDF sends: a product of nonnegative factors, with F and G2/G1 for 1 - loss."""
    kept_F, kept_G = sp.symbols("kept_F kept_G", positive=True)
    sent = complete.equals.doit().subs({F: 1 / (1 + kept_F), G2_h: G1_h / (1 + kept_G)}) * mu_i
    excess = sp.together(reflected.equals.doit().subs({G1: G1_h, D: D_h}) - sent)
    return [sp.Integer(0 if sp.factor(excess).is_nonnegative else 1)]


def _anchor_steps() -> list[Any]:
    """At alpha = 1: 1 + Lambda_o + Lambda_i = (1/mu_o + 1/mu)/2 and D = 1/pi; the BRDF depends on the cosines only."""
    Lambda_sum = (1 / mu_o - 1) / 2 + (1 / mu - 1) / 2
    rho = 1 / (1 + Lambda_sum) / sp.pi / (4 * mu_o * mu)
    antiderivative = mu - mu_o * sp.log(mu + mu_o)
    return [
        sp.simplify(2 * sp.pi * rho * mu - mu / (mu + mu_o)),
        sp.simplify(sp.diff(antiderivative, mu) - mu / (mu + mu_o)),
        sp.expand_log(antiderivative.subs(mu, 1) - antiderivative.subs(mu, 0) - (1 - mu_o * (sp.log(1 + mu_o) - sp.log(mu_o)))),
    ]


# --- kernels --------------------------------------------------------------------------------------------------------

stated_rho, stated_density = complete.scalar, reflected.scalar
BELOW = ByPrecision(double=1 - 2.0**-52, single=1 - 2.0**-23)  # of a height: a facet on edge still lies above the plane


class BRDFParameters(NamedTuple):
    """What the kernels of a BRDF take last: the parameters of distribution, masking and reflectance."""

    ndf: Any
    model: Any
    fresnel: Any


class LobeParameters(NamedTuple):
    """The same where a distribution has all but F as one kernel, the lobe."""

    lobe: Any
    fresnel: Any


def added(wo: Vector, wi: Vector) -> tuple[Vector, float]:
    """wo + wi and its length, half of which is the cosine of both with the half vector."""
    hx, hy, hz = wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]
    return (hx, hy, hz), sqrt(hx * hx + hy * hy + hz * hz)


def divided(v: Vector, length: float) -> Vector:
    return v[0] / length, v[1] / length, v[2] / length


@cache
def evaluation(
    D: Callable[..., float], Lambda: Callable[..., float], G2: Callable[..., float], F: Callable[..., float]
) -> Batch:
    """The BRDF part by part; D last, since it alone may be too small for a number: then `pdf` is 0 as well."""

    def evaluate(wo: Vector, wi: Vector, p: BRDFParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and wi[2] > HORIZON and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        shadowing = G2(Lambda(wo, p), Lambda(wi, p), cosine, cosine, wo, wi, wh, p)
        return stated_rho(F(cosine, p.fresnel), shadowing, 1.0, wo[2], wi[2]) * D(wh, p.ndf)

    return over_pairs(evaluate)


@cache
def joined_evaluation(lobe: Callable[..., float], F: Callable[..., float]) -> Batch:
    """The same where a distribution has all but F as one kernel."""

    def evaluate(wo: Vector, wi: Vector, p: LobeParameters) -> float:
        hx, hy, hz = wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]
        square = hx * hx + hy * hy + hz * hz
        if not (wo[2] > HORIZON and wi[2] > HORIZON and square > 0.0):
            return 0.0
        return F(min(0.5 * sqrt(square), 1.0), p.fresnel) * lobe(wo, wi, p.lobe)

    return over_pairs(evaluate)


@cache
def visible_pdf(D: Callable[..., float], Lambda: Callable[..., float], G1: Callable[..., float]) -> Batch:
    """Density of mirror directions of sampled visible normals."""

    def pdf(wo: Vector, wi: Vector, p: ModelParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and h[2] > 0.0 and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        masking = G1(Lambda(wo, p), cosine, wo, wh, p)
        return stated_density(masking, 1.0, wo[2]) * D(wh, p.ndf)

    return over_pairs(pdf)


@cache
def normals_pdf(drawn: Callable[..., float]) -> Batch:
    """Density of mirror directions of normals sampled without regard to the viewer.

    Facets turned away send theirs down, to where wo + wi points down: they count too, or the density would not sum to 1.
    """

    def pdf(wo: Vector, wi: Vector, p: ModelParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and length > 0.0):
            return 0.0
        wm = divided(h, length if h[2] > 0.0 else -length)
        return drawn(wm, p.ndf) * wm[2] / (2.0 * length)

    return over_pairs(pdf)


@cache
def visible_weight(
    Lambda: Callable[..., float], G1: Callable[..., float], G2: Callable[..., float], F: Callable[..., float]
) -> Batch:
    """The BRDF times the cosine over `visible_pdf`: D and the cosines cancel."""

    def weight(wo: Vector, wi: Vector, p: BRDFParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and wi[2] > HORIZON and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        Lambda_o, Lambda_i = Lambda(wo, p), Lambda(wi, p)
        masking = G1(Lambda_o, cosine, wo, wh, p)
        return F(cosine, p.fresnel) * (G2(Lambda_o, Lambda_i, cosine, cosine, wo, wi, wh, p) / masking)

    return over_pairs(weight)


@cache
def normals_weight(
    excess: Callable[..., float], Lambda: Callable[..., float], G2: Callable[..., float], F: Callable[..., float]
) -> Batch:
    """The same for `normals_pdf`; excess: D over the distribution of the normals that are drawn."""

    def weight(wo: Vector, wi: Vector, p: BRDFParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and wi[2] > HORIZON and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        shadowing = G2(Lambda(wo, p), Lambda(wi, p), cosine, cosine, wo, wi, wh, p)
        return F(cosine, p.fresnel) * (shadowing / wo[2]) * (cosine / wh[2]) * excess(wh, p.ndf)

    return over_pairs(weight)


@cache
def visible_mirror(sampler: Callable[..., Vector]) -> Batch:
    """Mirror directions of sampled visible normals."""

    def mirror(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
        if not wo[2] > HORIZON:
            return 0.0, 0.0, 0.0
        wm = sampler(wo, u, p)
        twice = 2.0 * dot(wo, wm)
        return twice * wm[0] - wo[0], twice * wm[1] - wo[1], max(twice * wm[2] - wo[2], -BELOW * wo[2])

    return Batch(mirror, [3, 2], 3)


@cache
def normals_mirror(slopes: Callable[..., Pair]) -> Batch:
    """Mirror directions of normals sampled without regard to the viewer, by their slopes."""

    def mirror(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
        ox, oy, oz = wo
        if not oz > HORIZON:
            return 0.0, 0.0, 0.0
        slope_x, slope_y = slopes(u, p.ndf)
        mz = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        twice = 2.0 * (oz - ox * slope_x - oy * slope_y) * mz
        return -twice * slope_x * mz - ox, -twice * slope_y * mz - oy, twice * mz - oz

    return Batch(mirror, [3, 2], 3)
