"""From an expression to its value at 50 digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath
import sympy as sp

from microfacet.statements import ball_functions, balls
from microfacet.statements.registry import registry

DIGITS = balls.DIGITS


def reference(expression: Any, arguments: Sequence[sp.Symbol]) -> Callable[..., mpmath.mpf]:
    """A function that gives the expression to 50 digits: proved in ball arithmetic where python-flint is installed."""
    if balls.available():
        try:
            return ball_functions.exact(expression, arguments)
        except balls.NoBall:
            pass
    return multiprecision(expression, arguments)


def multiprecision(expression: Any, arguments: Sequence[sp.Symbol]) -> Callable[..., mpmath.mpf]:
    """The expression to 50 digits with mpmath alone: the working precision doubles until two agree.

    It begins at 400 digits: a value that a double can hold has lost at most some 330 of them to cancellation.
    """
    translate = {"chi": lambda value: mpmath.mpf(1 if value > 0 else 0)}
    function = sp.lambdify(arguments, registry.expand(expression), modules=[translate, "mpmath"])

    def evaluate(*values: Any) -> mpmath.mpf:
        exact = [mpmath.mpf(float(v)) if not isinstance(v, mpmath.mpf) else v for v in values]
        before, digits = None, 400
        while digits <= 6400:
            with mpmath.workdps(digits):
                now = mpmath.mpf(function(*exact))
                if before is not None and abs(now - before) <= abs(now) * mpmath.mpf(10) ** -DIGITS:
                    return now
            before, digits = now, 2 * digits
        raise ArithmeticError(f"no {DIGITS} digits of {expression} at {values}")

    return evaluate
