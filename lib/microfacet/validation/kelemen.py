"""Table 2 of the talk, its crosses for Kelemen: the area of the facets that face the viewer is not right at other angles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy as sp

from microfacet.statements import balls, enclosures
from microfacet.statements.balls import Ball, ball
from microfacet.statements.enclosures import Enclosure
from microfacet.statements.notation import alpha
from microfacet.statements.statement import Equation
from microfacet.validation.slopes_along_view import HIGH, LOW, compiled_form, radians, visible_fraction, w

r, limit = sp.symbols("r limit", positive=True)  # length of a slope in units of alpha; the edge of visibility in the same units
azimuth = sp.Symbol("azimuth", real=True)
DIGITS_NEAR_1 = 12  # digits of an integral that must differ from 1
LAST_RADIUS = 6  # in units of alpha: Gaussian slopes beyond have less than 1e-15 of the area
_AREA = sp.sqrt(1 + alpha**2 * r**2) * 2 * r * sp.exp(-(r**2))
_RING = (
    sp.sqrt(sp.cos(azimuth) ** 2 + alpha**2 * limit**2)
    / (sp.cos(azimuth) ** 2 + limit**2) ** 2
    * 2
    * limit**2
    * sp.sin(azimuth)
)
_VISIBLE = {
    "beckmann_inside": sp.Integral(_AREA, (r, LOW, HIGH)),
    "beckmann_outside": sp.Integral(_AREA * (1 - sp.acos(limit / r) / sp.pi), (r, LOW, HIGH)),
    "ggx_inside": sp.Integral(2 * sp.sin(w) * sp.sqrt(sp.cos(w) ** 2 + alpha**2 * sp.sin(w) ** 2), (w, LOW, HIGH)),
    "ggx_outside": sp.Integral(_RING * (1 - azimuth / sp.pi), (azimuth, LOW, HIGH)),
}


def _visible(part: str, alpha_: Ball, reach: Ball, low: Any, high: Any) -> Ball:
    return compiled_form(_VISIBLE[part], alpha, limit, LOW, HIGH)(alpha_, reach, low, high)


def beckmann_visible_area(alpha: Ball, reach: Ball) -> Ball:
    """Area of the facets that face the viewer: all slopes below `reach`, and the fraction 1 - acos/pi of each ring beyond."""
    edge = reach.min(ball(LAST_RADIUS))
    rest = ball(-LAST_RADIUS * LAST_RADIUS).exp() * (1 + alpha * (LAST_RADIUS + 1))
    inside, outside = _visible("beckmann_inside", alpha, reach, 0, edge), ball(0)
    if edge < LAST_RADIUS:
        outside = _visible("beckmann_outside", alpha, reach, edge, LAST_RADIUS)
    return inside + outside + rest.union(0)


def ggx_visible_area(alpha: Ball, reach: Ball) -> Ball:
    """The same with r = tan w inside, r = reach/cos(azimuth) outside."""
    right_angle = balls.pi() / 2
    return _visible("ggx_inside", alpha, reach, 0, reach.atan()) + _visible("ggx_outside", alpha, reach, 0, right_angle)


def _kelemen_box(visible_area: Callable[[Ball, Ball], Ball], alpha: Ball, degrees: Ball) -> Ball:
    """Area grows with alpha, and its visible part falls with the angle and with the slopes' size: the ends bound it."""
    cotangent = 1 / radians(degrees).tan()
    with balls.precision(int(DIGITS_NEAR_1 * 3.33) + 20):
        least = visible_area(alpha.lower(), cotangent.lower() / alpha.upper())
        most = visible_area(alpha.upper(), cotangent.upper() / alpha.lower())
        return least.union(most) - 1


STEEP_ANGLES, GRAZING_ANGLES = (0.001, 45.0), (87.0, 89.999)  # degrees
KELEMEN_ROUGH = (0.1, 0.9)


def _cross(
    key: str, over: str, visible_area: Callable[[Ball, Ball], Ball], relation: str, angles: tuple[float, float]
) -> Equation:
    def enclosed(it: Equation) -> list[Enclosure]:
        def residual(alpha: Ball, degrees: Ball) -> Ball:
            return _kelemen_box(visible_area, alpha, degrees)

        return [enclosures.over(residual, alpha=KELEMEN_ROUGH, degrees=angles)]

    return Equation(
        key=key,
        title=f"Kelemen over {over} shows too {'much from above' if relation == '>' else 'little at grazing angles'}",
        symbol=visible_fraction("Kelemen", over),
        equals=sp.Integer(1),
        relation=relation,
        enclosed=enclosed,
        slides=(58,),
        cite="kelemen2001",
        note="What is seen is the area of the facets turned to the viewer. It falls with the angle: it is right at one.",
    )


_cross(
    key="validation.table2.kelemen_beckmann_above",
    over="Beckmann",
    visible_area=beckmann_visible_area,
    relation=">",
    angles=STEEP_ANGLES,
)
_cross(
    key="validation.table2.kelemen_beckmann_grazing",
    over="Beckmann",
    visible_area=beckmann_visible_area,
    relation="<",
    angles=GRAZING_ANGLES,
)
_cross(
    key="validation.table2.kelemen_ggx_above",
    over="GGX",
    visible_area=ggx_visible_area,
    relation=">",
    angles=STEEP_ANGLES,
)
_cross(
    key="validation.table2.kelemen_ggx_grazing",
    over="GGX",
    visible_area=ggx_visible_area,
    relation="<",
    angles=GRAZING_ANGLES,
)
