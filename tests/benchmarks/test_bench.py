"""The benchmarks: every method does what it says, a record is renewed by name, and code that changed is called stale."""

from __future__ import annotations

import dataclasses
import json
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from microfacet.brdf.microfacet import Microfacet
from microfacet.directions import spherical

from benchmarks import (
    bench,
    record,
    rivals,
    rivals_estimate,
    rivals_fresnel,
    rivals_growth,
    rivals_integral,
    rivals_rays,
    rivals_tracing,
    yardsticks,
)

FRESNEL = rivals_fresnel.METHODS
EXACT = {"masking": 1e-6, "normals": 2e-6, "brdf": 2e-6, "sampling": 5e-6, "fresnel": 2e-6}
FITS = {"walter": 4e-3, "walter_single": 4e-3, "schlick": 0.3, "schlick_single": 0.3}


@pytest.mark.parametrize("quantity", EXACT)
def test_methods_of_a_quantity_compute_the_same(quantity: str) -> None:
    for name, method in rivals.QUANTITIES[quantity].items():
        assert method.error(100) < FITS.get(name, EXACT[quantity] if "single" in name else 1e-13), name


@pytest.mark.slow
def test_rules_converge() -> None:
    for name, last in {"midpoint": 1e-4, "gauss_angles": 1e-8, "gauss_slopes": 1e-13, "tanh_sinh": 1e-13}.items():
        method = rivals_integral.METHODS[name]
        assert method.error(method.sizes[-1]) < last
    assert rivals_integral.METHODS["library"].error(0) < 1e-12
    assert rivals_integral.METHODS["any"].error(12) < 1e-12
    assert rivals_integral.METHODS["cubature"].error(12) < 1e-12


@pytest.mark.parametrize("name", rivals_estimate.SAMPLERS)
def test_samplers_draw_from_the_density_that_they_claim(name: str) -> None:
    """Difference quotients tell exact samplers from fits, whatever is inside."""
    fits = {"heitz_d_eon": (1e-3, 1e-2), "beckmann_jakob": (1e-7, 1e-4)}
    least, most = fits.get(name, (0, 1e-7))
    assert least <= rivals_estimate.apart(rivals_estimate.SAMPLERS[name]) < most


@pytest.mark.parametrize("name", [n for n in rivals_estimate.SAMPLERS if n != "heitz_d_eon"])
def test_weights_add_up_to_the_albedo(name: str) -> None:
    sampler, wo, count = rivals_estimate.SAMPLERS[name], spherical(np.radians(70.0), 0.5), 40000
    model = sampler.model(0.5, 0.3)
    u = rivals_estimate.uniform(count, 4)
    weights = rivals_estimate.estimates(sampler)([np.broadcast_to(wo, (count, 3)), u], model.parameters)[:, 3]
    assert abs(weights.mean() - Microfacet(model).albedo(wo)) < 4 * weights.std() / np.sqrt(count)


@pytest.mark.parametrize("name", ["normals", "caps", "bounded"])
def test_the_variance_is_within_its_interval(name: str) -> None:
    """Against midpoints over the square of the uniform numbers."""
    sampler, theta = rivals_estimate.SAMPLERS[name], np.radians(65.0)
    found, error = rivals_estimate.variance(sampler, 0.4, theta, each=2**10)
    u = np.stack(np.meshgrid(*2 * [(np.arange(1000) + 0.5) / 1000]), -1).reshape(-1, 2)
    views = np.broadcast_to(spherical(theta), (len(u), 3))
    exact = rivals_estimate.estimates(sampler)([views, u], sampler.model(0.4).parameters)[:, 3].var()
    assert error < 0.1 * exact
    assert abs(found - exact) < 4 * error


def test_an_enclosure_holds_the_area_and_is_as_narrow_as_asked() -> None:
    exact = float(rivals_integral.area_exact())
    for digits in (6, 12, 30):
        found = rivals_integral.enclosed(digits)
        assert abs(float(found.mid()) - exact) <= float(found.rad()) + 1e-15
        assert float(found.rad()) < 10.0 ** (2 - digits)


def test_scatter_falls_with_rays_and_with_the_size_of_the_surface(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rivals_tracing, "SURFACES", 8)
    rivals_tracing.masking.cache_clear()
    few, many, large = (rivals_tracing.scatter(*plan) for plan in ((128, 4), (128, 64), (512, 64)))
    rivals_tracing.masking.cache_clear()
    assert few > 1.5 * many > 1.5 * large > 0


def test_a_power_is_fitted_to_what_is_known() -> None:
    from speed_growth_data import power

    sizes = np.array([1.0, 10, 100, 1000, 10000])
    slope, error = power(sizes, np.array([7.0, 2e2, 2e4, np.nan, 2e8]), 10)
    assert abs(slope - 2) < 1e-12
    assert error < 1e-12
    assert np.isnan(power(sizes, np.full(5, np.nan), 10)[0])


def test_what_does_not_fit_into_memory_is_left_out(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    huge = dataclasses.replace(rivals_growth.METHODS["values"], sizes=(100, 10**15))
    monkeypatch.setitem(rivals.QUANTITIES, "growth", {"values": huge})
    assert [size for _, size, _ in bench.jobs("growth", 10**16)] == [100]
    assert "size 1000000000000000 is left out: it takes" in capsys.readouterr().out


def run(monkeypatch: pytest.MonkeyPatch, path: Path, *asked: str) -> dict[str, Any]:
    monkeypatch.setattr(sys, "argv", ["bench.py", *asked, "--rounds", "2", "--largest", "50", "--record", str(path)])
    bench.main()
    return dict(json.loads(path.read_text("utf-8")))


def test_a_benchmark_is_renewed_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "records" / "benchmarks.json"
    first = run(monkeypatch, path, "fresnel", "masking")
    assert set(first) == {"fresnel", "masking"}
    assert set(first["fresnel"]["rows"]) == set(FRESNEL)
    low, middle, high = first["fresnel"]["rows"]["plain"]["seconds"][0]
    assert 0 < low <= middle <= high
    second = run(monkeypatch, path, "fresnel")
    assert second["masking"] == first["masking"]
    assert second["fresnel"]["rows"]["plain"]["seconds"] != first["fresnel"]["rows"]["plain"]["seconds"]


def test_an_unknown_benchmark_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SystemExit, match="No benchmark frensel; there are masking, normals, brdf"):
        run(monkeypatch, tmp_path / "none.json", "frensel")


def test_code_that_changed_is_stale(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "benchmarks.json"
    run(monkeypatch, path, "fresnel")
    monkeypatch.setattr(record, "RECORD", path)
    assert record.stale("fresnel", FRESNEL) == []
    assert record.mark("fresnel", FRESNEL) == ""
    assert record.summary("fresnel", FRESNEL)[1:] == [record.summary("fresnel", FRESNEL)[1], "2", "as it was"]
    assert "Stale" not in record.note("fresnel", FRESNEL)
    assert "No times are on record" in record.note("brdf", {})
    changed = dataclasses.replace(FRESNEL["plain"], code=(rivals_fresnel.fresnel_exact,))
    monkeypatch.setitem(FRESNEL, "plain", changed)
    assert record.stale("fresnel", FRESNEL) == [changed.label]
    assert record.mark("fresnel", FRESNEL) == "stale times"
    assert record.summary("fresnel", FRESNEL)[3] == f"**changed** for 1 of 5: {changed.label}"
    assert record.summary("brdf", FRESNEL)[3] == "not measured"
    assert f"**Stale**: the code has changed since for {changed.label}" in record.note("fresnel", FRESNEL)


def test_the_front_has_what_nothing_beats() -> None:
    nan = float("nan")
    assert record.front([1, 2, 3, 1, 0], [3, 2, 2, 4, nan]) == [True, True, False, False, False]


def test_times_of_unmeasured_methods_are_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(record, "RECORD", tmp_path / "none.json")
    assert np.isnan(record.seconds("fresnel", "plain", FRESNEL["plain"])).all()


def test_a_guest_that_is_absent_is_named_and_nothing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(yardsticks.importlib.util, "find_spec", lambda name: None)
    found = run(monkeypatch, tmp_path / "benchmarks.json", "brdf")
    assert found["brdf"]["rivals"] == dict.fromkeys(yardsticks.GUESTS["brdf"], "not installed")
    assert set(rivals.QUANTITIES["brdf"]) <= set(found["brdf"]["rows"])


def test_a_guest_that_cannot_start_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = yardsticks.Entry("another program", "json", np.float64, "brdf")
    monkeypatch.setattr(yardsticks, "GUESTS", {"brdf": {"other": entry}})
    with ExitStack() as stay:
        jobs, refused, _ = yardsticks.guest_jobs("brdf", str(tmp_path), 100, stay)
    assert jobs == []
    assert refused["other"].startswith("installed, but it ended with status 1: KeyError: ('json', 'brdf')")


def test_calls_that_take_long_are_repeated_less() -> None:
    assert bench.plan_of(lambda: None, 15)[1] == 15
    assert bench.plan_of(lambda: bench.time.sleep(0.5), 15) == (1, 7)


@pytest.mark.parametrize("order", rivals_rays.ORDERS)
def test_rays_of_known_verdict_get_it(order: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for kind in ("primary", "shadow"):
        assert rivals_rays.false(f"{kind}_{order}", 20_000) == 0
    assert np.isnan(rivals_rays.false(f"reflected_{order}", 10))
    origins, ways, facets = rivals_rays.rays(f"shadow_{order}", 20_000)
    monkeypatch.setattr(rivals_rays, "rays", lambda task, count: (origins, -ways, facets))
    assert rivals_rays.false(f"shadow_{order}", 20_000) == 1


def test_rays_by_tiles_are_the_same_rays() -> None:
    loose, sorted_ = (rivals_rays.rays(f"primary_{order}", 5000)[0] for order in rivals_rays.ORDERS)
    steps = [abs(np.diff(origins[:, :2] // rivals_rays.TILE, axis=0)).max(axis=1).mean() for origins in (loose, sorted_)]
    np.testing.assert_array_equal(np.sort(loose, axis=0), np.sort(sorted_, axis=0))
    assert steps[1] < 0.2 < steps[0]


def test_rays_without_embree_are_charted_as_not_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import speed_rays_data

    monkeypatch.setattr(record, "RECORD", tmp_path / "none.json")
    found = speed_rays_data.embree()
    assert np.isnan(found["embree_times"]).all()
    assert np.isnan(found["embree_reflected"]).all()
    assert found["embree_said"] == "not measured"


def torn_records() -> list[bytes]:
    whole = Path("records/benchmarks.json").read_bytes()
    changed = [
        whole.replace(name, b"x", 1) for name in (b"commit", b"machine", b"load", b"rows", b"sizes", b"words", b"rounds")
    ]
    return [
        b"",
        b"[]",
        b"3",
        b"null",
        b"\xff",
        b'{"brdf": 3}',
        b'{"brdf": {}}',
        whole[:-100],
        whole[: len(whole) // 2],
        *changed,
    ]


@pytest.mark.parametrize("content", torn_records(), ids=lambda content: str(content[-8:]))
def test_a_torn_record_is_one_sentence(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "benchmarks.json"
    path.write_bytes(content)
    with pytest.raises(SystemExit, match=r"benchmarks\.json is torn or no record of benchmarks: `git checkout"):
        record.read(path)
