"""Mirror facets: where light goes, and how a density of normals becomes a density of directions."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.notation import G1, D, ih, mu_o, om, raw
from microfacet.statement import Equation
from microfacet.visibility.masking import MODELS

m_vector, o_vector = raw("m_vector", r"\omega_m"), raw("o_vector", r"\omega_o")
i_vector, h_vector = raw("i_vector", r"\omega_i"), raw("h_vector", r"\omega_h")
D_visible = raw("D_visible_at_m", r"D_{\omega_o}(\omega_m)", positive=True)


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
    jacobian = Equation(
        key="material.reflection.jacobian",
        title="solid angle of half vectors per solid angle of light",
        symbol=raw("dh_di", r"\left| \frac{\partial \omega_h}{\partial \omega_i} \right|"),
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
        symbol=raw("p_i", r"p_{\omega_o}(\omega_i)"),
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
        symbol=raw("weak_furnace", r"\int_{\Omega} \frac{G_1(\omega_o, \omega_h) D(\omega_h)}{4 \cos \theta_o} \, d\omega_i"),
        equals=sp.Integer(1),
        enclosed=MODELS,
        slides=(46,),
        cite="heitz2014",
        note="Over the whole sphere of light directions: reflections that go down still count here.",
    )
