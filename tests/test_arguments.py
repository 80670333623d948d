"""Where a check looks, and how it counts: arguments over the whole domain, errors in last places, words of marks."""

from __future__ import annotations

import math
from typing import Any

import microfacet as mf
import mpmath
import numpy as np
import pytest
from microfacet.statements import balls, checks, enclosures
from microfacet.statements.checks import CheckResult
from microfacet.statements.notation import Direction

WITH_DIRECTIONS = [key for key in mf.equations if any(isinstance(a, Direction) for a in mf.equations[key].over)]
HORIZON = 1e-6 * math.pi / 180


@pytest.mark.parametrize("kind", ["hemisphere", "sphere"])
def test_polar_angles_are_dense_at_both_ends(kind: str) -> None:
    """Half of them by magnitude from 1e-9 of an eighth of a turn, half by their distance from the horizon."""
    share = np.random.default_rng(1).random(3000)
    theta = checks._angle(share, kind)
    below = theta > math.pi / 2
    assert below.mean() == pytest.approx(1 / 3 if kind == "sphere" else 0, abs=1e-9)
    above = np.where(below, math.pi - theta, theta)
    assert above.min() >= 0
    assert above.max() <= math.pi / 2 - HORIZON * (1 - 1e-9)
    near, far = above[::2], above[1::2]
    np.testing.assert_allclose(np.log(near / (math.pi / 4)) / math.log(1e-9), 1 - share[::2], atol=1e-12)
    apart = math.pi / 2 - far
    inside = apart < math.pi / 2 - 1e-9
    np.testing.assert_allclose(np.log(apart[inside]) / math.log(HORIZON), share[1::2][inside], atol=1e-6)
    assert (near < 1e-4).mean() == pytest.approx(1 - math.log(1e-4 / (math.pi / 4)) / math.log(1e-9), abs=0.03)
    assert (apart < 1e-4).mean() == pytest.approx(1 - math.log(1e-4) / math.log(HORIZON), abs=0.03)


def test_intervals_are_filled_by_magnitude_only_where_they_span_it() -> None:
    share = np.linspace(0, 1, 5)
    np.testing.assert_allclose(checks._interval((1e-2, 1e6), share), [1e-2, 1, 1e2, 1e4, 1e6])
    np.testing.assert_allclose(checks._interval((1e-2, 1.0), share), [0.01, 0.2575, 0.505, 0.7525, 1])
    np.testing.assert_allclose(checks._interval((0, 1e6), share), 1e6 * share)
    np.testing.assert_allclose(checks._interval((-2, 2), share), [-2, -1, 0, 1, 2])
    assert checks._interval((1e-3, 0.7), np.array([1.0]))[0] == 0.7


@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("key", WITH_DIRECTIONS[:6])
def test_directions_of_a_sample_are_of_unit_length_and_anywhere(key: str, real: type) -> None:
    equation = mf.equations[key]
    points, column = checks.sample(equation, real), 0
    assert points.dtype == real
    for argument, domain in equation.over.items():
        if not isinstance(argument, Direction):
            column += 1
            continue
        w = points[:, column : column + 3].astype(float)
        column += 3
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
        assert (w[:, 2] < 0).any() == (domain == "sphere")
        quarters = np.histogram(np.arctan2(w[:, 1], w[:, 0]), 4, (-math.pi, math.pi))[0]
        assert quarters.min() > 0.15 * len(w)
    assert column == points.shape[1]


def test_rounding_never_leaves_the_domain() -> None:
    """The end of an interval lies between two single numbers: the one inside is taken."""
    values = np.array([0.1, 0.3, 1 / 3], np.float32)
    for value in values:
        step = 0.3 * float(np.spacing(value))
        assert float(value) + step <= checks._clip(np.array([value]), (float(value) + step, 1.0), np.float32)[0]
        assert float(value) - step >= checks._clip(np.array([value]), (0.0, float(value) - step), np.float32)[0]
    np.testing.assert_array_equal(checks._clip(values, (0.0, 1.0), np.float32), values)


@pytest.mark.parametrize("value", [1.0, 1.5, 2.0, 0.1, 3e-300, 7e200, -1.25])
def test_a_last_place_is_that_of_the_exact_value(value: float) -> None:
    exact = mpmath.mpf(value)
    assert checks.ulps(value + math.ulp(value), exact, np.float64) == 1
    assert checks.ulps(value - 3 * math.ulp(value), exact, np.float64) == 3
    if 1e-30 < abs(value) < 1e30:
        single = float(np.spacing(np.float32(abs(value))))
        assert checks.ulps(value + 2 * single, exact, np.float32) == 2
    assert checks.ulps(0.0, mpmath.mpf(0), np.float64) == 0
    assert checks.ulps(math.inf, exact, np.float64) == math.inf


def test_what_a_precision_cannot_hold_is_not_counted() -> None:
    for real, tiny, huge in ((np.float64, 2.2250738585072014e-308, 1.7976931348623157e308), (np.float32, 2.0**-126, 3.4e38)):
        assert checks.representable(mpmath.mpf(0), real)
        assert checks.representable(mpmath.mpf(tiny), real)
        assert checks.representable(mpmath.mpf(huge), real)
        assert checks.representable(-mpmath.mpf(huge), real)
        assert not checks.representable(mpmath.mpf(tiny) / 2, real)
        assert not checks.representable(mpmath.mpf(huge) * 2, real)


def test_the_worst_error_is_told_with_its_place() -> None:
    """Of a kernel that is off by two last places at its largest arguments only."""

    class Stub:
        key, over, arguments = "a.b", {"x": (1.0, 2.0)}, ("x",)

        def kernel(self, x: np.ndarray) -> np.ndarray:
            return np.where(x == x.max(), x + 2 * np.spacing(x), x)

        def exact(self, x: Any) -> mpmath.mpf:
            return mpmath.mpf(float(x))

    error, where = checks.worst_error(Stub(), np.float64)  # type: ignore[arg-type]
    assert (error, where) == (pytest.approx(2, abs=1), "x=2")


# --- marks ------------------------------------------------------------------------------------------------------------------


def enclosure(low: float, high: float, where: str) -> enclosures.Enclosure:
    return enclosures.Enclosure(where, balls.between(low, high))


def test_enclosures_are_told_by_the_widest() -> None:
    zero = [enclosure(-1e-30, 1e-30, "a = 1"), enclosure(-1e-20, 1e-20, "a = 2")]
    figures = checks._enclosed_figures(zero)
    assert (figures["count"], figures["at"]) == (2, "a = 2")
    assert figures["radius"] == pytest.approx(1e-20, rel=1e-3)
    assert "low" not in figures
    assert checks._enclosed_detail(zero).endswith("at 2 points")
    assert checks._enclosed_detail(zero[:1]).endswith("for a = 1")


def test_crosses_are_told_by_both_ends() -> None:
    off = [enclosure(0.25, 0.5, "a = 1"), enclosure(0.375, 1.0, "a = 2")]
    figures = checks._enclosed_figures(off)
    assert (figures["low"], figures["high"], figures["count"]) == (pytest.approx(0.25), pytest.approx(1.0), 2)
    words = checks._enclosed_detail(off)
    assert "a = 1" in words
    assert "a = 2" in words


def test_a_mark_fails_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    record = checks.StatementRecord(
        "a.b", {"symbolic": CheckResult("pass"), "enclosed": CheckResult("none"), "numeric": CheckResult("fail", "off")}
    )
    assert record.failures == ["numeric: off"]
    assert record.verdict == "fail"
    assert checks.StatementRecord("a.b", {"symbolic": CheckResult("pass"), "numeric": CheckResult("none")}).verdict == "pass"


def test_domains_are_told_to_people() -> None:
    equation = mf.equations["geometry.ggx.Lambda"]
    ((argument, (low, high)),) = equation.over.items()
    assert checks._domain(equation) == f"{argument} in [{low}, {high}]"
    with_direction = checks._domain(mf.equations["geometry.ggx.D"])
    assert "on the sphere" in with_direction or "on the hemisphere" in with_direction


def test_fifty_digits_stand_behind_three_hundred_arguments() -> None:
    """Forms agree to 30 digits: more than either precision can tell, less than the 50 that are computed."""
    assert 2 * 16 - 2 <= checks.AGREE < 50
    assert checks.POINTS == 300
    for key in ("geometry.ggx.Lambda", "geometry.ggx.D"):
        assert len(checks.sample(mf.equations[key], np.float64)) == checks.POINTS
