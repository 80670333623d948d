"""Formulas are printed as an author writes them: each of these was written by hand first."""

from __future__ import annotations

import re

import pytest
import sympy as sp
from microfacet.statements.notation import chi, im, latex, om, printed_symbol

x, y, theta = sp.symbols("x y theta", positive=True)
w = sp.Symbol("w", real=True)
t = sp.Symbol("t")
under = sp.Integral(sp.sqrt(x), (x, 0, 1))
HALF = sp.Rational(1, 2)


def mul(*factors: sp.Expr) -> sp.Expr:
    return sp.Mul(*factors, evaluate=False)


PRINTED = {
    r"\cos^{4} \theta": sp.cos(theta) ** 4,
    r"\sin \theta": sp.sin(theta),
    r"\tan^{2} \left( x y \right)": sp.tan(x * y) ** 2,
    r"\cot \theta": sp.cot(theta, evaluate=False),
    r"e^{- x}": sp.exp(-x),
    r"\exp \left( - \frac{x}{y} \right)": sp.exp(-x / y),
    r"\exp \left( - \tan^{2} \theta \right)": sp.exp(-(sp.tan(theta) ** 2)),
    r"\mathrm{erf}\left( x \right)": sp.erf(x),
    r"\mathrm{erfc}^{2}\left( x \right)": sp.erfc(x) ** 2,
    r"\mathrm{artanh}\left( x \right)": sp.atanh(x),
    r"\mathrm{arsinh}\left( x \right)": sp.asinh(x),
    r"\mathrm{arctan}\left( x \right)": sp.atan(x),
    r"\mathrm{arcsin}\left( x \right)": sp.asin(x, evaluate=False),
    r"\mathrm{arccos}^{3}\left( x \right)": sp.acos(x) ** 3,
    r"E_{2}\left( x \right)": sp.expint(2, x),
    r"{}_2F_1\left( 1, 2; 3; x \right)": sp.hyper([1, 2], [3], x),
    r"\chi^{+}\left( t \right)": chi(t),
    r"\min \left( 1, 2 x, y \right)": sp.Min(2 * x, y, 1),
    r"\max \left( 0, t \right)": sp.Max(sp.Symbol("t", real=True), 0),
    r"f(x, y)": sp.Function("f")(x, y),
    r"f(x)^{2}": sp.Function("f")(x) ** 2,
    r"f\left( \frac{x}{y} \right)": sp.Function("f")(x / y),
    r"x + y - 1": sp.Add(x, y, -1, evaluate=False),
    r"-1 + x + y": sp.Add(-1, sp.Add(x, y, evaluate=False), evaluate=False),
    r"x y": mul(sp.Integer(1), mul(x, sp.Integer(1), y)),
    r"1": mul(sp.Integer(1), sp.Integer(1)),
    r"0.00125": sp.Rational(1, 800),
    r"\frac{1}{8}": sp.Rational(1, 8),
    r"\frac{1}{9}": sp.Rational(1, 9),
    r"\frac{1}{3}": sp.Rational(1, 3),
    r"\left|{x y}\right|": sp.Abs(mul(x, y), evaluate=False),
    r"\int_{0}^{1} \sqrt{x} \, dx": under,
    r"\frac{1}{2} \int_{0}^{1} \sqrt{x} \, dx": mul(HALF, under),
    r"\frac{x}{2} \int_{0}^{1} \sqrt{x} \, dx": mul(HALF, x, under),
    r"\frac{1}{y} \left( 1 + \frac{x}{2} \right)": mul(1 / y, sp.Add(1, x / 2, evaluate=False)),
    r"\frac{1 + x}{y}": mul(sp.Add(1, x, evaluate=False), 1 / y),
    r"\frac{1}{2} \mathrm{erf}\left( \frac{x}{y} \right)": mul(HALF, sp.erf(x / y)),
    r"\frac{e^{- x}}{2}": mul(HALF, sp.exp(-x)),
}


def spaced(text: str) -> str:
    """Spaces do not print; where letters would run into one another, one is kept."""
    return re.sub(r"\s+", " ", text).replace("{ ", "{").replace(" }", "}").replace(r" \,", r"\,").strip()


@pytest.mark.parametrize("printed", PRINTED)
def test_a_formula_is_printed_as_it_was_written(printed: str) -> None:
    assert spaced(latex(PRINTED[printed])) == spaced(printed)


def test_of_several_the_number_is_first_and_the_light_last() -> None:
    text = latex(sp.Min(mul(im, x), mul(om, y), 1))
    assert text.index("1") < text.index(r"\omega_o") < text.index(r"\omega_i")
    text = latex(sp.Max(mul(sp.Integer(100), om), x, evaluate=False))
    assert text.index("x") < text.index("100")


def test_the_field_is_a_step() -> None:
    assert chi(x) == 1
    assert chi(-x) == 0
    assert chi(sp.Integer(0)) == 0
    assert chi(w).args == (w,)


def test_a_symbol_may_be_printed_in_its_own_way() -> None:
    symbol = printed_symbol("my_own_left_side", r"\mathcal{L}", positive=True)
    assert symbol.is_positive
    assert latex(symbol + 1) == r"1 + \mathcal{L}"
