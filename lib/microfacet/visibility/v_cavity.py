"""V-cavities (Cook and Torrance): each facet stands opposite its mirror image, and they mask each other."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.notation import chi, gm, im, mu_i, mu_o, om, raw
from microfacet.statement import Equation
from microfacet.visibility.masking import Masking, nothing

opposite = sp.Symbol("opposite", real=True)  # wo.wm' for the facet on the other side of the cavity


def _cavity_steps() -> list[Any]:
    """A cavity of two facets, normals m and m' mirrored at z, each of area 1/(2 m_z).

    The opening projects to cos_o. Both project to (wo.wm + wo.wm')/(2 m_z) = cos_o: nothing is masked while both are turned
    to the viewer. If m' is turned away, only m is seen, and of its projected area wo.wm/(2 m_z) only cos_o is left.
    """
    theta, angle = sp.symbols("theta angle", real=True)
    towards = sp.cos(theta - angle)  # viewer at theta, facet tilted by angle, in the plane of the cavity
    away = sp.cos(theta + angle)
    share = 2 * sp.cos(angle) * sp.cos(theta) / towards
    return [
        (towards + away) / (2 * sp.cos(angle)) - sp.cos(theta),
        share * towards / (2 * sp.cos(angle)) - sp.cos(theta),
    ]


with sp.evaluate(False):
    G1 = Equation(
        key="visibility.v_cavity.G1",
        title="masking in a V-cavity",
        symbol=raw("G1_v_cavity", r"G_1(\omega_o, \omega_m)"),
        equals=chi(om) * sp.Min(1, 2 * gm * mu_o / om),
        over={om: (1e-6, 1), gm: (0, 1), mu_o: (1e-8, 1)},
        proof=_cavity_steps,
        proved_by="sympy: projected areas of the two facets of one cavity",
        slides=(58,),
        cite="cook1982; heitz2014",
        note="Needs a distribution with D(theta, phi) = D(theta, phi + pi): every facet has its opposite.",
    )
    G2 = Equation(
        key="brdf.v_cavity.G2",
        title="masking and shadowing in a V-cavity",
        symbol=raw("G2_v_cavity", r"G_2(\omega_o, \omega_i, \omega_m)"),
        equals=chi(om) * chi(im) * sp.Min(1, 2 * gm * mu_o / om, 2 * gm * mu_i / im),
        over={om: (1e-6, 1), im: (1e-6, 1), gm: (0, 1), mu_o: (1e-8, 1), mu_i: (1e-8, 1)},
        slides=(49, 50, 58),
        cite="cook1982",
    )

cavity_G1, cavity_G2 = G1.scalar, G2.scalar


def masked(view: float, ox: float, oy: float, oz: float, mx: float, my: float, mz: float, p: Any) -> float:
    cosine = ox * mx + oy * my + oz * mz
    return cavity_G1(cosine, mz, oz) if cosine > 0.0 and mz > 0.0 else 0.0


def shadowed(
    view: float,
    light: float,
    ox: float,
    oy: float,
    oz: float,
    ix: float,
    iy: float,
    iz: float,
    mx: float,
    my: float,
    mz: float,
    p: Any,
) -> float:
    return cavity_G2(ox * mx + oy * my + oz * mz, ix * mx + iy * my + iz * mz, mz, oz, iz) if mz > 0.0 else 0.0


class VCavity(Masking):
    """V-cavities over a distribution with opposite facets, D(theta, phi) = D(theta, phi + pi). cook1982."""

    view_kernel = staticmethod(nothing)
    masked_kernel = staticmethod(masked)
    shadowed_kernel = staticmethod(shadowed)
