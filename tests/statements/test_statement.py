"""The statement: one expression gives print, reference, kernel and checks, and a check that cannot fail is none."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import microfacet as mf
import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from microfacet.statements import checks, statement
from microfacet.statements.code import generate
from microfacet.statements.fingerprints import fingerprint
from microfacet.statements.notation import a, chi, latex, q, wm
from microfacet.statements.reference import reference
from microfacet.statements.registry import registry
from microfacet.statements.statement import Equation

x, y = sp.symbols("v w", real=True)


@pytest.fixture(autouse=True)
def apart(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Statements made by a test are forgotten after it; fewer arguments than the ledger's checks are tried."""
    len(mf.equations)
    monkeypatch.setattr(checks, "POINTS", 60)
    with registry.without():
        yield


def stated(key: str = "geometry.test.f", **parts: Any) -> Equation:
    return Equation(key=key, title="a test", symbol=parts.pop("symbol", sp.Symbol("f")), **parts)


def lambda_like(**changes: Any) -> Equation:
    """GGX's Lambda once more: definition, closed form, stable rewrite."""
    with sp.evaluate(False):
        parts: dict[str, Any] = {
            "means": sp.Integral((q - a) / (2 * (1 + q**2) ** sp.Rational(3, 2)), (q, a, sp.oo)) / a,
            "equals": (-1 + sp.sqrt(1 + 1 / a**2)) / 2,
            "computed_as": 1 / (2 * a * (a + sp.sqrt(1 + a**2))),
            "over": {a: (1e-3, 1e3)},
        }
    return stated(**(parts | changes))


# --- what may be stated -------------------------------------------------------------------------------------------------


def test_nothing_is_stated_twice() -> None:
    stated(equals=a)
    with pytest.raises(ValueError, match=r"equation geometry.test.f is stated twice"):
        stated(equals=a)


def test_something_is_stated() -> None:
    with pytest.raises(ValueError, match=r"equation geometry.test.f states nothing: give means or equals"):
        stated()


def test_a_statement_knows_where_it_stands() -> None:
    where = mf.equations["geometry.ggx.Lambda"].stated_at
    module, line = where.split(", line ")
    assert module == "microfacet.geometry.ggx"
    text = (Path(statement.__file__).parents[1] / "geometry" / "ggx.py").read_text().splitlines()
    assert 'key="geometry.ggx.Lambda"' in "\n".join(text[int(line) - 2 : int(line) + 3])


def test_kernels_and_references_want_their_arguments() -> None:
    for evaluate in (mf.equations["geometry.ggx.Lambda"].kernel, mf.equations["geometry.ggx.Lambda"].exact):
        with pytest.raises(ValueError, match=r"geometry.ggx.Lambda takes 1 arguments \(a,\), got 2"):
            evaluate(1.0, 2.0)
    for wrong in (1j, "a", None, np.ma.masked):
        with pytest.raises(ValueError, match="a must be an array of numbers, got"):
            mf.equations["geometry.ggx.Lambda"].kernel(wrong)


@pytest.mark.parametrize("wrong", [5, None, ["geometry.ggx.Lambda"]])
def test_a_key_is_text(wrong: Any) -> None:
    assert wrong not in mf.equations
    with pytest.raises(KeyError, match=r"no equation .*: a key is text such as geometry\.ggx\.D"):
        mf.equations[wrong]


# --- print --------------------------------------------------------------------------------------------------------------


def test_print_keeps_the_order_in_which_it_was_written() -> None:
    with sp.evaluate(False):
        assert latex(x + 1 - y) == "v + 1 - w"
        assert latex(-1 + sp.sqrt(1 + 1 / a**2)).startswith("-1 + ")


def test_print_is_symbol_definition_closed_form() -> None:
    with sp.evaluate(False):
        short = stated(means=x + 1, equals=1 + x)
    assert short.latex == "f = v + 1 = 1 + v"
    long = stated(key="geometry.test.g", means=sum(sp.symbols("c:20")), equals=sum(sp.symbols("d:20")), computed_as=x)
    assert long.latex.startswith(r"\begin{aligned} f &= ")
    assert long.latex.count("&=") == 2
    assert lambda_like(key="geometry.test.i").latex.startswith(r"f = \frac{1}{a} \int_{a}^{\infty} \frac{q - a}")
    bound = stated(key="geometry.test.h", equals=sp.Integer(0), relation=r"\ge")
    assert bound.latex == r"f \ge 0"


# --- reference ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [1e-8, 0.3, 1.0, 700.0, 1e8])
def test_reference_has_fifty_digits_whatever_cancels(value: float) -> None:
    """The textbook form of Lambda loses 16 digits of 50 at a = 1e8: the reference works with more."""
    exact = reference(lambda_like().equals, [a])(value)
    with mpmath.workdps(120):
        expected = (mpmath.sqrt(1 + 1 / mpmath.mpf(value) ** 2) - 1) / 2
        assert abs(exact - expected) < expected * mpmath.mpf(10) ** -48


def test_reference_takes_binary_numbers_as_they_are() -> None:
    assert reference(x, [x])(np.float32(0.1)) == mpmath.mpf(float(np.float32(0.1)))


# --- kernel -------------------------------------------------------------------------------------------------------------

LEAVES = st.one_of(st.sampled_from([x, y]), st.integers(1, 5).map(sp.Integer), st.fractions(0.1, 3).map(sp.Rational))


def _grow(children: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    pairs = st.tuples(children, children)
    return st.one_of(
        pairs.map(lambda p: sp.Add(*p, evaluate=False)),
        pairs.map(lambda p: sp.Mul(*p, evaluate=False)),
        pairs.map(lambda p: sp.Mul(p[0], sp.Pow(p[1], -1, evaluate=False), evaluate=False)),
        pairs.map(lambda p: sp.Max(*p)),
        children.map(lambda c: sp.Pow(c, 2, evaluate=False)),
        children.map(lambda c: sp.Pow(c, sp.Rational(1, 2), evaluate=False)),
        children.map(lambda c: sp.Pow(c, sp.Rational(-3, 2), evaluate=False)),
        children.map(lambda c: sp.log(1 + c)),
        children.map(lambda c: sp.exp(-c)),
        children.map(lambda c: sp.erfc(c)),
        children.map(lambda c: chi(c) * c),
    )


@given(expression=st.recursive(LEAVES, _grow, max_leaves=8), u=st.floats(0.1, 3), v=st.floats(0.1, 3))
def test_generated_code_is_the_expression(expression: Any, u: float, v: float) -> None:
    """Whatever tree, evaluated as floats, is near its 50 digits; cancellation aside."""
    try:
        value = generate("f", expression, [x, y])(u, v)
        exact = float(reference(expression, [x, y])(u, v))
    except (OverflowError, ZeroDivisionError, ValueError, ArithmeticError, TypeError):
        return  # a root or logarithm of something negative, or of nothing
    if 1e-100 < abs(exact) < 1e100:
        assert value == pytest.approx(exact, rel=1e-9)


def test_what_a_kernel_cannot_evaluate_is_refused() -> None:
    with pytest.raises(TypeError, match="a kernel cannot evaluate zeta"):
        generate("f", sp.zeta(x), [x])


def test_kernel_is_plain_text() -> None:
    assert mf.equations["visibility.smith.heights"].scalar.__source__.startswith("def visibility_smith_heights(Lambda_o):")


def test_directions_become_components() -> None:
    equation = stated(equals=wm.z * chi(wm.z), over={wm: "hemisphere"})
    assert [str(s) for s in equation.arguments] == ["x_m", "y_m", "z_m"]
    assert equation.scalar(0.0, 0.0, 0.5) == 0.5
    assert equation.scalar(0.0, 0.0, -0.5) == 0


# --- checks can fail ----------------------------------------------------------------------------------------------------


def off(value: float) -> float:
    return (1 + 1e-13) / (2 * value * (value + (1 + value * value) ** 0.5))


def right(value: float) -> float:
    return 1.0 / (2.0 * value * (value + (1.0 + value * value) ** 0.5))


def test_a_true_statement_passes() -> None:
    record = lambda_like().check()
    assert record.verdict == "pass", record.failures
    assert {record.marks[kind].status for kind in ("symbolic", "numeric")} == {"pass"}
    assert lambda_like(key="geometry.test.g", computed_by=right).check().verdict == "pass"


BREAKS: dict[str, Callable[[], dict[str, Any]]] = {
    "definition": lambda: {"means": sp.Integral((q - a) / (1 + q**2) ** sp.Rational(3, 2), (q, a, sp.oo)) / a},
    "closed form, sign": lambda: {"equals": (1 + sp.sqrt(1 + 1 / a**2)) / 2},
    "closed form, by one in a million": lambda: {"equals": (-1 + sp.sqrt(1 + 1 / a**2)) / 2 * sp.Rational(1000001, 1000000)},
    "rewrite": lambda: {"computed_as": 1 / (2 * a * (a + sp.sqrt(1 + 2 * a**2)))},
    "all but the definition": lambda: {"equals": 1 / a, "computed_as": 1 / a},
    "kernel, by one in 1e13": lambda: {"computed_by": off},
    "kernel that cancels": lambda: {"computed_as": (-1 + sp.sqrt(1 + 1 / a**2)) / 2},
    "promise": lambda: {"within": (0.01, 0.01)},
}


@pytest.mark.parametrize("name", BREAKS)
def test_each_way_to_be_wrong_is_found(name: str) -> None:
    with sp.evaluate(False):
        changes = BREAKS[name]()
    record = lambda_like(**changes).check()
    assert record.verdict == "fail"
    message = record.as_json()["message"]
    assert message.startswith("geometry.test.f (")
    assert record.failures


def test_what_is_built_on_a_wrong_statement_is_wrong() -> None:
    """Abbreviations are put in: a caller is judged by what it calls."""
    g = sp.Function("g_test")
    stated(key="geometry.test.g", symbol=g(a), equals=1 + a, computed_as=a + 2, over={a: (1, 2)})
    caller = stated(equals=2 * g(a), over={a: (1, 2)}, computed_as=2 + 2 * a)
    assert caller.scalar(1.0) == 4
    assert caller.check().verdict == "pass"
    other = stated(key="geometry.test.h", equals=2 + 2 * a, over={a: (1, 2)}, computed_as=2 * g(a))
    assert other.scalar(1.0) == 6
    assert other.check().verdict == "fail"


# --- fingerprints -------------------------------------------------------------------------------------------------------


def renamed(equation: Equation, **changes: Any) -> Equation:
    """The same statement with changes, in place of the first."""
    del registry.statements[equation.key]
    return replace(equation, **changes)


def test_fingerprint_ignores_what_no_check_reads() -> None:
    first = lambda_like()
    before = fingerprint(first)
    assert fingerprint(renamed(first, title="another", slides=(3,), note="so", cite="walter2007")) == before


@pytest.mark.parametrize(
    "changes",
    [
        {"equals": a},
        {"means": a},
        {"computed_as": a},
        {"over": {a: (1e-3, 1e4)}},
        {"within": (4.0, 8.0)},
        {"relation": r"\le"},
        {"proof": lambda: [sp.Integer(0)]},
        {"computed_by": right},
    ],
    ids=lambda c: next(iter(c)),
)
def test_fingerprint_changes_with_what_is_checked(changes: dict[str, Any]) -> None:
    first = lambda_like()
    before = fingerprint(first)
    assert fingerprint(renamed(first, **changes)) != before


def test_fingerprint_sees_what_is_called(monkeypatch: pytest.MonkeyPatch) -> None:
    g = sp.Function("g_test")
    inner = stated(key="geometry.test.g", symbol=g(a), equals=1 + a)
    caller = stated(equals=2 * g(a), over={a: (1, 2)})
    before = fingerprint(caller)
    renamed(inner, equals=2 + a)
    assert fingerprint(caller) != before
    handwritten = lambda_like(key="geometry.test.h", computed_by=right)
    before = fingerprint(handwritten)
    monkeypatch.setattr(sys.modules[__name__], "right", off)
    assert fingerprint(renamed(handwritten, computed_by=off)) != before


@pytest.mark.slow
def test_fingerprints_are_the_same_in_every_process() -> None:
    """Else every check would be redone at every build."""
    code = "import json; from microfacet.statements.fingerprints import fingerprints; print(json.dumps(fingerprints()))"
    library = str(Path(statement.__file__).parents[2])
    runs = [
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": library},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    ]
    first, second = map(json.loads, runs)
    assert first == second
    assert len(set(first.values())) == len(first)
