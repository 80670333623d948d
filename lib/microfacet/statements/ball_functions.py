"""From an expression to a function of balls, whose result is proved to hold the value.

Arguments may be balls as well, so a single evaluation can speak of a whole box of parameters. `exact` raises the precision
until the ball is small enough to give 50 digits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mpmath
import sympy as sp
from sympy.core.function import AppliedUndef

from microfacet.statements.balls import DIGITS, Ball, NoBall, ball, middle, precision
from microfacet.statements.notation import chi
from microfacet.statements.registry import registry

Scope = Mapping[sp.Symbol, Ball]
Evaluator = Callable[[Scope, bool], Ball]
START, LARGEST = 224, 1 << 17  # bits of working precision
EVALUATIONS = 200000  # of an integrand, at most


def evaluator(expression: Any, arguments: Sequence[sp.Symbol]) -> Callable[..., Ball]:
    """The expression as a function of balls, at the precision that is set when it is called."""
    whole = sp.sympify(expression)
    if missing := whole.free_symbols - set(arguments):
        raise NoBall(f"no value for {', '.join(sorted(map(str, missing)))} in {whole}")
    compiled = _compile(whole)

    def evaluate(*values: Any) -> Ball:
        return compiled(dict(zip(arguments, map(ball, values), strict=True)), False)

    return evaluate


def constant(expression: Any) -> Ball:
    """The ball around an expression without symbols."""
    return evaluator(expression, ())()


def exact(expression: Any, arguments: Sequence[sp.Symbol]) -> Callable[..., mpmath.mpf]:
    """The expression to 50 digits: the precision doubles until the ball is proved to be that small."""
    evaluate = evaluator(expression, arguments)
    wanted = int(DIGITS * 3.33) + 2

    def digits(*values: Any) -> mpmath.mpf:
        bits = START
        while bits <= LARGEST:
            with precision(bits):
                now = evaluate(*values)
                if now.is_finite() and (now.is_exact() or now.rel_accuracy_bits() >= wanted):
                    return middle(now)
            bits *= 2
        raise ArithmeticError(f"no {DIGITS} digits of {expression} at {', '.join(map(str, values))}")

    return digits


def integral(function: Callable[[Ball, bool], Ball], low: Any, high: Any, digits: int = 30) -> Ball:
    """A proved enclosure of the integral of a real function over a bounded interval.

    function(z, analytic): a complex ball that holds all values on z; not finite where `analytic` is set and it may not be.
    """
    from flint import acb, arb

    goal = arb(10) ** -digits
    found = acb.integral(
        lambda z, analytic: acb(function(z, analytic)),
        acb(ball(low)),
        acb(ball(high)),
        rel_tol=goal,
        abs_tol=goal**4,
        eval_limit=EVALUATIONS,
    )
    return found.real


def _compile(e: Any) -> Evaluator:
    if e.is_Symbol:
        return lambda scope, analytic: scope[e]
    if e.is_Rational or e.is_Float:
        exactly = sp.Rational(e)
        return _rational(int(exactly.p), int(exactly.q))
    if e is sp.pi or e is sp.E:
        return _constant(e)
    for kind, compiler in _COMPILERS.items():
        if isinstance(e, kind):
            return compiler(e)
    return _function(e, [_compile(part) for part in e.args])


def _sum(e: Any) -> Evaluator:
    return _fold(lambda a, b, analytic: a + b, [_compile(part) for part in e.args])


def _product(e: Any) -> Evaluator:
    return _fold(lambda a, b, analytic: a * b, [_compile(part) for part in e.args])


def _rational(p: int, q: int) -> Evaluator:
    from flint import arb

    above, below = arb(p), arb(q)
    return (lambda scope, analytic: above) if q == 1 else (lambda scope, analytic: above / below)


def _constant(e: Any) -> Evaluator:
    from flint import arb

    return (lambda scope, analytic: arb.pi()) if e is sp.pi else (lambda scope, analytic: arb.const_e())


def _fold(join: Callable[[Ball, Ball, bool], Ball], parts: Sequence[Evaluator]) -> Evaluator:
    first, *rest = parts

    def folded(scope: Scope, analytic: bool) -> Ball:
        value = first(scope, analytic)
        for part in rest:
            value = join(value, part(scope, analytic), analytic)
        return value

    return folded


def _function(e: Any, parts: list[Evaluator]) -> Evaluator:
    if isinstance(e, AppliedUndef) and (stated := registry.definition(e.func)) is not None:
        inner, names = _compile(sp.sympify(stated[1])), stated[0]
        return lambda scope, analytic: inner(
            {name: part(scope, analytic) for name, part in zip(names, parts, strict=True)}, analytic
        )
    if e.func in (sp.Min, sp.Max, chi):
        return _fold(_minimum if e.func is sp.Min else _maximum, parts) if e.func is not chi else _step(parts[0])
    if e.func is sp.expint:
        order, argument = parts
        return lambda scope, analytic: argument(scope, analytic).expint(order(scope, analytic))
    if e.func not in _NAMED:
        raise NoBall(f"no ball arithmetic for {e.func.__name__} in {e}")
    return _named(_NAMED[e.func], parts[0])


_WHOLE = (sp.exp, sp.sin, sp.cos, sp.tan, sp.cot, sp.sinh, sp.cosh, sp.tanh, sp.erf, sp.erfc, sp.gamma)
_CUT = (sp.log, sp.asin, sp.acos, sp.atan, sp.asinh, sp.acosh, sp.atanh)
_NAMED: dict[Any, str] = {**{f: f.__name__ for f in (*_WHOLE, *_CUT)}, sp.Abs: "abs"}


def _named(name: str, part: Evaluator) -> Evaluator:
    """A function of one argument; functions with branch cuts may not meet them where they must be analytic."""
    if name == "abs":
        return lambda scope, analytic: _absolute(part(scope, analytic), analytic)
    if name == "log":
        return lambda scope, analytic: _logarithm(part(scope, analytic), analytic)
    if name in {f.__name__ for f in _CUT}:
        return lambda scope, analytic: _off_cut(name, part(scope, analytic), analytic)
    return lambda scope, analytic: getattr(part(scope, analytic), name)()


def _complex(z: Ball) -> bool:
    return type(z).__name__ == "acb"  # asked at every node: an import would take longer than the answer


def _nowhere(z: Ball) -> Ball:
    """A ball that says nothing, real or complex."""
    from flint import acb, arb

    return acb(arb.nan()) if _complex(z) else arb.nan()


def _logarithm(z: Ball, analytic: bool) -> Ball:
    return z.log(analytic=analytic) if _complex(z) else z.log()


def _off_cut(name: str, z: Ball, analytic: bool) -> Ball:
    """asin and its like: analytic in the unit disc, atan and asinh too, and there their enclosures are finite."""
    from flint import arb

    if analytic and not z.abs_upper() < arb(1):
        near_axis = bool(abs(z.imag) < 1) and name in ("atan", "asinh")
        return getattr(z, name)() if near_axis else _nowhere(z)
    return getattr(z, name)()


def _absolute(z: Ball, analytic: bool) -> Ball:
    return z.real_abs(analytic=analytic) if _complex(z) else abs(z)


def _maximum(a: Ball, b: Ball, analytic: bool) -> Ball:
    if not (_complex(a) or _complex(b)):
        return a.max(b)
    from flint import acb

    return acb(a).real_max(acb(b), analytic=analytic)


def _minimum(a: Ball, b: Ball, analytic: bool) -> Ball:
    if not (_complex(a) or _complex(b)):
        return a.min(b)
    from flint import acb

    return acb(a).real_min(acb(b), analytic=analytic)


def _step(part: Evaluator) -> Evaluator:
    from flint import arb

    def step(scope: Scope, analytic: bool) -> Ball:
        z = part(scope, analytic)
        x = z.real if _complex(z) else z
        if x > 0:
            return arb(1)
        if x <= 0 and not (analytic and x.contains(0)):
            return arb(0)
        return _nowhere(z) if analytic else arb(0).union(1)

    return step


def _hypergeometric(e: Any) -> Evaluator:
    above, below = ([_compile(part) for part in parts] for parts in (e.ap, e.bq))
    argument = _compile(e.argument)

    def value(scope: Scope, analytic: bool) -> Ball:
        a, b = ([part(scope, analytic) for part in parts] for parts in (above, below))
        z = argument(scope, analytic)
        if (len(a), len(b)) != (2, 1):
            return z.hypgeom(a, b)
        (a1, a2), (b1,) = a, b
        return gauss_series(a1, a2, b1, z) if _series_converges(a1, a2, b1, z) else z.hypgeom_2f1(a1, a2, b1)

    return value


def _series_converges(a: Ball, b: Ball, c: Ball, z: Ball) -> bool:
    """Whether `gauss_series` may be used: all terms positive, and their ratios fall."""
    return not any(map(_complex, (a, b, c, z))) and bool(a >= 1 and b >= c and c > 0 and z >= 0 and z < 0.6)


def gauss_series(a: Ball, b: Ball, c: Ball, z: Ball) -> Ball:
    """2F1(a, b; c; z) for a >= 1, b >= c > 0, 0 <= z < 1 by its series, faster than Arb's own for large b.

    The ratio of successive terms, (a+k)/(1+k) (b+k)/(c+k) z, falls with k: what is left is less than a geometric series.
    """
    from flint import arb, ctx

    term = total = arb(1)
    smallest = arb(2) ** -(ctx.prec + 8)
    for k in range(10**6):
        ratio = (a + k) * (b + k) * z / ((c + k) * (k + 1))
        term *= ratio
        if ratio < 1 and term < total * smallest * (1 - ratio):
            return total + (term / (1 - ratio)).union(0)
        total += term
    return arb.nan()


# --- powers ---------------------------------------------------------------------------------------------------------


def _power(e: Any) -> Evaluator:
    base, exponent = _compile(e.base), e.exp
    if e.base is sp.E:
        inner = _compile(exponent)
        return lambda scope, analytic: inner(scope, analytic).exp()
    if exponent.is_Integer:
        whole = int(exponent)
        return lambda scope, analytic: base(scope, analytic) ** whole
    if exponent.is_Rational and exponent.q == 2:
        return _half_power(base, int(exponent.p))
    raised = _compile(exponent)
    return lambda scope, analytic: _general_power(base(scope, analytic), raised(scope, analytic), analytic)


def _half_power(base: Evaluator, odd: int) -> Evaluator:
    """The power odd/2."""
    return lambda scope, analytic: _root(base(scope, analytic), analytic) ** odd


def _root(z: Ball, analytic: bool) -> Ball:
    """A root, over the part of the ball where it is real."""
    if _complex(z):
        return z.sqrt(analytic=analytic)
    return z.nonnegative_part().sqrt() if z.contains(0) and not z.is_zero() else z.sqrt()


def _general_power(z: Ball, p: Ball, analytic: bool) -> Ball:
    """z^p; around 0 by the largest modulus, if the exponent is positive."""
    from flint import acb, arb

    real = p.real if _complex(p) else p
    if not (z.contains(0) and real > 0) or analytic:
        return acb(z).pow(acb(p), analytic=analytic) if _complex(z) or _complex(p) else z**p
    largest = z.abs_upper()
    if not largest > 0:
        return arb(0)
    bound = (largest**real).upper()
    if not _complex(z):
        return arb(0).union(bound)
    around = arb(0, bound)
    return acb(around, around)


# --- integrals ------------------------------------------------------------------------------------------------------


def _integral(e: Any) -> Evaluator:
    """An integral over one variable between finite ends."""
    if len(e.limits) != 1 or len(e.limits[0]) != 3 or any(end.is_infinite for end in e.limits[0][1:]):
        raise NoBall(f"ball arithmetic integrates over one bounded interval, not {e}")
    variable, low, high = e.limits[0]
    fixed: dict[Any, sp.Symbol] = {}
    with sp.evaluate(False):
        varying = _set_aside(e.function, variable, fixed)
    inside, start, stop = _compile(varying), _compile(low), _compile(high)
    once = {symbol: _compile(part) for part, symbol in fixed.items()}

    def value(scope: Scope, analytic: bool) -> Ball:
        from flint import ctx

        digits = ctx.prec // 5  # the working precision allows half as many again
        known = {**scope, **{symbol: part(scope, False) for symbol, part in once.items()}}
        return integral(lambda z, flag: inside(known | {variable: z}, flag), start(scope, False), stop(scope, False), digits)

    return value


def _set_aside(e: Any, variable: sp.Symbol, fixed: dict[Any, sp.Symbol]) -> Any:
    """The expression with a symbol for every part that the variable does not occur in: these are `fixed` over an integral."""
    if e.is_Atom or isinstance(e, sp.Integral):
        return e
    if not e.has(variable):
        symbol: sp.Symbol = fixed.setdefault(e, sp.Dummy())
        return symbol
    parts = list(e.args)
    if isinstance(e, sp.Add | sp.Mul):
        constant = [part for part in parts if not part.has(variable)]
        if len(constant) > 1:
            parts = [e.func(*constant), *(part for part in parts if part.has(variable))]
    return e.func(*(_set_aside(part, variable, fixed) for part in parts))


_COMPILERS: dict[type, Callable[[Any], Evaluator]] = {
    sp.Add: _sum,
    sp.Mul: _product,
    sp.Pow: _power,
    sp.Integral: _integral,
    sp.hyper: _hypergeometric,
}
