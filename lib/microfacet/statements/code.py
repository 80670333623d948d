"""From an expression to a kernel: a Python function of floats that evaluates it as it is written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import FunctionType
from typing import Any

import sympy as sp

from microfacet.arithmetic import exp_minus_square
from microfacet.statements.notation import chi
from microfacet.statements.registry import registry

_FUNCTIONS: dict[Any, str] = {
    sp.log: "log",
    sp.sin: "sin",
    sp.cos: "cos",
    sp.tan: "tan",
    sp.erf: "erf",
    sp.erfc: "erfc",
    sp.Abs: "abs",
    sp.Max: "max",
    sp.Min: "min",
    sp.atanh: "atanh",
    sp.asinh: "asinh",
}


def generate(name: str, expression: Any, arguments: Sequence[sp.Symbol]) -> FunctionType:
    """A Python function of floats that evaluates the expression as it is written."""
    scope: dict[str, Any] = {f: getattr(math, f) for f in ("sqrt", "exp", *_FUNCTIONS.values()) if hasattr(math, f)}
    text = f"def {name}({', '.join(map(str, arguments))}):\n    return {_code(sp.sympify(expression), scope)}\n"
    exec(text, scope)
    function: FunctionType = scope[name]
    function.__source__ = text  # type: ignore[attr-defined]
    return function


def _code(e: Any, scope: dict[str, Any]) -> str:
    """Python text of an expression; operations are kept in the order in which they were written."""
    if e.is_Symbol:
        return str(e)
    if e.is_Number or e.is_NumberSymbol:
        return f"({e.p}.0 / {e.q}.0)" if e.is_Rational and e.q != 1 else _decimal(e)
    for kind, writer in ((sp.Add, _sum), (sp.Mul, _product), (sp.Pow, _power)):
        if isinstance(e, kind):
            return writer(e, scope)
    return _call(e, scope)


def _sum(e: Any, scope: dict[str, Any]) -> str:
    return "(" + " + ".join(_code(term, scope) for term in e.args) + ")"


def _call(e: Any, scope: dict[str, Any]) -> str:
    inside = [_code(argument, scope) for argument in e.args]
    if isinstance(e, chi):
        return f"(1.0 if {inside[0]} > 0.0 else 0.0)"
    if isinstance(e, sp.exp):
        return _exponential(e.args[0], scope)
    if e.func in registry.defining:
        called = registry.defining[e.func].scalar
        scope[called.__name__] = called
        return f"{called.__name__}({', '.join(inside)})"
    if e.func in _FUNCTIONS:
        return f"{_FUNCTIONS[e.func]}({', '.join(inside)})"
    raise TypeError(f"a kernel cannot evaluate {e.func.__name__} in {e}")


def _exponential(exponent: Any, scope: dict[str, Any]) -> str:
    """exp(-a^2) has a kernel of its own, because rounding the square costs a^2/2 ulps."""
    square = -exponent
    if square.is_Pow and square.base.is_Symbol and square.exp == 2:
        scope["exp_minus_square"] = exp_minus_square
        return f"exp_minus_square({_code(square.base, scope)})"
    return f"exp({_code(exponent, scope)})"


def _decimal(number: Any) -> str:
    text = repr(float(number))
    return f"({text})" if text.startswith("-") else text


def _product(e: Any, scope: dict[str, Any]) -> str:
    below = [f for f in e.args if f.is_Pow and f.exp.is_Number and f.exp.is_negative]
    above = [f for f in e.args if f not in below]
    top = " * ".join(_code(f, scope) for f in above) or "1.0"
    bottom = " * ".join(_code(sp.Pow(f.base, -f.exp, evaluate=False) if f.exp != -1 else f.base, scope) for f in below)
    return f"({top})" if not below else f"({top} / ({bottom}))"


def _power(e: Any, scope: dict[str, Any]) -> str:
    base = _code(e.base, scope)
    if e.base == sp.E:
        return _exponential(e.exp, scope)
    if e.exp.is_Integer and 1 <= e.exp <= 8:
        return "(" + " * ".join([base] * int(e.exp)) + ")"
    if e.exp == sp.Rational(1, 2):
        return f"sqrt({base})"
    if e.exp.is_Number and e.exp.is_negative:
        return f"(1.0 / {_code(sp.Pow(e.base, -e.exp, evaluate=False) if e.exp != -1 else e.base, scope)})"
    return f"({base} ** {_code(e.exp, scope)})"
