"""Kernels: the compiled loop is the Python function, in the precision asked for, once per text, over whatever broadcasts."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from math import erf, exp, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import mutually_broadcastable_shapes
from microfacet.arithmetic import cosine_and_sine, exp_minus_square, exp_minus_squares, two_product, two_sum
from microfacet.compiler.batch import Batch
from microfacet.compiler.exponential import one_minus_exp
from microfacet.compiler.kernels import ByPrecision, Count, Table, packed, source
from microfacet.compiler.loop import layout
from microfacet.directions import points, uniform

HALF = 0.5
CHUNK = 16384
TABLE = (0.1, 0.2, 0.3)
PRECISE = ByPrecision(double=1.0, single=2.0)


def helper(x: float) -> float:
    return HALF * x + TABLE[1]


def kernel(w: tuple[float, float, float], s: float, p: Any) -> float:
    x, y, z = w
    return helper(x) * exp(-y * y) + sqrt(abs(z)) * p[0] + erf(s) * 0.1


def length(w: tuple[float, float, float], p: Any) -> tuple[float, float]:
    """Two results."""
    x, y, z = w
    size: float = sqrt(x * x + y * y + z * z)
    return size, PRECISE


MANY = Batch(kernel, [3, 1])
TWO = Batch(length, [3], 2)


def python(rows: np.ndarray, s: np.ndarray, p: tuple[float, ...]) -> np.ndarray:
    return np.array([kernel(tuple(row), value, p) for row, value in zip(rows, s, strict=True)])


def arguments(count: int, real: type = np.float64) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(count)
    return random.normal(size=(count, 3)).astype(real), random.normal(size=count).astype(real)


def test_loop_is_the_python_function() -> None:
    rows, s = arguments(200)
    np.testing.assert_allclose(MANY([rows, s], (0.3,)), python(rows, s, (0.3,)), rtol=1e-15, atol=1e-15)


def test_single_precision_is_single_throughout() -> None:
    """No literal, constant, table entry or parameter makes the arithmetic double: NumPy's single one gives the same."""
    rows, s = arguments(2000, np.float32)
    one = np.float32
    plain = (one(0.5) * rows[:, 0] + one(0.2)) * np.exp(-rows[:, 1] * rows[:, 1]) + np.sqrt(np.abs(rows[:, 2])) * one(0.3)
    last = np.array([math.erf(v) for v in s], np.float32) * one(0.1)
    value = MANY([rows, s], (0.3,))
    assert value.dtype == np.float32
    assert np.mean(value == plain + last) > 0.5
    np.testing.assert_allclose(value, plain + last, rtol=4e-7, atol=4e-7)
    text = MANY.text(np.float32)
    assert "R, T = float32, np.float32" in text
    assert "R(0.5)" in text
    assert "R(0.1)" in text


def test_constants_may_differ_by_precision() -> None:
    rows = arguments(5)[0]
    assert (TWO([rows])[:, 1] == 1).all()
    assert (TWO([rows.astype(np.float32)])[:, 1] == 2).all()
    assert PRECISE == 1


@pytest.mark.parametrize("count", [0, 1, CHUNK, 2 * CHUNK + 1, 7 * CHUNK + 5])
@pytest.mark.parametrize("threads", ["1", "2", "5"])
def test_any_number_of_threads_gives_the_same(count: int, threads: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rows, s = arguments(count)
    monkeypatch.setenv("MICROFACET_THREADS", threads)
    shared = MANY([rows, s], (0.3,))
    monkeypatch.setenv("MICROFACET_THREADS", "1")
    np.testing.assert_array_equal(shared, MANY([rows, s], (0.3,)))
    assert shared.shape == (count,)


@given(mutually_broadcastable_shapes(num_shapes=2, max_dims=3, max_side=3, min_side=0))
def test_broadcasting_is_numpys(found: Any) -> None:
    (first, second), shape = found.input_shapes, found.result_shape
    rows = np.random.default_rng(0).normal(size=(*first, 3))
    s = np.random.default_rng(1).normal(size=second)
    value = MANY([rows, s], (0.3,))
    assert np.shape(value) == shape
    wide, long = np.broadcast_to(rows, (*shape, 3)).reshape(-1, 3), np.broadcast_to(s, shape).reshape(-1)
    np.testing.assert_allclose(np.ravel(value), python(wide, long, (0.3,)), rtol=1e-14, atol=1e-15)


def test_strided_reversed_and_read_only_arrays() -> None:
    rows, s = arguments(50)
    expected = MANY([rows, s], (0.3,))
    padded = np.zeros((100, 6))
    padded[::2, ::2] = rows
    np.testing.assert_array_equal(MANY([padded[::2, ::2], s], (0.3,)), expected)
    np.testing.assert_array_equal(MANY([np.asfortranarray(rows), s[::-1][::-1]], (0.3,)), expected)
    np.testing.assert_array_equal(MANY([rows[::-1], s[::-1]], (0.3,))[::-1], expected)
    rows.flags.writeable = False
    np.testing.assert_array_equal(MANY([rows, s], (0.3,)), expected)
    np.testing.assert_array_equal(MANY([rows.astype(">f8"), s], (0.3,)), expected)


def test_scalars_come_out_as_scalars() -> None:
    value = MANY([[1.0, 2.0, 3.0], 0.5], (0.3,))
    assert isinstance(value, np.float64)
    assert TWO([[3.0, 4.0, 0.0]]).tolist() == [5.0, 1.0]


def test_out_is_filled_and_returned() -> None:
    rows, s = arguments(20)
    out = np.full(20, np.nan)
    assert MANY([rows, s], (0.3,), out) is out
    np.testing.assert_array_equal(out, MANY([rows, s], (0.3,)))
    scalar = np.zeros(())
    assert MANY([rows[0], s[0]], (0.3,), scalar) is scalar
    assert scalar == out[0]


@pytest.mark.parametrize(
    ("out", "found"),
    [
        (np.zeros(19), r"float64 \(19,\)"),
        (np.zeros(20, np.float32), r"float32 \(20,\)"),
        (np.zeros(40)[::2], r"float64 \(20,\)"),
        ([0.0] * 20, "list"),
    ],
)
def test_out_that_does_not_fit(out: Any, found: str) -> None:
    rows, s = arguments(20)
    with pytest.raises(ValueError, match=rf"out must be a C-contiguous float64 array of shape \(20,\), got {found}"):
        MANY([rows, s], (0.3,), out)


def test_out_that_is_read_only_stays_as_it_is() -> None:
    rows, s = arguments(20)
    out = np.zeros(20)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="out must be writeable, got a read-only array"):
        MANY([rows, s], (0.3,), out)
    assert not out.any()


def test_out_may_not_overlap_an_argument() -> None:
    """The loop would read what it has written."""
    memory = np.ones(60)
    rows = memory[:30].reshape(10, 3)
    with pytest.raises(ValueError, match="out must not overlap an argument"):
        TWO([rows], out=memory[25:45].reshape(10, 2))
    TWO([rows], out=memory[30:50].reshape(10, 2))
    np.testing.assert_array_equal(rows, 1)


# --- parameters by name ---------------------------------------------------------------------------------------------


class Alphas(NamedTuple):
    alpha_x: float
    alpha_y: float


class Swapped(NamedTuple):
    alpha_y: float
    alpha_x: float


class Whole(NamedTuple):
    ndf: Alphas
    first: int
    last: int
    table: tuple[float, ...]


alpha_y = object()  # no constant: but a field of this name is none of the kernel's free names


def uneven(w: tuple[float, float, float], p: Alphas) -> float:
    return w[0] * p.alpha_x + w[1] * p.alpha_y * p.alpha_y


def turned(w: tuple[float, float, float], p: Alphas) -> float:
    return uneven((w[1], w[0], w[2]), Alphas(2.0 * p.alpha_x, p.alpha_y))


def summed(w: tuple[float, float, float], u: tuple[float, float], p: Whole) -> float:
    total = turned(w, p.ndf) + u[0] - u[1]
    for k in range(p.first, p.last):
        total += p.table[k] / (p.last - k)
    return total


SUMMED = Batch(summed, [3, 2])


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_parameters_have_their_names_in_the_loop(real: type) -> None:
    rows, u = arguments(50, real)[0], np.random.default_rng(3).random((50, 2)).astype(real)
    p = Whole(Alphas(0.3, 0.7), Count(1), Count(4), Table((0.5, 1.5, 2.5, 3.5)))
    expected = [summed(tuple(map(float, w)), tuple(map(float, v)), p) for w, v in zip(rows, u, strict=True)]
    found = SUMMED([rows, u], p)
    assert found.dtype == real
    np.testing.assert_allclose(found, expected, rtol=10 * np.finfo(real).eps, atol=10 * np.finfo(real).eps)


def test_arrays_among_named_parameters_keep_the_names() -> None:
    rows, u = arguments(50)[0], np.full(2, 0.5)
    alpha = np.linspace(0.1, 1, 50)
    rest = (Count(0), Count(2), Table((0.5, 1.5)))
    found = SUMMED([rows, u], Whole(Alphas(0.3, alpha), *rest))
    one_by_one = [SUMMED([w, u], Whole(Alphas(0.3, float(a)), *rest)) for w, a in zip(rows, alpha, strict=True)]
    np.testing.assert_array_equal(found, one_by_one)


def test_equal_numbers_under_other_names_are_other_parameters() -> None:
    """A tuple is equal to any of the same numbers; what was found for one must not serve another."""
    batch, w = Batch(uneven, [3]), [2.0, 3.0, 0.0]
    for _ in range(2):
        assert batch([w], Alphas(5.0, 7.0)) == 2 * 5 + 3 * 49
        assert batch([w], Swapped(5.0, 7.0)) == 2 * 7 + 3 * 25
    assert len({batch.text(np.float64, shape=layout(p)) for p in (Alphas(5.0, 7.0), Swapped(5.0, 7.0))}) == 2


def picked(x: float, p: Any) -> float:
    return x * TABLE[p[0]]


def shifted(x: float, p: Any) -> float:
    return x * p[0] - 16777216.0


def test_counts_stay_whole_numbers_and_other_integers_become_floats() -> None:
    assert Batch(picked, [1])([2.0], (Count(1),)) == 2 * TABLE[1]
    assert Batch(shifted, [1])([np.float32(1)], (16777217,)) == 0  # 2^24 + 1 rounds to 2^24


def test_tables_of_integers_are_such() -> None:
    assert "np.array((0, 2, 5), np.intp)" in Batch(looked_up, [1]).text(np.float32)
    assert Batch(looked_up, [1])([np.float32(3)]) == 5


STARTS = (0, 2, 5)


def looked_up(x: float, p: Any) -> float:
    total = 0.0
    for _ in range(STARTS[0], STARTS[2]):
        total += x / 3.0
    return total


# --- texts and their cache ------------------------------------------------------------------------------------------


def mutable(x: float, p: Any) -> float:
    return x + len(os.sep)


def test_a_kernel_may_not_depend_on_other_things() -> None:
    with pytest.raises(TypeError, match="mutable uses os, which is no kernel and no constant"):
        Batch(mutable, [1]).text(np.float64)


def test_text_holds_all_that_is_called_and_each_constant() -> None:
    text = MANY.text(np.float64)
    for part in ("def kernel_", "def helper_", "R(0.5)", "0.2"):
        assert part in text
    assert text == Batch(kernel, [3, 1]).text(np.float64)
    assert text != MANY.text(np.float32)
    assert '"""' not in TWO.text(np.float64)


def test_a_constant_that_changes_is_another_text(monkeypatch: pytest.MonkeyPatch) -> None:
    before = MANY.text(np.float64)
    monkeypatch.setitem(globals(), "HALF", 0.25)
    assert MANY.text(np.float64) != before


def test_a_file_that_changed_under_a_running_process_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Source is looked up by line: after an edit above it, another function would stand there."""
    (tmp_path / "edited_kernels.py").write_text("def first(x):\n    return x\n\n\ndef second(x):\n    return 2.0 * x\n")
    monkeypatch.syspath_prepend(tmp_path)
    import edited_kernels

    assert "2.0" in source(edited_kernels.second)
    (tmp_path / "edited_kernels.py").write_text("X = 1.0\n\n\n\ndef other(x):\n    return x\n")
    with pytest.raises(RuntimeError, match=r"edited_kernels.py has changed since it was imported"):
        source(edited_kernels.second)


def test_packed_passes_parameters_on() -> None:
    def power(x: float, y: float, n: float, m: float) -> float:
        return x**n + y**m

    assert packed(power, 2, 2)(2.0, 3.0, (3.0, 2.0)) == 17


COUNT = """
import json, sys
import numpy as np
from numba.core import event
with event.install_recorder("numba:compile") as seen:
    import microfacet as mf
    values = [mf.GGX(0.3).D(np.array([[0, 0.6, 0.8], [0, 0, 1]], real)).tolist() for real in (np.float64, np.float32)]
print(json.dumps([len(seen.buffer), values]))
"""


def run(code: str, **environment: str) -> Any:
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **environment}, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


@pytest.mark.slow
def test_a_cached_kernel_compiles_nothing(tmp_path: Path) -> None:
    """Another process, and no compilation in it: what a figure that is redrawn relies on."""
    library = str(Path(__file__).parents[2] / "lib")
    environment = {"MICROFACET_CACHE": str(tmp_path), "PYTHONPATH": library}
    compiled, values = run(COUNT, **environment)
    assert compiled > 0
    files = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert len(files) == 2
    again, same = run(COUNT, **environment)
    assert again == 0
    assert same == values
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == files


NAMED = """
import json, sys
import numpy as np
from typing import NamedTuple
from numba.core import event
from microfacet.compiler.batch import Batch

class Line(NamedTuple):
    {fields}

def line(x, p):
    return p.slope * x + p.constant

line.__source__ = "def line(x, p): return p.slope * x + p.constant"
with event.install_recorder("numba:compile") as seen:
    value = Batch(line, [1])([2.0], Line(3.0, 5.0))
print(json.dumps([len(seen.buffer), float(value)]))
"""


@pytest.mark.slow
def test_classes_of_a_main_program_are_no_part_of_what_is_kept(tmp_path: Path) -> None:
    """Another process has them not; and classes of other fields are other parameters there too."""
    environment = {"MICROFACET_CACHE": str(tmp_path), "PYTHONPATH": str(Path(__file__).parents[2] / "lib")}
    one, other = (NAMED.format(fields=f"{a}: float\n    {b}: float") for a, b in (("slope", "constant"), ("constant", "slope")))
    (compiled, value), again = run(one, **environment), run(one, **environment)
    assert compiled > 0
    assert value == 11
    assert again == [0, 11]
    assert run(other, **environment)[1] == 13


SHARED = """
import json, sys
import microfacet as mf
model, wo = mf.VCavity(mf.Beckmann(0.5)), [0.6, 0.0, 0.8]
values = {"G1": lambda: model.G1(wo, [0, 0, 1]), "D_visible": lambda: model.D_visible(wo, [0, 0, 1])}
print(json.dumps([float(values[name]()) for name in sys.argv[1:]]))
"""


@pytest.mark.slow
def test_a_kernel_that_shares_functions_is_found_alone(tmp_path: Path) -> None:
    """Compiled after another one, its loop refers to that one's module, which a later process has not loaded."""
    environment = os.environ | {"MICROFACET_CACHE": str(tmp_path), "PYTHONPATH": str(Path(__file__).parents[2] / "lib")}
    command = [sys.executable, "-c", SHARED]
    both, alone = (
        json.loads(subprocess.run([*command, *names], env=environment, capture_output=True, text=True, check=True).stdout)
        for names in (("G1", "D_visible"), ("D_visible",))
    )
    assert both[1:] == alone


# --- arithmetic -------------------------------------------------------------------------------------------------------

MODERATE = st.floats(-1e100, 1e100).filter(lambda v: v == 0 or abs(v) > 1e-100)


@given(a=MODERATE, b=MODERATE)
def test_sums_and_products_lose_nothing(a: float, b: float) -> None:
    """As rational numbers, exactly."""
    from fractions import Fraction

    product, error = two_product(a, b)
    assert Fraction(product) + Fraction(error) == Fraction(a) * Fraction(b)
    total, rest = two_sum(a, b)
    assert Fraction(total) + Fraction(rest) == Fraction(a) + Fraction(b)


@given(a=st.floats(0, 27))
def test_exponential_of_a_square(a: float) -> None:
    import mpmath

    with mpmath.workdps(60):
        exact = mpmath.exp(-(mpmath.mpf(a) ** 2))
        if exact > 1e-300:
            assert abs(exp_minus_square(a) - exact) <= 2.5 * np.finfo(float).eps * exact


def test_exponential_of_squares_next_to_the_horizon() -> None:
    """The factor overflows where the exponential is 0: the product is 0."""
    assert exp_minus_squares(1.0, 0.0, 0.5, 0.5, 1e-90, math.inf) == 0
    assert exp_minus_squares(0.0, 1.0, 10.0, 10.0, 1e-100, math.inf) == 0


def exponent(x: float) -> float:
    return exp(x)


EXPONENT = Batch(packed(exponent, 1, 0), [1])
LESS_THAN_ONE = Batch(packed(one_minus_exp, 1, 0), [1])
TURN = Batch(packed(cosine_and_sine, 1, 0), [1], 2)


@pytest.mark.parametrize(("real", "low", "high"), [(np.float64, -708.0, 709.0), (np.float32, -87.0, 88.0)])
def test_the_exponential_of_loops_is_exact_to_an_ulp(real: type, low: float, high: float) -> None:
    import mpmath

    x = np.random.default_rng(0).uniform(low, high, 2000).astype(real)
    exact = [mpmath.exp(mpmath.mpf(float(v))) for v in x]
    errors = [abs(mpmath.mpf(float(v)) / e - 1) for v, e in zip(EXPONENT([x]), exact, strict=True)]
    assert max(errors) <= 1.1 * np.finfo(real).eps


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_the_exponential_of_loops_at_its_ends(real: type) -> None:
    tiny = math.log(float(np.finfo(real).smallest_subnormal))
    x = np.array([0.0, -0.0, -math.inf, math.inf, math.nan, 2 * tiny, tiny + 1, -2 * tiny], real)
    with np.errstate(over="ignore"):
        np.testing.assert_array_equal(EXPONENT([x]), np.exp(x))


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_one_less_an_exponential_keeps_its_digits(real: type) -> None:
    """Down to the smallest numbers, and where the exponential has long been too small to matter."""
    import mpmath

    random = np.random.default_rng(1)
    x = np.concatenate([10 ** random.uniform(-37, 2, 2000), random.uniform(0, 3, 2000), [0.0, math.inf]]).astype(real)
    values = LESS_THAN_ONE([x])
    assert values.dtype == real
    for value, number in zip(values, x, strict=True):
        exact = -mpmath.expm1(-mpmath.mpf(float(number)))
        assert abs(mpmath.mpf(float(value)) - exact) <= 1.5 * np.finfo(real).eps * exact


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_a_turn_is_exact_to_an_ulp(real: type) -> None:
    import mpmath

    u = np.concatenate(
        [np.random.default_rng(0).random(2000), np.arange(9) / 8, [1e-30, 0.25 + 1e-7, 0.5 - 1e-7, 0.125 - 1e-7, 0.875 + 1e-7]]
    ).astype(real)
    for found, share in zip(TURN([u]), u, strict=True):
        for value, exact in zip(
            found, (mpmath.cospi(2 * mpmath.mpf(float(share))), mpmath.sinpi(2 * mpmath.mpf(float(share)))), strict=True
        ):
            assert abs(mpmath.mpf(float(value)) - exact) <= np.finfo(real).eps * abs(exact)


def doubled(x: float) -> float:
    total = 0.0
    for k in range(3):
        total += exponent(k * x)
    return total


def test_an_integer_in_a_single_precision_loop_spoils_nothing() -> None:
    """An integer times a float32 is a float64 to the compiler."""
    x = np.linspace(-30, 20, 101).astype(np.float32)
    found = Batch(packed(doubled, 1, 0), [1])([x])
    np.testing.assert_allclose(found, sum(np.exp(k * x.astype(float)) for k in range(3)), rtol=1e-5)


def test_one_row_for_all_is_read_once_and_rows_of_one_turn_are_not_copied() -> None:
    rows, s = arguments(50)
    np.testing.assert_array_equal(MANY([rows[:1], s], (0.3,)), MANY([np.repeat(rows[:1], 50, 0), s], (0.3,)))
    np.testing.assert_array_equal(MANY([rows, 0.4], (0.3,)), MANY([rows, np.full(50, 0.4)], (0.3,)))
    assert "b0_2 = a0[2]" in MANY.text(np.float64, (True, False))


# --- arguments that are checked while they are read ---------------------------------------------------------------------

MANY_ROWS = 2 * CHUNK + 7  # more than one thread's share


def of_pair(wo: tuple[float, float, float], wi: tuple[float, float, float], p: Any) -> float:
    return (wo[0] + wo[1] + wo[2]) * p[0] + wi[0] - wi[1] + wi[2]


def first_half(w: tuple[float, float, float], u: tuple[float, float], p: Any) -> float:
    return 0.5 * w[0]


PAIRS, HALVES = Batch(of_pair, [3, 3]), Batch(first_half, [3, 2])


def pairs(wo: Any, wi: Any, out: np.ndarray | None = None) -> Any:
    return PAIRS([points("wo", wo), points("wi", wi)], (2.0,), out)


@pytest.mark.parametrize("threads", ["1", "2"])
@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("row", [0, CHUNK, MANY_ROWS - 1])
def test_a_number_that_is_none_is_found_wherever_it_stands(
    row: int, wrong: float, real: type, threads: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", threads)
    given = [np.ones((MANY_ROWS, 3), real), np.ones((MANY_ROWS, 3), real)]
    np.testing.assert_array_equal(pairs(*given), 7)
    for k, name in enumerate(("wo", "wi")):
        given[k][row, 2] = wrong
        with pytest.raises(ValueError, match=rf"^{name} must be finite, got {wrong} at index \({row}, 2\)$"):
            pairs(*given)
        given[k][row, 2] = 1
    np.testing.assert_array_equal(pairs(*given), 7)


def test_of_two_wrong_arguments_the_first_is_named() -> None:
    rows = np.full((4, 3), np.nan)
    with pytest.raises(ValueError, match=r"^wo must be finite, got nan at index \(0, 0\)$"):
        pairs(rows, rows)


@pytest.mark.parametrize("shape", [(3,), (1, 3), (1, 1, 3), (1, 4, 3), (5, 1, 3)])
def test_a_number_that_is_none_in_what_is_broadcast(shape: tuple[int, ...]) -> None:
    row = np.ones(shape)
    rows = np.ones((5, 4, 3))
    np.testing.assert_array_equal(pairs(rows, row), pairs(row, rows))
    row[..., 1] = np.nan
    for name, both in (("wo", (row, rows)), ("wi", (rows, row))):
        with pytest.raises(ValueError, match=rf"^{name} must be finite, got nan at index \("):
            pairs(*both)


def test_a_number_that_is_none_in_strided_rows_and_between_them() -> None:
    padded = np.ones((100, 7))
    view = padded[::2, 1:7:2]
    for rows in (view, np.asfortranarray(view), view[::-1]):
        np.testing.assert_array_equal(pairs(rows, rows), 7)
    padded[1::2] = padded[:, ::2] = np.nan
    np.testing.assert_array_equal(pairs(view, view), 7)
    view[49, 2] = np.inf
    for rows, at in ((view, 49), (np.asfortranarray(view), 49), (view[::-1], 0)):
        with pytest.raises(ValueError, match=rf"^wi must be finite, got inf at index \({at}, 2\)$"):
            pairs(np.ones((50, 3)), rows)


def test_arguments_of_a_loop_without_a_turn_are_checked() -> None:
    """Nothing is computed from them; they are wrong all the same."""
    assert pairs(np.ones((1, 3)), np.ones((0, 3))).shape == (0,)
    assert pairs(np.ones((2, 0, 3)), np.ones(3)).shape == (2, 0)
    with pytest.raises(ValueError, match=r"^wi must be finite, got nan at index \(2,\)$"):
        pairs(np.ones((0, 3)), [1.0, 1.0, np.nan])
    with pytest.raises(ValueError, match=r"^wo must be finite, got inf at index \(1, 0\)$"):
        pairs([[1.0, 1.0, 1.0], [np.inf, 1.0, 1.0]], np.ones((0, 1, 3)))


def test_out_is_filled_whether_or_not_arguments_are_checked() -> None:
    rows = arguments(MANY_ROWS)[0]
    out = np.full(MANY_ROWS, np.nan)
    assert pairs(rows, rows, out) is out
    np.testing.assert_array_equal(out, PAIRS([rows, rows], (2.0,)))
    rows[-1, 0] = np.nan
    with pytest.raises(ValueError, match="wo must be finite"):
        pairs(rows, rows, out)
    with pytest.raises(ValueError, match="out must be"):
        pairs(rows, rows, out[1:])


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_finite_numbers_whose_sum_overflows_pass(real: type) -> None:
    """The sum of all numbers of a turn is what a loop looks at first."""
    rows, u = np.ones((MANY_ROWS, 3), real), np.full(2, 0.5, real)
    rows[7] = np.finfo(real).max
    for x in (rows, rows[7]):
        np.testing.assert_array_equal(HALVES([points("x", x), uniform("u", u)]), 0.5 * x[..., 0])


def test_not_checked_unless_named() -> None:
    assert np.isnan(PAIRS([np.full(3, np.nan), np.ones(3)], (2.0,)))


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_shares_lie_in_their_interval(real: type) -> None:
    rows, u = np.ones((MANY_ROWS, 3), real), np.full((MANY_ROWS, 2), 0.5, real)
    last, least = np.nextafter(real(1), real(0)), np.finfo(real).smallest_subnormal
    for fine in (0.0, -0.0, least, last):
        u[-1, 1] = fine
        HALVES([points("x", rows), uniform("u", u)])
    for wrong, words in ((1.0, r"lie in \[0, 1\)"), (-least, r"lie in \[0, 1\)"), (np.nan, "be finite"), (np.inf, "be finite")):
        u[-1, 1] = wrong
        with pytest.raises(ValueError, match=f"^u must {words}, got .*{real(wrong)}"):
            HALVES([points("x", rows), uniform("u", u)])
        with pytest.raises(ValueError, match=f"^u must {words}, got .*{real(wrong)}"):
            HALVES([points("x", rows), uniform("u", u[-1])])


def test_arrays_that_are_not_aligned() -> None:
    rows, s = arguments(50)
    bytes_ = np.zeros(rows.nbytes + 1, np.uint8)
    crooked = bytes_[1:].view(np.float64).reshape(rows.shape)
    crooked[:] = rows
    assert not crooked.flags.aligned
    np.testing.assert_array_equal(MANY([crooked, s], (0.3,)), MANY([rows, s], (0.3,)))
