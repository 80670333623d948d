"""Blinn-Phong: a power of the cosine, in the old form and normalised. Its slopes follow Student's t distribution."""

from __future__ import annotations

from collections.abc import Callable
from math import cosh, exp, expm1, log, log1p, pi, sinh, sqrt
from typing import Any, ClassVar, NamedTuple

import mpmath
import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from microfacet.arithmetic import inverse_power, quotient_of_squares, two_product, two_sum
from microfacet.compiler.kernels import ByPrecision, Pair, Vector
from microfacet.directions import within
from microfacet.geometry.slopes import Distribution, around, normals_integral
from microfacet.parameters import double, each
from microfacet.statements import enclosures
from microfacet.statements.notation import chi, n, printed_symbol, q, u, wm, x, y
from microfacet.statements.proofs import under_integral
from microfacet.statements.statement import Equation

EXPONENT = (0.5, 1e4)
POWERS = [(0.5,), (1.0,), (10.0,), (1e4,)]  # at which integrals are enclosed
POWER_LIMITS = (1e-22, 1e22)  # within, as for the limits of alpha, all are numbers in both precisions
r = sp.Symbol("r", positive=True)
D_at_m = printed_symbol("D_m", r"D(\omega_m)")
K = printed_symbol("K", "K", positive=True)  # normalisation of the slopes along one direction

STEEPEST = ByPrecision(double=1e-140, single=1e-16)  # of a facet's cosine: below, the square of its slope is too large


def power_of_cosine(x: float, y: float, z: float, n: float) -> float:
    """cos^n of a normal above the horizon, by its slopes: next to the pole the rounded cosine has lost what they still have."""
    height = max(z, STEEPEST)
    tangent, rest = quotient_of_squares(x, y, height)
    return inverse_power(tangent, rest, 0.5 * n) if z > 0.0 else 0.0


def normalized_power(x: float, y: float, z: float, n: float) -> float:
    """By the root of the power, which keeps its digits where the power itself is too small for a number."""
    root = power_of_cosine(x, y, z, 0.5 * n)
    return ((n + 2.0) / (2.0 * pi) * root) * root


# --- statements ---------------------------------------------------------------------------------------------------


def _length_steps(it: Equation) -> list[Any]:
    """Over its length, which is 1, a unit vector's height is the cosine; with that put in, both forms are the same."""
    length = (wm.x**2 + wm.y**2 + wm.z**2).subs(wm.spherical) - 1
    return [length, (it.computed_as.subs(_COSINE, wm.z) - it.equals).subs(wm.spherical)]


with sp.evaluate(False):
    _COSINE = wm.z / sp.sqrt(wm.x**2 + wm.y**2 + wm.z**2)
with sp.evaluate(False):
    D = Equation(
        key="geometry.blinn_phong.D",
        title="Blinn-Phong distribution of normals, as first used",
        symbol=printed_symbol("D_blinn_phong", r"D(\omega_m)"),
        equals=chi(sp.cos(wm.theta)) * sp.cos(wm.theta) ** n,
        computed_as=chi(wm.z) * _COSINE**n,
        computed_by=power_of_cosine,
        rewrite_proof=_length_steps,
        where=wm.spherical,
        over={wm: "hemisphere", n: EXPONENT},
        slides=(55,),
        cite="blinn1977",
    )
    normalized_D = Equation(
        key="geometry.normalized_blinn_phong.D",
        title="normalised Blinn-Phong distribution of normals",
        symbol=printed_symbol("D_normalized_blinn_phong", r"D(\omega_m)"),
        equals=chi(sp.cos(wm.theta)) * (n + 2) / (2 * sp.pi) * sp.cos(wm.theta) ** n,
        computed_as=chi(wm.z) * (n + 2) / (2 * sp.pi) * _COSINE**n,
        computed_by=normalized_power,
        rewrite_proof=_length_steps,
        where=wm.spherical,
        within=(16, 16),
        over={wm: "hemisphere", n: EXPONENT},
        slides=(55,),
        cite="heitz2014",
    )

with sp.evaluate(False):
    cosine_power = sp.Integral(2 * sp.pi * sp.cos(wm.theta) ** (n + 1) * sp.sin(wm.theta), (wm.theta, 0, sp.pi / 2))


def _antiderivative() -> sp.Expr:
    return -2 * sp.pi * sp.cos(wm.theta) ** (n + 2) / (n + 2)


def _power_steps() -> list[Any]:
    """The antiderivative is checked by differentiation; it vanishes at pi/2, where the cosine does."""
    F = _antiderivative()
    return [
        sp.diff(F, wm.theta) - cosine_power.function,
        F.subs(wm.theta, sp.pi / 2),
        -F.subs(wm.theta, 0) - 2 * sp.pi / (n + 2),
    ]


with sp.evaluate(False):
    _mean = 2 * sp.pi / (n + 2)
    _scaled = (n + 2) / (2 * sp.pi) * cosine_power
    _student = sp.Integral((1 + q**2 + y**2) ** (-(n + 4) / 2), (y, -sp.oo, sp.oo))

projected_area = Equation(
    key="geometry.blinn_phong.projected_area",
    title="Blinn-Phong facets do not project to the surface",
    symbol=normals_integral(r"\left( \omega_m \cdot \omega_g \right) D(\omega_m)"),
    means=cosine_power,
    equals=_mean,
    proof=_power_steps,
    proved_by="sympy: antiderivative by differentiation, taken between the ends",
    over={n: EXPONENT},
    enclosed=lambda it: enclosures.agreement(cosine_power, it.equals, (n,), POWERS),
    slides=(55,),
    cite="heitz2014",
    note="Equal to 1 at one exponent only, n = 2 pi - 2.",
)
normalized_projected_area = Equation(
    key="geometry.normalized_blinn_phong.projected_area",
    title="normalised Blinn-Phong facets project to the whole surface",
    symbol=normals_integral(r"\left( \omega_m \cdot \omega_g \right) D(\omega_m)"),
    means=_scaled,
    equals=sp.Integer(1),
    enclosed=lambda it: enclosures.agreement(_scaled, 1, (n,), POWERS),
    proof=lambda: [*_power_steps(), (n + 2) / (2 * sp.pi) * 2 * sp.pi / (n + 2) - 1],
    proved_by="sympy: antiderivative by differentiation, taken between the ends",
    slides=(35, 36, 55),
    cite="heitz2014",
)

# --- masking of these slopes ----------------------------------------------------------------------------------------

STEPS = 120  # nodes of the trapezoidal rule below
REACH = 3.8  # they span (-REACH, REACH)
STEP = 2.0 * REACH / (STEPS - 1.0)
HALF_PI = 1.5707963267948966


def overlap(w: float, n: float) -> float:
    """H(w, n) by the trapezoidal rule after v = s exp(pi/2 sinh t), which decays doubly exponentially at both ends."""
    power = 0.5 * (n + 3.0)
    middle = 2.0 / (power * w + sqrt(power))
    total = 0.0
    for k in range(STEPS):
        t = k * STEP - REACH
        v = middle * exp(HALF_PI * sinh(t))
        total += cosh(t) * (v * v) * exp(-power * log1p(v * (2.0 * w + v)))
    return total * STEP * HALF_PI


v, w = sp.symbols("v w", positive=True)
c = sp.Symbol("c", positive=True)  # the cotangent of the view angle

with sp.evaluate(False):
    H = Equation(
        key="geometry.blinn_phong.H",
        title="overlap integral of Student's t distribution",
        symbol=sp.Function("H")(w, n),
        means=sp.Integral(v * (1 + 2 * w * v + v**2) ** (-(n + 3) / 2), (v, 0, sp.oo)),
        equals=sp.hyper([2, n + 1], [(n + 4) / 2], (1 - w) / 2) / ((n + 1) * (n + 2)),
        computed_by=overlap,
        within=(24, 24),
        over={w: (0, 1), n: EXPONENT},
        enclosed=lambda it: enclosures.agreement(
            _overlap_folded(), it.equals, (w, n), [(0.0, 0.5), (1.0, 0.5), (0.3, 1.0), (0.0, 10.0), (0.9, 10.0), (0.0, 1e3)]
        ),
        proof=lambda: _overlap_steps(),
        proved_by="Gradshteyn and Ryzhik 3.252.10, checked against the integral at 50 digits",
        slides=(62,),
        cite="gradshteyn2007, 3.252.10",
    )


def _overlap_folded() -> sp.Expr:
    """The integral up to 1, and beyond it over 1/v."""
    base = 1 + 2 * w * v + v**2
    return sp.Integral(v * base ** (-(n + 3) / 2), (v, 0, 1)) + sp.Integral(v**n * base ** (-(n + 3) / 2), (v, 0, 1))


def _overlap_steps() -> list[Any]:
    """The integral against the closed form, to 40 digits, at a few arguments: sympy has no rule for it."""
    with mpmath.workdps(60):
        return [sp.Integer(int(abs(_overlap_gap(k, e)) > mpmath.mpf(10) ** -40)) for k, e in ((0.1, 1.5), (0.5, 4), (0.9, 30))]


def _overlap_gap(k: float, e: float) -> Any:
    integral = mpmath.quad(
        lambda s: s * (1 + 2 * k * s + s * s) ** (-(mpmath.mpf(e) + 3) / 2), [0, 1 / mpmath.sqrt(e), 1, 4, mpmath.inf]
    )
    return integral - mpmath.hyp2f1(2, e + 1, (mpmath.mpf(e) + 4) / 2, (1 - mpmath.mpf(k)) / 2) / ((e + 1) * (e + 2))


def student_Lambda(c: float, n: float, K: float) -> float:
    """K (1+c^2)^(-(n+1)/2) H / c, with the rounding of 1 + c^2 and of n + 1 carried through the power."""
    square, lost = two_product(c, c)
    total = 1.0 + square
    doubled, missing = two_sum(n, 1.0)
    decay = inverse_power(square, lost, 0.5 * doubled) * (1.0 - 0.5 * missing * log(total))
    return K * decay * overlap(c / sqrt(total), n) / c


with sp.evaluate(False):
    Lambda = Equation(
        key="geometry.blinn_phong.Lambda",
        title="Smith's Lambda for Blinn-Phong slopes",
        symbol=sp.Function("Lambda_student")(c),
        means=sp.Integral((q - c) * K * (1 + q**2) ** (-(n + 3) / 2), (q, c, sp.oo)) / c,
        equals=K * (1 + c**2) ** (-(n + 1) / 2) * sp.Function("H")(c / sp.sqrt(1 + c**2), n) / c,
        computed_by=student_Lambda,
        within=(32, 32),
        over={c: (1e-6, 1e3), n: (0.5, 1000), K: (1e-2, 1e2)},
        enclosed=lambda it: enclosures.agreement(
            _hidden_folded(it), it.equals, (c, n, K), [(0.1, 0.5, 1.0), (1.0, 1.0, 1.0), (0.5, 10.0, 1.0), (2.0, 10.0, 1.0)]
        ),
        proof=lambda: _substitution_steps(),
        proved_by="sympy: substitution q = c + sqrt(1+c^2) v",
        slides=(62,),
        cite="heitz2014",
        note="Normalised Blinn-Phong needs its own Lambda; borrowing Beckmann's breaks the furnace.",
    )


def _hidden_folded(it: Equation) -> sp.Expr:
    """The integral up to c + 1, and beyond it over 1/q."""
    (whole,) = it.means.atoms(sp.Integral)
    factor_ = sp.simplify(whole.function.doit() / ((q - c) * (1 + q**2) ** (-(n + 3) / 2)))  # what does not depend on q
    beyond = factor_ * (1 - c * u) * u**n * (1 + u**2) ** (-(n + 3) / 2)
    return under_integral(it, sp.Integral(whole.function, (q, c, c + 1)) + sp.Integral(beyond, (u, 0, 1 / (c + 1))))


def _substitution_steps() -> list[Any]:
    """q = c + sqrt(1+c^2) v turns 1+q^2 into (1+c^2)(1+2wv+v^2), w = c/sqrt(1+c^2), and q-c into sqrt(1+c^2) v."""
    s = sp.sqrt(1 + c**2)
    moved = c + s * v
    kernel = s**2 * (1 + 2 * c / s * v + v**2)
    return [1 + moved**2 - kernel, (moved - c) * sp.diff(moved, v) - s**2 * v, s**2 * s ** (-(n + 3)) - s ** (-(n + 1))]


_K = sp.sqrt(sp.pi) * sp.gamma((n + 3) / 2) / sp.gamma((n + 4) / 2)

with sp.evaluate(False):
    slopes = Equation(
        key="geometry.blinn_phong.P22",
        title="Blinn-Phong slopes are Student's, but for a factor",
        symbol=printed_symbol("P22_blinn_phong", r"P_{22}(\tilde{x}, \tilde{y})"),
        means=sp.cos(wm.theta) ** 4 * D_at_m,
        equals=(1 + x**2 + y**2) ** (-(n + 4) / 2),
        proof=lambda it: _slope_steps(it),
        proved_by="sympy: the slopes of a normal at its angles put in",
        slides=(55, 62),
        cite="blinn1977",
    )
    factor = Equation(
        key="geometry.blinn_phong.K",
        title="the factor of Blinn-Phong slopes along one direction",
        symbol=K,
        means=sp.Integral((1 + r**2) ** (-(n + 4) / 2), (r, -sp.oo, sp.oo)),
        equals=sp.sqrt(sp.pi) * sp.gamma((n + 3) / 2) / sp.gamma((n + 4) / 2),
        enclosed=lambda it: enclosures.agreement(_beta_folded(it), it.equals, (n,), POWERS),
        proof=lambda it: _beta_steps(it),
        proved_by="sympy: Euler's beta integral",
        slides=(62,),
        cite="heitz2014",
    )
    marginal = Equation(
        key="geometry.blinn_phong.P2",
        title="Blinn-Phong slopes along one direction",
        symbol=printed_symbol("P2_blinn_phong", r"P_2(q)"),
        means=_student,
        equals=K * (1 + q**2) ** (-(n + 3) / 2),
        where={K: _K},
        proof=lambda it: _marginal_steps(it),
        enclosed=lambda it: enclosures.agreement(
            _across_folded(it), it.equals.subs(K, _K), (q, n), [(0.0, 0.5), (1.0, 1.0), (3.0, 10.0), (0.5, 1e3)]
        ),
        proved_by="sympy: y = sqrt(1+q^2) r leaves the integral K",
        slides=(62,),
        cite="heitz2014",
    )


def _slope_steps(it: Equation) -> list[Any]:
    """At the slopes of a normal 1 + x^2 + y^2 is 1/cos^2; then both forms are powers of the cosine."""
    cosine = sp.Symbol("cosine", positive=True)
    put = {x: -sp.tan(wm.theta) * sp.cos(wm.phi), y: -sp.tan(wm.theta) * sp.sin(wm.phi)}
    density = D.equals.doit().subs(chi(sp.cos(wm.theta)), 1)
    normals = it.means.doit().subs(D_at_m, density).subs(sp.cos(wm.theta), cosine)
    return [
        (1 + x**2 + y**2).subs(put) - 1 / sp.cos(wm.theta) ** 2,
        normals - it.equals.doit().subs(x**2, cosine**-2 - 1 - y**2),
    ]


def _beta_folded(it: Equation) -> sp.Expr:
    """Twice the integral up to 1, and beyond it over 1/r."""
    (whole,) = it.means.atoms(sp.Integral)
    beyond = whole.function.doit().subs(r, 1 / r) / r**2
    beyond = beyond.subs((1 + r**-2) ** (-(n + 4) / 2), r ** (n + 4) * (1 + r**2) ** (-(n + 4) / 2))
    parts = (whole.function, sp.powsimp(beyond, force=True))
    return under_integral(it, 2 * sum(sp.Integral(part, (r, 0, 1)) for part in parts))


def _beta_steps(it: Equation) -> list[Any]:
    beta = 2 * sp.integrate((1 + r**2) ** (-(n + 4) / 2), (r, 0, sp.oo), conds="none")
    return [sp.gammasimp(beta / it.equals.doit()) - 1]


def _across_folded(it: Equation) -> sp.Expr:
    """Twice the integral up to 1, and beyond it over 1/y."""
    near = (1 + q**2 + y**2) ** (-(n + 4) / 2)
    beyond = y ** (n + 2) * (1 + (1 + q**2) * y**2) ** (-(n + 4) / 2)
    (whole,) = it.means.atoms(sp.Integral)
    scale = sp.simplify(whole.function.doit() / near)
    return under_integral(it, 2 * scale * sum(sp.Integral(part, (y, 0, 1)) for part in (near, beyond)))


def _marginal_steps(it: Equation) -> list[Any]:
    """1 + q^2 + y^2 = (1 + q^2)(1 + r^2), and dy = sqrt(1 + q^2) dr."""
    base = sp.Symbol("base", positive=True)  # 1 + q^2
    across = sp.sqrt(base) * r
    moved = base ** (-(n + 4) / 2) * (1 + r**2) ** (-(n + 4) / 2) * sp.diff(across, r)
    stated = it.means.doit(integrals=False) if it.means.has(sp.Integral) else it.means
    spread = under_integral(it, sp.Symbol("spread"))
    return [
        base + across**2 - base * (1 + r**2),
        moved / factor.means.function.doit() * K - it.equals.doit().subs(1 + q**2, base),
        spread - sp.Symbol("spread"),
        *(i.function.doit() - (1 + q**2 + y**2) ** (-(n + 4) / 2) for i in stated.atoms(sp.Integral)),
    ]


# --- kernels --------------------------------------------------------------------------------------------------------


class Power(NamedTuple):
    """Parameters: the exponent n, and the factor K of the slopes along one direction."""

    n: float
    K: float


def kernel_D(wm: Vector, p: Power) -> float:
    return power_of_cosine(wm[0], wm[1], wm[2], p.n)


def kernel_normalized_D(wm: Vector, p: Power) -> float:
    return normalized_power(wm[0], wm[1], wm[2], p.n)


def kernel_drawn(wm: Vector, p: Power) -> float:
    """The normalised distribution where the other is not 0, so that no direction has a density and no value."""
    return (p.n + 2.0) / (2.0 * pi) * power_of_cosine(wm[0], wm[1], wm[2], p.n)


def kernel_Lambda(w: Vector, p: Power) -> float:
    x, y, z = w
    across = sqrt(x * x + y * y)
    return 0.0 if across == 0.0 else student_Lambda(abs(z) / across, p.n, p.K)


def kernel_sample(u: Pair, p: Power) -> Pair:
    """The square of the tangent is (1 - u1)^(-2/(n + 2)) - 1."""
    return around(sqrt(expm1(-2.0 * log1p(-u[0]) / (p.n + 2.0))), u[1])


def kernel_excess(wm: Vector, p: Power) -> float:
    return 2.0 * pi / (p.n + 2.0)


def _power(name: str, value: Any) -> float:
    return within(name, value, POWER_LIMITS)


EULER = (-1.0, 5.0, -61.0, 1385.0, -50521.0)  # E_2, E_4, ...
SHIFT, HIGH = 16, 1e3


def gamma_ratio(a: Any) -> Any:
    """Gamma(a + 3/2)/Gamma(a + 2) of numbers or arrays a >= 0, to a few ulps.

    About w = a + 5/4 its logarithm is -log(w)/2 plus the sum of E_2j/(j 4^(2j + 1) w^2j), which five terms give from w = 17 on;
    lower arguments are raised by as much, factor by factor. tricomi1951.
    """
    low = np.minimum(a, HIGH)[..., None] + np.arange(SHIFT)
    raised = np.where(a < HIGH, np.prod((low + 2) / (low + 1.5), axis=-1), 1.0)
    w = np.where(a < HIGH, a + SHIFT, a) + 1.25
    total: Any = 0.0
    for j in range(len(EULER), 0, -1):
        total = (total + EULER[j - 1] / (j * 4.0 ** (2 * j + 1))) / (w * w)
    ratio = raised * np.exp(total) / np.sqrt(w)
    return ratio if np.ndim(a) else float(ratio)


class BlinnPhong(Distribution):
    r"""Blinn-Phong distribution of normals, not normalised.

    .. math:: D(\omega_m) = \chi^{+}(z_m) \, z_m^n

    Its projected area is :math:`2\pi/(n + 2)`, so `validate` fails it for nearly every exponent. Statement
    ``geometry.blinn_phong.D``.

    Parameters
    ----------
    n : array_like
        Exponent, dimensionless, from 1e-22 to 1e22; a number, or an array that broadcasts with the directions.

    Raises
    ------
    ValueError
        If an exponent is outside that range.

    References
    ----------
    blinn1977.

    Examples
    --------
    >>> import microfacet as mf
    >>> print(f"{mf.BlinnPhong(100).D([0.1, 0.0, 0.99 ** 0.5]):.4f}")
    0.6050
    """

    label, cite = "Blinn-Phong", "blinn1977"
    statements: ClassVar = {"D": D, "projected_area": projected_area}
    regular = True

    kernel: ClassVar[Callable[..., float]] = staticmethod(kernel_D)
    sample_kernel: ClassVar[Callable[..., Pair] | None] = staticmethod(kernel_sample)
    sampled_kernel: ClassVar[Callable[..., float] | None] = staticmethod(kernel_drawn)
    excess_kernel: ClassVar[Callable[..., float] | None] = staticmethod(kernel_excess)
    closed_Lambda: ClassVar[Callable[..., float] | None] = staticmethod(kernel_Lambda)
    isotropic = True

    def __init__(self, n: ArrayLike) -> None:
        self.n = each(_power, "n", n)
        half = double(self.n) / 2
        self.parameters = Power(self.n, sqrt(pi) * gamma_ratio(half) * self._normalisation())
        self.alpha = self.slope_scale = (1 / (1 + half) ** 0.5,) * 2

    def _normalisation(self) -> Any:
        return 1.0

    @property
    def shown(self) -> tuple[Any, ...]:
        return (self.n,)


class NormalizedBlinnPhong(BlinnPhong):
    r"""Blinn-Phong distribution of normals, normalised.

    .. math:: D(\omega_m) = \frac{n + 2}{2\pi} \, \chi^{+}(z_m) \, z_m^n

    Statements ``geometry.normalized_blinn_phong.D`` and ``geometry.blinn_phong.Lambda``.

    Parameters
    ----------
    n : array_like
        Exponent, dimensionless, from 1e-22 to 1e22; a number, or an array that broadcasts with the directions.

    Raises
    ------
    ValueError
        If an exponent is outside that range.

    References
    ----------
    blinn1977; heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> ndf = mf.NormalizedBlinnPhong(100)
    >>> print(f"{ndf.D([0, 0, 1]):.4f} {mf.seen_area(ndf).value:.6f}")
    16.2338 1.000000
    """

    label, cite = "Blinn-Phong, normalised", "heitz2014"
    statements: ClassVar = {"D": normalized_D, "projected_area": normalized_projected_area}
    regular = True

    kernel = staticmethod(kernel_normalized_D)
    sample_kernel, closed_Lambda = BlinnPhong.sample_kernel, BlinnPhong.closed_Lambda

    def _normalisation(self) -> Any:
        return (double(self.n) + 2) / (2 * pi)
