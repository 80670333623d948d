"""Beckmann: normally distributed slopes, the statistics of a Gaussian random surface."""

from __future__ import annotations

from itertools import product
from math import log1p, pi, sqrt
from typing import Any, ClassVar

import mpmath
import sympy as sp

from microfacet.arithmetic import exp_minus_squares
from microfacet.compiler.kernels import Pair, Vector
from microfacet.geometry.facets import beckmann_facet
from microfacet.geometry.ggx import ROUGHNESS
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.slopes import Stretched, around, normals_integral, slope_integral, unstretched_norm
from microfacet.geometry.visible_normals import sample_beckmann
from microfacet.special_functions import SQRT_PI
from microfacet.statements import enclosures
from microfacet.statements.notation import a, alpha, alpha_x, alpha_y, chi, printed_symbol, q, wm, x, y
from microfacet.statements.statement import Equation

# --- the distribution -----------------------------------------------------------------------------------------------


SLOPE_LIMIT = sp.Integer(9)  # in units of alpha: the contribution of slopes beyond is below 1e-34
ROUGHNESSES = [(1e-4,), (0.1,), (1.0,), (10.0,)]  # at which integrals are enclosed


def compensated_P22(x: float, y: float, alpha_x: float, alpha_y: float) -> float:
    return exp_minus_squares(x, y, alpha_x, alpha_y, 1.0, 1.0 / (pi * alpha_x * alpha_y))


def compensated_D(x: float, y: float, z: float, alpha_x: float, alpha_y: float) -> float:
    height = z if z > 0.0 else 1.0
    square = height * height
    value = exp_minus_squares(x, y, alpha_x, alpha_y, height, 1.0 / (pi * alpha_x * alpha_y * (square * square)))
    return value if z > 0.0 else 0.0


with sp.evaluate(False):
    P22 = Equation(
        key="geometry.beckmann.P22",
        title="Beckmann distribution of slopes",
        symbol=printed_symbol("P22_beckmann", r"P_{22}(\tilde{x}, \tilde{y})"),
        equals=sp.exp(-(x**2) / alpha_x**2 - y**2 / alpha_y**2) / (sp.pi * alpha_x * alpha_y),
        computed_by=compensated_P22,
        within=(12, 12),
        over={x: (-50, 50), y: (-50, 50), alpha_x: ROUGHNESS, alpha_y: ROUGHNESS},
        slides=(64, 65, 66),
        cite="heitz2014",
    )
    D = Equation(
        key="geometry.beckmann.D",
        title="Beckmann distribution of normals, anisotropic",
        symbol=printed_symbol("D_beckmann", r"D(\omega_m)"),
        equals=chi(sp.cos(wm.theta))
        * sp.exp(-(sp.tan(wm.theta) ** 2) * (sp.cos(wm.phi) ** 2 / alpha_x**2 + sp.sin(wm.phi) ** 2 / alpha_y**2))
        / (sp.pi * alpha_x * alpha_y * sp.cos(wm.theta) ** 4),
        computed_as=chi(wm.z)
        * sp.exp(-((wm.x / alpha_x) ** 2 + (wm.y / alpha_y) ** 2) / wm.z**2)
        / (sp.pi * alpha_x * alpha_y * wm.z**4),
        computed_by=compensated_D,
        where=wm.spherical,
        within=(12, 12),
        over={wm: "hemisphere", alpha_x: ROUGHNESS, alpha_y: ROUGHNESS},
        slides=(55, 67),
        cite="heitz2014",
        note="The rounding error of the exponent is carried along: a plain formula loses as many ulps as that is large.",
    )

r = sp.Symbol("r", positive=True)


def _polar_steps() -> list[Any]:
    """Unstretch (x, y) to polar slopes (r, phi): the integrand no longer depends on phi; its radial integral is 1."""
    phi = sp.Symbol("phi", real=True)
    unstretched = P22.equals.doit().subs({x: alpha_x * r * sp.cos(phi), y: alpha_y * r * sp.sin(phi)}) * alpha_x * alpha_y
    radial = sp.exp(-(r**2)) / sp.pi
    return [unstretched - radial, sp.integrate(2 * sp.pi * r * radial, (r, 0, sp.oo)) - 1]


projected_area = Equation(
    key="geometry.beckmann.projected_area",
    title="Beckmann facets project to the whole surface",
    symbol=normals_integral(r"\left( \omega_m \cdot \omega_g \right) D(\omega_m)"),
    means=slope_integral(P22.equals),
    equals=sp.Integer(1),
    proof=_polar_steps,
    proved_by="sympy: slopes unstretched, then polar coordinates",
    enclosed=lambda it: enclosures.agreement(
        enclosures.truncated(unstretched_norm(P22.equals), SLOPE_LIMIT, sp.exp(-(SLOPE_LIMIT**2))), 1, (), [()]
    ),
    slides=(35, 36, 55, 67),
    cite="heitz2014",
)


def marginal(q: float, alpha: float) -> float:
    return exp_minus_squares(q, 0.0, alpha, 1.0, 1.0, 1.0 / (SQRT_PI * alpha))


with sp.evaluate(False):
    P2 = Equation(
        key="geometry.beckmann.P2",
        title="Beckmann slopes along one direction",
        symbol=printed_symbol("P2_beckmann", r"P_2(q)"),
        means=sp.Integral(sp.exp(-(q**2) / alpha**2 - y**2 / alpha**2) / (sp.pi * alpha**2), (y, -sp.oo, sp.oo)),
        equals=sp.exp(-(q**2) / alpha**2) / (sp.sqrt(sp.pi) * alpha),
        computed_by=marginal,
        enclosed=lambda it: enclosures.agreement(
            enclosures.truncated(it.means, SLOPE_LIMIT * alpha, it.equals * sp.exp(-(SLOPE_LIMIT**2))),
            it.equals,
            (q, alpha),
            [(ratio * scale, scale) for ratio, scale in product((0.0, 1.0, 5.0), (1e-4, 1.0, 10.0))],
        ),
        within=(12, 12),
        over={q: (-50, 50), alpha: ROUGHNESS},
        slides=(70, 71),
        cite="heitz2014",
    )

    rms = Equation(
        key="geometry.beckmann.rms",
        title="root mean square of Beckmann slopes along one direction",
        symbol=printed_symbol("rms_beckmann", r"\sqrt{\int_{-\infty}^{\infty} q^2 P_2(q) \, dq}"),
        means=sp.sqrt(sp.Integral(q**2 * sp.exp(-(q**2) / alpha**2) / (sp.sqrt(sp.pi) * alpha), (q, -sp.oo, sp.oo))),
        equals=alpha / sp.sqrt(2),
        enclosed=lambda it: enclosures.agreement(
            enclosures.truncated(it.means, SLOPE_LIMIT * alpha, 10 * alpha**2 * sp.exp(-(SLOPE_LIMIT**2))),
            it.equals,
            (alpha,),
            ROUGHNESSES,
        ),
        over={alpha: ROUGHNESS},
        slides=(64, 65),
        cite="heitz2014",
    )


# --- the gap between erfcx and its limit ------------------------------------------------------------------------------

CENTRE = 2.75  # maps a = 2.75 to the middle of the Chebyshev interval: the series is shortest there
TERMS = 28


def _gap(argument: Any) -> Any:
    return 1 - mpmath.sqrt(mpmath.pi) * argument * mpmath.exp(argument**2) * mpmath.erfc(argument)


def _gap_series() -> tuple[float, ...]:
    """Chebyshev coefficients of g(a) (1 + sqrt(pi) a + 2 a^2) in (a - CENTRE)/(a + CENTRE): a smooth function near 1."""
    nodes = 2 * TERMS
    with mpmath.workdps(60):
        angles = [mpmath.pi * (k + mpmath.mpf(1) / 2) / nodes for k in range(nodes)]
        arguments = [CENTRE * (1 + mpmath.cos(w)) / (1 - mpmath.cos(w)) for w in angles]
        values = [_gap(s) * (1 + mpmath.sqrt(mpmath.pi) * s + 2 * s**2) for s in arguments]
        sums = [sum(f * mpmath.cos(j * w) for f, w in zip(values, angles, strict=True)) for j in range(TERMS)]
        return tuple(float(s * (1 if j == 0 else 2) / nodes) for j, s in enumerate(sums))


GAP_SERIES = _gap_series()


def gap(a: float) -> float:
    """g(a) by Clenshaw's recurrence, without a branch."""
    bounded = min(a, 1e17)
    w = (bounded - CENTRE) / (bounded + CENTRE)
    b1 = 0.0
    b2 = 0.0
    for k in range(TERMS - 1, 0, -1):
        b1, b2 = 2.0 * w * b1 - b2 + GAP_SERIES[k], b1
    return (w * b1 - b2 + GAP_SERIES[0]) / (1.0 + bounded * (SQRT_PI + 2.0 * bounded))


with sp.evaluate(False):
    g = Equation(
        key="geometry.beckmann.g",
        title="how far the scaled complementary error function is from its limit",
        symbol=sp.Function("g")(a),
        equals=1 - sp.sqrt(sp.pi) * a * sp.exp(a**2) * sp.erfc(a),
        computed_by=gap,
        over={a: (1e-8, 1e8)},
        slides=(62,),
        cite="heitz2014",
        note="Computed as a Chebyshev series whose coefficients are derived from this definition at 60 digits.",
    )
    Lambda = Equation(
        key="geometry.beckmann.Lambda",
        title="Smith's Lambda for Beckmann",
        symbol=sp.Function("Lambda_Beckmann")(a),
        means=sp.Integral((q - a) * sp.exp(-(q**2)) / sp.sqrt(sp.pi), (q, a, sp.oo)) / a,
        equals=(sp.erf(a) - 1) / 2 + sp.exp(-(a**2)) / (2 * a * sp.sqrt(sp.pi)),
        computed_as=sp.exp(-(a**2)) * sp.Function("g")(a) / (2 * a * sp.sqrt(sp.pi)),
        within=(12, 12),
        over={a: (1e-8, 1e8)},
        slides=(58, 62, 63),
        cite="heitz2014, eq. 69",
        enclosed=lambda it: enclosures.agreement(
            enclosures.truncated(it.means, a + SLOPE_LIMIT, sp.exp(-((a + SLOPE_LIMIT) ** 2))),
            it.equals,
            (a,),
            [(1e-8,), (0.01,), (1.0,), (4.0,)],
        ),
        note="The closed form subtracts the error function from 1; the rewrite has nothing left to subtract.",
    )

area = Equation(
    key="geometry.beckmann.area",
    title="area of a Beckmann microsurface",
    symbol=normals_integral(r"D(\omega_m)"),
    means=sp.Integral(2 * q * sp.sqrt(1 + q**2) * sp.exp(-(q**2) / alpha**2) / alpha**2, (q, 0, sp.oo)),
    equals=1 + sp.sqrt(sp.pi) * alpha * sp.exp(1 / alpha**2) * sp.erfc(1 / alpha) / 2,
    computed_as=1 + alpha**2 * (1 - sp.Function("g")(1 / alpha)) / 2,
    within=(16, 16),
    over={alpha: ROUGHNESS},
    enclosed=lambda it: enclosures.agreement(
        enclosures.truncated(it.means, SLOPE_LIMIT * alpha, (2 + SLOPE_LIMIT * alpha) * sp.exp(-(SLOPE_LIMIT**2))),
        it.equals,
        (alpha,),
        ROUGHNESSES,
    ),
    proof=lambda: _area_steps(),
    proved_by="sympy: substitution w^2 = 1 + q^2, then the antiderivative",
    slides=(34,),
    cite="heitz2014",
)


def _area_steps() -> list[Any]:
    """With w = sqrt(1+q^2) the integral is that of 2 w^2 exp((1-w^2)/alpha^2)/alpha^2 over w from 1."""
    w = sp.Symbol("w", positive=True)
    slope = sp.sqrt(w**2 - 1)
    integrand = 2 * q * sp.sqrt(1 + q**2) * sp.exp(-(q**2) / alpha**2) / alpha**2
    substituted = 2 * w**2 * sp.exp((1 - w**2) / alpha**2) / alpha**2
    antiderivative = -w * sp.exp((1 - w**2) / alpha**2) - sp.sqrt(sp.pi) * alpha * sp.exp(1 / alpha**2) * sp.erfc(w / alpha) / 2
    return [
        integrand.subs(q, slope) * sp.diff(slope, w) - substituted,
        sp.diff(antiderivative, w) - substituted,
        sp.limit(antiderivative.subs(alpha, 1), w, sp.oo),
        -antiderivative.subs(w, 1) - area.equals,
    ]


# --- kernels --------------------------------------------------------------------------------------------------------

beckmann_Lambda = Lambda.scalar


def kernel_D(wm: Vector, p: Alphas) -> float:
    return compensated_D(wm[0], wm[1], wm[2], p.alpha_x, p.alpha_y)


def kernel_Lambda(w: Vector, p: Alphas) -> float:
    (x, y, z), alpha_x, alpha_y = w, p.alpha_x, p.alpha_y
    return beckmann_Lambda(abs(z) / sqrt((alpha_x * x) * (alpha_x * x) + (alpha_y * y) * (alpha_y * y)))


def kernel_sample(u: Pair, p: Alphas) -> Pair:
    x, y = around(sqrt(-log1p(-u[0])), u[1])
    return p.alpha_x * x, p.alpha_y * y


class Beckmann(Stretched):
    r"""Beckmann distribution of normals, whose slopes are normally distributed.

    .. math:: D(\omega_m) = \frac{\chi^{+}(z_m)}{\pi \alpha_x \alpha_y z_m^4}
              \exp\left( -\frac{x_m^2/\alpha_x^2 + y_m^2/\alpha_y^2}{z_m^2} \right)

    The root mean square of the slopes along x is :math:`\alpha_x/\sqrt{2}`. Statements ``geometry.beckmann.D`` and
    ``geometry.beckmann.Lambda``.

    Parameters
    ----------
    alpha_x : array_like
        Roughness along x, dimensionless, from 1e-11 to 1e11; a number, or an array that broadcasts with the directions.
    alpha_y : array_like, optional
        Roughness along y; by default that along x.

    Raises
    ------
    ValueError
        If a roughness is outside that range, or if the shapes do not broadcast.

    References
    ----------
    heitz2014, eq. 69 (Lambda); beckmann1963; heitzdeon2014 (visible normals).

    Examples
    --------
    >>> import microfacet as mf
    >>> ndf = mf.Beckmann(0.3)
    >>> print(f"{ndf.D([0, 0, 1]):.4f} {ndf.Lambda([0.96, 0.0, 0.28]):.4f}")
    3.5368 0.0282
    """

    label, cite = "Beckmann", "heitz2014"
    statements: ClassVar = {"D": D, "Lambda": Lambda, "projected_area": projected_area}
    regular = True

    kernel = staticmethod(kernel_D)
    sample_kernel = staticmethod(kernel_sample)
    closed_Lambda = staticmethod(kernel_Lambda)
    sample_visible_kernel = staticmethod(sample_beckmann)
    facet_kernel = staticmethod(beckmann_facet)
    reach = 6.5
