"""Proofs of the talk's two tables: for each tick an enclosure of an integral, for each cross a residual that excludes 0.

All integrals over normals are taken over the slope q along the view direction, where a facet faces the viewer if
q < cot theta_o: per unit of projected area its visible area is then 1 - q tan theta_o. Only Kelemen's needs slopes in polar
coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import sympy as sp

from microfacet.geometry import beckmann, blinn_phong, ggx, ward
from microfacet.geometry.slopes import normals_integral
from microfacet.statements import ball_functions, balls, enclosures
from microfacet.statements.balls import Ball, ball
from microfacet.statements.enclosures import Enclosure
from microfacet.statements.notation import Lambda_o, a, alpha, mu_o, n, printed_symbol, q, theta_o, wm
from microfacet.statements.registry import registry
from microfacet.statements.statement import Equation

ROUGH = (1e-4, 0.1, 1.0, 10.0)
POWERS = (0.5, 10.0, 1e4)
ANGLES = (1e-3, 30.0, 60.0, 89.9, 90 - 1e-6)  # degrees
FAR = 9  # in units of alpha: the fraction of Gaussian slopes beyond is below 1e-36

w = sp.Symbol("w", real=True)  # a slope along the view, substituted to suit the distribution
tan_o = printed_symbol("tan_o", r"\tan \theta_o", positive=True)
COTANGENT = sp.cot(theta_o)
CONSTANT, SLOPE, LOW, HIGH = sp.symbols("constant slope low high", real=True)

# --- slopes along the view ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Slopes:
    """One distribution's slopes along the view, as functions of w, which goes from -end to end.

    q: the slope. density: P2(q), evaluated; printed: the same, as its statement writes it.
    level: density times dq/dw. tilted: the same times q.
    hidden: Smith's Lambda. Lambda, edge: the same, and w at q = cot theta_o, from shape and tan theta_o.
    missing: bounds the integrals of 1 and of q tan theta_o, times the density, beyond the ends.
    """

    shape: sp.Symbol
    shapes: tuple[float, ...]
    q: sp.Expr
    density: sp.Expr
    printed: sp.Expr
    level: sp.Expr
    tilted: sp.Expr
    end: sp.Expr
    hidden: sp.Expr
    Lambda: Callable[[Ball, Ball], Ball]
    edge: Callable[[Ball, Ball], Ball]
    missing: Callable[[Ball, Ball], Ball] = lambda shape, tangent: ball(0)

    @property
    def points(self) -> list[dict[str, float]]:
        return [{str(self.shape): s, "degrees": d} for s in self.shapes for d in ANGLES]

    def integral(self, constant: Any, slope: Any, shape: Ball, low: Ball, high: Ball) -> Ball:
        """Integral of (constant + slope q) P2(q) dq between two values of w."""
        return _integral(self.level, self.tilted, self.shape)(ball(constant), ball(slope), shape, low, high)

    def steps(self) -> list[Any]:
        """The substitution, in tau = tan w where cosines occur; and the density is even."""
        tau = sp.Symbol("tau", real=True)
        angular = self.level.has(sp.cos)
        put = {w: sp.atan(tau)} if angular else {w: tau}
        rate = sp.diff(self.q.subs(put), tau) * (1 + tau**2 if angular else 1)
        measure = self.density.subs(q, self.q.subs(put)) * rate
        return [
            sp.powsimp(sp.simplify(measure / self.level.subs(put))) - 1,
            sp.simplify(self.q.subs(put) * self.level.subs(put) - self.tilted.subs(put)),
            self.density - self.density.subs(q, -q),
        ]


@cache
def _integral(level: sp.Expr, tilted: sp.Expr, shape: sp.Symbol) -> Callable[..., Ball]:
    inside = sp.Integral(CONSTANT * level + SLOPE * tilted, (w, LOW, HIGH))
    return ball_functions.evaluator(inside, (CONSTANT, SLOPE, shape, LOW, HIGH))


@cache
def _function(statement: Equation, *arguments: sp.Symbol) -> Callable[..., Ball]:
    """The closed form of a statement as a function of balls."""
    return ball_functions.evaluator(statement.equals, arguments)


def _beckmann_Lambda(alpha: Ball, tangent: Ball) -> Ball:
    return _function(beckmann.Lambda, *beckmann.Lambda.arguments)(1 / (alpha * tangent))


def _ggx_Lambda(alpha: Ball, tangent: Ball) -> Ball:
    return _function(ggx.Lambda, *ggx.Lambda.arguments)(1 / (alpha * tangent))


def _student_Lambda(n: Ball, tangent: Ball) -> Ball:
    K = (n + 2) / (2 * balls.pi()) * _function(blinn_phong.factor, sp.Symbol("n", positive=True))(n)
    return _function(blinn_phong.Lambda, *blinn_phong.Lambda.arguments)(1 / tangent, n, K)


def _gaussian_tail(alpha: Ball, tangent: Ball) -> Ball:
    """Bound of the integrals beyond s = FAR, q = alpha s: of exp(-s^2)/sqrt(pi), and of that times alpha s tan theta_o."""
    tail = ball(FAR).erfc() + alpha * tangent * ball(-FAR * FAR).exp()
    return tail.union(-tail)


BECKMANN = Slopes(
    shape=alpha,
    shapes=ROUGH,
    q=alpha * w,
    density=beckmann.P2.equals.doit(),
    printed=beckmann.P2.equals,
    level=sp.exp(-(w**2)) / sp.sqrt(sp.pi),
    tilted=alpha * w * sp.exp(-(w**2)) / sp.sqrt(sp.pi),
    end=sp.Integer(FAR),
    hidden=beckmann.Lambda.equals.doit().subs(a, COTANGENT / alpha),
    Lambda=_beckmann_Lambda,
    edge=lambda alpha, tangent: 1 / (alpha * tangent),
    missing=_gaussian_tail,
)
GGX = Slopes(
    shape=alpha,
    shapes=ROUGH,
    q=alpha * sp.tan(w),
    density=ggx.P2.equals.doit(),
    printed=ggx.P2.equals,
    level=sp.cos(w) / 2,
    tilted=alpha * sp.sin(w) / 2,
    end=sp.pi / 2,
    hidden=ggx.Lambda.equals.doit().subs(a, COTANGENT / alpha),
    Lambda=_ggx_Lambda,
    edge=lambda alpha, tangent: (1 / (alpha * tangent)).atan(),
)
_NORM = (n + 2) / (2 * sp.pi) * blinn_phong.factor.equals.doit()
STUDENT = Slopes(
    shape=n,
    shapes=POWERS,
    q=sp.tan(w),
    density=blinn_phong.marginal.equals.doit().subs(blinn_phong.K, _NORM),
    printed=blinn_phong.marginal.equals,
    level=_NORM * sp.cos(w) ** (n + 1),
    tilted=_NORM * sp.cos(w) ** n * sp.sin(w),
    end=sp.pi / 2,
    hidden=registry.expand(
        blinn_phong.Lambda.equals.doit().subs(dict(zip(blinn_phong.Lambda.arguments, (COTANGENT, n, _NORM), strict=True)))
    ),
    Lambda=_student_Lambda,
    edge=lambda n, tangent: (1 / tangent).atan(),
)
TABLE_2_FAMILIES = ("beckmann", "ggx", "normalized_blinn_phong")


def radians(degrees: Ball) -> Ball:
    return degrees * balls.pi() / 180


# --- ticks: Smith and V-cavities ------------------------------------------------------------------------------------------


def smith_residual(slopes: Slopes, shape: Ball, degrees: Ball) -> Ball:
    """Visible area by Smith's masking of the facets that face the viewer, over the true value, less 1."""
    tangent = radians(degrees).tan()
    edge = slopes.edge(shape, tangent).min(ball(slopes.end))
    facing = slopes.integral(1, -tangent, shape, -ball(slopes.end), edge) + slopes.missing(shape, tangent)
    return facing / (1 + slopes.Lambda(shape, tangent)) - 1


def cavity_residual(slopes: Slopes, shape: Ball, degrees: Ball) -> Ball:
    """V-cavities leave 1 - q tan theta_o of a facet visible, but at most 2, which masks it where q < -cot theta_o."""
    tangent = radians(degrees).tan()
    edge, end = slopes.edge(shape, tangent).min(ball(slopes.end)), ball(slopes.end)
    free = slopes.integral(1, -tangent, shape, -edge, edge)
    masked = slopes.integral(2, 0, shape, -end, -edge)
    return free + masked + 2 * slopes.missing(shape, ball(0)) - 1


def _enclosed(residual: Callable[[Slopes, Ball, Ball], Ball], slopes: Slopes) -> list[Enclosure]:
    return enclosures.at(lambda **point: residual(slopes, point[str(slopes.shape)], point["degrees"]), slopes.points)


def visible_fraction(masking: str, over: str) -> sp.Symbol:
    """The visible area over its true value, for a masking function over a distribution, whose last word is its subscript."""
    integrand = (
        rf"G_1^{{\text{{{masking}}}}}(\omega_o, \omega_m) \left\langle \omega_o, \omega_m \right\rangle"
        rf" D_{{\text{{{over.split()[-1]}}}}}(\omega_m)"
    )
    return printed_symbol(
        f"visible_share_{masking}_{over}", rf"\frac{{1}}{{\cos \theta_o}} \int_{{\Omega}} {integrand} \, d\omega_m"
    )


def deviation(masking: str, over: str) -> sp.Expr:
    """The deviation of that from 1."""
    with sp.evaluate(False):
        return visible_fraction(masking, over) - 1


def _facing(P2: sp.Expr) -> sp.Expr:
    """Visible area by Smith's masking of the facets that face the viewer."""
    with sp.evaluate(False):
        return sp.Integral((1 - q * sp.tan(theta_o)) * P2, (q, -sp.oo, sp.cot(theta_o))) / (1 + Lambda_o)


def _free_and_cut(P2: sp.Expr) -> sp.Expr:
    """Visible area by V-cavities: facets of small slope whole, those of large slope with twice their projected area."""
    free, cut = (-sp.cot(theta_o), sp.cot(theta_o)), (-sp.oo, -sp.cot(theta_o))
    with sp.evaluate(False):
        return 2 * sp.Integral(P2, (q, *cut)) + sp.Integral((1 - q * sp.tan(theta_o)) * P2, (q, *free))


def _smith_steps(slopes: Slopes) -> list[Any]:
    """Beyond the edge -(1 - q tan) is tan (q - cot), which is Lambda's integrand; below it, 1 - q tan averages to 1."""
    return [*slopes.steps(), -(1 - q * tan_o) - tan_o * (q - 1 / tan_o)]


def _cavity_steps(slopes: Slopes) -> list[Any]:
    """A slope and its opposite together show 2: each is unmasked, or one shows 2 and the other 0."""
    return [*slopes.steps(), (1 - q * tan_o) + (1 + q * tan_o) - 2]


def _smith(key: str, over: str, slopes: Slopes) -> Equation:
    return Equation(
        key=key,
        title=f"Smith over {over}: what is seen is what there is to see",
        symbol=visible_fraction("Smith", over),
        means=_facing(slopes.printed),
        equals=sp.Integer(1),
        where={blinn_phong.K: _NORM, Lambda_o: slopes.hidden},
        proof=lambda it: [*_smith_steps(slopes), it.means - _facing(slopes.printed), it.equals - 1],
        proved_by="sympy: the hidden part is Lambda's integral; the slopes are even, and their density is of norm 1",
        enclosed=lambda it: _enclosed(smith_residual, slopes),
        slides=(39, 40, 58),
        cite="heitz2014",
    )


def _cavity(key: str, over: str, slopes: Slopes) -> Equation:
    return Equation(
        key=key,
        title=f"V-cavities over {over}: what is seen is what there is to see",
        symbol=visible_fraction("V", over),
        means=_free_and_cut(slopes.printed),
        equals=sp.Integer(1),
        where={blinn_phong.K: _NORM},
        proof=lambda it: [*_cavity_steps(slopes), it.means - _free_and_cut(slopes.printed), it.equals - 1],
        proved_by="sympy: a slope and its opposite together show 2; the slopes are even, and their density is of norm 1",
        enclosed=lambda it: _enclosed(cavity_residual, slopes),
        slides=(39, 40, 58),
        cite="cook1982; heitz2014",
    )


PHONG_LABEL = "normalised Blinn-Phong"

_smith(
    key="validation.table2.smith_beckmann",
    over="Beckmann",
    slopes=BECKMANN,
)
_smith(
    key="validation.table2.smith_ggx",
    over="GGX",
    slopes=GGX,
)
_smith(
    key="validation.table2.smith_normalized_blinn_phong",
    over=PHONG_LABEL,
    slopes=STUDENT,
)
_cavity(
    key="validation.table2.v_cavity_beckmann",
    over="Beckmann",
    slopes=BECKMANN,
)
_cavity(
    key="validation.table2.v_cavity_ggx",
    over="GGX",
    slopes=GGX,
)
_cavity(
    key="validation.table2.v_cavity_normalized_blinn_phong",
    over=PHONG_LABEL,
    slopes=STUDENT,
)


# --- crosses: table 1 -------------------------------------------------------------------------------------------------------

projected = normals_integral(r"\left( \omega_m \cdot \omega_g \right) D(\omega_m)")

with sp.evaluate(False):
    _PHONG = 2 * sp.pi / (n + 2) - 1
    phong = Equation(
        key="validation.table1.blinn_phong",
        title="by how much Blinn-Phong misses its projected area",
        symbol=projected - 1,
        means=_PHONG,
        equals=(2 * sp.pi - 2 - n) / (n + 2),
        enclosed=lambda it: _phong_enclosed(it.equals),
        slides=(35, 36, 55),
        cite="blinn1977",
        note="Too much below n = 2 pi - 2, right there, too little above.",
    )


def _phong_enclosed(closed: sp.Expr) -> list[Enclosure]:
    """Integral minus closed form, at exponents down to 0.5 and up to 10^4, and at the one that passes."""
    area = ball_functions.evaluator(blinn_phong.cosine_power, (n,))
    excess = ball_functions.evaluator(closed, (n,))
    with balls.precision(enclosures.ENCLOSING):
        exponents = [*(ball(e) for e in POWERS), 2 * balls.pi() - 2]
    return enclosures.at(lambda n: area(n) - 1 - excess(n), [{"n": e} for e in exponents])


def _ward_steps() -> list[Any]:
    """Ward's D is Beckmann's times cos^4, which is below 1 except at the pole; and Beckmann's integral is 1."""
    return [ward.D.equals.doit() - beckmann.D.equals.doit() * sp.cos(wm.theta) ** 4]


ward_area = Equation(
    key="validation.table1.ward",
    title="Ward's facets never project to the whole surface",
    symbol=projected,
    equals=sp.Integer(1),
    relation="<",
    proof=_ward_steps,
    proved_by="sympy: Ward is Beckmann times the fourth power of the cosine",
    enclosed=lambda it: [enclosures.over(_ward_residual, alpha=(0.05, 1))],
    slides=(35, 36, 55),
    cite="ward1992",
    note="For every roughness, isotropic or not; the enclosure says by how much, for alpha between 0.05 and 1.",
)


def _ward_residual(alpha: Ball) -> Ball:
    """x e^x E_2(x), x = 1/alpha^2, is the integral of e^(-s)/(1 + s/x)^2 over s > 0 and rises with x: its ends suffice."""
    area = _function(ward.projected_area, sp.Symbol("alpha", positive=True))
    return area(alpha.lower()).union(area(alpha.upper())) - 1


# --- crosses: table 2, closed forms ---------------------------------------------------------------------------------------

k = sp.Symbol("k", positive=True)
root = sp.sqrt(mu_o**2 + alpha**2 * (1 - mu_o**2))
tangent = sp.sqrt(1 - mu_o**2) / mu_o
ggx_Lambda_o = ggx.Lambda.equals.doit().subs(ggx.Lambda.symbol.args[0], 1 / (alpha * tangent))


def _closed_steps(masking: sp.Expr, stated: sp.Expr) -> list[Any]:
    """1 + Lambda = (mu + E)/(2 mu), E the root; then with mu and E as unknowns bound by E^2 = mu^2 + alpha^2 (1 - mu^2)."""
    E = sp.Symbol("E", positive=True)
    residual = masking * (mu_o + E) / (2 * mu_o) - 1 - stated.doit().subs(root, E)
    numerator = sp.expand(sp.fraction(sp.together(residual))[0])
    lambda_square = sp.simplify(((2 * ggx_Lambda_o + 1) * mu_o) ** 2 - root**2)
    return [lambda_square, sp.rem(numerator, E**2 - root**2, E)]


def _sign_steps(bracket: sp.Expr, largest: sp.Expr) -> list[Any]:
    """The bracket is linear in mu, negative at 0, and 0 at mu = 1 for the largest alpha: below it, negative for every mu."""
    ends = [bracket.subs(mu_o, 0).subs(alpha, largest), bracket.subs(mu_o, 1).diff(alpha)]
    signs = sp.Integer(0 if ends[0].is_negative and ends[1].is_positive else 1)
    return [sp.diff(bracket, mu_o, 2), bracket.subs({mu_o: 1, alpha: largest}), signs]


with sp.evaluate(False):
    _IMPLICIT = (1 - mu_o) * (alpha**2 * (1 + mu_o) - 4) / (2 * (2 - mu_o + root))
    _SCHLICK = (
        (1 - mu_o)
        * (alpha**2 * (1 + mu_o) - 4 * k**2 * (1 - mu_o) - 4 * k * mu_o)
        / (2 * (mu_o + k * (1 - mu_o)) * (root + mu_o + 2 * k * (1 - mu_o)))
    )
    _HALVED = alpha * (alpha - 1) * mu_o * (1 - mu_o) / ((mu_o + alpha * (1 - mu_o) / 2) * (root + mu_o + alpha * (1 - mu_o)))

COSINES = (1e-6, 0.5, 0.999)
SCHLICK_K = sp.sqrt(2 / sp.pi)
IMPLICIT_UP_TO, SCHLICK_UP_TO = sp.sqrt(2), 2 * SCHLICK_K  # the largest alpha for which the closed forms have one sign


def _closed_enclosed(masking: sp.Expr, stated: sp.Expr, alphas: tuple[float, ...]) -> list[Enclosure]:
    """Integral over slopes times the masking function, less 1, less the closed form."""
    mask, excess = ball_functions.evaluator(masking, (alpha, mu_o)), ball_functions.evaluator(stated, (alpha, mu_o))

    def apart(alpha: Ball, mu: Ball) -> Ball:
        tangent = (1 - mu**2).sqrt() / mu
        facing = GGX.integral(1, -tangent, alpha, -ball(GGX.end), GGX.edge(alpha, tangent))
        return mask(alpha, mu) * facing - 1 - excess(alpha, mu)

    return enclosures.at(apart, [{"alpha": a, "mu": m} for a in alphas for m in COSINES])


implicit_ggx = Equation(
    key="validation.table2.implicit_ggx",
    title="by how much Implicit masking over GGX misses what there is to see",
    symbol=deviation("implicit", "GGX"),
    equals=_IMPLICIT,
    proof=lambda: [*_closed_steps(mu_o, _IMPLICIT), *_sign_steps(alpha**2 * (1 + mu_o) - 4, IMPLICIT_UP_TO)],
    proved_by="sympy: Lambda put in, then modulo the square of the root",
    enclosed=lambda it: _closed_enclosed(mu_o, it.equals, ROUGH),
    slides=(58,),
    cite="hoffman2010",
    note="Zero at normal incidence and where alpha^2 (1 + cos theta_o) = 4, which needs alpha above sqrt 2.",
)
schlick_ggx = Equation(
    key="validation.table2.schlick_smith_ggx",
    title="by how much Schlick-Smith over GGX misses what there is to see",
    symbol=deviation("Schlick", "GGX"),
    equals=_SCHLICK,
    proof=lambda: [
        *_closed_steps(mu_o / (mu_o + k * (1 - mu_o)), _SCHLICK),
        *_sign_steps(alpha * (1 + mu_o) - 4 * alpha * SCHLICK_K**2 * (1 - mu_o) - 4 * SCHLICK_K * mu_o, SCHLICK_UP_TO),
    ],
    proved_by="sympy: Lambda put in, then modulo the square of the root",
    enclosed=lambda it: _closed_enclosed(
        (mu_o / (mu_o + k * (1 - mu_o))).subs(k, alpha * SCHLICK_K), it.equals.doit().subs(k, alpha * SCHLICK_K), ROUGH
    ),
    slides=(58,),
    cite="schlick1994",
    note="Zero at normal incidence; enclosed for k = alpha sqrt(2/pi).",
)
halved_ggx = Equation(
    key="validation.table2.schlick_smith_halved_ggx",
    title="by how much Schlick-Smith with k = alpha/2 over GGX misses what there is to see",
    symbol=deviation("Schlick", "GGX"),
    equals=_HALVED,
    proof=lambda: [*_closed_steps((mu_o / (mu_o + k * (1 - mu_o))).subs(k, alpha / 2), _HALVED), _HALVED.doit().subs(alpha, 1)],
    proved_by="sympy: Lambda put in, then modulo the square of the root",
    enclosed=lambda it: _closed_enclosed((mu_o / (mu_o + k * (1 - mu_o))).subs(k, alpha / 2), it.equals, ROUGH),
    slides=(58,),
    cite="schlick1994",
    note="Zero for every direction at alpha = 1, where it is Smith's function; elsewhere at normal and grazing incidence only.",
)

# --- crosses: table 2, over boxes -----------------------------------------------------------------------------------------

SMOOTHEST, ROUGHEST = 0.01, 2.0
STEEPEST, FLATTEST = 0.001, 90.0  # degrees

_hidden_slopes = sp.expand(beckmann.Lambda.equals.doit() * a)  # a Lambda(a), the integral of (q - a) P2(q) over q > a


def _hidden(alpha: Ball, degrees: Ball) -> Ball:
    """mu Lambda/(alpha (1 - mu)) for Beckmann: cot(theta/2) a Lambda(a), which falls with a: the ends of a box bound it."""
    slopes = _plain(_hidden_slopes, a)
    argument = radians(degrees).cos().nonnegative_part() / (alpha * radians(degrees).sin())
    return slopes(argument.upper()).union(slopes(argument.lower().nonnegative_part())) / (radians(degrees) / 2).tan()


@cache
def _plain(expression: sp.Expr, *arguments: sp.Symbol) -> Callable[..., Ball]:
    return ball_functions.evaluator(expression, arguments)


def _implicit_box(alpha: Ball, degrees: Ball) -> Ball:
    """(fraction - 1)/(1 - mu) with fraction = mu (1 + Lambda)."""
    return alpha * _hidden(alpha, degrees) - 1


def _schlick_box(alpha: Ball, degrees: Ball) -> Ball:
    """(f - 1)(mu + k (1 - mu))/(alpha (1 - mu)) with f = mu (1 + Lambda)/(mu + k (1 - mu)), k = alpha sqrt(2/pi)."""
    return _hidden(alpha, degrees) - (2 / balls.pi()).sqrt()


def _box_steps() -> list[Any]:
    """Both differences, divided as above, in Lambda and mu; and mu/(1 - mu) is cot(theta/2)/tan(theta)."""
    L, mu = sp.symbols("L mu", positive=True)
    half = sp.Symbol("half", positive=True)
    weight = mu + k * (1 - mu)
    return [
        sp.simplify((mu * (1 + L) - 1) / (1 - mu) - (mu * L / (1 - mu) - 1)),
        sp.simplify((mu * (1 + L) / weight - 1) * weight / (1 - mu) - (mu * L / (1 - mu) - k)),
        sp.cos(2 * half) / (1 - sp.cos(2 * half)) - sp.cot(half) / sp.tan(2 * half),
    ]


BOX = {"alpha": (SMOOTHEST, ROUGHEST), "degrees": (STEEPEST, FLATTEST)}

implicit_beckmann = Equation(
    key="validation.table2.implicit_beckmann",
    title="Implicit masking over Beckmann shows too little from every side",
    symbol=visible_fraction("implicit", "Beckmann"),
    equals=sp.Integer(1),
    relation="<",
    proof=_box_steps,
    proved_by="sympy: the difference over 1 - cos theta_o in terms of a Lambda(a); its sign by balls over the whole box",
    enclosed=lambda it: [enclosures.over(_implicit_box, **BOX)],
    slides=(58,),
    cite="hoffman2010",
    note="The difference is divided by 1 - cos theta_o, so that its sign can be told close to normal incidence, where it is 0.",
)
schlick_beckmann = Equation(
    key="validation.table2.schlick_smith_beckmann",
    title="Schlick-Smith over Beckmann shows too little from every side",
    symbol=visible_fraction("Schlick", "Beckmann"),
    equals=sp.Integer(1),
    relation="<",
    proof=_box_steps,
    proved_by="sympy: the difference over 1 - cos theta_o in terms of a Lambda(a); its sign by balls over the whole box",
    enclosed=lambda it: [enclosures.over(_schlick_box, **BOX)],
    slides=(58,),
    cite="schlick1994",
    note="For k = alpha sqrt(2/pi). The difference is divided by alpha (1 - cos theta_o) G_1/cos theta_o, which is positive.",
)


# --- crosses: Kelemen, the area of the facets that face the viewer --------------------------------------------------------

r, limit = sp.symbols("r limit", positive=True)  # length of a slope in units of alpha; the edge of visibility in the same units
azimuth = sp.Symbol("azimuth", real=True)
DIGITS_NEAR_1 = 12  # digits of an integral that must differ from 1
LAST_RADIUS = 6  # in units of alpha: Gaussian slopes beyond have less than 1e-15 of the area
_AREA = sp.sqrt(1 + alpha**2 * r**2) * 2 * r * sp.exp(-(r**2))
_RING = (
    sp.sqrt(sp.cos(azimuth) ** 2 + alpha**2 * limit**2)
    / (sp.cos(azimuth) ** 2 + limit**2) ** 2
    * 2
    * limit**2
    * sp.sin(azimuth)
)
_VISIBLE = {
    "beckmann_inside": sp.Integral(_AREA, (r, LOW, HIGH)),
    "beckmann_outside": sp.Integral(_AREA * (1 - sp.acos(limit / r) / sp.pi), (r, LOW, HIGH)),
    "ggx_inside": sp.Integral(2 * sp.sin(w) * sp.sqrt(sp.cos(w) ** 2 + alpha**2 * sp.sin(w) ** 2), (w, LOW, HIGH)),
    "ggx_outside": sp.Integral(_RING * (1 - azimuth / sp.pi), (azimuth, LOW, HIGH)),
}


def _visible(part: str, alpha_: Ball, reach: Ball, low: Any, high: Any) -> Ball:
    return _plain(_VISIBLE[part], alpha, limit, LOW, HIGH)(alpha_, reach, low, high)


def beckmann_visible_area(alpha: Ball, reach: Ball) -> Ball:
    """Area of the facets that face the viewer: all slopes below `reach`, and the fraction 1 - acos/pi of each ring beyond."""
    edge = reach.min(ball(LAST_RADIUS))
    rest = ball(-LAST_RADIUS * LAST_RADIUS).exp() * (1 + alpha * (LAST_RADIUS + 1))
    inside, outside = _visible("beckmann_inside", alpha, reach, 0, edge), ball(0)
    if edge < LAST_RADIUS:
        outside = _visible("beckmann_outside", alpha, reach, edge, LAST_RADIUS)
    return inside + outside + rest.union(0)


def ggx_visible_area(alpha: Ball, reach: Ball) -> Ball:
    """The same with r = tan w inside, r = reach/cos(azimuth) outside."""
    right_angle = balls.pi() / 2
    return _visible("ggx_inside", alpha, reach, 0, reach.atan()) + _visible("ggx_outside", alpha, reach, 0, right_angle)


def _kelemen_box(visible_area: Callable[[Ball, Ball], Ball], alpha: Ball, degrees: Ball) -> Ball:
    """Area grows with alpha, and its visible part falls with the angle and with the slopes' size: the ends bound it."""
    cotangent = 1 / radians(degrees).tan()
    with balls.precision(int(DIGITS_NEAR_1 * 3.33) + 20):
        least = visible_area(alpha.lower(), cotangent.lower() / alpha.upper())
        most = visible_area(alpha.upper(), cotangent.upper() / alpha.lower())
        return least.union(most) - 1


STEEP_ANGLES, GRAZING_ANGLES = (0.001, 45.0), (87.0, 89.999)  # degrees
KELEMEN_ROUGH = (0.1, 0.9)


def _cross(
    key: str, over: str, visible_area: Callable[[Ball, Ball], Ball], relation: str, angles: tuple[float, float]
) -> Equation:
    def enclosed(it: Equation) -> list[Enclosure]:
        def residual(alpha: Ball, degrees: Ball) -> Ball:
            return _kelemen_box(visible_area, alpha, degrees)

        return [enclosures.over(residual, alpha=KELEMEN_ROUGH, degrees=angles)]

    return Equation(
        key=key,
        title=f"Kelemen over {over} shows too {'much from above' if relation == '>' else 'little at grazing angles'}",
        symbol=visible_fraction("Kelemen", over),
        equals=sp.Integer(1),
        relation=relation,
        enclosed=enclosed,
        slides=(58,),
        cite="kelemen2001",
        note="What is seen is the area of the facets turned to the viewer. It falls with the angle: it is right at one.",
    )


_cross(
    key="validation.table2.kelemen_beckmann_above",
    over="Beckmann",
    visible_area=beckmann_visible_area,
    relation=">",
    angles=STEEP_ANGLES,
)
_cross(
    key="validation.table2.kelemen_beckmann_grazing",
    over="Beckmann",
    visible_area=beckmann_visible_area,
    relation="<",
    angles=GRAZING_ANGLES,
)
_cross(
    key="validation.table2.kelemen_ggx_above",
    over="GGX",
    visible_area=ggx_visible_area,
    relation=">",
    angles=STEEP_ANGLES,
)
_cross(
    key="validation.table2.kelemen_ggx_grazing",
    over="GGX",
    visible_area=ggx_visible_area,
    relation="<",
    angles=GRAZING_ANGLES,
)
