"""Integrals of statements by quadrature, which knows nothing of any proof."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import sympy as sp
from microfacet.statements.notation import P2
from microfacet.statements.registry import registry
from microfacet.statements.statement import Equation

SAME = 1e-10  # relative


def stands_for_integrals(equation: Equation) -> bool:
    """Whether the definition has integrals over one variable of functions that are known; those over the plane of slopes are
    tests/geometry's, those of any distribution of slopes tests/visibility's."""
    if equation.means is None or equation.equals is None or sp.sympify(equation.means).subs(equation.where).has(P2):
        return False
    return max((len(i.limits) for i in sp.sympify(equation.means).atoms(sp.Integral)), default=0) == 1


def integral_differs(equation: Equation, count: int = 2, digits: int = 20) -> str:
    """A sentence if the definition is not the closed form at some random arguments, else nothing."""
    means, equals = (registry.expand(form).subs(equation.where) for form in (equation.means, equation.equals))
    symbols = sorted(means.free_symbols | equals.free_symbols, key=str)
    random = np.random.default_rng(7)
    for _ in range(count):
        at = {s: sp.Float(0.3 + float(random.random()), 30) for s in symbols}
        here, there = _number(numerically(means.subs(at), digits)), _number(equals.subs(at).evalf(25))
        if not abs(here - there) <= SAME * abs(there):
            return f"the integral is {here}, not {there}, at {at}"
    return ""


def _number(form: Any) -> complex:
    return complex(form) if form.is_number else complex("nan")


def numerically(form: Any, digits: int = 20) -> Any:
    """Every integral in the form by mpmath; what surrounds it by sympy."""
    return form.replace(lambda e: isinstance(e, sp.Integral), lambda e: quadrature(e, digits)).evalf(digits)


def quadrature(integral: sp.Integral, digits: int = 20) -> sp.Float:
    variables = [limit[0] for limit in integral.limits]
    function = sp.lambdify(variables, integral.function, "mpmath")
    ends = [[_end(low), *([0] if low == -sp.oo else []), _end(high)] for _, low, high in integral.limits]
    with mpmath.workdps(digits):
        return sp.sympify(mpmath.quad(function, *ends))


def _end(value: Any) -> Any:
    return mpmath.inf if value == sp.oo else -mpmath.inf if value == -sp.oo else mpmath.mpf(str(sp.N(value, 25)))
