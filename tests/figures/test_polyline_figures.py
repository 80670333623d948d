"""What the polyline's figures print is what their data scripts computed, and it adds up."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

FIGURES = Path(__file__).parents[2] / "figures"


def compute(name: str) -> dict[str, Any]:
    values: dict[str, Any] = runpy.run_path(str(FIGURES / f"{name}_data.py"))["compute"]()
    return values


def test_microsurface_is_longer_than_its_plane() -> None:
    data = compute("geometry/microsurface")
    assert data["length"] == pytest.approx(np.hypot(np.diff(data["x"]), np.diff(data["z"])).sum(), abs=1e-14)
    assert data["length"] > 1
    np.testing.assert_allclose(np.linalg.norm(data["normals"], axis=1), 1)


def test_every_facet_lands_in_the_bin_of_its_normal() -> None:
    data = compute("geometry/facets_to_circle")
    theta = np.arctan2(data["normals"][:, 0], data["normals"][:, 1])
    assert np.all(data["bounds"][data["bins"]] <= theta)
    assert np.all(theta < data["bounds"][data["bins"] + 1])
    assert data["percent"].sum() == 100
    assert data["share"].sum() == pytest.approx(np.hypot(*data["edges"].T).sum(), abs=1e-14)
    for k in range(5):
        assert sorted(data["rank"][data["bins"] == k]) == list(range(np.sum(data["bins"] == k)))


def test_projections_add_up_to_the_plane() -> None:
    data = compute("geometry/projection")
    assert data["thousandths"].sum() == 1000
    assert data["projected"].sum() == pytest.approx(1, abs=1e-14)
    np.testing.assert_allclose(data["thousandths"], 1000 * data["projected"], atol=1)
    np.testing.assert_allclose(data["projected"], np.diff(data["x"]), atol=1e-15)


def test_every_surface_fills_the_same_screen() -> None:
    data = compute("visibility/masking")
    for name in ("flat", "fine", "zoom"):
        assert data[f"{name}_projected"].sum() == pytest.approx(np.cos(np.radians(data["degrees"])), abs=1e-13)
    assert data["thousandths"].sum() == 500
    assert 0 < data["zoom_G1"].min() + 0.5 < data["zoom_G1"].max() + 0.5
    ends = data["zoom_ends"][data["zoom_G1"] > 0]
    screen = ends @ np.array([-data["wo"][1], data["wo"][0]])
    np.testing.assert_allclose(screen[:-1, 1], screen[1:, 0], atol=1e-14, err_msg="the screen has a gap")


def test_visible_normals_add_up_before_and_after() -> None:
    data = compute("visibility/visible_normals")
    for name in ("all", "seen"):
        assert data[f"{name}_percent"].sum() == 100
        assert data[f"{name}_bin_percent"].sum() == 100
    assert data["seen_bin_percent"][4] > data["all_bin_percent"][4]
    assert np.any((data["seen_percent"] == 0) & (data["all_percent"] > 0))


def test_reflected_percentages_equal_the_visible_ones() -> None:
    data = compute("material/reflected_directions")
    np.testing.assert_array_equal(data["seen_percent"], data["reflected_percent"])
    assert data["reflected_percent"].sum() == 100
    assert data["seen"].sum() == pytest.approx(1, abs=1e-13)
    assert data["reflected"].sum() == pytest.approx(1, abs=1e-13)


def test_what_escapes_and_what_is_shadowed_is_everything() -> None:
    data = compute("material/shadowing")
    assert data["percent"].sum() == 100
    assert data["shares"].sum() == pytest.approx(1, abs=1e-13)
    drawn = np.mean(np.isfinite(data["length"]))
    assert abs(drawn - data["shares"][1]) < 3 / len(data["length"])


@pytest.mark.slow
def test_pipeline_draws_sums_that_hold() -> None:
    data = compute("overview/pipeline")
    assert np.all(data["holds"])
    assert np.all(data["classic"])
    np.testing.assert_allclose(data["sums"][:3], [1, data["wo"][1], 1], atol=1e-13)
    assert 0 < data["sums"][3] < 1
    assert 0.8 < np.sum(data["lobe"]) * np.diff(data["theta"])[0] < 1
