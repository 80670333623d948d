"""V-cavities (Cook and Torrance): each facet stands opposite its mirror image, and they mask each other."""

from __future__ import annotations

from typing import Any

import sympy as sp

from microfacet.compiler.kernels import Vector
from microfacet.statements.notation import chi, gm, im, mu_i, mu_o, om, printed_symbol, wm, wo
from microfacet.statements.proofs import residuals_of_forms
from microfacet.statements.statement import Equation
from microfacet.visibility.masking import Masking, ModelParameters

facing = printed_symbol("o_dot_m", r"\left( \omega_o \cdot \omega_m \right)", real=True)
opposite = printed_symbol("o_dot_opposite", r"\left( \omega_o \cdot \omega_m' \right)", real=True)
up, normal = printed_symbol("g_vector", r"\omega_g"), printed_symbol("m_vector", r"\omega_m")


def _vectors() -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """The view, a normal, and the normal of the other side, for any view and any normal."""
    o, m = sp.Matrix(wo.components), sp.Matrix(wm.components)
    z = sp.Matrix([0, 0, 1])
    return o, m, 2 * m.dot(z) * z - m


def _mirror_steps(it: Equation) -> list[Any]:
    """The other side has the same height over the plane, the opposite slopes, and the same length."""
    _, m, other = _vectors()
    printed = [it.equals.subs({gm: m[2], up: int(k == 2), normal: m[k]}) - other[k] for k in range(3)]
    return [*printed, other[2] - m[2], other[0] + m[0], other[1] + m[1], sp.expand(other.dot(other) - m.dot(m))]


def _opening_steps(it: Equation) -> list[Any]:
    """Each side covers half of the opening, so has the area 1/(2 m_z)."""
    _, m, other = _vectors()
    return [1 / (2 * m[2]) * m[2] + 1 / (2 * other[2]) * other[2] - 1, *residuals_of_forms(it, left=True)]


def _meanings() -> dict[sp.Symbol, sp.Expr]:
    """The products of vectors in components."""
    o, m, other = _vectors()
    return {facing: o.dot(m), opposite: o.dot(other), gm: m[2], mu_o: o[2]}


def _cavity_steps() -> list[Any]:
    """The fraction of one side that fills the opening alone; below 1 exactly where the other side is back-facing."""
    o, m, other = _vectors()
    fraction = one_side.doit().subs({gm: m[2], mu_o: o[2], om: o.dot(m)}, simultaneous=True)
    return [fraction * o.dot(m) / (2 * m[2]) - o[2], (fraction - 1) - o.dot(other) / o.dot(m)]


with sp.evaluate(False):
    one_side = 2 * gm * mu_o / om
    other_side = Equation(
        key="visibility.v_cavity.opposite",
        title="the normal of the other side of a V-cavity",
        symbol=printed_symbol("m_opposite", r"\omega_m'"),
        equals=2 * gm * up - normal,
        proof=_mirror_steps,
        proved_by="sympy: the same height, the opposite slopes",
        slides=(58,),
        cite="torrance1967; cook1982",
    )
    opening = Equation(
        key="visibility.v_cavity.opening",
        title="both sides of a V-cavity project to its opening",
        symbol=(facing + opposite) / (2 * gm),
        equals=mu_o,
        where=_meanings(),
        proof=_opening_steps,
        proved_by="sympy: vectors put in, for any view and any normal",
        slides=(39, 40, 58),
        cite="cook1982; heitz2014",
        note="Each side covers half of an opening of area 1.",
    )
    turning = Equation(
        key="visibility.v_cavity.share",
        title="the share of one side that fills the opening, and when it is below 1",
        symbol=2 * gm * mu_o / facing,
        equals=1 + opposite / facing,
        where=_meanings(),
        proof=lambda it: [*residuals_of_forms(it, left=True), *_cavity_steps()],
        proved_by="sympy: vectors put in, for any view and any normal",
        slides=(39, 40, 58),
        cite="cook1982; heitz2014",
        note="Below 1 just where the other side is turned away.",
    )
    G1 = Equation(
        key="visibility.v_cavity.G1",
        title="masking in a V-cavity",
        symbol=printed_symbol("G1_v_cavity", r"G_1(\omega_o, \omega_m)"),
        equals=chi(om) * sp.Min(1, one_side),
        over={om: (1e-6, 1), gm: (0, 1), mu_o: (1e-8, 1)},
        proof=lambda it: [it.equals - chi(om) * sp.Min(1, one_side), *_cavity_steps()],
        proved_by="sympy: projected areas of the two facets of one cavity",
        slides=(58,),
        cite="cook1982; heitz2014",
        note="Needs a distribution with D(theta, phi) = D(theta, phi + pi): every facet has its opposite.",
    )
    G2 = Equation(
        key="visibility.v_cavity.G2",
        title="masking and shadowing in a V-cavity",
        symbol=printed_symbol("G2_v_cavity", r"G_2(\omega_o, \omega_i, \omega_m)"),
        equals=chi(om) * chi(im) * sp.Min(1, 2 * gm * mu_o / om, 2 * gm * mu_i / im),
        over={om: (1e-6, 1), im: (1e-6, 1), gm: (0, 1), mu_o: (1e-8, 1), mu_i: (1e-8, 1)},
        slides=(49, 50, 58),
        cite="cook1982",
    )

cavity_G1, cavity_G2 = G1.scalar, G2.scalar


def kernel_G1(Lambda_o: float, om: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
    return cavity_G1(om, wm[2], wo[2]) if wm[2] > 0.0 else 0.0


def kernel_G2(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return cavity_G2(om, im, wm[2], wo[2], wi[2]) if wm[2] > 0.0 else 0.0


class VCavity(Masking):
    r"""Masking and shadowing of V-shaped cavities, each of two opposite microfacets.

    .. math:: G_2(\omega_o, \omega_i, \omega_m) = \min\left( 1,
              \frac{2 (\omega_m \cdot \omega_g)(\omega_o \cdot \omega_g)}{\omega_o \cdot \omega_m},
              \frac{2 (\omega_m \cdot \omega_g)(\omega_i \cdot \omega_g)}{\omega_i \cdot \omega_m} \right)

    for microfacets turned to both directions. Statements ``visibility.v_cavity.G1`` and ``visibility.v_cavity.G2``.

    Parameters
    ----------
    ndf : Distribution
        Distribution of normals with opposite microfacets: D does not change when the azimuth does by pi.
    own : tuple, optional
        Parameters that a subclass adds; none here.

    Raises
    ------
    ValueError
        If ndf is not a distribution.

    References
    ----------
    torrance1967; cook1982; heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> mf.validate(mf.VCavity(mf.Beckmann(0.3))).holds
    True
    """

    label, cite = "V-cavities", "cook1982"

    G1_kernel = staticmethod(kernel_G1)
    G2_kernel = staticmethod(kernel_G2)
