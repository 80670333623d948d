"""Table 2 of the talk, its ticks: under Smith's model and V-cavities the visible area is right, for three distributions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy as sp

from microfacet.geometry import blinn_phong
from microfacet.statements import enclosures
from microfacet.statements.ball_functions import constant
from microfacet.statements.balls import Ball, ball
from microfacet.statements.enclosures import Enclosure
from microfacet.statements.notation import Lambda_o, q, theta_o
from microfacet.statements.statement import Equation
from microfacet.validation.slopes_along_view import (
    BECKMANN,
    GGX,
    STUDENT,
    STUDENT_NORM,
    Slopes,
    radians,
    tan_o,
    visible_fraction,
)


def smith_residual(slopes: Slopes, shape: Ball, degrees: Ball) -> Ball:
    """Visible area by Smith's masking of the facets that face the viewer, over the true value, less 1."""
    tangent = radians(degrees).tan()
    edge = slopes.edge(shape, tangent).min(constant(slopes.end))
    facing = slopes.integral(1, -tangent, shape, -constant(slopes.end), edge) + slopes.missing(shape, tangent)
    return facing / (1 + slopes.Lambda(shape, tangent)) - 1


def cavity_residual(slopes: Slopes, shape: Ball, degrees: Ball) -> Ball:
    """V-cavities leave 1 - q tan theta_o of a facet visible, but at most 2, which masks it where q < -cot theta_o."""
    tangent = radians(degrees).tan()
    edge, end = slopes.edge(shape, tangent).min(constant(slopes.end)), constant(slopes.end)
    free = slopes.integral(1, -tangent, shape, -edge, edge)
    masked = slopes.integral(2, 0, shape, -end, -edge)
    return free + masked + 2 * slopes.missing(shape, ball(0)) - 1


def _enclosed(residual: Callable[[Slopes, Ball, Ball], Ball], slopes: Slopes) -> list[Enclosure]:
    return enclosures.at(lambda **point: residual(slopes, point[str(slopes.shape)], point["degrees"]), slopes.points)


def deviation(masking: str, over: str) -> sp.Expr:
    """The deviation of that from 1."""
    with sp.evaluate(False):
        return visible_fraction(masking, over) - 1


def _facing(P2: sp.Expr) -> sp.Expr:
    """Visible area by Smith's masking of the facets that face the viewer."""
    with sp.evaluate(False):
        return sp.Integral((1 - q * sp.tan(theta_o)) * P2, (q, -sp.oo, sp.cot(theta_o))) / (1 + Lambda_o)


def _free_and_cut(P2: sp.Expr) -> sp.Expr:
    """Visible area by V-cavities: facets of small slope whole, those of large slope with twice their projected area."""
    free, cut = (-sp.cot(theta_o), sp.cot(theta_o)), (-sp.oo, -sp.cot(theta_o))
    with sp.evaluate(False):
        return 2 * sp.Integral(P2, (q, *cut)) + sp.Integral((1 - q * sp.tan(theta_o)) * P2, (q, *free))


def _smith_steps(slopes: Slopes) -> list[Any]:
    """Beyond the edge -(1 - q tan) is tan (q - cot), which is Lambda's integrand; below it, 1 - q tan averages to 1."""
    return [*slopes.steps(), -(1 - q * tan_o) - tan_o * (q - 1 / tan_o)]


def _cavity_steps(slopes: Slopes) -> list[Any]:
    """A slope and its opposite together show 2: each is unmasked, or one shows 2 and the other 0."""
    return [*slopes.steps(), (1 - q * tan_o) + (1 + q * tan_o) - 2]


def _smith(key: str, over: str, slopes: Slopes) -> Equation:
    return Equation(
        key=key,
        title=f"Smith over {over}: what is seen is what there is to see",
        symbol=visible_fraction("Smith", over),
        means=_facing(slopes.printed),
        equals=sp.Integer(1),
        where={blinn_phong.K: STUDENT_NORM, Lambda_o: slopes.hidden},
        proof=lambda it: [*_smith_steps(slopes), it.means - _facing(slopes.printed), it.equals - 1],
        proved_by="sympy: the hidden part is Lambda's integral; the slopes are even, and their density is of norm 1",
        enclosed=lambda it: _enclosed(smith_residual, slopes),
        slides=(39, 40, 58),
        cite="heitz2014",
    )


def _cavity(key: str, over: str, slopes: Slopes) -> Equation:
    return Equation(
        key=key,
        title=f"V-cavities over {over}: what is seen is what there is to see",
        symbol=visible_fraction("V", over),
        means=_free_and_cut(slopes.printed),
        equals=sp.Integer(1),
        where={blinn_phong.K: STUDENT_NORM},
        proof=lambda it: [*_cavity_steps(slopes), it.means - _free_and_cut(slopes.printed), it.equals - 1],
        proved_by="sympy: a slope and its opposite together show 2; the slopes are even, and their density is of norm 1",
        enclosed=lambda it: _enclosed(cavity_residual, slopes),
        slides=(39, 40, 58),
        cite="cook1982; heitz2014",
    )


PHONG_LABEL = "normalised Blinn-Phong"

_smith(
    key="validation.table2.smith_beckmann",
    over="Beckmann",
    slopes=BECKMANN,
)
_smith(
    key="validation.table2.smith_ggx",
    over="GGX",
    slopes=GGX,
)
_smith(
    key="validation.table2.smith_normalized_blinn_phong",
    over=PHONG_LABEL,
    slopes=STUDENT,
)
_cavity(
    key="validation.table2.v_cavity_beckmann",
    over="Beckmann",
    slopes=BECKMANN,
)
_cavity(
    key="validation.table2.v_cavity_ggx",
    over="GGX",
    slopes=GGX,
)
_cavity(
    key="validation.table2.v_cavity_normalized_blinn_phong",
    over=PHONG_LABEL,
    slopes=STUDENT,
)
