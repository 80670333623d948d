"""The BRDF of GGX in Smith's model as one formula in the sum of both directions: neither the half vector's length nor a
cosine is divided out, and roughness is inverted once for all rows, so that two divisions and two roots remain."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.geometry import ggx
from microfacet.geometry.ggx import ROUGHNESS, lobe
from microfacet.statements.notation import Lambda_i, Lambda_o, a, alpha_x, alpha_y, chi, mu_i, mu_o, printed_symbol, wi, wm, wo
from microfacet.statements.statement import Equation
from microfacet.visibility import shadowing

x_h, y_h, z_h = sp.symbols("x_h y_h z_h", real=True)  # the sum of both directions
reach_o, reach_i = printed_symbol("reach_o", "r_o", positive=True), printed_symbol("reach_i", "r_i", positive=True)


def _reach(direction: Any) -> sp.Expr:
    return sp.sqrt(alpha_x**2 * direction.x**2 + alpha_y**2 * direction.y**2 + direction.z**2)


with sp.evaluate(False):
    _PRINTED = (x_h**2 + y_h**2 + z_h**2) ** 2 / (
        2
        * sp.pi
        * alpha_x
        * alpha_y
        * (x_h**2 / alpha_x**2 + y_h**2 / alpha_y**2 + z_h**2) ** 2
        * (wo.z * reach_i + wi.z * reach_o)
    )
_SUM = {x_h: wo.x + wi.x, y_h: wo.y + wi.y, z_h: wo.z + wi.z}
_REACHES = {reach_o: _reach(wo), reach_i: _reach(wi)}


def _steps(it: Equation) -> list[Any]:
    """D at the sum over its length; Lambda by the reach; G2 over the cosines; their product."""
    length, reach, z = sp.symbols("length reach z", positive=True)
    squared = x_h**2 + y_h**2 + z_h**2
    unit = {wm.x: x_h / length, wm.y: y_h / length, wm.z: z_h / length}
    D = ggx.D.computed_as.doit().subs(chi(wm.z), 1).subs(unit)
    stretched = (x_h**2 / alpha_x**2 + y_h**2 / alpha_y**2 + z_h**2) ** 2
    by_reach = (reach / z - 1) / 2
    Lambda = ggx.Lambda.equals.doit().subs(a, z / sp.sqrt(reach**2 - z**2))
    known = {Lambda_o: by_reach.subs({reach: reach_o, z: mu_o}), Lambda_i: by_reach.subs({reach: reach_i, z: mu_i})}
    visible = shadowing.height.equals.doit().subs(known) / (4 * mu_o * mu_i)
    return [
        D - length**4 / (sp.pi * alpha_x * alpha_y * stretched),
        Lambda - by_reach,
        visible - 1 / (2 * (mu_o * reach_i + mu_i * reach_o)),
        it.equals.doit() - squared**2 / (2 * sp.pi * alpha_x * alpha_y * stretched * (wo.z * reach_i + wi.z * reach_o)),
    ]


joined = Equation(
    key="brdf.microfacet.ggx",
    title="the BRDF of GGX for F = 1, height-correlated, in one fraction",
    symbol=printed_symbol("rho_ggx", r"\rho(\omega_o, \omega_i)"),
    equals=_PRINTED,
    computed_as=_PRINTED.subs({**_SUM, **_REACHES}),
    rewrite_proof=list,
    computed_by=lobe,
    where={**_SUM, **_REACHES},
    within=(24, 24),
    over={wo: "hemisphere", wi: "hemisphere", alpha_x: ROUGHNESS, alpha_y: ROUGHNESS},
    proof=_steps,
    proved_by="sympy: D, Lambda and G2 put in one after another",
    slides=(51, 52),
    cite="heitz2014",
    note="x, y, z with index h: the sum of both directions, whose length cancels.",
)
