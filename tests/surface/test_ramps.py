"""Measurements on a surface whose answers are known without tracing: ramps that all rise along y, each ending in a cliff.

What is seen of it from one side is one facet's slope, over and over: its mirror sends all light into one bin, and the shadows
of the cliffs have lengths that a ruler gives. Every sign, axis and unit of a measurement is one here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from microfacet.directions import spherical
from microfacet.surface import measure
from microfacet.surface.compare import in_plane
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField
from microfacet.surface.measure import Measurement, Plan
from report.campaign import CAMPAIGN

SIZE, RISE, SIDE = 64, 0.2, 256
ALPHA = np.array([0.5, 0.3])
FAMILY = GaussianField(64, 0.5, correlation=4)  # for its seeds only
TOP = RISE * (SIZE - 1)  # of the cliff, one cell wide
NORMAL = np.array([0.0, -RISE, 1.0]) / np.hypot(RISE, 1)


def ramps(axis: int = 1) -> HeightField:
    """They rise along y, or along x."""
    heights = np.broadcast_to(RISE * np.arange(SIZE), (SIZE, SIZE))
    return HeightField(heights if axis == 1 else heights.T)


def measured(wo: np.ndarray, axis: int = 1, **changes: Any) -> tuple[Plan, Measurement]:
    plan = Plan([wo], **{"side": SIDE, "slopes": 25, "reach": 3.0, "bins": (45, 72), **changes})  # type: ignore[arg-type]
    return plan, measure._view(ramps(axis), ALPHA, plan, np.asarray(wo), FAMILY, (0, 0))


def bin_of(value: float, edges: np.ndarray) -> int:
    return int(np.digitize(value, edges)) - 1


@pytest.mark.parametrize("azimuth", [-60.0, -90.0, -130.0])  # ramps lean to -90 degrees
@pytest.mark.parametrize("theta", [20.0, 50.0])
def test_all_light_leaves_into_the_mirror_of_the_ramp(theta: float, azimuth: float) -> None:
    wo = spherical(np.radians(theta), np.radians(azimuth))
    plan, found = measured(wo)
    wi = 2 * (wo @ NORMAL) * NORMAL - wo
    turn = np.remainder(np.arctan2(wi[1], wi[0]) - np.radians(azimuth) + np.pi, 2 * np.pi) - np.pi
    if abs(turn) > 3.1:
        assert found["lobe"][0, :, [0, -1]].sum() == pytest.approx(1)  # straight on: on the edge of the bins
        return
    at = bin_of(float(np.arccos(wi[2])), plan.lobe_edges[0]), bin_of(float(turn), plan.lobe_edges[1])
    assert found["lobe"][0][at] == pytest.approx(1)
    assert found["escaped"][0] == pytest.approx(1)
    assert found["lobe"][1].sum() == 0


@pytest.mark.parametrize(("axis", "azimuth"), [(1, -90.0), (1, -50.0), (0, 180.0), (0, 140.0)])
def test_what_is_seen_is_in_the_bin_of_the_ramps_slope(axis: int, azimuth: float) -> None:
    """In units of the roughness along the view; the normals' bins in units of that along each axis."""
    wo = spherical(np.radians(40.0), np.radians(azimuth))
    plan, found = measured(wo, axis)
    ahead = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))])
    along = RISE * ahead[axis] / np.hypot(*(ALPHA * ahead))
    seen = np.zeros(plan.slopes)
    seen[bin_of(float(along), plan.slope_edges)] = wo[2]
    np.testing.assert_allclose(found["seen"], seen, atol=4e-3)  # rays are one in each square
    normals = np.zeros((plan.slopes, plan.slopes))
    bins = [bin_of(slope / alpha, plan.slope_edges) for slope, alpha in zip(np.roll([RISE, 0.0], axis), ALPHA, strict=True)]
    normals[tuple(bins)] = 1
    np.testing.assert_allclose(found["normals"], normals, atol=1e-12)


def test_from_above_the_cliff_is_one_cell_in_64() -> None:
    """Its slope is beyond all bins: it is counted in the last one."""
    plan, found = measured(np.array([0.0, 0.0, 1.0]))
    expected = np.zeros((plan.slopes, plan.slopes))
    middle = bin_of(0.0, plan.slope_edges)
    expected[middle, bin_of(RISE / ALPHA[1], plan.slope_edges)] = 1 - 1 / SIZE
    expected[middle, 0] = 1 / SIZE
    np.testing.assert_allclose(found["normals"], expected, atol=1e-12)
    np.testing.assert_allclose(found["faced"].sum(), 1)
    np.testing.assert_allclose(found["seen"], found["faced"])


@pytest.mark.parametrize("theta", [40.0, 60.0, 75.0])
def test_shadows_of_the_cliffs_have_their_length(theta: float) -> None:
    """Seen from above, lit from the side on which the cliff is behind the ramp, from the other side, and along the cliff."""
    t = np.radians(theta)
    plan, found = measured(np.array([0.0, 0.0, 1.0]), lights=([t], [-np.pi / 2, np.pi / 2, 0.0]), bounces=0)
    cot = 1 / np.tan(t)
    edge = (TOP - cot) / (RISE + cot)  # where the ray over the top of the last cliff, at y = -1, comes down
    steep = -TOP * np.tan(t) < -1  # the cliff is turned away from this light
    np.testing.assert_allclose(found["facing"][0], [1 - 1 / SIZE, 1.0, 1.0], atol=1e-12)
    assert steep
    np.testing.assert_allclose(found["lit"][0], [(SIZE - 1 - edge) / SIZE, 1.0, 1.0], atol=2e-3)
    assert plan.side == SIDE


def test_azimuths_of_lights_are_relative_to_the_view() -> None:
    """The view leans along the cliff; a light a quarter turn from it lights the ramps, or is behind the cliff."""
    for azimuth, wanted in ((0.0, [np.pi / 2, -np.pi / 2]), (180.0, [-np.pi / 2, np.pi / 2])):
        wo = spherical(np.radians(10.0), np.radians(azimuth))
        _, found = measured(wo, lights=([np.radians(60.0)], wanted), bounces=0)
        assert found["lit"][0, 0] == pytest.approx(1, abs=1e-3)
        assert found["lit"][0, 1] < 0.8


@pytest.mark.parametrize("axis", [0, 1])
def test_rays_look_at_every_square_of_the_period(axis: int) -> None:
    plan = Plan([[0, 0, 1]], side=8)
    places = measure._places(ramps(), plan, np.random.default_rng(1))
    assert sorted(map(tuple, (places // (SIZE / 8)).astype(int))) == [(i, j) for i in range(8) for j in range(8)]
    assert 0.2 < np.std(places[:, axis] % (SIZE / 8)) / (SIZE / 8) < 0.4  # anywhere in its square


def test_rays_and_points_of_a_view_are_drawn_apart() -> None:
    states = {tuple(FAMILY.seed(k, purpose, view).generate_state(2)) for k in (0, 1) for purpose in (1, 2) for view in (0, 1)}
    assert len(states) == 8
    assert measure.RAYS != measure.POINTS


def test_a_plane_of_incidence_has_the_viewer_on_its_left() -> None:
    """Light that goes on, away from the viewer, is at azimuths around pi: on the right."""
    plan = Plan([[0, 0, 1]], bins=(9, 12))
    lobe = np.zeros((9, 12))
    lobe[4, 0], lobe[2, 6] = 3.0, 5.0  # away; towards
    angles = plan.solid_angle
    found = in_plane(lobe, angles)
    expected = np.zeros(18)
    expected[9 + 4], expected[8 - 2] = 1.5 / angles[4, 0], 2.5 / angles[2, 6]
    np.testing.assert_allclose(found, expected)


# --- the campaign -------------------------------------------------------------------------------------------------------------


def test_surfaces_of_different_families_are_different_ones() -> None:
    """The same root only where the same surfaces are looked at in another way."""
    roots = {name: entry.family.root for name, entry in CAMPAIGN.items()}
    assert all(roots[f"lobes_{name}"] == roots[f"azimuths_{name}"] for name in ("04", "07", "10"))
    apart = [roots[name] for name in CAMPAIGN if not name.startswith("azimuths")]
    assert len(set(apart)) == len(apart)


def test_names_of_the_campaign_say_what_is_measured() -> None:
    for name, entry in CAMPAIGN.items():
        kind, _, alpha = name.partition("_")
        assert not alpha or entry.family.alpha_x == int(alpha) / 10
        assert (entry.family.alpha_x == entry.family.alpha_y) == (kind != "stretched")
        assert entry.plan.method == ("gabor" if kind == "gabor" else "spectral")
        assert (entry.plan.bounces == 0) == (kind == "azimuths") == (len(entry.plan.lights[0]) > 0)


@pytest.mark.parametrize(("name", "count"), [("lobes_04", 6), ("lobes_10", 6), ("gabor_07", 3)])
def test_no_view_of_an_even_surface_looks_along_the_grid(name: str, count: int) -> None:
    """Nor do two views share a vertical plane: azimuths are multiples of the golden angle, in degrees."""
    views = np.asarray(CAMPAIGN[name].plan.views)[1:]  # the first is from above
    turns = np.degrees(np.arctan2(views[:, 1], views[:, 0]))
    golden = 180 * (3 - np.sqrt(5))
    np.testing.assert_allclose(np.remainder(turns - golden * np.arange(2, count + 1) + 180, 360), 180, atol=1e-9)
    assert min(abs(np.remainder(turns + 22.5, 45) - 22.5)) > 1


def test_stretched_surfaces_are_seen_along_both_axes_and_between() -> None:
    views = np.asarray(CAMPAIGN["stretched"].plan.views)
    theta, phi = np.degrees(np.arccos(views[:, 2])), np.degrees(np.arctan2(views[:, 1], views[:, 0]))
    assert sorted(zip(theta.round(9).tolist(), phi.round(9).tolist(), strict=True)) == [
        (t, p) for t in (40.0, 60.0, 80.0) for p in (0.0, 45.0, 90.0)
    ]


def test_angles_of_the_campaign_are_in_degrees() -> None:
    lights = CAMPAIGN["azimuths_07"].plan.lights
    assert np.degrees(lights[0]).round(6).tolist() == [60.0, 75.0]
    assert np.degrees(lights[1])[[0, -1]].round(6).tolist() == [0.0, 180.0]
    for name, degrees in {"azimuths_07": [60], "lobes_07": [0, 20, 40, 60, 70, 80], "gabor_07": [0, 60, 80]}.items():
        theta = np.arccos(np.asarray(CAMPAIGN[name].plan.views)[:, 2])
        np.testing.assert_allclose(np.degrees(theta), degrees, atol=1e-5)
