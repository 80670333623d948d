"""Balls: numbers with a bound on their error, computed by python-flint's Arb.

python-flint is optional: only the modules on balls import it, and only when asked.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import mpmath
import sympy as sp

Ball = Any  # flint.arb, or flint.acb on the complex plane

DIGITS = 50


class NoBall(TypeError):
    """The expression has a part that cannot be evaluated in ball arithmetic."""


@cache
def available() -> bool:
    """Whether python-flint can be imported."""
    try:
        import flint  # noqa: F401
    except ImportError:
        return False
    return True


def ball(value: Any, radius: Any = 0) -> Ball:
    """The ball around a number, taken as it is: floats and mpmath's numbers are exact binary numbers."""
    from flint import arb

    if isinstance(value, arb):
        return value
    if isinstance(value, mpmath.mpf):
        return _binary(value)
    if isinstance(value, sp.Rational):
        return arb(int(value.p)) / int(value.q)
    if isinstance(value, sp.Basic):
        raise NoBall(f"{value} is no rational number")
    return arb(value if isinstance(value, int) else float(value), radius)


def _binary(value: mpmath.mpf) -> Ball:
    from flint import arb

    sign, mantissa, exponent, _ = value._mpf_
    if not mantissa and exponent:
        raise ValueError(f"{value} is not a finite number")
    return arb((-int(mantissa) if sign else int(mantissa), int(exponent)))


def pi() -> Ball:
    """The number, in the precision that is set."""
    from flint import arb

    return arb.pi()


def between(low: Any, high: Any) -> Ball:
    """A ball that holds the interval."""
    return ball(low).union(ball(high))


def middle(value: Ball) -> mpmath.mpf:
    """The midpoint of a ball, exactly."""
    mantissa, exponent = value.mid().man_exp()
    return mpmath.mp.make_mpf(mpmath.libmp.from_man_exp(int(mantissa), int(exponent)))


def precision(bits: int) -> Any:
    """A context in which balls are computed with this many bits."""
    from flint import ctx

    return ctx.workprec(bits)
