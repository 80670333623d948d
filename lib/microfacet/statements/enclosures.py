"""What is enclosed: balls that are proved to hold a statement's left side minus its right, at points or over boxes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from microfacet.statements.ball_functions import evaluator
from microfacet.statements.balls import Ball, NoBall, ball, between, precision

RADIUS = 1e-25  # of the ball that may pass for 0
ENCLOSING = 160  # bits
DEEPEST = 60  # halvings of a box


@dataclass(frozen=True)
class Enclosure:
    """A ball that is proved to hold a statement's left side minus its right side.

    where: at which parameters. scope: whether these are a whole range or points of it.
    """

    where: str
    residual: Ball
    scope: str = "points"

    def supports(self, relation: str) -> bool:
        """Whether the ball proves the relation; for equality it can only fail to disprove it, within `RADIUS`."""
        r = self.residual
        if not r.is_finite():
            return False
        if relation == "=":
            return bool(r.contains(0)) and bool(r.rad() < RADIUS)
        return bool({"<": r < 0, ">": r > 0, r"\le": r <= 0, r"\ge": r >= 0, r"\ne": not r.contains(0)}[relation])

    @property
    def shown(self) -> str:
        """The ball in words: its radius if it lies around 0, else its ends."""
        if self.residual.contains(0):
            return f"0 within {self.radius:.1e}"
        return f"{float(self.residual.lower()):.5g} to {float(self.residual.upper()):.5g}"

    @property
    def radius(self) -> float:
        """The largest modulus in a ball around 0, else the radius."""
        size = self.residual.abs_upper() if self.residual.contains(0) else self.residual.rad()
        return float(size.upper())


def at(residual: Callable[..., Ball], points: Sequence[Mapping[str, Any]]) -> list[Enclosure]:
    """The residual at each of the points, given as named numbers."""
    with precision(ENCLOSING):
        return [Enclosure(named(point), residual(**{k: ball(v) for k, v in point.items()})) for point in points]


def agreement(form: Any, closed: Any, symbols: Sequence[sp.Symbol], points: Sequence[Sequence[Any]]) -> list[Enclosure]:
    """The form over the closed form, less 1, at each of the points. `SHARE` in the form may be any number from 0 to 1."""
    ratio = evaluator(sp.sympify(form) / sp.sympify(closed) - 1, (*symbols, SHARE))
    names = list(map(str, symbols))
    return at(lambda **point: ratio(*point.values(), between(0, 1)), [dict(zip(names, p, strict=True)) for p in points])


SHARE = sp.Symbol("share_of_the_tail")


def folded(form: Any, cut: Any) -> sp.Expr:
    """A form with its integral up to infinity as two that are bounded: beyond the cut, over the inverse of the variable."""
    whole, (variable, low, inside) = _unbounded(form)
    u = sp.Dummy("u", positive=True)
    tail = sp.simplify(inside.subs(variable, 1 / u) / u**2)
    return form.xreplace({whole: sp.Integral(inside, (variable, low, cut)) + sp.Integral(tail, (u, 0, 1 / sp.sympify(cut)))})


def truncated(form: Any, cut: Any, tail: Any) -> sp.Expr:
    """A form with its integral up to infinity as one up to the cut, and a fraction between 0 and 1 of a bound on the rest."""
    whole, (variable, low, inside) = _unbounded(form)
    return form.xreplace({whole: sp.Integral(inside, (variable, low, cut)) + SHARE * tail})


def _unbounded(form: Any) -> tuple[sp.Integral, tuple[Any, Any, Any]]:
    """The integral in a form; its variable, lower end and integrand, from 0 on if it is even and over all numbers."""
    (whole,) = form.atoms(sp.Integral)
    variable, low, high = whole.limits[0]
    inside = whole.function.doit()
    if low == -sp.oo:
        if sp.simplify(inside - inside.subs(variable, -variable)) != 0:
            raise NoBall(f"not even: {whole}")
        low, inside = sp.Integer(0), 2 * inside
    if high != sp.oo or len(whole.limits) != 1:
        raise NoBall(f"not one integral up to infinity: {whole}")
    return whole, (variable, low, inside)


def over(residual: Callable[..., Ball], **box: tuple[Any, Any]) -> Enclosure:
    """The residual over a whole box of parameters, which is halved until each part excludes 0 or `DEEPEST` is reached."""
    with precision(ENCLOSING):
        whole = [between(*ends) for ends in box.values()]
        parts = _parts(lambda *balls: residual(**dict(zip(box, balls, strict=True))), whole, DEEPEST)
        return Enclosure(", ".join(f"{k} in [{float(a):g}, {float(b):g}]" for k, (a, b) in box.items()), parts, "range")


def _parts(residual: Callable[..., Ball], box: list[Ball], halvings: int) -> Ball:
    value = residual(*box)
    if halvings == 0 or (value.is_finite() and not value.contains(0)):
        return value
    widest = max(range(len(box)), key=lambda k: float(box[k].rad() / (1e-300 + abs(box[k].mid()))))
    middle, halves = box[widest].mid(), []
    for end in (box[widest].lower(), box[widest].upper()):
        part = [*box[:widest], end.union(middle), *box[widest + 1 :]]
        halves.append(_parts(residual, part, halvings - 1))
        if not halves[-1].is_finite() or halves[-1].contains(0):
            return halves[-1]
    return halves[0].union(halves[1])


def named(point: Mapping[str, Any]) -> str:
    """`alpha = 0.5, theta = 60`, for people."""
    return ", ".join(f"{name} = {float(value):.12g}" for name, value in point.items()) or "any parameters"
