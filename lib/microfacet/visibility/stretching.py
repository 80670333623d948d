"""Stretching: a surface of two roughnesses is an isotropic one, stretched. What was hidden stays hidden.

A prime marks the stretched surface: lengths along x are divided by alpha_x, along y by alpha_y, heights stay as they are.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.geometry import beckmann, ggx, slopes
from microfacet.statements import enclosures
from microfacet.statements.notation import (
    G1,
    P2,
    P22,
    D,
    Direction,
    alpha,
    alpha_x,
    alpha_y,
    chi,
    gm,
    mu_o,
    om,
    phi_o,
    printed_symbol,
    q,
    theta_o,
    wm,
    wo,
    x,
    y,
)
from microfacet.statements.notation import alpha_o as roughness_o
from microfacet.statements.proofs import residuals_of_forms, under_integral
from microfacet.statements.statement import Equation
from microfacet.visibility import masking, v_cavity

across = sp.Symbol("r", real=True)  # a slope across the view
turned_P22 = printed_symbol("P22_turned", r"P_{22}'(q \cos\phi_o - r \sin\phi_o, \, q \sin\phi_o + r \cos\phi_o)")
chained = printed_symbol("slope_by_chain", r"\frac{\partial}{\partial x} h(\alpha_x x, \alpha_y y)")
slope_before = printed_symbol("slope_before", r"\tilde{x}(\alpha_x x, \alpha_y y)")
facing_after = printed_symbol("facing_stretched", r"\frac{\omega_o' \cdot \omega_m'}{z_o' z_m'}")
facing_before = printed_symbol("facing_before", r"\frac{\omega_o \cdot \omega_m}{z_o z_m}")
leaning = printed_symbol("slope_over_sight", r"\frac{x_o \tilde{x} + y_o \tilde{y}}{z_o}")
masked_before = printed_symbol("G1_before", r"G_1(\omega_o, \omega_m)")
visible_after = printed_symbol("visible_after", r"D_{\omega_o'}'(\omega_m') \, d\omega_m'")
visible_before = printed_symbol("visible_before", r"D_{\omega_o}(\omega_m) \, d\omega_m")
STRETCHED_P22 = printed_symbol("P22_stretched", r"P_{22}'(\tilde{x}, \tilde{y})")
FAMILIES = (beckmann, ggx)
ALONG = sp.cos(phi_o) ** 2 * alpha_x**2 + sp.sin(phi_o) ** 2 * alpha_y**2  # alpha_o squared
GGX_REACH = sp.Integer(10) ** 10  # in units of alpha_x alpha_y/alpha_o across the view
POINTS = [(0.0, 2.0, 0.5, 2.0), (0.75, 0.3, 0.5, 0.05), (0.75, 2.0, 2.0, 0.5)]

sight = tuple(printed_symbol(f"{part}_sight", rf"{part}_o'", real=True) for part in "xyz")
length = sp.Symbol("length", positive=True)

# --- the map ----------------------------------------------------------------------------------------------------------


def moved_direction(w: Direction) -> sp.Matrix:
    """Along which the line of this direction runs after stretching; not of unit length."""
    return sp.Matrix([w.x / alpha_x, w.y / alpha_y, w.z])


def moved_normal(w: Direction) -> sp.Matrix:
    """Along which the facet of this normal points after stretching; not of unit length."""
    return sp.Matrix([alpha_x * w.x, alpha_y * w.y, w.z])


def moved_slopes() -> dict[sp.Symbol, sp.Expr]:
    """The slopes after stretching, as functions of those before."""
    return {x: alpha_x * x, y: alpha_y * y}


def _chain_steps(it: Equation) -> list[Any]:
    """Of any height field: the derivative of the stretched one, and the slope before at the place that came there."""
    first, second = sp.symbols("first second", real=True)
    h = sp.Function("h")
    there = {first: alpha_x * first, second: alpha_y * second}
    before = sp.diff(h(first, second), first).subs(there, simultaneous=True)
    return [it.means.subs(chained, sp.diff(h(alpha_x * first, alpha_y * second), first)) - it.equals.subs(slope_before, before)]


def _density_steps(it: Equation) -> list[Any]:
    """The area that slopes are spread over grows by the Jacobian; Beckmann and GGX are stretched from their unit forms."""
    spread = sp.Matrix([alpha_x * x, alpha_y * y]).jacobian([x, y]).det()
    forms = [family.P22.equals.doit() for family in FAMILIES]
    units = [form.subs({alpha_x: 1, alpha_y: 1}) for form in forms]
    printed = [it.equals.replace(P22, lambda a, b, unit=unit: unit.subs({x: a, y: b}, simultaneous=True)) for unit in units]
    return [spread - alpha_x * alpha_y, *(form - stated for form, stated in zip(forms, printed, strict=True))]


def _tangent_steps() -> list[Any]:
    """What lies in the facet before lies in it after: the moved normal is at right angles to every moved tangent."""
    tangent = sp.Matrix(sp.symbols("t1:4", real=True))
    moved = sp.Matrix([tangent[0] / alpha_x, tangent[1] / alpha_y, tangent[2]])
    m = moved_normal(wm)
    return [
        m.dot(moved) - sp.Matrix(wm.components).dot(tangent),
        -m[0] / m[2] - alpha_x * (-wm.x / wm.z),
        -m[1] / m[2] - alpha_y * (-wm.y / wm.z),
    ]


def facing(o: sp.Matrix, m: sp.Matrix) -> sp.Expr:
    """wo.wm over both heights: how far a facet is turned to the viewer, per area of the plane and of the view."""
    return o.dot(m) / (o[2] * m[2])


def _facing_meanings() -> dict[sp.Symbol, sp.Expr]:
    """Lengths cancel, so the moved vectors need not be unit vectors."""
    o, m = sp.Matrix(wo.components), sp.Matrix(wm.components)
    a, b = sp.symbols("a b", positive=True)
    lean = (wo.x * (-wm.x / wm.z) + wo.y * (-wm.y / wm.z)) / wo.z
    return {facing_after: facing(moved_direction(wo) / a, moved_normal(wm) / b), facing_before: facing(o, m), leaning: lean}


def _cavity_steps() -> list[Any]:
    """The stated G1 depends on one quotient, which is 2/facing. (Where facets face away, facing is negative in both.)"""
    o, m = sp.Matrix(wo.components), sp.Matrix(wm.components)
    a, b = sp.symbols("a b", positive=True)
    before, after = (_cavity_share(*pair) for pair in ((o, m), (moved_direction(wo) / a, moved_normal(wm) / b)))
    stated = chi(om) * sp.Min(1, v_cavity.one_side.doit())
    return [v_cavity.G1.equals.doit() - stated, after - before, before - 2 / facing(o, m)]


def _cavity_share(o: sp.Matrix, m: sp.Matrix) -> sp.Expr:
    return v_cavity.one_side.doit().subs({gm: m[2], mu_o: o[2], om: o.dot(m)}, simultaneous=True)


def _centre() -> sp.Expr:
    """The slope across the view around which those are centred that go with q along it."""
    return sp.sin(phi_o) * sp.cos(phi_o) * (alpha_y**2 - alpha_x**2) / roughness_o**2 * q


def _square_steps() -> list[Any]:
    """Completing the square: what is left is q over alpha_o and, across, a slope over alpha_x alpha_y/alpha_o."""
    here = turned(_centre() + alpha_x * alpha_y / roughness_o * across)
    gap = (here[x] / alpha_x) ** 2 + (here[y] / alpha_y) ** 2 - (q / roughness_o) ** 2 - across**2
    powers = sp.Poly(sp.expand(gap * roughness_o**4), roughness_o).terms()
    return [sum(factor * ALONG ** (k // 2) * roughness_o ** (k % 2) for (k,), factor in powers)]


def _marginal_steps() -> list[Any]:
    """After that the integral across is that of the unit form at q/alpha_o; P2 of any roughness is it, scaled."""
    steps = _square_steps()
    unit, there = {alpha_x: 1, alpha_y: 1, alpha: 1}, {q: q / roughness_o}
    for family in FAMILIES:
        hill = family.P22.equals.doit().subs(unit).subs({x: q / roughness_o, y: across}, simultaneous=True)
        ridge = family.P2.means.function.doit().subs(unit).subs({**there, y: across}, simultaneous=True)
        scaled = family.P2.equals.doit().subs(unit).subs(there) / roughness_o
        steps += [hill - ridge, scaled - family.P2.equals.doit().subs(alpha, roughness_o)]
    return steps


def turned(aside: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
    """The slopes along x and y of a facet with slope q along the view and the given one across it."""
    c, s = sp.cos(phi_o), sp.sin(phi_o)
    return {x: c * q - s * aside, y: s * q + c * aside}


def _marginal_enclosed(it: Equation) -> list[enclosures.Enclosure]:
    """Both families: the integral over the slope across, in pairs around its centre, against P2 of roughness alpha_o."""
    rho = sp.Symbol("rho", positive=True)
    found = []
    for family, reach, tail in (
        (beckmann, beckmann.SLOPE_LIMIT, sp.exp(-(beckmann.SLOPE_LIMIT**2))),
        (ggx, GGX_REACH, _ggx_tail()),
    ):
        unit = family.P2.equals.doit().subs(alpha, 1).subs(q, q / roughness_o)
        hill, closed = family.P22.equals.doit(), it.equals.subs(P2(q / roughness_o), unit)
        pair = sum(hill.subs(turned(_centre() + sign * rho), simultaneous=True) for sign in (1, -1))
        cut = reach * alpha_x * alpha_y / roughness_o
        form = under_integral(it, enclosures.truncated(sp.Integral(pair, (rho, 0, sp.oo)), cut, closed * tail))
        put = {roughness_o: sp.sqrt(ALONG)}
        found += enclosures.agreement(form.subs(put), closed.subs(put), (q, phi_o, alpha_x, alpha_y), POINTS)
    return found


def _ggx_tail() -> sp.Expr:
    """Beyond the reach GGX is below a fourth power: 4/(3 pi reach^3) of what P2(0) is to P2(q)."""
    return 4 * (1 + (q / roughness_o) ** 2) ** sp.Rational(3, 2) / (3 * sp.pi * GGX_REACH**3)


def _visible_steps(it: Equation) -> list[Any]:
    """In slopes visible normals are G1 times facing times P22, of which only P22 changes, and its spread undoes that."""
    f = sp.Symbol("facing", positive=True)
    per_slopes = masking.visible_normals.equals.doit() * slopes.solid_angle.computed_as
    before = per_slopes.subs({D: P22(x, y) / wm.z**4, om: f * mu_o * wm.z})
    spread = slopes.stretched(P22).subs(moved_slopes(), simultaneous=True).doit() * alpha_x * alpha_y
    put_in = {visible_after: G1 * f * spread, visible_before: before}
    return [(it.symbol - it.equals).subs(put_in)]


def _sight_steps(it: Equation) -> list[Any]:
    """The view in polar angles, with its sine a positive number."""
    sine, cosine = sp.symbols("sine cosine", positive=True)
    view = {wo.x: sine * sp.cos(phi_o), wo.y: sine * sp.sin(phi_o), wo.z: cosine}
    along = sp.sqrt((alpha_x * sp.cos(phi_o)) ** 2 + (alpha_y * sp.sin(phi_o)) ** 2)
    quotient = it.means.subs(view) / it.equals.subs({sp.tan(theta_o): sine / cosine, roughness_o: along})
    return [sp.simplify(quotient) - 1]


with sp.evaluate(False):
    slope = Equation(
        key="visibility.stretching.slope",
        title="the slope of a stretched surface",
        symbol=printed_symbol("slope_stretched", r"\tilde{x}'(x, y)"),
        means=chained,
        equals=alpha_x * slope_before,
        proof=_chain_steps,
        proved_by="sympy: the chain rule, for any height field",
        slides=(64, 65, 66),
        cite="heitz2014",
    )
    density = Equation(
        key="visibility.stretching.P22",
        title="the distribution of slopes of a stretched surface",
        symbol=STRETCHED_P22,
        equals=slopes.stretched(P22),
        proof=_density_steps,
        proved_by="sympy: Jacobian of the map of slopes; Beckmann and GGX are stretched from their unit forms",
        slides=(65, 66, 67),
        cite="heitz2014",
    )
    turned_towards = Equation(
        key="visibility.stretching.facing",
        title="how far a facet is turned to the viewer does not change by stretching",
        symbol=facing_after,
        means=facing_before,
        equals=1 - leaning,
        where=_facing_meanings(),
        proof=lambda it: [*_tangent_steps(), *residuals_of_forms(it, left=True)],
        proved_by="sympy: tangents go with the map and normals against it; then the quotient in components",
        slides=(68, 69),
        cite="heitz2014",
    )
    argument = Equation(
        key="visibility.stretching.a",
        title="Smith's masking does not change by stretching",
        symbol=printed_symbol("a_stretched", r"a'"),
        means=sight[2] / sp.sqrt((alpha_x * sight[0]) ** 2 + (alpha_y * sight[1]) ** 2),
        equals=wo.z / sp.sqrt(wo.x**2 + wo.y**2),
        where={part: moved / length for part, moved in zip(sight, moved_direction(wo), strict=True)},
        proved_by="sympy: the moved view direction put in",
        slides=(68, 70, 71),
        cite="heitz2014",
    )
    cavity = Equation(
        key="visibility.stretching.v_cavity",
        title="the masking of V-cavities does not change by stretching",
        symbol=printed_symbol("G1_stretched", r"G_1(\omega_o', \omega_m')"),
        equals=masked_before,
        proof=lambda it: [*_cavity_steps(), it.equals - masked_before],
        proved_by="sympy: G1 depends on 2/facing only",
        slides=(68,),
        cite="heitz2014",
    )
    visible = Equation(
        key="visibility.stretching.visible_normals",
        title="stretching moves visible normals and does not change their shares",
        symbol=visible_after,
        equals=visible_before,
        proof=_visible_steps,
        proved_by="sympy: in slopes, G1 times facing times P22; the first two do not change, the last is spread by the map",
        slides=(69,),
        cite="heitz2014",
        note="For any masking function that is the same before and after, such as Smith's and that of V-cavities.",
    )
    unstretched = Equation(
        key="visibility.stretching.sight",
        title="slope of the line of sight after unstretching",
        symbol=printed_symbol("cot_unstretched", r"\cot \theta"),
        means=wo.z / sp.sqrt((alpha_x * wo.x) ** 2 + (alpha_y * wo.y) ** 2),
        equals=1 / (roughness_o * sp.tan(theta_o)),
        proof=_sight_steps,
        proved_by="sympy: the view in polar angles",
        slides=(70, 71),
        cite="heitz2014",
    )
    marginal = Equation(
        key="visibility.stretching.P2",
        title="slopes along the view are those of an isotropic surface of roughness alpha_o",
        symbol=printed_symbol("P2_stretched", r"P_2'(q)"),
        means=sp.Integral(turned_P22, (across, -sp.oo, sp.oo)),
        equals=P2(q / roughness_o) / roughness_o,
        where={
            turned_P22: ggx.P22.equals.doit().subs(turned(across), simultaneous=True),
            P2(q / roughness_o): ggx.P2.equals.doit().subs({q: q / roughness_o, alpha: 1}, simultaneous=True),
            roughness_o: sp.sqrt(ALONG),
        },
        proof=_marginal_steps,
        proved_by="sympy: the square completed, for any round hill; Beckmann and GGX put in",
        enclosed=lambda it: _marginal_enclosed(it),
        slides=(70, 71),
        cite="heitz2014",
        note="P_2 is that of unit roughness.",
    )
