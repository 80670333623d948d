"""Mirror facets: where light goes, and how a density of normals becomes a density of directions."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.geometry import ggx
from microfacet.geometry.slopes import normals_integral
from microfacet.statements import enclosures
from microfacet.statements.notation import G1, D, a, alpha_x, alpha_y, chi, ih, mu_i, mu_o, om, printed_symbol, wm
from microfacet.statements.proofs import residuals_of_forms
from microfacet.statements.statement import Equation
from microfacet.visibility.masking import MODELS, visible_norm, visible_normals

m_vector, o_vector = printed_symbol("m_vector", r"\omega_m"), printed_symbol("o_vector", r"\omega_o")
i_vector, h_vector = printed_symbol("i_vector", r"\omega_i"), printed_symbol("h_vector", r"\omega_h")
D_visible = printed_symbol("D_visible_at_m", r"D_{\omega_o}(\omega_m)", positive=True)


def _mirror_steps() -> list[Any]:
    """For unit vectors: wi has length 1, and makes with wm the same angle as wo."""
    m, o = sp.Matrix(sp.symbols("m1:4", real=True)), sp.Matrix(sp.symbols("o1:4", real=True))
    unit = {m[2] ** 2: 1 - m[0] ** 2 - m[1] ** 2, o[2] ** 2: 1 - o[0] ** 2 - o[1] ** 2}
    i = 2 * o.dot(m) * m - o
    length, angle = sp.expand(i.dot(i) - 1), sp.expand(i.dot(m) - o.dot(m))
    return [_reduce(length, m, o, unit), _reduce(angle, m, o, unit)]


def _reduce(e: sp.Expr, m: sp.Matrix, o: sp.Matrix, unit: dict[sp.Expr, sp.Expr]) -> sp.Expr:
    """Remainder modulo |m| = 1 and |o| = 1."""
    return sp.reduced(e, [m.dot(m) - 1, o.dot(o) - 1], *m, *o)[1]


def _jacobian_steps() -> list[Any]:
    """With wo as the pole, wh lies at half the polar angle of wi and at the same azimuth."""
    angle = sp.Symbol("gamma", positive=True)
    per_light, per_half = sp.sin(angle), sp.sin(angle / 2) * sp.diff(angle / 2, angle)
    return [per_half / per_light - 1 / (4 * sp.cos(angle / 2))]


def _half_angle_steps(it: Equation) -> list[Any]:
    """Elements of solid angle at gamma/2 and at gamma; the azimuth is the same."""
    element = sp.sin(gamma / 2) * sp.diff(gamma / 2, gamma)
    return [element / sp.sin(gamma) - it.means.subs(it.where), *residuals_of_forms(it)]


def _furnace_steps(it: Equation) -> list[Any]:
    """Reflected directions, with d omega_i = 4 (wo.wm) d omega_m put in, are the visible normals."""
    stretch = 1 / jacobian.equals.doit().subs(ih, om)
    same = reflected.equals.doit() * stretch - visible_normals.equals.doit()
    return [same, it.means - visible_norm.symbol, it.equals - visible_norm.equals]


def _down_steps() -> list[Any]:
    """At alpha = 1: D is 1/pi, G1 is 2 mu/(1 + mu); so the density is constant wherever the half vector points up."""
    unit = {alpha_x: 1, alpha_y: 1, **wm.spherical}
    masked = 1 / (1 + ggx.Lambda.equals.doit().subs(a, mu_o / sp.sqrt(1 - mu_o**2)))
    density = reflected.equals.doit().subs({G1: 2 * mu_o / (1 + mu_o), D: 1 / sp.pi})
    return [
        ggx.D.computed_as.doit().subs(chi(wm.z), 1).subs(unit) - 1 / sp.pi,
        masked - 2 * mu_o / (1 + mu_o),
        density - 1 / (2 * sp.pi * (1 + mu_o)),
        1 - 2 * sp.pi / (2 * sp.pi * (1 + mu_o)) - mu_o / (1 + mu_o),
    ]


gamma = sp.Symbol("gamma", positive=True)  # between the view and the light
sin_half, cos_half = printed_symbol("sin_half", r"\sin\frac{\gamma}{2}"), printed_symbol("cos_half", r"\cos\frac{\gamma}{2}")

with sp.evaluate(False):
    mirror = Equation(
        key="material.reflection.mirror",
        title="the light that a mirror facet sends to the viewer comes from",
        symbol=i_vector,
        equals=2 * om * m_vector - o_vector,
        proof=_mirror_steps,
        proved_by="sympy: a unit vector at the same angle to the facet's normal",
        slides=(44, 45),
        cite="walter2007",
    )
    half_vector = Equation(
        key="material.reflection.half_vector",
        title="the one facet that joins two directions",
        symbol=h_vector,
        equals=(o_vector + i_vector) / sp.Abs(o_vector + i_vector),
        slides=(45, 46),
        cite="walter2007",
        note="Undefined for wi = -wo, which no facet joins; the library returns the zero vector there.",
    )
    half_angle = Equation(
        key="material.reflection.half_angle",
        title="solid angle around the view direction, at half the angle and at the whole",
        symbol=printed_symbol(
            "half_per_whole",
            r"\frac{\sin\frac{\gamma}{2} \, d\frac{\gamma}{2} \, d\varphi}{\sin\gamma \, d\gamma \, d\varphi}",
        ),
        means=sin_half / (2 * sp.sin(gamma)),
        equals=1 / (4 * cos_half),
        where={sin_half: sp.sin(gamma / 2), cos_half: sp.cos(gamma / 2)},
        proof=_half_angle_steps,
        proved_by="sympy: the element at half the angle, then the sine of the double angle",
        slides=(46,),
        cite="walter2007",
    )
    jacobian = Equation(
        key="material.reflection.jacobian",
        title="solid angle of half vectors per solid angle of light",
        symbol=printed_symbol("dh_di", r"\left| \frac{\partial \omega_h}{\partial \omega_i} \right|"),
        equals=1 / (4 * ih),
        over={ih: (1e-8, 1)},
        proof=_jacobian_steps,
        proved_by="sympy: spherical coordinates around the view direction",
        slides=(46,),
        cite="walter2007",
    )
    reflected = Equation(
        key="material.reflection.density",
        title="the distribution of reflected directions",
        symbol=printed_symbol("p_i", r"p_{\omega_o}(\omega_i)"),
        means=D_visible / (4 * om),
        equals=G1 * D / (4 * mu_o),
        over={G1: (0, 1), D: (1e-6, 1e6), mu_o: (1e-8, 1)},
        where={D_visible: G1 * om * D / mu_o},
        proved_by="sympy: the visible normals put in",
        slides=(45, 46),
        cite="heitz2014",
    )
    weak_furnace = Equation(
        key="material.reflection.weak_furnace",
        title="the weak white furnace: with perfect mirrors and no shadowing nothing is lost",
        symbol=printed_symbol(
            "weak_furnace", r"\int_{\Omega} \frac{G_1(\omega_o, \omega_h) D(\omega_h)}{4 \cos \theta_o} \, d\omega_i"
        ),
        means=normals_integral(r"D_{\omega_o}(\omega_m)"),
        equals=sp.Integer(1),
        proof=_furnace_steps,
        proved_by="sympy: by the Jacobian it is the norm of the visible normals",
        enclosed=MODELS,
        slides=(46,),
        cite="heitz2014",
        note="Over the whole sphere of light directions: reflections that go down still count here.",
    )
    down = Equation(
        key="material.reflection.down",
        title="what mirrors send down, for GGX at alpha = 1",
        symbol=printed_symbol("sent_down", r"1 - \int_{\Omega^{+}} p_{\omega_o}(\omega_i) \, d\omega_i"),
        means=1 - sp.Integral(1 / (1 + mu_o), (mu_i, 0, 1)),
        equals=mu_o / (1 + mu_o),
        proof=_down_steps,
        proved_by="sympy: D and G1 at alpha = 1 put in; the density does not depend on the light",
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (mu_o,), [(1e-6,), (0.3,), (1.0,)]),
        over={mu_o: (1e-8, 1)},
        slides=(46,),
        cite="dupuy2023",
        note="The upper hemisphere alone makes a right model look wrong by this much.",
    )
