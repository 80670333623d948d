"""Table 2 of the talk, its crosses: over GGX in closed form, over Beckmann enclosed for a whole box of roughness and angle."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.geometry import beckmann, ggx
from microfacet.statements import ball_functions, balls, enclosures
from microfacet.statements.balls import Ball
from microfacet.statements.enclosures import Enclosure
from microfacet.statements.notation import a, alpha, mu_o
from microfacet.statements.statement import Equation
from microfacet.validation.physical import deviation
from microfacet.validation.slopes_along_view import GGX, ROUGH, compiled_form, radians, visible_fraction

# --- crosses: table 2, closed forms ---------------------------------------------------------------------------------------

k = sp.Symbol("k", positive=True)
root = sp.sqrt(mu_o**2 + alpha**2 * (1 - mu_o**2))
tangent = sp.sqrt(1 - mu_o**2) / mu_o
ggx_Lambda_o = ggx.Lambda.equals.doit().subs(ggx.Lambda.symbol.args[0], 1 / (alpha * tangent))


def _closed_steps(masking: sp.Expr, stated: sp.Expr) -> list[Any]:
    """1 + Lambda = (mu + E)/(2 mu), E the root; then with mu and E as unknowns bound by E^2 = mu^2 + alpha^2 (1 - mu^2)."""
    E = sp.Symbol("E", positive=True)
    residual = masking * (mu_o + E) / (2 * mu_o) - 1 - stated.doit().subs(root, E)
    numerator = sp.expand(sp.fraction(sp.together(residual))[0])
    lambda_square = sp.simplify(((2 * ggx_Lambda_o + 1) * mu_o) ** 2 - root**2)
    return [lambda_square, sp.rem(numerator, E**2 - root**2, E)]


def _sign_steps(bracket: sp.Expr, largest: sp.Expr) -> list[Any]:
    """The bracket is linear in mu, negative at 0, and 0 at mu = 1 for the largest alpha: below it, negative for every mu."""
    ends = [bracket.subs(mu_o, 0).subs(alpha, largest), bracket.subs(mu_o, 1).diff(alpha)]
    signs = sp.Integer(0 if ends[0].is_negative and ends[1].is_positive else 1)
    return [sp.diff(bracket, mu_o, 2), bracket.subs({mu_o: 1, alpha: largest}), signs]


with sp.evaluate(False):
    _IMPLICIT = (1 - mu_o) * (alpha**2 * (1 + mu_o) - 4) / (2 * (2 - mu_o + root))
    _SCHLICK = (
        (1 - mu_o)
        * (alpha**2 * (1 + mu_o) - 4 * k**2 * (1 - mu_o) - 4 * k * mu_o)
        / (2 * (mu_o + k * (1 - mu_o)) * (root + mu_o + 2 * k * (1 - mu_o)))
    )
    _HALVED = alpha * (alpha - 1) * mu_o * (1 - mu_o) / ((mu_o + alpha * (1 - mu_o) / 2) * (root + mu_o + alpha * (1 - mu_o)))

COSINES = (1e-6, 0.5, 0.999)
SCHLICK_K = sp.sqrt(2 / sp.pi)
IMPLICIT_UP_TO, SCHLICK_UP_TO = sp.sqrt(2), 2 * SCHLICK_K  # the largest alpha for which the closed forms have one sign


def _closed_enclosed(masking: sp.Expr, stated: sp.Expr, alphas: tuple[float, ...]) -> list[Enclosure]:
    """Integral over slopes times the masking function, less 1, less the closed form."""
    mask, excess = ball_functions.evaluator(masking, (alpha, mu_o)), ball_functions.evaluator(stated, (alpha, mu_o))

    def apart(alpha: Ball, mu: Ball) -> Ball:
        tangent = (1 - mu**2).sqrt() / mu
        facing = GGX.integral(1, -tangent, alpha, -ball_functions.constant(GGX.end), GGX.edge(alpha, tangent))
        return mask(alpha, mu) * facing - 1 - excess(alpha, mu)

    return enclosures.at(apart, [{"alpha": a, "mu": m} for a in alphas for m in COSINES])


implicit_ggx = Equation(
    key="validation.table2.implicit_ggx",
    title="by how much Implicit masking over GGX misses what there is to see",
    symbol=deviation("implicit", "GGX"),
    equals=_IMPLICIT,
    proof=lambda: [*_closed_steps(mu_o, _IMPLICIT), *_sign_steps(alpha**2 * (1 + mu_o) - 4, IMPLICIT_UP_TO)],
    proved_by="sympy: Lambda put in, then modulo the square of the root",
    enclosed=lambda it: _closed_enclosed(mu_o, it.equals, ROUGH),
    slides=(58,),
    cite="hoffman2010",
    note="Zero at normal incidence and where alpha^2 (1 + cos theta_o) = 4, which needs alpha above sqrt 2.",
)
schlick_ggx = Equation(
    key="validation.table2.schlick_smith_ggx",
    title="by how much Schlick-Smith over GGX misses what there is to see",
    symbol=deviation("Schlick", "GGX"),
    equals=_SCHLICK,
    proof=lambda: [
        *_closed_steps(mu_o / (mu_o + k * (1 - mu_o)), _SCHLICK),
        *_sign_steps(alpha * (1 + mu_o) - 4 * alpha * SCHLICK_K**2 * (1 - mu_o) - 4 * SCHLICK_K * mu_o, SCHLICK_UP_TO),
    ],
    proved_by="sympy: Lambda put in, then modulo the square of the root",
    enclosed=lambda it: _closed_enclosed(
        (mu_o / (mu_o + k * (1 - mu_o))).subs(k, alpha * SCHLICK_K), it.equals.doit().subs(k, alpha * SCHLICK_K), ROUGH
    ),
    slides=(58,),
    cite="schlick1994",
    note="Zero at normal incidence; enclosed for k = alpha sqrt(2/pi).",
)
halved_ggx = Equation(
    key="validation.table2.schlick_smith_halved_ggx",
    title="by how much Schlick-Smith with k = alpha/2 over GGX misses what there is to see",
    symbol=deviation("Schlick", "GGX"),
    equals=_HALVED,
    proof=lambda: [*_closed_steps((mu_o / (mu_o + k * (1 - mu_o))).subs(k, alpha / 2), _HALVED), _HALVED.doit().subs(alpha, 1)],
    proved_by="sympy: Lambda put in, then modulo the square of the root",
    enclosed=lambda it: _closed_enclosed((mu_o / (mu_o + k * (1 - mu_o))).subs(k, alpha / 2), it.equals, ROUGH),
    slides=(58,),
    cite="schlick1994",
    note="Zero for every direction at alpha = 1, where it is Smith's function; elsewhere at normal and grazing incidence only.",
)

# --- crosses: table 2, over boxes -----------------------------------------------------------------------------------------

SMOOTHEST, ROUGHEST = 0.01, 2.0
STEEPEST, FLATTEST = 0.001, 90.0  # degrees

_hidden_slopes = sp.expand(beckmann.Lambda.equals.doit() * a)  # a Lambda(a), the integral of (q - a) P2(q) over q > a


def _hidden(alpha: Ball, degrees: Ball) -> Ball:
    """mu Lambda/(alpha (1 - mu)) for Beckmann: cot(theta/2) a Lambda(a), which falls with a: the ends of a box bound it."""
    slopes = compiled_form(_hidden_slopes, a)
    argument = radians(degrees).cos().nonnegative_part() / (alpha * radians(degrees).sin())
    return slopes(argument.upper()).union(slopes(argument.lower().nonnegative_part())) / (radians(degrees) / 2).tan()


def _implicit_box(alpha: Ball, degrees: Ball) -> Ball:
    """(fraction - 1)/(1 - mu) with fraction = mu (1 + Lambda)."""
    return alpha * _hidden(alpha, degrees) - 1


def _schlick_box(alpha: Ball, degrees: Ball) -> Ball:
    """(f - 1)(mu + k (1 - mu))/(alpha (1 - mu)) with f = mu (1 + Lambda)/(mu + k (1 - mu)), k = alpha sqrt(2/pi)."""
    return _hidden(alpha, degrees) - (2 / balls.pi()).sqrt()


def _box_steps() -> list[Any]:
    """Both differences, divided as above, in Lambda and mu; and mu/(1 - mu) is cot(theta/2)/tan(theta)."""
    L, mu = sp.symbols("L mu", positive=True)
    half = sp.Symbol("half", positive=True)
    weight = mu + k * (1 - mu)
    return [
        sp.simplify((mu * (1 + L) - 1) / (1 - mu) - (mu * L / (1 - mu) - 1)),
        sp.simplify((mu * (1 + L) / weight - 1) * weight / (1 - mu) - (mu * L / (1 - mu) - k)),
        sp.cos(2 * half) / (1 - sp.cos(2 * half)) - sp.cot(half) / sp.tan(2 * half),
    ]


BOX = {"alpha": (SMOOTHEST, ROUGHEST), "degrees": (STEEPEST, FLATTEST)}

implicit_beckmann = Equation(
    key="validation.table2.implicit_beckmann",
    title="Implicit masking over Beckmann shows too little from every side",
    symbol=visible_fraction("implicit", "Beckmann"),
    equals=sp.Integer(1),
    relation="<",
    proof=_box_steps,
    proved_by="sympy: the difference over 1 - cos theta_o in terms of a Lambda(a); its sign by balls over the whole box",
    enclosed=lambda it: [enclosures.over(_implicit_box, **BOX)],
    slides=(58,),
    cite="hoffman2010",
    note="The difference is divided by 1 - cos theta_o, so that its sign can be told close to normal incidence, where it is 0.",
)
schlick_beckmann = Equation(
    key="validation.table2.schlick_smith_beckmann",
    title="Schlick-Smith over Beckmann shows too little from every side",
    symbol=visible_fraction("Schlick", "Beckmann"),
    equals=sp.Integer(1),
    relation="<",
    proof=_box_steps,
    proved_by="sympy: the difference over 1 - cos theta_o in terms of a Lambda(a); its sign by balls over the whole box",
    enclosed=lambda it: [enclosures.over(_schlick_box, **BOX)],
    slides=(58,),
    cite="schlick1994",
    note="For k = alpha sqrt(2/pi). The difference is divided by alpha (1 - cos theta_o) G_1/cos theta_o, which is positive.",
)
