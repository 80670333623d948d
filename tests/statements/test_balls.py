"""Ball arithmetic: right values, proved radii, and honest refusal."""

import itertools
import sys

import mpmath
import numpy as np
import pytest
import sympy as sp
from microfacet.statements import ball_functions, balls, checks, enclosures
from microfacet.statements.notation import chi
from microfacet.statements.reference import multiprecision, reference
from microfacet.statements.statement import equations

pytest.importorskip("flint")
COMPUTED = [key for key, e in equations.items() if checks.is_computed(e)]
x, p = sp.symbols("x p", real=True)


def in_normal_range(value: mpmath.mpf) -> bool:
    return value == 0 or mpmath.mpf(10) ** -300 < abs(value) < mpmath.mpf(10) ** 300


@pytest.mark.parametrize("key", COMPUTED)
def test_every_reference_is_proved(key):
    equation = equations[key]
    assert ball_functions.exact(equation.computed, equation.arguments)


@pytest.mark.parametrize("key", COMPUTED)
def test_light_install_gives_the_same_50_digits(key):
    equation = equations[key]
    light = multiprecision(equation.computed, equation.arguments)
    points = [q for q in checks.sample(equation, np.float64)[8:40] if in_normal_range(equation.exact(*q))][:4]
    assert points
    for point in points:
        with mpmath.workdps(70):
            proved, other = equation.exact(*point), light(*point)
            assert abs(proved - other) <= 2 * abs(proved) * mpmath.mpf(10) ** -50


def test_without_python_flint_mpmath_takes_over(monkeypatch):
    balls.available.cache_clear()
    monkeypatch.setitem(sys.modules, "flint", None)
    try:
        assert not balls.available()
        value = reference(sp.erfc(x), [x])(2.5)
    finally:
        balls.available.cache_clear()
    with mpmath.workdps(70):
        assert abs(value - mpmath.erfc(2.5)) < mpmath.mpf(10) ** -54


FUNCTIONS = [
    *(f(x) for f in (sp.exp, sp.log, sp.sqrt, sp.sin, sp.cos, sp.tan, sp.cot, sp.erf, sp.erfc, sp.gamma, sp.asinh, sp.Abs)),
    *(f(x / 4) for f in (sp.atanh, sp.asin, sp.acos, sp.atan)),
    *(f(x) for f in (sp.sinh, sp.cosh, sp.tanh)),
    *(sp.Min(x, 1), sp.Max(x, 1, 2), x ** sp.Rational(3, 2), x ** (-sp.pi), x**-3, sp.Float(0.25) * x),
    *(sp.expint(2, x), sp.hyper([2, x + 1], [(x + 4) / 2], sp.Rational(1, 3)), sp.hyper([1], [x], sp.Rational(1, 3))),
]


@pytest.mark.parametrize("expression", FUNCTIONS, ids=str)
def test_functions_agree_with_mpmath(expression):
    value, light = ball_functions.exact(expression, [x])(1.375), multiprecision(expression, [x])(1.375)
    with mpmath.workdps(70):
        assert abs(value - light) <= 2 * abs(value) * mpmath.mpf(10) ** -50


@pytest.mark.parametrize("n", [0.5, 3.25, 700.0, 1e4])
@pytest.mark.parametrize("z", [0.0, 1e-9, 0.25, 0.5])
def test_gauss_series_lies_in_arbs_ball(n, z):
    with balls.precision(256):
        a, b, c, argument = map(balls.ball, (2, n + 1, (n + 4) / 2, z))
        mine, theirs = ball_functions.gauss_series(a, b, c, argument), argument.hypgeom_2f1(a, b, c)
        assert mine.overlaps(theirs)
        assert mine.rel_accuracy_bits() > 200


def test_cancellation_costs_precision_not_digits():
    small = ball_functions.exact(sp.exp(x) - 1 - x - x**2 / 2, [x])(1e-40)
    with mpmath.workdps(70):
        assert abs(small / (mpmath.mpf(1e-40) ** 3 / 6) - 1) < mpmath.mpf(10) ** -39


def test_an_argument_at_a_jump_is_exact():
    assert ball_functions.exact(chi(x), [x])(0.0) == 0
    assert ball_functions.exact(chi(x), [x])(1e-300) == 1


def test_what_has_no_digits_is_refused():
    with pytest.raises(ArithmeticError, match="no 50 digits"):
        ball_functions.exact(sp.log(x), [x])(-1.0)
    with pytest.raises(balls.NoBall):
        ball_functions.evaluator(sp.zeta(x), [x])
    with pytest.raises(balls.NoBall, match="bounded interval"):
        ball_functions.evaluator(sp.Integral(sp.exp(-x), (x, 0, sp.oo)), [])


def test_a_ball_of_arguments_holds_all_values():
    expression = sp.sqrt(x) * sp.Max(x, p) / (1 + p**2) + x**p
    evaluate = ball_functions.evaluator(expression, [x, p])
    box = evaluate(balls.between(0.5, 1), balls.between(0.25, 2))
    for point in itertools.product((0.5, 0.8, 1), (0.25, 1.0, 2)):
        assert box.contains(evaluate(*point))


def test_integrals_are_enclosed():
    with balls.precision(256):
        quarter = ball_functions.evaluator(sp.Integral(sp.sqrt(1 - x**2), (x, 0, 1)), [])()
        assert quarter.contains(ball_functions.constant(sp.pi / 4))
        assert quarter.rad() < 1e-25
        power = ball_functions.evaluator(sp.Integral(x**p, (x, 0, 1)), [p])(0.3)
        assert power.contains(1 / (1 + balls.ball(0.3)))


def test_an_integral_over_a_jump_is_enclosed():
    with balls.precision(64):
        value = ball_functions.evaluator(sp.Integral(chi(x - sp.Rational(1, 3)), (x, 0, 1)), [])()
        assert value.contains(balls.ball(sp.Rational(2, 3)))


@pytest.mark.parametrize("zero", [0.2, 0.45, 0.55, 0.8])
def test_a_zero_anywhere_in_a_box_is_not_overlooked(zero):
    """Whichever half it lies in, nothing is proved of the sign."""
    found = enclosures.over(lambda **at: at["x"] - zero, x=(0.0, 1.0))
    assert found.residual.contains(0)
    assert not any(found.supports(relation) for relation in ("<", ">", r"\le", r"\ge", r"\ne"))
    assert enclosures.over(lambda **at: at["x"] - zero, x=(zero + 0.01, 1.0)).supports(">")
    assert enclosures.over(lambda **at: at["x"] - zero, x=(0.0, zero - 0.01)).supports("<")
