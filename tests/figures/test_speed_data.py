"""What the charts of speed compute from a record, by a made-up record and methods whose errors are known."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import equal_time_data
import numpy as np
import pytest
import speed_arrays_data
import speed_growth_data
import speed_integrals_data
import speed_rays_data
import speed_samplers_data
import speed_tracing_data

from benchmarks import record
from benchmarks.method import Method

Write = Callable[..., None]


def method(error: Callable[[int], float], sizes: tuple[int, ...] = (10, 100, 1000), kind: str = "") -> Method:
    return Method("in words", lambda size: lambda: None, error, sizes, (method,), kind=kind)


def row(one: Method, seconds: Callable[[int], float], spread: float = 0.1) -> dict[str, Any]:
    """Quartiles around a median for each size."""
    times = [[seconds(n) * (1 - spread), seconds(n), seconds(n) * (1 + spread)] for n in one.sizes]
    return {"fingerprint": one.fingerprint, "sizes": list(one.sizes), "seconds": times, "words": one.label}


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Put a record of quantities in the place of the real one."""
    monkeypatch.setattr(record, "RECORD", tmp_path / "benchmarks.json")

    def write(**quantities: dict[str, dict[str, Any]]) -> None:
        machine = {"processor": "one", "threads": 2, "load": 0.25}
        kept = {name: {"commit": "abc", "machine": machine, "rounds": 16, "rows": rows} for name, rows in quantities.items()}
        record.RECORD.write_text(json.dumps(kept))

    return write


# --- arrays -----------------------------------------------------------------------------------------------------------------


@pytest.fixture
def two(monkeypatch: pytest.MonkeyPatch, write: Write) -> dict[str, Method]:
    """A slow exact method, a fast rough one of the same kind, a worse one, and one without a time."""
    methods = {
        "exact": method(lambda n: 0.0, kind="a"),
        "fast": method(lambda n: n * 1e-6, kind="a"),
        "worse": method(lambda n: n * 1e-5, kind="a"),
        "new": method(lambda n: 0.5, kind="b"),
    }
    monkeypatch.setattr(speed_arrays_data, "SHOWN", {"brdf": methods})
    monkeypatch.setattr(speed_arrays_data, "BRDF", methods)
    slopes = {"exact": (4e-6, 1.0), "fast": (1e-6, 0.5), "worse": (2e-6, 1.0)}
    kept = {name: row(methods[name], lambda n, c=c, p=p: c * n**p) for name, (c, p) in slopes.items()}  # type: ignore[misc]
    other = row(method(lambda n: 0.0), lambda n: 3e-9 * n) | {"version": "7.1", "error": 0.125, "words": "compiled"}
    write(brdf=kept | {"cpp": other | {"sizes": [10, 1000], "seconds": [other["seconds"][0], other["seconds"][2]]}})
    return methods


def test_a_panel_has_errors_and_nanoseconds_a_value_of_the_largest_arrays(two: dict[str, Method]) -> None:
    found = speed_arrays_data.panel("brdf")
    assert list(found["brdf_names"]) == list(two)
    np.testing.assert_allclose(found["brdf_errors"], [2.0**-64, 1e-3, 1e-2, 0.5])  # none is drawn at 0
    per_value = [4e3, 1e3 / np.sqrt(1000), 2e3]
    np.testing.assert_allclose(found["brdf_times"][:3], np.outer(per_value, [0.9, 1, 1.1]))
    assert np.isnan(found["brdf_times"][3]).all()
    assert list(found["brdf_best"]) == [True, True, False, False]
    assert list(found["brdf_kinds"]) == ["a", "a", "a", "b"]
    assert (found["brdf_exact_ns"], found["brdf_fast_error"]) == (pytest.approx(4e3), pytest.approx(1e-3))
    assert "Not measured yet: in words" in found["brdf_told"]
    assert list(found["brdf_record"]) == ["abc", "0.2", "16", "not measured yet for in words"]
    assert found["brdf_stale"] == ""


def test_a_call_costs_microseconds_and_grows_with_a_power(two: dict[str, Method]) -> None:
    found = speed_arrays_data.call_cost()
    np.testing.assert_array_equal(found["growth_sizes"], [10, 100, 1000])
    np.testing.assert_allclose(found["growth_exponents"][:3], [1, 0.5, 1], atol=1e-12)
    assert np.isnan(found["growth_exponents"][3])
    assert found["growth_exact_call_us"] == pytest.approx(40)
    assert found["growth_fast_exponent"] == pytest.approx(0.5)
    np.testing.assert_allclose(found["growth_times"][0], [4e-5, 4e-4, 4e-3])
    assert found["yardstick_cpp_ns"] == pytest.approx(3)
    assert np.isnan(found["yardstick_cpp_no_errno_ns"])
    np.testing.assert_allclose(found["yardstick_times"], [[3e-8, np.nan, 3e-6]])
    assert list(found["yardstick_words"]) == ["compiled"]


def test_a_power_is_that_of_the_largest_three_sizes(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    """What a call costs before its first value is not counted."""
    methods = {"one": method(lambda n: 0.0, sizes=(1, 10, 100, 1000))}
    monkeypatch.setattr(speed_arrays_data, "BRDF", methods)
    write(brdf={"one": row(methods["one"], lambda n: max(n, 10) * 1e-6)})
    assert speed_arrays_data.call_cost()["growth_exponents"] == pytest.approx([1.0])


def test_others_say_their_version_and_why_they_are_absent(two: dict[str, Method], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed_arrays_data, "known", lambda quantity: {"cpp": "a variant, that", "gone": "another"})
    found = speed_arrays_data.others("brdf")
    assert list(found["brdf_others_words"]) == ["a variant 7.1, that", "another"]
    assert found["brdf_others_ns"][0] == pytest.approx(3)
    assert np.isnan(found["brdf_others_ns"][1])
    assert list(found["brdf_others_said"]) == ["", "not measured"]
    np.testing.assert_array_equal(found["brdf_others_error"], [0.125, np.nan])


# --- growth and integrals -----------------------------------------------------------------------------------------------------


def test_a_fit_has_the_standard_error_of_its_slope() -> None:
    """By the covariance of numpy's own fit, scaled by the scatter."""
    rng = np.random.default_rng(3)
    sizes = np.geomspace(10, 1e6, 9)
    times = sizes**1.5 * np.exp(0.1 * rng.standard_normal(9))
    x, y = np.log(sizes[2:]), np.log(times[2:])
    slope, covariance = np.polyfit(x, y, 1, cov=True)
    found, error = speed_growth_data.power(sizes, times, int(sizes[2]))
    assert found == pytest.approx(slope[0])
    assert error == pytest.approx(np.sqrt(covariance[0, 0]))
    assert np.isnan(speed_growth_data.power(sizes[:4], times[:4], int(sizes[2]))[0])  # two points have no error
    assert np.isfinite(speed_growth_data.power(sizes[:5], times[:5], int(sizes[2]))[0])


def test_growth_is_charted_with_what_is_expected(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    from benchmarks.rivals_growth import Expected

    one = method(lambda n: 0.0, sizes=(10, 100, 1000, 10000))
    monkeypatch.setattr(speed_growth_data, "METHODS", {"one": one})
    monkeypatch.setattr(speed_growth_data, "EXPECTED", {"one": Expected(2.0, 100, "pairs")})
    write(growth={"one": row(one, lambda n: 1e-6 * max(n, 50) ** 2)})
    found = speed_growth_data.compute()
    np.testing.assert_allclose(found["one_times"][:, 1], 1e-6 * np.array([50.0, 100, 1000, 10000]) ** 2)
    np.testing.assert_array_equal(found["one_sizes"], one.sizes)
    assert (found["one_power"], found["one_expected"], found["one_first"], found["one_why"]) == (2, 2, 100, "pairs")
    assert found["one_power_error"] < 1e-9
    assert list(found["record"]) == ["abc", "0.2", "16", "as it was"]
    assert found["rays_traced"] == speed_growth_data.RAYS


def test_integrals_say_what_reaches_the_error_asked_for_and_how_soon(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    methods = {
        "fast": method(lambda n: 10.0 ** -(n // 2), sizes=(4, 24, 28)),
        "slow": method(lambda n: 0.0, sizes=(4, 8)),
        "never": method(lambda n: 1e-3, sizes=(4,)),
        "new": method(lambda n: 0.0, sizes=(5,)),
    }
    monkeypatch.setattr(speed_integrals_data, "AREAS", methods)
    kept = {name: row(methods[name], lambda n, c=c: c * n) for name, c in (("fast", 1e-6), ("slow", 1e-5), ("never", 1e-4))}  # type: ignore[misc]
    write(integral=kept)
    found = speed_integrals_data.compute()
    np.testing.assert_allclose(found["fast_errors"], [1e-2, 1e-12, 1e-14])
    np.testing.assert_allclose(found["slow_errors"], [1e-16, 1e-16])
    np.testing.assert_allclose(found["fast_times"], [4e-6, 2.4e-5, 2.8e-5])
    assert found["fast_reaches"] == pytest.approx(2.4e-5)
    assert found["slow_reaches"] == pytest.approx(4e-5)
    assert found["never_reaches"] == found["new_reaches"] == np.inf
    assert [list(found[f"{name}_best"]) for name in methods] == [[True] * 3, [True, False], [False], [False]]
    assert found["asked"] == 1e-12


# --- samplers -----------------------------------------------------------------------------------------------------------------


def test_variance_times_time_of_samplers(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    """A variance of 2 at every angle: the effort is twice the time; the spread is 1.96 standard errors."""
    samplers = dict(list(speed_samplers_data.SAMPLERS.items())[:3])
    methods = {name: method(lambda n: 0.0, kind=name) for name in samplers}
    asked: list[tuple[float, float]] = []

    def variance(sampler: Any, alpha: float, theta: float, each: int) -> tuple[float, float]:
        asked.append((alpha, theta))
        return (8.0, 0.5) if np.degrees(theta) > 60 else (0.5, 0.25)

    monkeypatch.setattr(speed_samplers_data, "METHODS", methods)
    monkeypatch.setattr(speed_samplers_data, "SAMPLERS", samplers)
    monkeypatch.setattr(speed_samplers_data, "variance", variance)
    write(estimate={name: row(one, lambda n: 1e-8 * n) for name, one in methods.items()})
    found = speed_samplers_data.compute()
    degrees = found["degrees"]
    assert (degrees > 60).sum() == (degrees < 60).sum()  # so the mean of the logarithms is that of 8 and 1/2
    np.testing.assert_allclose(np.unique(np.round(np.degrees([theta for _, theta in asked]), 9)), degrees)
    assert {alpha for alpha, _ in asked} == {float(found["alpha"])}
    np.testing.assert_allclose(found["times"], 10 * np.array([[0.9, 1, 1.1]] * 3))
    np.testing.assert_allclose(found["efforts"], 2 * found["times"])
    np.testing.assert_allclose(found["variance"], [np.where(degrees > 60, 8, 0.5)] * 3)
    np.testing.assert_allclose(found["spread"], [1.96 * np.where(degrees > 60, 0.5, 0.25)] * 3)
    np.testing.assert_allclose(found["product"], 10 * found["variance"])
    np.testing.assert_allclose(found["errors"], found["floor"])
    name = next(iter(samplers))
    assert (found[f"{name}_ns"], found[f"{name}_effort"]) == (pytest.approx(10), pytest.approx(20))
    assert found["best"].all()


def test_axes_of_angles_rise_from_above_to_grazing() -> None:
    for axis in (equal_time_data.THETA, speed_samplers_data.DEGREES):
        assert axis[0] == 0
        assert 80 < axis[-1] < 90
        assert (np.diff(axis) > 0).all()
        assert (np.diff(np.radians(axis), 2) < 0.01).all()  # denser and denser
    assert (np.diff(equal_time_data.ALPHA) > 0).all()


def test_a_gain_has_an_interval_of_95_per_cent(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    """Of a quotient of variances and of times, each with its relative standard error, all four added in squares."""
    methods = {name: equal_time_data.ESTIMATE[name] for name in equal_time_data.NAMES.values()}
    kept = {
        name: row(one, lambda n, name=name: n * (2e-9 if name == "normals" else 5e-9), 0.2) for name, one in methods.items()
    }  # type: ignore[misc]
    write(estimate=kept)
    middle, error = equal_time_data.time("estimate", "normals", methods)
    assert middle == pytest.approx(2e-9)
    sigma = 0.4 / 1.349  # from the distance of the quartiles of a normal distribution
    assert error == pytest.approx(np.sqrt(np.pi / 2) * sigma / np.sqrt(16), rel=1e-4)  # the median's error
    monkeypatch.setattr(
        equal_time_data, "variance", lambda s, a, t: (6.0, 0.3) if s is equal_time_data.SAMPLERS["normals"] else (2.0, 0.2)
    )
    found = equal_time_data.gains()
    assert found["gain_timed"]
    assert found["time_ratio"] == pytest.approx(0.4)
    spread = 1.96 * np.sqrt(0.05**2 + 0.1**2 + 2 * error**2)
    np.testing.assert_allclose(found["gain"][2, 5], 1.2 * np.exp([-spread, 0, spread]))
    np.testing.assert_allclose(found["variance_ratio"][..., 1], 3)
    assert found["gain"].shape == (len(found["alpha"]), len(found["theta"]), 3)


def test_gains_without_times_are_those_of_variances(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    write()
    monkeypatch.setattr(equal_time_data, "variance", lambda s, a, t: (6.0, 0.0))
    found = equal_time_data.gains()
    assert not found["gain_timed"]
    np.testing.assert_allclose(found["gain"], 1)


def test_pictures_of_equal_time_have_samples_by_their_speed(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    """A method that takes half as long gets twice the samples; errors are those of the picture, relative to its mean."""
    for name, value in {"SIDE": 6, "SAMPLES": 3, "REFERENCE": 4, "RENDERS": 5}.items():
        monkeypatch.setattr(equal_time_data, name, value)
    methods = equal_time_data.METHODS
    write(render={name: row(methods[name], lambda n, c=c: c * n) for name, c in (("normals", 1e-8), ("visible", 2e-8))})  # type: ignore[misc]
    asked: list[tuple[str, int, int]] = []

    def render(name: str, normal: np.ndarray, samples: int, seed: int) -> np.ndarray:
        asked.append((name, samples, seed))
        return np.full(len(normal), 2.0 if seed == 99 else 2.0 + 0.1 * (seed + 1))

    monkeypatch.setattr(equal_time_data, "render", render)
    found = equal_time_data.pictures()
    assert found["ratio"] == pytest.approx(2)
    assert (found["visible_samples"], found["normals_samples"]) == (3, 6)
    assert asked[0] == ("visible", 4, 99)
    assert asked[1:] == [(name, count, seed) for name, count in (("normals", 6), ("visible", 3)) for seed in range(5)]
    off = 0.1 * np.arange(1, 6) / 2
    assert found["normals_error"] == pytest.approx(off.mean())
    assert found["normals_error_error"] == pytest.approx(1.96 * off.std(ddof=1) / np.sqrt(5))
    np.testing.assert_allclose(found["normals_picture"], 2.1)
    np.testing.assert_allclose(found["exact"], 2)


def test_a_render_is_the_mean_of_its_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    counted = iter(range(100))
    monkeypatch.setattr(equal_time_data, "shading", lambda sampler: lambda arrays, p: np.full(len(arrays[0]), next(counted)))
    np.testing.assert_allclose(equal_time_data.render("visible", np.zeros((4, 3)), 5, 1), 2.0)


# --- rays ---------------------------------------------------------------------------------------------------------------------


def test_rays_are_compared_by_the_ray(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    methods = {
        name: method(lambda n, w=w: w / n, sizes=(1000,)) for name, w in (("primary_unsorted", 2), ("shadow_unsorted", 1))
    }  # type: ignore[misc]
    guests = speed_rays_data.GUESTS["rays"]
    names = list(guests)
    monkeypatch.setattr(speed_rays_data, "METHODS", methods)
    monkeypatch.setattr(speed_rays_data, "RAYS", (1000,))
    monkeypatch.setattr(speed_rays_data, "GUESTS", {"rays": {name: guests[name] for name in names[:2]}})
    other = {name: row(methods["primary_unsorted"], lambda n: 5e-8 * n) | {"version": "4.4"} for name in names[:1]}
    write(rays={name: row(one, lambda n: 1e-7 * n) for name, one in methods.items()} | other)
    found = speed_rays_data.compute()
    np.testing.assert_allclose(found["times"], [[90, 100, 110]] * 2)
    np.testing.assert_allclose(found["embree_times"], [[45, 50, 55], [np.nan] * 3])
    np.testing.assert_allclose(found["ratio"], [0.5, np.nan])
    assert (found["false"], found["wrong"], found["checked"], found["rays"]) == (2e-3, 3, 2000, 1000)
    assert found["spacing"] == pytest.approx(2.0 ** (np.floor(np.log2(speed_rays_data.SIDE - 1)) - 23), rel=1e-3)
    assert found["embree_version"] == "4.4"
    assert found["embree_said"] == ""


def test_tracing_finds_the_least_effort(monkeypatch: pytest.MonkeyPatch, write: Write) -> None:
    """Scatter that falls with the root of the rays: error^2 times time is the same for all but one."""
    methods = {f"grid_{k}": method(lambda n, k=k: k / n, sizes=(10, 100)) for k in (1, 2)}  # type: ignore[misc]
    times = {"grid_1": {10: 4.0, 100: 900.0}, "grid_2": {10: 2.0, 100: 100.0}}
    monkeypatch.setattr(speed_tracing_data, "METHODS", methods)
    monkeypatch.setattr(speed_tracing_data, "GRIDS", (1, 2))
    monkeypatch.setattr(speed_tracing_data, "SIDES", (10, 100))
    write(tracing={name: row(one, times[name].__getitem__) for name, one in methods.items()})
    found = speed_tracing_data.compute()
    np.testing.assert_allclose(found["errors"], [[0.1, 0.01], [0.2, 0.02]])
    np.testing.assert_allclose(found["times"], [[4, 900], [2, 100]])
    assert found["front"].tolist() == [[True, True], [True, True]]
    effort = found["errors"] ** 2 * found["times"]  # 0.04 0.09, 0.08 0.04
    assert found["best"].tolist() in ([0, 0], [1, 1])
    assert found["goal_seconds"] == pytest.approx(effort.min() / 1e-6)
    assert found["worst_ratio"] == pytest.approx(0.09 / 0.04)
    surfaces = speed_tracing_data.SURFACES
    draws = np.random.default_rng(1).standard_normal((20000, surfaces)).std(axis=1, ddof=1)
    assert found["sure"] == pytest.approx(draws.std() / draws.mean(), rel=0.05)
    assert found["surfaces"] == surfaces


def test_tracing_quotes_the_campaign(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its surfaces, rays and grid, and the relative error of a ratio of sums, by another jackknife."""
    from report.campaign import CAMPAIGN, THETA_O, read

    found, entry = speed_tracing_data.campaign(), CAMPAIGN["lobes_07"]
    kept = read("lobes_07")
    view = int(np.argmin(abs(np.array(THETA_O) - np.degrees(speed_tracing_data.VIEW))))
    seen, faced = (kept[name][:, view].sum(axis=-1) for name in ("seen", "faced"))
    left = np.array([np.delete(seen, k).sum() / np.delete(faced, k).sum() for k in range(len(seen))])
    error = np.sqrt((len(left) - 1) * np.mean((left - left.mean()) ** 2)) / (seen.sum() / faced.sum())
    assert found["campaign_error"] == pytest.approx(error, rel=0.05)
    assert (found["campaign_surfaces"], found["campaign_side"], found["campaign_size"]) == (
        len(seen), entry.plan.side, entry.family.size,
    )  # fmt: skip
