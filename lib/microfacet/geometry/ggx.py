"""GGX (Trowbridge-Reitz): slopes of a stretched ellipsoid, tails that fall as the fourth power."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import atan, pi, sqrt
from typing import Any, ClassVar, NamedTuple

import sympy as sp

from microfacet.arithmetic import two_product
from microfacet.compiler.kernels import Pair, Parameters, Vector
from microfacet.geometry.facets import ggx_facet
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.slopes import Stretched, around, normals_integral, slope_integral, unstretched_norm
from microfacet.geometry.visible_normals import sample_ggx
from microfacet.statements import enclosures
from microfacet.statements.notation import a, alpha, alpha_x, alpha_y, chi, printed_symbol, q, wm, x, y
from microfacet.statements.statement import Equation

ROUGHNESS = (1e-4, 10)
ARGUMENTS = [(1e-8,), (0.01,), (1.0,), (100.0,), (1e8,)]  # of Lambda, where it is enclosed

# --- statements ---------------------------------------------------------------------------------------------------

with sp.evaluate(False):
    P22 = Equation(
        key="geometry.ggx.P22",
        title="GGX distribution of slopes",
        symbol=printed_symbol("P22_ggx", r"P_{22}(\tilde{x}, \tilde{y})"),
        equals=1 / (sp.pi * alpha_x * alpha_y * (1 + x**2 / alpha_x**2 + y**2 / alpha_y**2) ** 2),
        computed_as=1 / (sp.pi * alpha_x * alpha_y * (1 + (x / alpha_x) ** 2 + (y / alpha_y) ** 2) ** 2),
        within=(16, 16),
        over={x: (-1e3, 1e3), y: (-1e3, 1e3), alpha_x: ROUGHNESS, alpha_y: ROUGHNESS},
        slides=(64, 65, 66),
        cite="walter2007",
    )
    D = Equation(
        key="geometry.ggx.D",
        title="GGX distribution of normals, anisotropic",
        symbol=printed_symbol("D_ggx", r"D(\omega_m)"),
        equals=chi(sp.cos(wm.theta))
        / (
            sp.pi
            * alpha_x
            * alpha_y
            * sp.cos(wm.theta) ** 4
            * (1 + sp.tan(wm.theta) ** 2 * (sp.cos(wm.phi) ** 2 / alpha_x**2 + sp.sin(wm.phi) ** 2 / alpha_y**2)) ** 2
        ),
        computed_as=chi(wm.z) / (sp.pi * alpha_x * alpha_y * ((wm.x / alpha_x) ** 2 + (wm.y / alpha_y) ** 2 + wm.z**2) ** 2),
        where=wm.spherical,
        within=(16, 16),
        over={wm: "hemisphere", alpha_x: ROUGHNESS, alpha_y: ROUGHNESS},
        slides=(55, 67),
        cite="heitz2014, eq. 85",
        note="The textbook form loses all digits near the pole at small alpha; the rewrite only adds squares.",
    )

projected_area = Equation(
    key="geometry.ggx.projected_area",
    title="GGX facets project to the whole surface",
    symbol=normals_integral(r"\left( \omega_m \cdot \omega_g \right) D(\omega_m)"),
    means=slope_integral(P22.equals),
    equals=sp.Integer(1),
    proof=lambda: _polar_steps(),
    proved_by="sympy: slopes unstretched, then polar coordinates",
    enclosed=lambda it: enclosures.agreement(enclosures.folded(unstretched_norm(P22.equals), 1), 1, (), [()]),
    slides=(35, 36, 55, 67),
    cite="heitz2014",
)

r = sp.Symbol("r", positive=True)


def _polar_steps() -> list[Any]:
    """Unstretch (x, y) to polar slopes (r, phi): the integrand no longer depends on phi; its radial integral is 1."""
    phi = sp.Symbol("phi", real=True)
    unstretched = P22.equals.doit().subs({x: alpha_x * r * sp.cos(phi), y: alpha_y * r * sp.sin(phi)}) * alpha_x * alpha_y
    radial = 1 / (sp.pi * (1 + r**2) ** 2)
    return [unstretched - radial, sp.integrate(2 * sp.pi * r * radial, (r, 0, sp.oo)) - 1]


with sp.evaluate(False):
    P2 = Equation(
        key="geometry.ggx.P2",
        title="GGX slopes along one direction",
        symbol=printed_symbol("P2_ggx", r"P_2(q)"),
        means=sp.Integral(1 / (sp.pi * alpha**2 * (1 + q**2 / alpha**2 + y**2 / alpha**2) ** 2), (y, -sp.oo, sp.oo)),
        equals=alpha**2 / (2 * (alpha**2 + q**2) ** sp.Rational(3, 2)),
        computed_as=1 / (2 * alpha * (1 + (q / alpha) ** 2) * sp.sqrt(1 + (q / alpha) ** 2)),
        enclosed=lambda it: enclosures.agreement(
            enclosures.folded(it.means, alpha), it.equals, (q, alpha), list(product((0.0, 1.0, 1e3), (1e-4, 1.0, 10.0)))
        ),
        within=(12, 12),
        over={q: (-1e3, 1e3), alpha: ROUGHNESS},
        slides=(70, 71),
        cite="heitz2014",
    )
    Lambda = Equation(
        key="geometry.ggx.Lambda",
        title="Smith's Lambda for GGX",
        symbol=sp.Function("Lambda_GGX")(a),
        means=sp.Integral((q - a) / (2 * (1 + q**2) ** sp.Rational(3, 2)), (q, a, sp.oo)) / a,
        equals=(-1 + sp.sqrt(1 + 1 / a**2)) / 2,
        computed_as=1 / (2 * a * (a + sp.sqrt(1 + a**2))),
        over={a: (1e-8, 1e8)},
        enclosed=lambda it: enclosures.agreement(enclosures.folded(it.means, a + 1), it.equals, (a,), ARGUMENTS),
        slides=(58, 62, 63),
        cite="heitz2014, eq. 72",
        note="The closed form subtracts two numbers near 1 where a is large; the rewrite does not.",
    )


def _moment_steps() -> list[Any]:
    """The antiderivative by differentiation; as the reach grows it passes every bound."""
    closed = alpha**2 * (sp.asinh(reach / alpha) - reach / sp.sqrt(alpha**2 + reach**2))
    grows = sp.limit(closed.subs(alpha, 1), reach, sp.oo)
    return [
        sp.diff(closed, reach) - 2 * (q**2 * P2.equals.doit()).subs(q, reach),
        closed.subs(reach, 0),
        sp.Integer(0 if grows == sp.oo else 1),
    ]


reach = sp.Symbol("Q", positive=True)
with sp.evaluate(False):
    half_below = Equation(
        key="geometry.ggx.median",
        title="half of all GGX slopes are below alpha",
        symbol=printed_symbol(
            "slopes_below_alpha", r"\int_{\tilde{x}^2 + \tilde{y}^2 < \alpha^2} P_{22} \, d\tilde{x} \, d\tilde{y}"
        ),
        means=sp.Integral(2 * q / (1 + q**2) ** 2, (q, 0, 1)),
        equals=sp.Rational(1, 2),
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (), [()]),
        slides=(64, 65),
        cite="walter2007",
    )
    moment = Equation(
        key="geometry.ggx.second_moment",
        title="mean square of GGX slopes up to a reach Q: it grows without limit",
        symbol=printed_symbol("moment_ggx", r"\int_{-Q}^{Q} q^2 P_2(q) \, dq"),
        means=sp.Integral(q**2 * (alpha**2 / (2 * (alpha**2 + q**2) ** sp.Rational(3, 2))), (q, -reach, reach)),
        equals=alpha**2 * (sp.asinh(reach / alpha) - reach / sp.sqrt(alpha**2 + reach**2)),
        proof=lambda: _moment_steps(),
        proved_by="sympy: antiderivative by differentiation, and its limit",
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (alpha, reach), [(0.1, 1.0), (1.0, 1.0), (1.0, 1e6)]),
        slides=(64, 65),
        cite="walter2007",
    )

with sp.evaluate(False):
    _k = sp.sqrt((1 - alpha) * (1 + alpha))

area = Equation(
    key="geometry.ggx.area",
    title="area of a GGX microsurface",
    symbol=normals_integral(r"D(\omega_m)"),
    means=sp.Integral(2 * q * sp.sqrt(1 + q**2) / (alpha**2 * (1 + q**2 / alpha**2) ** 2), (q, 0, sp.oo)),
    equals=1 + alpha**2 * sp.atanh(sp.sqrt(1 - alpha**2)) / sp.sqrt(1 - alpha**2),
    computed_as=1 + alpha**2 * sp.asinh(_k / alpha) / _k,
    enclosed=lambda it: enclosures.agreement(enclosures.folded(it.means, 1), it.equals, (alpha,), [(1e-4,), (0.1,), (0.999,)]),
    rewrite_proof=lambda: [sp.tanh(sp.asinh(_k.doit() / alpha)) - _k.doit(), _k.doit() ** 2 - (1 - alpha**2)],
    over={alpha: (1e-4, 0.999)},
    proof=lambda: _area_steps(),
    proved_by="sympy: antiderivative in the cosine of the normal's angle, its derivative and its limits",
    slides=(34,),
    cite="heitz2014",
    note="Stated for alpha below 1.",
)
area_at_one = Equation(
    key="geometry.ggx.area_at_one",
    title="area of a GGX microsurface of alpha = 1",
    symbol=normals_integral(r"D(\omega_m)"),
    means=sp.Integral(2 * q * sp.sqrt(1 + q**2) / (1 + q**2) ** 2, (q, 0, sp.oo)),
    equals=sp.Integer(2),
    enclosed=lambda it: enclosures.agreement(enclosures.folded(it.means, 1), it.equals, (), [()]),
    proof=lambda it: [
        it.means.function - area.means.function.subs(alpha, 1),
        sp.diff(-2 / sp.sqrt(1 + q**2), q) - it.means.function,
        sp.limit(area.equals, alpha, 1, "-") - it.equals,
    ],
    proved_by="sympy: the antiderivative; and the limit of the form below 1",
    slides=(34,),
    cite="heitz2014",
)


def kernel_area(alpha: float) -> float:
    k = sqrt((alpha - 1.0) * (alpha + 1.0))
    return 1.0 + alpha * alpha * atan(k) / k


with sp.evaluate(False):
    area_above = Equation(
        key="geometry.ggx.area_above",
        title="area of a GGX microsurface of alpha above 1",
        symbol=normals_integral(r"D(\omega_m)"),
        means=area.means,
        equals=1 + alpha**2 * sp.atan(sp.sqrt(alpha**2 - 1)) / sp.sqrt(alpha**2 - 1),
        computed_by=kernel_area,
        enclosed=lambda it: enclosures.agreement(
            enclosures.folded(it.means, 1), it.equals, (alpha,), [(1.001,), (2.0,), (10.0,)]
        ),
        over={alpha: (1.001, 10)},
        proof=lambda: _area_above_steps(),
        proved_by="sympy: antiderivative in the cosine of the normal's angle, its derivative and its limits",
        slides=(34,),
        cite="heitz2014",
    )


def _area_above_steps() -> list[Any]:
    """As below 1, with arctan in place of artanh."""
    z, k = sp.symbols("z k", positive=True)
    antiderivative = (1 + k**2) * (z / (1 + k**2 * z**2) + sp.atan(k * z) / k)
    stated = 1 + (1 + k**2) * sp.atan(k) / k
    return [
        sp.diff(antiderivative, z) - 2 * (1 + k**2) / (1 + k**2 * z**2) ** 2,
        antiderivative.subs(z, 1) - antiderivative.subs(z, 0) - stated,
        stated.subs(k, sp.sqrt(alpha**2 - 1)) - area_above.equals.doit(),
    ]


def _area_steps() -> list[Any]:
    """With z = 1/sqrt(1+q^2) the integral is that of 2 alpha^2/(z^2(alpha^2-1)+1)^2 over z in (0, 1)."""
    z = sp.Symbol("z", positive=True)
    slope = sp.sqrt(1 / z**2 - 1)
    integrand = (2 * q * sp.sqrt(1 + q**2) / (alpha**2 * (1 + q**2 / alpha**2) ** 2)).subs(q, slope) * -sp.diff(slope, z)
    k = sp.sqrt(1 - alpha**2)
    antiderivative = alpha**2 * (z / (1 - k**2 * z**2) + sp.atanh(k * z) / k)
    return [
        integrand - 2 * alpha**2 / (1 + (alpha**2 - 1) * z**2) ** 2,
        sp.diff(antiderivative, z) - 2 * alpha**2 / (1 + (alpha**2 - 1) * z**2) ** 2,
        antiderivative.subs(z, 1) - antiderivative.subs(z, 0) - area.equals,
    ]


# --- kernels --------------------------------------------------------------------------------------------------------

ggx_D, ggx_Lambda = D.scalar, Lambda.scalar


def kernel_D(wm: Vector, p: Alphas) -> float:
    return ggx_D(wm[0], wm[1], wm[2], p.alpha_x, p.alpha_y)


def kernel_Lambda(w: Vector, p: Alphas) -> float:
    (x, y, z), alpha_x, alpha_y = w, p.alpha_x, p.alpha_y
    return ggx_Lambda(abs(z) / sqrt((alpha_x * x) * (alpha_x * x) + (alpha_y * y) * (alpha_y * y)))


def kernel_sample(u: Pair, p: Alphas) -> Pair:
    x, y = around(sqrt(u[0] / (1.0 - u[0])), u[1])
    return p.alpha_x * x, p.alpha_y * y


# --- the lobe under Smith's model ---------------------------------------------------------------------------------------


SMALL, LARGE = 1e-10, 1e10  # their squares keep their digits in either precision


def inverse_square(alpha: float) -> tuple[float, float]:
    """A factor f and 1/(f alpha)^2 to half an ulp or little more; f = 1 where the square of alpha keeps its digits.

    What rounding left out of the inverse and of its square is put back.
    """
    factor = 1.0 if SMALL < alpha < LARGE else 1.0 / alpha
    scaled = factor * alpha
    inverse = 1.0 / scaled
    product, product_rest = two_product(scaled, inverse)
    square, square_rest = two_product(inverse, inverse)
    return factor, square + (square_rest + 2.0 * square * ((1.0 - product) - product_rest))


class Inverted(NamedTuple):
    """Parameters of the lobe: both roughnesses, and what `inverse_square` makes of them."""

    alpha_x: float
    alpha_y: float
    of_x: Pair
    of_y: Pair


def lobe(x_o: float, y_o: float, z_o: float, x_i: float, y_i: float, z_i: float, alpha_x: float, alpha_y: float) -> float:
    """D G2/(4 cos cos) at the half vector, both directions above the horizon: neither the half vector's length nor a cosine is
    divided out."""
    p = Inverted(alpha_x, alpha_y, inverse_square(alpha_x), inverse_square(alpha_y))
    return inverted_lobe((x_o, y_o, z_o), (x_i, y_i, z_i), p)


def inverted_lobe(wo: Vector, wi: Vector, p: Inverted) -> float:
    """The same, given the inverse squares: computed once for all rows and calls."""
    (x_o, y_o, z_o), (x_i, y_i, z_i), (x_factor, x_inverse), (y_factor, y_inverse) = wo, wi, p.of_x, p.of_y
    x, y, z = x_o + x_i, y_o + y_i, z_o + z_i
    square = x * x + y * y + z * z
    stretched = (x_factor * x) * (x_factor * x) * x_inverse + (y_factor * y) * (y_factor * y) * y_inverse + z * z
    reach_o = sqrt((p.alpha_x * x_o) * (p.alpha_x * x_o) + (p.alpha_y * y_o) * (p.alpha_y * y_o) + z_o * z_o)
    reach_i = sqrt((p.alpha_x * x_i) * (p.alpha_x * x_i) + (p.alpha_y * y_i) * (p.alpha_y * y_i) + z_i * z_i)
    shrunk = square / stretched  # first: the squares of both underflow where both directions graze
    return (shrunk * shrunk) / ((2.0 * pi) * (p.alpha_x * p.alpha_y) * (z_o * reach_i + z_i * reach_o))


def lobe_of_arrays(wo: Vector, wi: Vector, p: Alphas) -> float:
    """Each row has its own roughness, for which `inverse_square` would dominate the run time."""
    inverse = 1.0 / (p.alpha_x * p.alpha_y)  # one division for both
    return inverted_lobe(wo, wi, Inverted(p.alpha_x, p.alpha_y, (p.alpha_y * inverse, 1.0), (p.alpha_x * inverse, 1.0)))


# --- the class ----------------------------------------------------------------------------------------------------------


class GGX(Stretched):
    r"""GGX (Trowbridge-Reitz) distribution of normals.

    .. math:: D(\omega_m) = \frac{\chi^{+}(z_m)}{\pi \alpha_x \alpha_y
              \left( x_m^2/\alpha_x^2 + y_m^2/\alpha_y^2 + z_m^2 \right)^2}

    Statements ``geometry.ggx.D`` and ``geometry.ggx.Lambda``.

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
    heitz2014, eq. 85 (D) and eq. 72 (Lambda); walter2007; trowbridge1975; dupuy2023 (visible normals).

    Examples
    --------
    >>> import microfacet as mf
    >>> ndf = mf.GGX(0.3, 0.1)
    >>> print(f"{ndf.D([0, 0, 1]):.4f} {ndf.Lambda([0.6, 0.0, 0.8]):.4f}")
    10.6103 0.0125
    >>> mf.GGX([0.1, 0.2, 0.4]).D([0, 0, 1]).round(3)  # a roughness per pixel
    array([31.831,  7.958,  1.989])
    """

    label, cite = "GGX", "walter2007"
    statements: ClassVar = {"D": D, "Lambda": Lambda, "projected_area": projected_area}
    regular = True

    kernel = staticmethod(kernel_D)
    sample_kernel = staticmethod(kernel_sample)
    closed_Lambda = staticmethod(kernel_Lambda)
    sample_visible_kernel = staticmethod(sample_ggx)
    facet_kernel = staticmethod(ggx_facet)

    @property
    def smith_lobe(self) -> tuple[Callable[..., float], Parameters]:
        if self.batch_shape:
            return lobe_of_arrays, self.parameters
        return inverted_lobe, Inverted(*self.parameters, *map(inverse_square, self.parameters))
