"""Table 1 of the talk, its crosses: distributions whose projected area is not 1."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.geometry import beckmann, blinn_phong, ward
from microfacet.geometry.slopes import normals_integral
from microfacet.statements import ball_functions, balls, enclosures
from microfacet.statements.balls import Ball, ball
from microfacet.statements.enclosures import Enclosure
from microfacet.statements.notation import n, wm
from microfacet.statements.statement import Equation
from microfacet.validation.slopes_along_view import POWERS, ball_function

projected = normals_integral(r"\left( \omega_m \cdot \omega_g \right) D(\omega_m)")

with sp.evaluate(False):
    _PHONG = 2 * sp.pi / (n + 2) - 1
    phong = Equation(
        key="validation.table1.blinn_phong",
        title="by how much Blinn-Phong misses its projected area",
        symbol=projected - 1,
        means=_PHONG,
        equals=(2 * sp.pi - 2 - n) / (n + 2),
        enclosed=lambda it: _phong_enclosed(it.equals),
        slides=(35, 36, 55),
        cite="blinn1977",
        note="Too much below n = 2 pi - 2, right there, too little above.",
    )


def _phong_enclosed(closed: sp.Expr) -> list[Enclosure]:
    """Integral minus closed form, at exponents down to 0.5 and up to 10^4, and at the one that passes."""
    area = ball_functions.evaluator(blinn_phong.cosine_power, (n,))
    excess = ball_functions.evaluator(closed, (n,))
    with balls.precision(enclosures.ENCLOSING):
        exponents = [*(ball(e) for e in POWERS), 2 * balls.pi() - 2]
    return enclosures.at(lambda n: area(n) - 1 - excess(n), [{"n": e} for e in exponents])


def _ward_steps() -> list[Any]:
    """Ward's D is Beckmann's times cos^4, which is below 1 except at the pole; and Beckmann's integral is 1."""
    return [ward.D.equals.doit() - beckmann.D.equals.doit() * sp.cos(wm.theta) ** 4]


ward_area = Equation(
    key="validation.table1.ward",
    title="Ward's facets never project to the whole surface",
    symbol=projected,
    equals=sp.Integer(1),
    relation="<",
    proof=_ward_steps,
    proved_by="sympy: Ward is Beckmann times the fourth power of the cosine",
    enclosed=lambda it: [enclosures.over(_ward_residual, alpha=(0.05, 1))],
    slides=(35, 36, 55),
    cite="ward1992",
    note="For every roughness, isotropic or not; the enclosure says by how much, for alpha between 0.05 and 1.",
)


def _ward_residual(alpha: Ball) -> Ball:
    """x e^x E_2(x), x = 1/alpha^2, is the integral of e^(-s)/(1 + s/x)^2 over s > 0 and rises with x: its ends suffice."""
    area = ball_function(ward.projected_area, sp.Symbol("alpha", positive=True))
    return area(alpha.lower()).union(area(alpha.upper())) - 1
