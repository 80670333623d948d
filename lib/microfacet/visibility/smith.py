"""Smith: a facet's masking does not depend on its normal; it follows from the distribution by conserving projected area."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import asinh, atan, atan2, cos, cosh, pi, sinh, sqrt, tan
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.compiler.kernels import ByPrecision, Pair, Vector
from microfacet.directions import one_of, vectors
from microfacet.geometry import beckmann, ggx
from microfacet.geometry.ggx import ROUGHNESS
from microfacet.geometry.roughness import SlopeScale
from microfacet.geometry.slopes import Distribution, lambda_batch
from microfacet.geometry.ward import Ward
from microfacet.statements import enclosures
from microfacet.statements.notation import (
    P2,
    Lambda_o,
    alpha,
    alpha_x,
    alpha_y,
    chi,
    mu_o,
    om,
    printed_symbol,
    q,
    theta_o,
    u,
    v,
    wo,
    y,
)
from microfacet.statements.notation import alpha_o as roughness_o
from microfacet.statements.proofs import residuals_of_forms
from microfacet.statements.statement import Equation
from microfacet.visibility import shadowing
from microfacet.visibility.hidden import Panelled, panels_Lambda, table_of
from microfacet.visibility.masking import Masking, ModelParameters, dot, hidden, seen
from microfacet.visibility.quadrature import (
    EXPONENTIAL_LEVELS,
    NODES,
    POWER_LEVELS,
    STARTS,
    WEIGHTS,
    has_exponential_tails,
    integrate_adaptively,
)

HALF = sp.Rational(1, 2)
CORRELATIONS = ("height", "none", "direction", "height-direction")

# --- statements ---------------------------------------------------------------------------------------------------

with sp.evaluate(False):
    alpha_o = Equation(
        key="visibility.smith.alpha_o",
        title="roughness along the view direction",
        symbol=sp.Symbol("alpha_o"),
        equals=sp.sqrt(sp.cos(wo.phi) ** 2 * alpha_x**2 + sp.sin(wo.phi) ** 2 * alpha_y**2),
        computed_as=sp.sqrt((alpha_x * wo.x) ** 2 + (alpha_y * wo.y) ** 2) / sp.sqrt(wo.x**2 + wo.y**2),
        where=wo.spherical,
        over={wo: "hemisphere", alpha_x: ROUGHNESS, alpha_y: ROUGHNESS},
        rewrite_proof=lambda: _alpha_steps(),
        slides=(70, 71),
        cite="heitz2014",
    )
    a_o = Equation(
        key="visibility.smith.a",
        title="the argument of Lambda: slope of the view direction in units of roughness",
        symbol=sp.Symbol("a"),
        equals=1 / (roughness_o * sp.tan(theta_o)),
        computed_as=wo.z / sp.sqrt((alpha_x * wo.x) ** 2 + (alpha_y * wo.y) ** 2),
        where={**wo.spherical, roughness_o: alpha_o.equals},
        over={wo: "hemisphere", alpha_x: ROUGHNESS, alpha_y: ROUGHNESS},
        rewrite_proof=lambda: _argument_steps(),
        slides=(63, 71),
        cite="heitz2014",
    )
    Lambda = Equation(
        key="visibility.smith.Lambda",
        title="Smith's Lambda for any distribution of slopes",
        symbol=Lambda_o,
        means=hidden / mu_o,
        equals=sp.Integral((q - sp.cot(theta_o)) * P2(q), (q, sp.cot(theta_o), sp.oo)) / sp.cot(theta_o),
        proof=lambda: _projection_steps(),
        proved_by="sympy: a facet of slope q along the view projects to sin theta_o (cot theta_o - q)",
        slides=(39, 40),
        cite="heitz2014",
    )
    facet = Equation(
        key="visibility.smith.facet",
        title="what a facet shows with its sign, per area of the plane below it",
        symbol=printed_symbol("facet_shows", r"\frac{\omega_o \cdot \omega_m}{\omega_m \cdot \omega_g}"),
        means=sp.cos(theta_o) - q * sp.sin(theta_o),
        equals=sp.sin(theta_o) * (sp.cot(theta_o) - q),
        proof=lambda it: _facet_steps(it),
        proved_by="sympy: the view in the plane of the first axis, the facet by its slopes",
        slides=(38, 39),
        cite="heitz2014",
    )
    signed = Equation(
        key="visibility.smith.signed",
        title="with their signs, all facets project to the surface",
        symbol=seen - hidden,
        means=sp.Integral((sp.cos(theta_o) - q * sp.sin(theta_o)) * P2(q), (q, -sp.oo, sp.oo)),
        equals=mu_o,
        where={P2(q): beckmann.P2.equals, mu_o: sp.cos(theta_o)},
        proof=lambda it: [
            *residuals_of_forms(it),
            it.means.atoms(sp.Integral).pop().function - facet.means * P2(q),
            *_signed_steps(),
        ],
        proved_by="sympy: P2 has the integral 1 and the mean 0, as Beckmann's and that of GGX",
        slides=(38, 39),
        cite="heitz2014",
    )
    seen_area = Equation(
        key="visibility.smith.seen",
        title="what would be seen if nothing were masked",
        symbol=seen,
        means=mu_o + hidden,
        equals=mu_o * (1 + Lambda_o),
        where={hidden: mu_o * Lambda_o},
        proved_by="sympy: facets turned to and away from the viewer project to the whole surface, with sign",
        over={mu_o: (1e-8, 1), Lambda_o: (0, 1e8)},
        slides=(38, 39),
        cite="heitz2014",
    )
    G1 = Equation(
        key="visibility.smith.G1",
        title="Smith's masking function, from conservation of projected area",
        symbol=printed_symbol("G1_smith", r"G_1(\omega_o, \omega_m)"),
        means=chi(om) * mu_o / seen,
        equals=chi(om) / (1 + Lambda_o),
        over={om: (-1, 1), Lambda_o: (0, 1e8)},
        where={seen: mu_o * (1 + Lambda_o)},
        proved_by="sympy: the visible projected area put in",
        slides=(39, 40, 58),
        cite="smith1967; heitz2014",
    )
    survival = Equation(
        key="visibility.smith.survival",
        title="the chance that a facet is seen, given its height",
        symbol=printed_symbol("chance_at_u", r"s(u)"),
        means=sp.exp(-sp.Integral(Lambda_o / v, (v, u, 1))),
        equals=u**Lambda_o,
        proof=lambda it: _survival_steps(it),
        proved_by="sympy: it solves ds/s = Lambda du/u and is 1 at the top",
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (Lambda_o, u), [(0.25, 0.5), (1.0, 1e-6), (1e3, 0.9)]),
        over={Lambda_o: (0, 100), u: (0.01, 1)},
        slides=(39, 40),
        cite="smith1967; heitz2014",
        note="u is the share of the surface that lies lower than the facet.",
    )
    heights = Equation(
        key="visibility.smith.heights",
        title="Smith's masking function, averaged over heights",
        symbol=printed_symbol("G1_heights", r"G_1(\omega_o, \omega_m)"),
        means=sp.Integral(u**Lambda_o, (u, 0, 1)),
        equals=1 / (1 + Lambda_o),
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (Lambda_o,), [(0.0,), (0.25,), (1.0,), (1e3,)]),
        over={Lambda_o: (0, 1e8)},
        slides=(39, 40),
        cite="heitz2014",
        note="u is the share of the surface that lies lower than the facet; the height distribution drops out.",
    )


def _facet_steps(it: Equation) -> list[Any]:
    """A view in the plane of the first axis; the facet's normal is (-q, -y, 1) over its length, which cancels."""
    view, normal = sp.Matrix([sp.sin(theta_o), 0, sp.cos(theta_o)]), sp.Matrix([-q, -y, 1])
    visible = view.dot(normal) / normal[2]
    return [visible - it.means, visible - it.equals.subs(sp.cot(theta_o), 1 / sp.tan(theta_o))]


def _signed_steps() -> list[Any]:
    """For each family: P2 is even, so its mean is 0, and its antiderivative rises from -1/2 to 1/2."""
    rises = {beckmann: sp.erf(q / alpha) / 2, ggx: q / (2 * sp.sqrt(alpha**2 + q**2))}
    steps: list[Any] = []
    for family, rise in rises.items():
        density = family.P2.equals.doit()
        steps += [density - density.subs(q, -q), sp.diff(rise, q) - density]
        steps += [sp.limit(rise.subs(alpha, 1), q, end) - half for end, half in ((sp.oo, HALF), (-sp.oo, -HALF))]
    return steps


def _survival_steps(it: Equation) -> list[Any]:
    stated = it.equals
    return [it.means - stated, sp.diff(stated, u) / stated - Lambda_o / u, stated.subs(u, 1) - 1]


def _alpha_steps() -> list[Any]:
    """Squares of both sides, both positive."""
    return [(sp.cos(wo.phi) ** 2 * alpha_x**2 + sp.sin(wo.phi) ** 2 * alpha_y**2) - _stretched_square() / sp.sin(wo.theta) ** 2]


def _argument_steps() -> list[Any]:
    """(alpha_o tan theta_o)^2 is the radicand over cos^2 theta_o."""
    alpha_squared = sp.cos(wo.phi) ** 2 * alpha_x**2 + sp.sin(wo.phi) ** 2 * alpha_y**2
    return [alpha_squared * sp.tan(wo.theta) ** 2 - _stretched_square() / sp.cos(wo.theta) ** 2]


def _stretched_square() -> sp.Expr:
    return (alpha_x * wo.spherical[wo.x]) ** 2 + (alpha_y * wo.spherical[wo.y]) ** 2


def _projection_steps() -> list[Any]:
    """-(wo.wm)/(wm.wg) for a facet of slope q, over cos theta_o, is (q - cot theta_o)/cot theta_o."""
    facet = sp.sin(theta_o) * -q + sp.cos(theta_o)
    return [sp.simplify(-facet / sp.cos(theta_o) - (q - sp.cot(theta_o)) / sp.cot(theta_o)).rewrite(sp.tan)]


# --- Lambda by quadrature, for any distribution -----------------------------------------------------------------------

CLOSE = ByPrecision(1e-10, 1e-5)  # difference of two rules, beside Lambda + LEAST: far above the error of the finer one
LEAST = 0.01
LIKE_BECKMANN = 1.0  # the largest alpha for which Ward's slopes are spread as its slope scale says; above, this quadrature errs
TAIL = 7.0  # scales, beyond which the hidden area of exponential tails is below 1e-20


@cache
def _hiding(D: Callable[..., float]) -> Callable[..., float]:
    """Integrand of the hidden area: the projected area of back-facing facets."""

    def hiding(Lambda_o: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
        return max(-dot(wo, wm), 0.0) * D(wm, p.ndf)

    return hiding


@cache
def quadrature_Lambda(D: Callable[..., float]) -> Callable[..., float]:
    """Lambda(wo, p) of any distribution: the integral over the half-plane of hidden slopes. p.model: its slope scale.

    By `integrate_adaptively`, with more and more nodes until two rules agree.
    """
    integrate, exponential_tails = integrate_adaptively(_hiding(D), hidden=True), has_exponential_tails(D)

    def tail_Lambda(wo: Vector, p: ModelParameters) -> float:
        x, y, z = wo
        if x * x + y * y == 0.0:
            return 0.0
        exponential = exponential_tails(p.model, p.ndf)
        return integrate(0, exponential, LEAST * abs(z), CLOSE, 0.0, (x, y, abs(z)), p.model, p)[0] / abs(z)

    return tail_Lambda


def one_minus_atan_over_t(t: float) -> float:
    """1 - atan(t)/t for t above 0, by its series where the difference would cancel."""
    if t > 0.125:
        return 1.0 - atan(t) / t
    s = t * t
    series = 1.0 / 13.0 - s / 15.0
    for k in range(11, 1, -2):
        series = 1.0 / k - s * series
    return s * series


@cache
def radial_Lambda(D: Callable[..., float]) -> Callable[..., float]:
    """Lambda of an isotropic distribution: the integral over azimuth has a closed form, one over slopes remains.

    All slopes of length sqrt(c^2 + s^2), c = cot theta_o, together hide 2 s (1 - atan(s/c)/(s/c)). s is the tangent of an angle
    times a width or, for exponential tails, the hyperbolic sine of the variable times a width: that spreads the nodes over all
    sizes from 1, where Ward's density of slopes falls as a power, to alpha. Nodes are added until two rules agree.
    """

    exponential_tails = has_exponential_tails(D)

    def ring_Lambda(wo: Vector, p: ModelParameters) -> float:
        x, y, z = wo
        across = sqrt(x * x + y * y)
        if across == 0.0:
            return 0.0
        c, alpha, exponential = abs(z) / across, p.model.scale_x, exponential_tails(p.model, p.ndf)
        width = min(alpha, 1.0) if exponential else sqrt(alpha * alpha + c * c)
        last = asinh(TAIL * alpha / width) if exponential else 0.5 * pi
        before, total = 0.0, 0.0
        for rule in range(POWER_LEVELS, EXPONENTIAL_LEVELS):
            before, total = total, 0.0
            for k in range(STARTS[rule], STARTS[rule + 1]):
                u = 0.5 * last * (1.0 + NODES[k])
                s = width * (sinh(u) if exponential else tan(u))
                stretch = width * (cosh(u) if exponential else 1.0 / (cos(u) * cos(u)))
                m = 1.0 / sqrt(1.0 + c * c + s * s)
                density = D((sqrt(c * c + s * s) * m, 0.0, m), p.ndf) * ((m * m) * (m * m))
                total += last * WEIGHTS[k] * stretch * density * s * s * one_minus_atan_over_t(s / c)
            if rule > POWER_LEVELS and abs(total - before) <= CLOSE * (LEAST * c + total):
                break
        return total / c

    return ring_Lambda


def Lambda_of(ndf: Distribution) -> Callable[..., float]:
    """The cheapest kernel of Lambda for a distribution: a closed form, a suitable quadrature, or one for any distribution."""
    kind = type(ndf)
    if kind.closed_Lambda is not None:
        return closed_form(kind.closed_Lambda)
    if kind.kernel is Ward.kernel and ndf.isotropic:
        return radial_Lambda(kind.kernel)
    if kind.kernel is Ward.kernel and max(map(np.max, ndf.slope_scale)) <= LIKE_BECKMANN:
        return quadrature_Lambda(kind.kernel)
    return panels_Lambda(kind.kernel)


@cache
def closed_form(Lambda: Callable[..., float]) -> Callable[..., float]:
    """The Lambda of a distribution with the parameters of a model over it."""

    def closed_Lambda(w: Vector, p: ModelParameters) -> float:
        return Lambda(w, p.ndf)

    return closed_Lambda


# --- the model --------------------------------------------------------------------------------------------------------

smith_G1 = G1.scalar
separable, height = shadowing.separable.scalar, shadowing.height.scalar
direction, height_direction = shadowing.direction.scalar, shadowing.height_direction.scalar
azimuth_blend = shadowing.correlation.scalar


def kernel_G1(Lambda_o: float, om: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
    return smith_G1(om, Lambda_o)


def azimuth_fraction(wo: Vector, wi: Vector) -> float:
    """lambda for the angle between two azimuths; at the pole, where the azimuth is undefined, any value will do."""
    return azimuth_blend(abs(atan2(wo[0] * wi[1] - wo[1] * wi[0], wo[0] * wi[0] + wo[1] * wi[1])))


def G2_height(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return height(Lambda_o, Lambda_i)


def G2_none(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return separable(Lambda_o, Lambda_i)


def G2_direction(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return direction(Lambda_o, Lambda_i, azimuth_fraction(wo, wi))


def G2_height_direction(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return height_direction(Lambda_o, Lambda_i, azimuth_fraction(wo, wi))


G2_BY_CORRELATION = dict(zip(CORRELATIONS, (G2_height, G2_none, G2_direction, G2_height_direction), strict=True))


@cache
def sampler_of_distribution(kernel: Callable[..., Vector]) -> Callable[..., Vector]:
    """The sampler of visible normals of a distribution with the parameters of a model over it."""

    def sampled(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
        return kernel(wo, u, p.ndf)

    return sampled


class Smith(Masking):
    r"""Smith's model of masking and shadowing, for any distribution of normals.

    .. math:: G_1(\omega_o, \omega_m) = \frac{\chi^{+}(\omega_o \cdot \omega_m)}{1 + \Lambda(\omega_o)}, \quad
              G_2(\omega_o, \omega_i, \omega_m) = \frac{\chi^{+}(\omega_o \cdot \omega_m) \, \chi^{+}(\omega_i \cdot \omega_m)}
              {1 + \Lambda(\omega_o) + \Lambda(\omega_i)}

    the latter correlated by height. Lambda is a closed form where the distribution has one, otherwise a quadrature.
    Statements ``visibility.smith.G1`` and ``visibility.shadowing.height``.

    Parameters
    ----------
    ndf : Distribution
        Distribution of normals; one without a closed form takes numbers for parameters, not arrays.
    correlation : {"height", "none", "direction", "height-direction"}, optional
        What masking and shadowing have in common: the height of a microfacet (the default), nothing (``"none"``, separable),
        the azimuth of the two directions, or both.

    Raises
    ------
    ValueError
        If ndf is not a distribution, or correlation not one of the four.

    References
    ----------
    smith1967; heitz2014, eq. 98 (separable) and eq. 99 (height-correlated); ashikhmin2000 and ginneken1998 (direction).

    Examples
    --------
    >>> import microfacet as mf
    >>> model = mf.Smith(mf.GGX(0.3, 0.1))
    >>> mf.validate(model).holds
    True
    >>> separable = mf.Smith(mf.GGX(0.3, 0.1), correlation="none")
    >>> wo, wi = [0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]
    >>> print(f"{model.G2(wo, wi, [0, 0, 1]):.5f} {separable.G2(wo, wi, [0, 0, 1]):.5f}")
    0.97561 0.97546
    """

    label, cite = "Smith", "smith1967"

    G1_kernel = staticmethod(kernel_G1)

    def __init__(self, ndf: Distribution, correlation: str = "height") -> None:
        super().__init__(ndf)
        self.correlation = one_of("correlation", correlation, CORRELATIONS)
        self.Lambda_kernel, self.G2_kernel = Lambda_of(ndf), G2_BY_CORRELATION[correlation]
        by_panels = self.Lambda_kernel is panels_Lambda(type(ndf).kernel)
        if by_panels:
            ndf.require_numbers("Lambda by quadrature")
        own = Panelled(table_of(ndf.panels)) if by_panels else SlopeScale(*ndf.slope_scale)
        self.parameters = ModelParameters(ndf.parameters, own)

    def Lambda(self, wo: ArrayLike) -> NDArray[Any]:
        r"""Smith's Lambda: the ratio of hidden to visible projected area, :math:`1/G_1 - 1`.

        In closed form where the distribution has one, otherwise by quadrature; statement ``visibility.smith.Lambda``.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.

        Returns
        -------
        ndarray, shape (...)
            Lambda, dimensionless, at least 0; infinite at the horizon and below.

        Raises
        ------
        ValueError
            If wo does not hold unit vectors.

        References
        ----------
        heitz2014, section 5.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.Smith(mf.Ward(0.5)).Lambda([0.96, 0.0, 0.28]):.4f}")
        0.0639
        """
        return lambda_batch(self.Lambda_kernel)([vectors("wo", wo)], self.parameters)

    @property
    def sampler(self) -> Callable[..., Vector] | None:
        visible = type(self.ndf).sample_visible_kernel
        return None if visible is None else sampler_of_distribution(visible)
