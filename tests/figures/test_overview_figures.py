"""The overview's figures and the light that is lost: estimators are right, verdicts and closed forms are the library's."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import microfacet as mf
import numpy as np
import pytest

pytestmark = pytest.mark.slow  # the spheres are shaded here

Compute = Callable[[str], dict[str, Any]]
FIGURES = Path(__file__).parents[2] / "figures"


@pytest.fixture(scope="module")
def spheres() -> dict[str, Any]:
    return runpy.run_path(str(FIGURES / "overview/spheres_data.py"))


@pytest.mark.parametrize("ndf", [mf.GGX(0.6), mf.Beckmann(0.25), mf.GGX(0.08, 0.5)], ids=repr)
def test_an_even_sky_shows_the_albedo(spheres: dict[str, Any], ndf: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever directions are tried, the mean is the albedo of the view, which a quadrature gives."""
    monkeypatch.setitem(spheres["shade"].__globals__, "environment", lambda w: np.ones((*w.shape[:-1], 3)))
    normal, _ = spheres["disc"]()
    few = normal[:: len(normal) // 40]
    axes = spheres["frames"](few)
    brdf, guide = mf.Microfacet(mf.Smith(ndf), spheres["METAL"]), mf.Microfacet(mf.Smith(mf.GGX(*ndf.slope_scale)))
    shifts = [np.random.default_rng(k).random((len(few), 2)) for k in range(24)]
    runs = [spheres["shade"](brdf, guide, axes, shift, 96).mean(axis=0) for shift in shifts]
    mean, error = np.mean(runs, axis=0)[:, 0], np.std(runs, axis=0)[:, 0] / np.sqrt(len(runs) - 1)
    apart = (mean - brdf.albedo(axes[:, :, 2])) / np.hypot(error, 1e-4)
    assert np.abs(apart).max() < 6
    assert np.mean(apart**2) < 2.5


def test_light_directions_have_their_density(spheres: dict[str, Any]) -> None:
    """The mean of 1/density over a cap is the cap's solid angle."""
    u = np.random.default_rng(1).random((200_000, 2))
    w = spheres["light_directions"](u)
    density = spheres["light_density"](w)
    np.testing.assert_allclose(np.linalg.norm(w, axis=-1), 1, atol=1e-12)
    for towards, narrow, _ in spheres["LIGHTS"]:
        cap = 1 - 0.5 / narrow
        inside = w @ (np.array(towards) / np.linalg.norm(towards)) > cap
        values = inside / density
        solid_angle = 2 * np.pi * (1 - cap)
        assert abs(values.mean() - solid_angle) < 5 * values.std() / np.sqrt(len(u))


def test_frames_are_right_handed(spheres: dict[str, Any]) -> None:
    axes = spheres["frames"](spheres["disc"]()[0])
    np.testing.assert_allclose(np.linalg.det(axes), 1, atol=1e-12)


def test_models_are_sorted_by_their_verdicts(compute: Compute) -> None:
    data = compute("overview/models")
    wrong = dict(zip(data["name"], data["failed"].sum(axis=1), strict=True))
    assert [wrong[f"GGX, {name}"] for name in ("Smith", "V-cavities")] == [0, 0]
    assert [wrong[f"GGX, {name}"] for name in ("Kelemen", "Implicit", "Schlick-Smith")] == [3, 3, 3]
    assert wrong["Ward, V-cavities"] == wrong["first Blinn-Phong, V-cavities"] == 4
    assert wrong["normalised Blinn-Phong, V-cavities"] == wrong["stretched GGX, Smith"] == 0


def test_lost_light_meets_its_closed_forms(compute: Compute) -> None:
    data = compute("brdf/energy_loss")
    np.testing.assert_allclose(data["ggx_angles"][-1], data["exact"], atol=2e-6)
    assert data["exact"][0] == pytest.approx(np.log(2), abs=1e-7)
    assert data["ggx_views"][0, -1] == pytest.approx(np.log(2), abs=2e-6)
    np.testing.assert_allclose(data["exact_views"], [np.log(2), np.log(3) / 2], atol=1e-6)
    np.testing.assert_allclose(data["ggx_views"][:, -1], data["exact_views"], atol=2e-6)
    assert data["ggx_average"][-1] == pytest.approx(1 - 4 / 3 * (1 - np.log(2)), abs=2e-6)
    for name in ("ggx", "beckmann"):
        assert np.all(np.diff(data[f"{name}_views"][0]) > -1e-6)
        assert np.all(np.diff(data[f"{name}_average"]) > 0)
    lines = np.array([np.interp(data["traced_alpha"], data["alpha"], line) for line in data["beckmann_views"]]).T
    assert abs(data["traced"][:, 0] - lines).max() < 0.05
