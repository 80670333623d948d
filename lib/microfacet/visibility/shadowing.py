"""Shadowing for Smith's model: four ways in which masking and shadowing may depend on each other."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.statements import enclosures
from microfacet.statements.notation import G1, LATEX, Lambda_i, Lambda_o, phi, printed_symbol, u
from microfacet.statements.statement import Equation

OCCLUSION = (0, 1e4)
G1_i = sp.Symbol("G1_i", nonnegative=True)
LATEX[G1_i] = r"G_1(\omega_i, \omega_m)"
blend = sp.Symbol("lambda_", nonnegative=True)
LATEX[blend] = r"\lambda"
DEGREES_OF_CORRELATION = sp.Rational(441, 100)  # van Ginneken et al. 1998: 4.41 per radian


def stated(name: str) -> sp.Symbol:
    symbol = sp.Symbol(f"G2_{name}")
    LATEX[symbol] = r"G_2(\omega_o, \omega_i, \omega_m)"
    return symbol


with sp.evaluate(False):
    separable = Equation(
        key="visibility.shadowing.separable",
        title="masking and shadowing independent",
        symbol=stated("separable"),
        means=G1 * G1_i,
        equals=1 / ((1 + Lambda_o) * (1 + Lambda_i)),
        where={G1: 1 / (1 + Lambda_o), G1_i: 1 / (1 + Lambda_i)},
        proved_by="sympy: Smith's G1 put in for both directions",
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION},
        slides=(49, 50),
        cite="heitz2014, eq. 98",
    )
    height = Equation(
        key="visibility.shadowing.height",
        title="masking and shadowing correlated by the height of the facet",
        symbol=stated("height"),
        means=sp.Integral(u**Lambda_o * u**Lambda_i, (u, 0, 1)),
        equals=1 / (1 + Lambda_o + Lambda_i),
        enclosed=lambda it: enclosures.agreement(
            it.means, it.equals, (Lambda_o, Lambda_i), [(0.0, 0.0), (0.25, 0.5), (1.0, 3.0), (1e3, 0.1)]
        ),
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION},
        slides=(49, 50),
        cite="heitz2014, eq. 99",
        note="A facet at height quantile u is seen with probability u to the Lambda, whatever the distribution of heights.",
    )
    correlation = Equation(
        key="visibility.shadowing.lambda",
        title="how far apart in azimuth the two directions are",
        symbol=sp.Function("lambda")(phi),
        equals=DEGREES_OF_CORRELATION * phi / (DEGREES_OF_CORRELATION * phi + 1),
        over={phi: (0, 3.141592)},
        slides=(49, 50),
        cite="ginneken1998",
        note="Measured by van Ginneken et al.: 0 for the same azimuth, near 1 beyond a radian.",
    )
    direction = Equation(
        key="visibility.shadowing.direction",
        title="masking and shadowing correlated by direction",
        symbol=stated("direction"),
        equals=blend / ((1 + Lambda_o) * (1 + Lambda_i)) + (1 - blend) / (1 + sp.Max(Lambda_o, Lambda_i)),
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION, blend: (0, 1)},
        slides=(49, 50),
        cite="ashikhmin2000; heitz2014",
        note="From the smaller of both G1 where the directions agree to their product where they do not.",
    )
    height_direction = Equation(
        key="visibility.shadowing.height_direction",
        title="masking and shadowing correlated by height and direction",
        symbol=stated("height_direction"),
        equals=1 / (1 + sp.Max(Lambda_o, Lambda_i) + blend * sp.Min(Lambda_o, Lambda_i)),
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION, blend: (0, 1)},
        slides=(49, 50),
        cite="heitz2014",
    )


# --- order, limits, reciprocity -----------------------------------------------------------------------------------------

less, more = sp.symbols("less more", nonnegative=True)  # of two Lambdas the smaller, and what the other has in excess


def _ordered(expression: Any) -> sp.Expr:
    """With Lambda_o the smaller of the two: no loss, since every form here is symmetric."""
    return sp.sympify(expression).doit().subs({Lambda_o: less, Lambda_i: less + more}, simultaneous=True)


def _falls_short(lower: Any, upper: Any) -> list[Any]:
    """lower <= upper, for 0 <= lambda <= 1 and any two Lambdas: over its denominator the difference has no negative term."""
    rest = sp.Symbol("rest", nonnegative=True)
    put = {blend: 1 / (1 + rest)}  # any lambda above 0; the difference is continuous at 0
    above, below = sp.fraction(sp.together(_ordered(upper).subs(put) - _ordered(lower).subs(put)))
    terms = [*sp.Poly(sp.expand(above), less, more, rest).coeffs(), *sp.Poly(sp.expand(below), less, more, rest).coeffs()]
    return [sp.Integer(0 if all(term > 0 for term in terms) else 1)]


def _touch(it: Equation, symbol: sp.Symbol, value: int) -> list[Any]:
    """Both sides are the same there: nothing smaller would be a bound."""
    return [_ordered(it.symbol.subs(symbol, value) - it.equals.subs(it.where).subs(symbol, value))]


with sp.evaluate(False):
    _SMALLER = 1 / (1 + sp.Max(Lambda_o, Lambda_i))
    smaller = Equation(
        key="visibility.shadowing.smaller",
        title="the smaller of both masking functions",
        symbol=sp.Min(G1, G1_i),
        equals=_SMALLER,
        proof=lambda it: [
            _ordered(it.equals) - _ordered(1 / (1 + Lambda_i)),
            *_falls_short(1 / (1 + Lambda_i), 1 / (1 + Lambda_o)),
        ],
        proved_by="sympy: the larger Lambda belongs to the smaller G1",
        slides=(49, 50),
        cite="heitz2014",
    )
    heights_help = Equation(
        key="visibility.shadowing.height_above_separable",
        title="correlation by height never shadows more than none",
        symbol=separable.equals,
        equals=height.equals,
        relation=r"\le",
        proof=lambda it: [*_falls_short(it.symbol, it.equals), *_touch(it, Lambda_o, 0), *_touch(it, Lambda_i, 0)],
        proved_by="sympy: over the common denominator the difference is the product of both Lambdas",
        slides=(49, 50),
        cite="heitz2014",
    )
    direction_helps = Equation(
        key="visibility.shadowing.height_direction_above_height",
        title="correlation by direction as well never shadows more",
        symbol=height.equals,
        equals=height_direction.equals,
        relation=r"\le",
        proof=lambda it: [*_falls_short(it.symbol, it.equals), *_touch(it, blend, 1)],
        proved_by="sympy: over the common denominator the difference has no negative term",
        slides=(49, 50),
        cite="heitz2014",
    )
    bound = Equation(
        key="visibility.shadowing.height_direction_bound",
        title="light and viewer together see no more than the one that sees less",
        symbol=height_direction.equals,
        equals=sp.Min(G1, G1_i),
        where={sp.Min(G1, G1_i): _SMALLER},
        relation=r"\le",
        proof=lambda it: [*_falls_short(it.symbol, it.equals.subs(it.where)), *_touch(it, blend, 0)],
        proved_by="sympy: over the common denominator the difference has no negative term",
        slides=(49, 50),
        cite="heitz2014",
    )
    direction_bound = Equation(
        key="visibility.shadowing.direction_bound",
        title="the same for correlation by direction",
        symbol=direction.equals,
        equals=sp.Min(G1, G1_i),
        where={sp.Min(G1, G1_i): _SMALLER},
        relation=r"\le",
        proof=lambda it: [
            *_falls_short(it.symbol, it.equals.subs(it.where)),
            *_falls_short(separable.equals, it.symbol),
            *_touch(it, blend, 0),
        ],
        proved_by="sympy: over the common denominator the difference has no negative term; nor has that to the product of both",
        slides=(49, 50),
        cite="ashikhmin2000; heitz2014",
    )
    near = Equation(
        key="visibility.shadowing.same_azimuth",
        title="from the same azimuth, what one direction sees the other sees, or less",
        symbol=printed_symbol("G2_near", r"\lim_{\lambda \to 0} G_2(\omega_o, \omega_i, \omega_m)"),
        equals=sp.Min(G1, G1_i),
        where={sp.Min(G1, G1_i): _SMALLER},
        proof=lambda it: [
            correlation.equals.doit().subs(phi, 0),
            *(form.equals.doit().subs(blend, 0) - it.equals.subs(it.where).doit() for form in (direction, height_direction)),
        ],
        proved_by="sympy: lambda(0) = 0 put into both forms",
        slides=(49, 50),
        cite="ashikhmin2000; heitz2014",
    )
    far_direction = Equation(
        key="visibility.shadowing.far_direction",
        title="far apart, correlation by direction leaves masking and shadowing independent",
        symbol=printed_symbol("G2_far_direction", r"\lim_{\lambda \to 1} G_2(\omega_o, \omega_i, \omega_m)"),
        equals=separable.equals,
        proof=lambda it: [direction.equals.doit().subs(blend, 1) - it.equals.doit()],
        proved_by="sympy: lambda = 1 put in",
        slides=(49, 50),
        cite="ashikhmin2000",
    )
    far_heights = Equation(
        key="visibility.shadowing.far_height_direction",
        title="far apart, correlation by height is left",
        symbol=printed_symbol("G2_far_heights", r"\lim_{\lambda \to 1} G_2(\omega_o, \omega_i, \omega_m)"),
        equals=height.equals,
        proof=lambda it: [
            _ordered(height_direction.equals).subs(blend, 1) - _ordered(it.equals),
            sp.limit(correlation.equals.doit(), phi, sp.oo) - 1,
        ],
        proved_by="sympy: lambda = 1 put in, which it tends to as the azimuths part",
        slides=(49, 50),
        cite="heitz2014",
    )
