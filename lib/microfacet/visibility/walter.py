"""Walter's rational fit of Beckmann's masking: stated for its error. No model of this library uses it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import ceil

import sympy as sp

from microfacet.geometry import beckmann
from microfacet.statements import ball_functions, enclosures
from microfacet.statements.balls import Ball
from microfacet.statements.enclosures import Enclosure
from microfacet.statements.notation import a, printed_symbol
from microfacet.statements.reference import reference
from microfacet.statements.statement import Equation

END = sp.Rational(8, 5)  # from here on the fit is 1
ERROR = sp.Rational(32, 10000)
FOUR_DECIMALS = 10**4
ABOVE = 1.5482  # from here to the end the fit is above 1


def _fitted_Lambda() -> sp.Expr:
    """The same fit as renderers write it, for Lambda."""
    c = [sp.Rational(k, 1000) for k in (1259, 396, 3535, 2181)]
    return (1 - c[0] * a + c[1] * a**2) / (c[2] * a + c[3] * a**2)


with sp.evaluate(False):
    _C = [sp.Rational(k, 1000) for k in (3535, 2181, 2276, 2577)]
    fit = Equation(
        key="visibility.beckmann.walter",
        title="Walter's fit of Smith's masking for Beckmann, below a = 1.6",
        symbol=printed_symbol("G1_walter", r"G_1(\omega_o, \omega_m)"),
        equals=(_C[0] * a + _C[1] * a**2) / (1 + _C[2] * a + _C[3] * a**2),
        relation=r"\approx",
        proof=lambda it: [it.equals - 1 / (1 + _fitted_Lambda())],
        proved_by="sympy: the forms in use, for G1 and for Lambda, are one function",
        over={a: (1e-8, END)},
        slides=(58, 62),
        cite="walter2007",
        note="From a = 1.6 on it is 1.",
    )
    error = Equation(
        key="visibility.beckmann.walter_error",
        title="how far Walter's fit is from what it fits, at most",
        symbol=printed_symbol("walter_off", r"\left| \left(1 + \Lambda(a)\right) G_1^{\mathrm{fit}}(a) - 1 \right|"),
        equals=ERROR,
        relation="<",
        proof=lambda it: [it.equals - sp.Rational(ceil(largest() * FOUR_DECIMALS), FOUR_DECIMALS)],
        proved_by="the largest error found, rounded up to four decimals; that it is the largest, by balls",
        enclosed=lambda it: _bounded(it),
        slides=(58, 62),
        cite="walter2007",
        note="Over the fit's whole range by balls; beyond it the error is Lambda itself, which falls with a.",
    )
    above = Equation(
        key="visibility.beckmann.walter_above",
        title="just below a = 1.6 Walter's fit shows more than there is",
        symbol=printed_symbol("walter_fit", r"G_1^{\mathrm{fit}}(a)"),
        equals=sp.Integer(1),
        relation=">",
        proof=lambda it: [fit.equals.doit().subs(a, root) - it.equals for root in sp.solve(_fitted_Lambda(), a)],
        proved_by="sympy: the fit is 1 where its Lambda is 0; its sign beyond by balls",
        enclosed=lambda it: [
            enclosures.over(lambda **at: _fitted(at["a"]) - ball_functions.constant(it.equals), a=(ABOVE, float(END)))
        ],
        slides=(58, 62),
        cite="walter2007",
    )


@cache
def _compiled(expression: sp.Expr) -> Callable[..., Ball]:
    return ball_functions.evaluator(expression, (a,))


def _fitted(argument: Ball) -> Ball:
    return _compiled(fit.equals)(argument)


def ratio() -> sp.Expr:
    """(1 + Lambda) times the fit, with a factor a taken from the one to the other, so that it can be bounded down to a = 0."""
    above, below = fit.equals.args if fit.equals.args[0].is_Add else fit.equals.args[::-1]
    shown = a * (1 + sp.erf(a)) / 2 + sp.exp(-(a**2)) / (2 * sp.sqrt(sp.pi))
    return shown * sp.expand(above.doit() / a) * below.doit()


def largest(steps: int = 800) -> float:
    """The largest error of the fit at evenly spaced arguments."""
    apart = reference(ratio() - 1, (a,))
    return max(abs(float(apart(float(END) * (k + 1) / steps))) for k in range(steps))


def _bounded(it: Equation) -> list[Enclosure]:
    apart, limit = _compiled(ratio() - 1), ball_functions.constant(it.equals)
    beyond = ball_functions.evaluator(beckmann.Lambda.equals, (a,))
    inside = enclosures.over(lambda **at: abs(apart(at["a"])) - limit, a=(0, float(END)))
    return [inside, *enclosures.at(lambda **at: beyond(at["a"]) - limit, [{"a": float(END)}])]
