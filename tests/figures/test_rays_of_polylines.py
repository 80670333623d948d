"""Rays, bins and pieces that the polyline's figures draw, against rays walked in small steps and sums written out here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]
Compute = Callable[[str], dict[str, Any]]
STEP = 1e-4


def height(data: dict[str, Any], x: Array) -> Array:
    """Of the periodic polyline."""
    return np.interp(np.remainder(x, 1.0), data["x"], data["z"])


def walk(data: dict[str, Any], origin: Array, w: Array, far: float = 1.5) -> float:
    """Where a ray first goes below the surface, in steps; inf if it does not."""
    t = np.arange(10 * STEP, far, STEP)
    below = height(data, origin[0] + t * w[0]) > origin[1] + t * w[1]
    return float(t[below.argmax()]) if below.any() else np.inf


def same_way(length: float, walked: float) -> bool:
    return bool(np.isinf(length) and np.isinf(walked)) or abs(length - walked) < 20 * STEP


@pytest.mark.parametrize("name", ["geometry/facets_to_circle", "visibility/visible_normals"])
def test_bins_are_alike_and_even(compute: Compute, name: str) -> None:
    bounds = np.degrees(compute(name)["bounds"])
    np.testing.assert_allclose(np.diff(bounds), 120 / 5)
    np.testing.assert_allclose(bounds, -bounds[::-1], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "degrees"),
    [("visibility/visible_normals", 60), ("material/reflected_directions", 60), ("material/shadowing", 60)],
)
def test_chapters_look_at_one_surface_from_one_place(compute: Compute, name: str, degrees: float) -> None:
    data, first = compute(name), compute("geometry/microsurface")
    angle = np.radians(degrees)
    np.testing.assert_allclose(data["wo"], [np.sin(angle), np.cos(angle)])
    np.testing.assert_allclose(data["x"], first["x"])
    np.testing.assert_allclose(data["z"], first["z"])


def test_beams_leave_by_the_law_of_reflection(compute: Compute) -> None:
    """Light and viewer make the same angle with the normal, on either side of it."""
    data = compute("material/reflected_directions")
    wi, wo, normals = data["wi"], data["wo"], data["normals"]
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1)
    np.testing.assert_allclose((wi * normals).sum(axis=1), normals @ wo, atol=1e-12)
    np.testing.assert_allclose(wi @ [0, 1] * normals[:, 0] - wi[:, 0] * normals[:, 1],
                               -(wo[1] * normals[:, 0] - wo[0] * normals[:, 1]), atol=1e-12)  # fmt: skip


def test_rays_of_shadowing_stand_for_equal_parts_of_the_view(compute: Compute) -> None:
    data = compute("material/shadowing")
    wo, across = data["wo"], np.array([data["wo"][1], -data["wo"][0]])
    screen = np.sort(data["origin"] @ across)
    count = len(screen)
    assert count == 40
    seen = np.remainder(screen - screen[0] + 0.5 * wo[1] / count, wo[1])  # a period fills cos theta of the screen
    np.testing.assert_allclose(np.sort(seen), (np.arange(count) + 0.5) * wo[1] / count, atol=1e-9)
    for origin, wi, length in zip(data["origin"], data["wi"], data["length"], strict=True):
        assert height(data, origin[0]) == pytest.approx(origin[1], abs=1e-12)
        assert np.isinf(walk(data, origin, wo))  # all are seen
        assert same_way(length, walk(data, origin, wi)) or length < 20 * STEP
        assert np.hypot(*wi) == pytest.approx(1)


def test_free_and_blocked_pieces_are_so_in_their_middle(compute: Compute) -> None:
    data = compute("material/shadowing")
    for name, free in (("free", True), ("blocked", False)):
        pieces = data[name][np.hypot(*np.moveaxis(data[name][:, 1] - data[name][:, 0], -1, 0)) > 1e-3]
        assert len(pieces) >= 1
        for piece in pieces:
            middle, along = piece.mean(axis=0), piece[1] - piece[0]
            normal = np.array([-along[1], along[0]]) / np.hypot(*along)
            wi = 2 * (data["wo"] @ normal) * normal - data["wo"]
            assert np.isinf(walk(data, middle, data["wo"]))
            assert np.isinf(walk(data, middle, wi)) == free
    widths = [(np.diff(data[name], axis=1)[:, 0] @ [data["wo"][1], -data["wo"][0]]).sum() for name in ("free", "blocked")]
    np.testing.assert_allclose(np.array(widths) / data["wo"][1], data["shares"], atol=1e-12)
    np.testing.assert_allclose(data["percent"], 100 * data["shares"], atol=1)


def test_masking_is_seen_of_three_surfaces(compute: Compute) -> None:
    data = compute("visibility/masking")
    assert data["degrees"] == pytest.approx(60)
    assert data["cosine"] == pytest.approx(np.cos(np.radians(60)))
    np.testing.assert_array_equal(data["flat_z"], 0)
    times = (len(data["fine_x"]) - 1) // (len(data["zoom_x"]) - 1)
    assert times == 12
    np.testing.assert_allclose(data["fine_z"][: len(data["zoom_z"])], data["zoom_z"] / times)
    np.testing.assert_allclose(data["fine_x"][: len(data["zoom_x"])], data["zoom_x"] / times)
    zoom = {"x": data["zoom_x"], "z": data["zoom_z"]}
    for (start, stop), share in zip(data["zoom_ends"], data["zoom_G1"], strict=True):
        if share > 1e-2:
            assert np.isinf(walk(zoom, (start + stop) / 2, data["wo"]))


def test_stretched_rays_meet_what_the_first_ones_meet(compute: Compute) -> None:
    """Each of 16 rays starts over the middle of its part, and ends on the surface or a little above it."""
    data = compute("anisotropy/stretched_view")
    np.testing.assert_allclose(data["degrees"], np.degrees(np.arctan(data["stretch"] * np.tan(np.radians(55)))))
    assert data["kept"].all()
    assert data["same"].all()
    for k, stretch in enumerate(data["stretch"]):
        surface = {"x": data["x"][k] / stretch, "z": data["z"][k] / stretch}
        start, stop = data["start"][k] / stretch, data["stop"][k] / stretch
        np.testing.assert_allclose(start[:, 0], (np.arange(16) + 0.5) / 16)
        np.testing.assert_allclose(start[:, 1], height(surface, start[:, 0]), atol=1e-12)
        ways = stop - start
        np.testing.assert_allclose(np.degrees(np.arctan2(*ways.T)), data["degrees"][k])
        free = data["free"][k]
        np.testing.assert_allclose(stretch * ways[free, 1], 0.15)  # all as high
        np.testing.assert_allclose(height(surface, stop[~free, 0]), stop[~free, 1], atol=1e-9)
        for origin, way, leaves in zip(start, ways, free, strict=True):
            assert np.isinf(walk(surface, origin, way / np.hypot(*way))) == leaves
        np.testing.assert_allclose(data["share"][k].sum(), 1)
        np.testing.assert_allclose(data["middle"][k][:, 0], (data["x"][k][1:] + data["x"][k][:-1]) / 2)
        assert data["percent"][k].sum() == 100
    np.testing.assert_allclose(data["z"], data["z"][:1] * np.ones((3, 1)))  # stretching moves nothing up or down
    np.testing.assert_allclose(data["x"], data["stretch"][:, None] * data["x"][0])


def test_every_piece_lies_on_its_facet(compute: Compute) -> None:
    for name, keys in {
        "geometry/projection": ["ends"],
        "material/reflected_directions": ["ends"],
        "visibility/visible_normals": ["all_ends", "seen_ends"],
    }.items():
        data = compute(name)
        for key in keys:
            for end in (0, 1):
                x, z = data[key][:, end].T
                np.testing.assert_allclose(np.interp(x, data["x"], data["z"]), z, atol=1e-12)


def test_projected_lengths_are_whole_widths(compute: Compute) -> None:
    data = compute("geometry/projection")
    np.testing.assert_allclose(data["area"], np.hypot(np.diff(data["x"]), np.diff(data["z"])).sum())
    np.testing.assert_allclose(data["projected"], np.hypot(*np.diff(data["ends"], axis=1)[:, 0].T) * data["normals"][:, 1])


def test_shares_of_normals_before_and_after(compute: Compute) -> None:
    """Before: of the length; after: of the view, which is what the pieces fill of the screen."""
    data = compute("visibility/visible_normals")
    lengths = np.hypot(np.diff(data["x"]), np.diff(data["z"]))
    np.testing.assert_allclose(data["all_percent"], 100 * lengths / lengths.sum(), atol=1)
    width = np.diff(data["seen_ends"], axis=1)[:, 0] @ [data["wo"][1], -data["wo"][0]]
    np.testing.assert_allclose(data["seen_percent"], 100 * width / data["wo"][1], atol=1)
    for name in ("all", "seen"):
        by_bin = [data[f"{name}_percent"][data["bins"] == k].sum() for k in range(5)]
        np.testing.assert_array_equal(data[f"{name}_bin_percent"], by_bin)


@pytest.mark.slow
def test_the_final_lobe_is_over_all_angles(compute: Compute) -> None:
    """36 bins from horizon to horizon; most light goes on, away from the viewer at 50 degrees."""
    data = compute("overview/pipeline")
    np.testing.assert_allclose(np.degrees(data["theta"]), np.arange(-87.5, 90, 5), atol=1e-9)
    np.testing.assert_allclose(data["wo"], [np.sin(np.radians(50)), np.cos(np.radians(50))])
    assert -50 < np.degrees((data["theta"] * data["lobe"]).sum() / data["lobe"].sum()) < -20
    assert data["lobe"][-9:].max() < 1e-3
