"""Slopes along the view, of three distributions: what the proofs of both tables of the talk integrate over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import sympy as sp

from microfacet.geometry import beckmann, blinn_phong, ggx
from microfacet.statements import ball_functions, balls
from microfacet.statements.balls import Ball, ball
from microfacet.statements.notation import a, alpha, n, printed_symbol, q, theta_o
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
def ball_function(statement: Equation, *arguments: sp.Symbol) -> Callable[..., Ball]:
    """The closed form of a statement as a function of balls."""
    return ball_functions.evaluator(statement.equals, arguments)


def _beckmann_Lambda(alpha: Ball, tangent: Ball) -> Ball:
    return ball_function(beckmann.Lambda, *beckmann.Lambda.arguments)(1 / (alpha * tangent))


def _ggx_Lambda(alpha: Ball, tangent: Ball) -> Ball:
    return ball_function(ggx.Lambda, *ggx.Lambda.arguments)(1 / (alpha * tangent))


def _student_Lambda(n: Ball, tangent: Ball) -> Ball:
    K = (n + 2) / (2 * balls.pi()) * ball_function(blinn_phong.factor, sp.Symbol("n", positive=True))(n)
    return ball_function(blinn_phong.Lambda, *blinn_phong.Lambda.arguments)(1 / tangent, n, K)


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
STUDENT_NORM = (n + 2) / (2 * sp.pi) * blinn_phong.factor.equals.doit()
STUDENT_ARGUMENTS = dict(zip(blinn_phong.Lambda.arguments, (COTANGENT, n, STUDENT_NORM), strict=True))
STUDENT = Slopes(
    shape=n,
    shapes=POWERS,
    q=sp.tan(w),
    density=blinn_phong.marginal.equals.doit().subs(blinn_phong.K, STUDENT_NORM),
    printed=blinn_phong.marginal.equals,
    level=STUDENT_NORM * sp.cos(w) ** (n + 1),
    tilted=STUDENT_NORM * sp.cos(w) ** n * sp.sin(w),
    end=sp.pi / 2,
    hidden=registry.expand(
        blinn_phong.Lambda.equals.doit().subs(
            dict(zip(blinn_phong.Lambda.arguments, (COTANGENT, n, STUDENT_NORM), strict=True))
        )
    ),
    Lambda=_student_Lambda,
    edge=lambda n, tangent: (1 / tangent).atan(),
)
TABLE_2_FAMILIES = ("beckmann", "ggx", "normalized_blinn_phong")


def radians(degrees: Ball) -> Ball:
    return degrees * balls.pi() / 180


@cache
def compiled_form(expression: sp.Expr, *arguments: sp.Symbol) -> Callable[..., Ball]:
    return ball_functions.evaluator(expression, arguments)


def visible_fraction(masking: str, over: str) -> sp.Symbol:
    """The visible area over its true value, for a masking function over a distribution, whose last word is its subscript."""
    integrand = (
        rf"G_1^{{\text{{{masking}}}}}(\omega_o, \omega_m) \left\langle \omega_o, \omega_m \right\rangle"
        rf" D_{{\text{{{over.split()[-1]}}}}}(\omega_m)"
    )
    return printed_symbol(
        f"visible_share_{masking}_{over}", rf"\frac{{1}}{{\cos \theta_o}} \int_{{\Omega}} {integrand} \, d\omega_m"
    )
