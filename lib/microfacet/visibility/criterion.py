"""Which masking functions belong to a surface: a criterion for all that depend on the view alone, over all distributions.

"Surface" means Smith's model of one: slopes that do not depend on heights, symmetric. If G1 is the same for all facets turned
to the viewer, conservation of projected area makes it Smith's, with Lambda the integral of the slopes along the view. So
f(x) = x Lambda, x = cot theta_o, tells them: its second derivative is their density. A function G1 has slopes, and meets the
equations with their distribution, if and only if f is convex and tends to 0, no more than the whole surface is tilted
(f'(0+) >= -1/2; what is missing is level), and, since slopes along all azimuths are spread alike, the density of slopes in the
plane that has f'' along each line, its inverse Abel transform, is not negative.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.geometry import ggx
from microfacet.statements.notation import P2, Lambda_i, Lambda_o, a, alpha, chi, mu_i, mu_o, om, printed_symbol, q, theta_o
from microfacet.statements.statement import Equation
from microfacet.visibility import smith, unphysical
from microfacet.visibility.unphysical import k

HALF = sp.Rational(1, 2)
x = sp.Symbol("x", positive=True)  # the cotangent of the view's polar angle
r, s = sp.symbols("r s", positive=True)
P22_of_r = printed_symbol("P22_of_r", r"P_{22}(r)")
level = printed_symbol("level", r"p_0", nonnegative=True)  # fraction of the surface that is level
G1_view = printed_symbol("G1_view", r"G_1(\omega_o)", positive=True)
f_prime = printed_symbol("f_prime_at_0", r"f'(0^{+})")

# --- what follows from f ----------------------------------------------------------------------------------------------

with sp.evaluate(False):
    hidden_slopes = Equation(
        key="visibility.criterion.f",
        title="what a masking function of the view alone says of slopes",
        symbol=printed_symbol("f_of_x", r"f(x)"),
        means=x * (1 / G1_view - 1),
        equals=sp.Integral((q - x) * P2(q), (q, x, sp.oo)),
        proof=lambda it: _hidden_steps(it),
        proved_by="sympy: Smith's G1 and Lambda put in, for slopes exp(-q^2/s) of any width and so for their mixtures",
        slides=(39, 40, 58),
        cite="heitz2014",
        note="x is cot theta_o.",
    )
    density = Equation(
        key="visibility.criterion.density",
        title="its second derivative is the density of slopes along the view",
        symbol=printed_symbol("f_second", r"f''(x)"),
        means=sp.Derivative(sp.Integral((q - x) * P2(q), (q, x, sp.oo)), (x, 2)),
        equals=P2(x),
        proof=lambda it: [it.means.doit() - it.equals, sp.diff(hidden_slopes.equals, x, 2) - it.equals],
        proved_by="sympy: the integral differentiated twice by its limit",
        slides=(39, 40, 58),
        cite="heitz2014",
        note="So f is convex.",
    )
    level_facets = Equation(
        key="visibility.criterion.level",
        title="its slope at 0 tells how much of the surface is level",
        symbol=level,
        means=1 - 2 * sp.Integral(P2(q), (q, 0, sp.oo)),
        equals=1 + 2 * f_prime,
        where={f_prime: -sp.Integral(P2(q), (q, 0, sp.oo))},
        proof=lambda it: _level_steps(it),
        proved_by="sympy: f differentiated at 0, for slopes exp(-q^2/s) of any width and so for their mixtures",
        slides=(39, 40, 58),
        cite="heitz2014",
        note="So f'(0+) is at least -1/2.",
    )
    plane = Equation(
        key="visibility.criterion.P22",
        title="the density of slopes in the plane, if it is the same along all azimuths",
        symbol=P22_of_r,
        equals=-sp.Integral(sp.Derivative(P2(q), q) / sp.sqrt(q**2 - r**2), (q, r, sp.oo)) / sp.pi,
        proof=lambda it: _plane_steps(it),
        proved_by="sympy: Abel's inverse, for slopes exp(-r^2/s) of any width s and, since it is linear, for their mixtures",
        slides=(39, 40, 64),
        cite="heitz2014",
        note="It is not negative for a surface: convexity of f alone suffices for grooves only.",
    )


def _gaussian(form: Any) -> sp.Expr:
    """The form for slopes exp(-q^2/s): what is linear in the density and true for these is true for their mixtures."""
    return sp.sympify(form).subs(P2(q), sp.exp(-(q**2) / s)).doit()


def _hidden_steps(it: Equation) -> list[Any]:
    """x (1/G1 - 1) = x Lambda, and that is the integral."""
    Lambda = smith.Lambda.equals.subs(sp.cot(theta_o), x)
    return [it.means.doit().subs(G1_view, 1 / (1 + Lambda_o)) - x * Lambda_o, x * _gaussian(Lambda) - _gaussian(it.equals)]


def _level_steps(it: Equation) -> list[Any]:
    """f differentiated at 0 is the integral that it stands for; both forms with it."""
    steepest = _gaussian(it.where[f_prime])
    at_0 = sp.limit(sp.diff(_gaussian(hidden_slopes.equals), x), x, 0, "+")
    return [at_0 - steepest, _gaussian(it.means) - it.equals.subs(f_prime, steepest).doit()]


def _plane_steps(it: Equation) -> list[Any]:
    """Along a line at distance q slopes exp(-r^2/s) have the density sqrt(pi s) exp(-q^2/s); back by q = sqrt(r^2 + w^2)."""
    t, w = sp.Symbol("t", real=True), sp.Symbol("w", positive=True)
    along = sp.integrate(sp.exp(-(q**2 + t**2) / s), (t, -sp.oo, sp.oo))
    (whole,) = it.equals.atoms(sp.Integral)
    inside = whole.function.subs(P2(q), along).doit()
    distance = sp.sqrt(r**2 + w**2)
    back = sp.integrate(sp.simplify(inside.subs(q, distance) * sp.diff(distance, w)), (w, 0, sp.oo))
    undone = sp.Integer(1 if back.has(sp.Integral) else 0)
    return [undone, sp.simplify(it.equals.xreplace({whole: back}).doit() - sp.exp(-(r**2) / s))]


# --- the functions of the talk, for all distributions at once -----------------------------------------------------------


def _f(G1: Any) -> sp.Expr:
    """f of a masking function of the cosine."""
    cosine = x / sp.sqrt(1 + x**2)
    return sp.simplify(x * (1 / G1.subs(mu_o, cosine) - 1))


schlick_G1 = mu_o / (mu_o * (1 - k) + k)

with sp.evaluate(False):
    schlick = Equation(
        key="visibility.criterion.schlick_smith",
        title="Schlick's masking is Smith's, for a share 2k of GGX at alpha = 1 and a level rest",
        symbol=schlick_G1,
        equals=1 / (1 + 2 * k * Lambda_o),
        where={Lambda_o: (1 / mu_o - 1) / 2},
        proof=lambda it: _schlick_steps(it),
        proved_by="sympy: Lambda of GGX at alpha = 1 put in, which is linear in the density of slopes; k is half that share",
        slides=(58,),
        cite="schlick1994",
        note="So it belongs to a surface if k is at most 1/2, whatever the distribution is that it is used with.",
    )
    implicit = Equation(
        key="visibility.criterion.implicit",
        title="implicit masking would need twice the surface there is",
        symbol=f_prime,
        means=sp.Limit(sp.Derivative(sp.sqrt(1 + x**2) - x, x), x, 0, "+"),
        equals=sp.Integer(-1),
        proof=lambda it: [sp.diff(_f(mu_o), x).subs(x, 0) - it.equals, it.means.doit() - it.equals, *_implicit_steps()],
        proved_by="sympy: f of G1 = cos theta_o is sqrt(1 + x^2) - x, Schlick's for k = 1",
        slides=(58,),
        cite="hoffman2010",
        note="So it belongs to no surface, whatever its distribution.",
    )


def _schlick_steps(it: Equation) -> list[Any]:
    """The identity; its f; and that f'' is 2k times the density of slopes of GGX."""
    f, of_ggx = _f(schlick_G1), ggx.P2.equals.doit().subs({alpha: 1, q: x})
    return [
        it.symbol - it.equals.subs(it.where).doit(),
        it.where[Lambda_o].doit() - ggx.Lambda.equals.doit().subs(a, mu_o / sp.sqrt(1 - mu_o**2)),
        sp.simplify(f - k * (sp.sqrt(1 + x**2) - x)),
        sp.simplify(sp.diff(f, x, 2) - 2 * k * of_ggx),
        sp.limit(f, x, sp.oo),
        sp.diff(f, x).subs(x, 0) + k,
    ]


def _implicit_steps() -> list[Any]:
    stated = unphysical.implicit_G1.equals.doit().subs(chi(om), 1)
    return [stated - mu_o, _f(mu_o) - _f(schlick_G1).subs(k, 1)]


# --- what game engines use ----------------------------------------------------------------------------------------------

mu = sp.Symbol("mu", positive=True)  # a cosine over the roughness
perceptual = printed_symbol("perceptual", r"r_{\mathrm{p}}", positive=True)  # perceptual roughness


def _engines() -> list[sp.Expr]:
    """G2 as two engines and a talk write it: 4 cos cos times their visibility terms."""
    joint = mu_i * (mu_o * (1 - alpha) + alpha) + mu_o * (mu_i * (1 - alpha) + alpha)
    mixed = 2 * mu_o * mu_i * (1 - alpha) + (mu_o + mu_i) * alpha
    return [4 * mu_o * mu_i * HALF / form for form in (joint, mixed)]


with sp.evaluate(False):
    engines = Equation(
        key="visibility.criterion.engines",
        title="the fast masking and shadowing of game engines, one function in three disguises",
        symbol=printed_symbol("G2_fast", r"G_2(\omega_o, \omega_i, \omega_m)"),
        means=2 * mu_o * mu_i / (2 * mu_o * mu_i * (1 - alpha) + (mu_o + mu_i) * alpha),
        equals=1 / (1 + Lambda_o + Lambda_i),
        where={Lambda_o: alpha / 2 * (1 / mu_o - 1), Lambda_i: alpha / 2 * (1 / mu_i - 1)},
        proof=lambda it: [form - it.equals.subs(it.where).doit() for form in (it.means.doit(), *_engines())],
        proved_by="sympy: both ways to write it put in",
        slides=(58,),
        cite="hammon2017; karis2013; guy2018",
        note="Smith's, correlated by height, for a share alpha of GGX at alpha = 1 and a level rest.",
    )
    engines_least = Equation(
        key="visibility.criterion.engines_least",
        title="over GGX it shows too little, by less than a fifth",
        symbol=printed_symbol("fast_over_smith", r"\frac{G_1^{\mathrm{fast}}(\omega_o)}{G_1(\omega_o)}"),
        means=(mu + sp.sqrt(mu**2 * (1 - alpha**2) + 1)) / (2 * mu + 1 - alpha * mu),
        equals=sp.Rational(4, 5),
        relation=r"\ge",
        proof=lambda it: _least_steps(it),
        proved_by="sympy: squared, both sides differ by a quadratic in mu that has no real root; equal at mu = 3/4, alpha = 0",
        slides=(58,),
        cite="hammon2017",
        note="mu is cos theta_o over alpha; alpha is at most 1.",
    )
    remapped = Equation(
        key="visibility.criterion.remapped",
        title="next to the horizon Karis' k and Disney's remapped alpha show the same, and less than GGX",
        symbol=printed_symbol(
            "remapped_over_smith", r"\lim_{\theta_o \to 90^{\circ}} \frac{G_1^{\mathrm{remapped}}(\omega_o)}{G_1(\omega_o)}"
        ),
        means=alpha / (2 * k),
        equals=4 * perceptual**2 / (1 + perceptual) ** 2,
        where={alpha: perceptual**2, k: (1 + perceptual) ** 2 / 8},
        proof=lambda it: _remapped_steps(it),
        proved_by="sympy: the limits of Schlick's masking and of Smith's over GGX, both over the cosine",
        slides=(58,),
        cite="karis2013; burley2012",
        note="r_p is the perceptual roughness, alpha its square; Disney's alpha of masking is (1 + r_p)^2/4.",
    )


def _remapped_steps(it: Equation) -> list[Any]:
    """Next to the horizon Schlick's masking is the cosine over k, and Smith's over GGX twice the cosine over alpha."""
    cosine = 1 / (1 + ggx.Lambda.equals.doit().subs(a, mu_o / (alpha * sp.sqrt(1 - mu_o**2))))
    schlick_limit, ggx_limit = (sp.limit(G1 / mu_o, mu_o, 0, "+") for G1 in (schlick_G1, cosine))
    disney = (1 + perceptual) ** 2 / 4
    return [
        schlick_limit / ggx_limit - it.means,
        (ggx_limit.subs(alpha, disney) / ggx_limit - it.equals).subs(it.where),
        it.means.doit().subs(it.where) - it.equals,
    ]


def _least_steps(it: Equation) -> list[Any]:
    """5 root >= 4 (2 mu + 1 - alpha mu) - 5 mu, where that is positive: the squares differ by q2 mu^2 + q1 mu + 9."""
    stated, cosine = it.means.doit(), alpha * mu
    ratio = (1 + ggx.Lambda.equals.doit().subs(a, cosine / (alpha * sp.sqrt(1 - cosine**2)))) / (1 + (1 / mu - alpha) / 2)
    root = sp.sqrt(mu**2 * (1 - alpha**2) + 1)
    q2, q1 = 16 + 24 * alpha - 41 * alpha**2, 32 * alpha - 24
    squares = 25 * root**2 - (4 * (2 * mu + 1 - alpha * mu) - 5 * mu) ** 2
    return [
        sp.simplify(ratio - stated),
        sp.expand(squares - (q2 * mu**2 + q1 * mu + 9)),
        sp.expand(q1**2 - 36 * q2 - 100 * alpha * (25 * alpha - 24)),  # negative below alpha = 24/25
        sp.Integer(0 if _positive_beyond(q2, q1) else 1),
        stated.subs({alpha: 0, mu: sp.Rational(3, 4)}) - it.equals,
    ]


def _positive_beyond(q2: sp.Expr, q1: sp.Expr) -> bool:
    """From alpha = 24/25 to 1, where mu is at most 1/alpha: q2 >= -1, q1 > 0, so that q2 mu^2 + q1 mu + 9 > 0."""
    ends = (sp.Rational(24, 25), sp.Integer(1))
    concave = sp.diff(q2, alpha, 2) < 0  # so that its least value is at an end
    return bool(concave and all(q2.subs(alpha, end) >= -1 and q1.subs(alpha, end) > 0 for end in ends))
