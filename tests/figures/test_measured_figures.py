"""The figures of measured surfaces: what they draw is what was measured, and models are drawn as the library has them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.directions import spherical
from report.campaign import THETA_O, read

Compute = Callable[[str], dict[str, Any]]


@pytest.mark.slow
def test_lobes_hold_the_light(compute: Compute) -> None:
    data = compute("validation/measured_lobes")
    angles = np.outer(-np.diff(np.cos(data["theta"])), np.diff(data["phi"]))
    np.testing.assert_allclose((data["lobe"] * angles).sum(axis=(-2, -1)), data["albedo"], rtol=2e-3)
    assert (data["distance"][:, 1] < data["distance"][:, 0]).sum() >= 2
    assert (data["noise"] > 0.01).all()


def test_lobes_in_the_plane_are_the_models(compute: Compute) -> None:
    data = compute("validation/measured_plane")
    wi = spherical(np.radians(data["theta"]))
    wo = spherical(np.radians(60))
    rho = mf.Microfacet(mf.Smith(mf.Beckmann(0.4))).evaluate(wo * [-1, 1, 1], wi) * wi[:, 2]
    drawn = data["smith"][list(data["degrees"]).index(60), 0]
    assert data["theta"][drawn.argmax()] > 45
    np.testing.assert_allclose(drawn, rho, atol=0.05 * rho.max())


def test_masking_of_the_models_conserves_the_seen_area(compute: Compute) -> None:
    """Weighted with the facets turned to the viewer, both G1 have the same mean; so has the measured one."""
    data = compute("validation/measured_masking")
    for row, degrees in enumerate(data["degrees"]):
        for column, alpha in enumerate(data["alpha"]):
            q = data["fine"][row, column]
            faced = np.maximum(1 - alpha * q * np.tan(np.radians(degrees)), 0) * np.exp(-(q**2))
            smith, cavity = ((faced * data[name][row, column]).sum() / faced.sum() for name in ("smith", "v_cavity"))
            assert cavity == pytest.approx(smith, rel=0.01)
            value, error = data["mean"][row, column]
            assert abs(value - smith) < 5 * error + 0.01


def test_the_seen_area_is_the_cosine(compute: Compute) -> None:
    value = compute("validation/measured_masking")["area"][:, 0]
    assert abs(value[:, 0]).max() < 1e-6  # from above: nothing is hidden
    assert abs(value).max() < 0.05


def test_visible_normals_fill_the_view(compute: Compute) -> None:
    data = compute("validation/measured_normals")
    for name in ("v_cavity", "smith", "all"):
        np.testing.assert_allclose(np.trapezoid(data[name], data["fine"], axis=-1), 1, atol=0.01)
    np.testing.assert_allclose((data["seen"] * np.diff(data["edges"])).sum(axis=-1), 1, rtol=1e-4)


@pytest.mark.slow
def test_forms_of_shadowing_end_where_they_must(compute: Compute) -> None:
    data = compute("validation/measured_shadowing")
    np.testing.assert_array_equal(data["lit"][:, 0, 0], 1)
    forms = list(data["forms"])
    for form in ("direction", "height-direction"):
        assert data["smith"][0, 0, forms.index(form), 0] == pytest.approx(1)
    assert (data["smith"][:, :, forms.index("height")] >= data["smith"][:, :, forms.index("none")]).all()
    np.testing.assert_allclose(data["v_cavity"][:, 0, 0], 1)


@pytest.mark.slow
def test_distances_and_albedos_are_of_one_measurement(compute: Compute) -> None:
    data, lobes = compute("validation/measured_distances"), compute("validation/measured_lobes")
    view = THETA_O.index(float(lobes["degrees"]))
    names = list(data["names"][0])
    for row, name in enumerate(("V-cavities", "Smith, height")):
        np.testing.assert_allclose(data["distance"][:, view, names.index(name), 0], lobes["distance"][:, row])
        np.testing.assert_allclose(data["model_albedo"][:, view, names.index(name)], lobes["albedo"][:, row])
    assert (data["distance"][..., 0] <= 1).all()
    np.testing.assert_allclose(data["stretched_area"][:, 0], 1, atol=0.02)


@pytest.mark.slow
def test_bounces_add_up(compute: Compute) -> None:
    data = compute("validation/bounces")
    np.testing.assert_allclose(data["share"][1], read("lobes_07")["escaped"].mean(axis=0), atol=1e-4)
    assert (data["share"].sum(axis=-1) > 0.99).all()
    assert (data["share"].sum(axis=-1) < 1 + 1e-4).all()


@pytest.mark.slow
def test_walks_end_as_the_model_has_it_and_not_as_on_surfaces(compute: Compute) -> None:
    """After one bounce by quadrature; in all, everything; and near the surfaces, but not within their errors."""
    data = compute("validation/bounces")
    np.testing.assert_allclose(data["by_order"][..., :3], data["share"][..., :3], atol=2e-5)
    np.testing.assert_allclose(data["walk"].sum(axis=-1), 1, atol=1e-4)
    first = [mf.Microfacet(mf.Smith(mf.Beckmann(alpha))).albedo(spherical(np.radians(THETA_O))) for alpha in data["alpha"]]
    error = np.maximum(data["walk_error"][..., 0], 1e-4)
    assert (abs(data["walk"][..., 0] - np.array(first)) < 4.5 * error).all()
    assert abs(data["walk"] - data["by_order"]).max() < 0.1


@pytest.mark.slow
def test_light_in_the_wrong_place(compute: Compute) -> None:
    """At least half of what is missing; and what is made up for by construction is not missing."""
    data, shares = compute("validation/compensation"), compute("validation/bounces")
    missing = shares["share"].sum(axis=-1) - np.array([np.interp(THETA_O, shares["fine"], line) for line in shares["smith"]])
    assert (data["distance"][:, :, 0, 0] > 0.499 * missing - 0.01).all()
    assert (data["distance"][..., 0] > 0.4 * data["noise"][:, :, None]).all()
    mirrors = data["metal"][:, list(data["F0"]).index(1.0)]
    np.testing.assert_allclose(mirrors[:, 1:3], 1, atol=1e-5)
    assert (abs(mirrors[:, 3] - 1) < 4.5 * mirrors[:, 4]).all()
    assert ((data["forward"][:, 1:] > 0.45) & (data["forward"][:, 1:] <= 1)).all()


def test_rays_of_the_drawing_end_above_the_surface(compute: Compute) -> None:
    data = compute("validation/gaussian_surface")
    for path in data["paths"]:
        corners = path[~np.isnan(path[:, 0])]
        assert len(corners) >= 3
        assert corners[-1, 2] > corners[-2, 2]
        first = (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
        np.testing.assert_allclose(-first, spherical(np.radians(60), np.pi), atol=1e-4)


def facet_below(heights: np.ndarray, x: float, y: float) -> tuple[float, np.ndarray]:
    """Height and unit normal of the surface there: each cell is cut along the diagonal from its first node to its last."""
    i, j = int(x), int(y)
    corner, last = heights[i, j], heights[i + 1, j + 1]
    between = heights[i + 1, j] if x - i >= y - j else heights[i, j + 1]
    along, across = (between - corner, last - between) if x - i >= y - j else (last - between, between - corner)
    normal = np.array([-along, -across, 1.0])
    return corner + along * (x - i) + across * (y - j), normal / np.linalg.norm(normal)


def test_rays_of_the_drawing_are_mirrored_where_they_meet_the_surface(compute: Compute) -> None:
    data = compute("validation/gaussian_surface")
    heights, lengths, bounces = data["heights"], [], []
    assert heights.shape == (97, 97)
    for path in data["paths"]:
        corners = path[~np.isnan(path[:, 0])]
        ways = np.diff(corners, axis=0)
        lengths += [np.linalg.norm(ways[0]), np.linalg.norm(ways[-1])]
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        bounces.append(len(corners) - 2)
        for corner, before, after in zip(corners[1:-1], ways, ways[1:], strict=False):
            height, normal = facet_below(heights, *corner[:2])
            assert corner[2] == pytest.approx(height, abs=2e-3)
            np.testing.assert_allclose(after, before - 2 * (before @ normal) * normal, atol=5e-3)
            for share in (0.02, 0.3, 0.7):
                on = corner + share * 20 * after
                inside = (on[:2] > 0).all() and (on[:2] < 96).all() and len(corners) == 3
                assert not inside or on[2] > facet_below(heights, *on[:2])[0]
    np.testing.assert_allclose(lengths, lengths[0], rtol=1e-3)  # what is drawn before the first mirror and behind the last
    assert max(bounces) > 1


def test_lobes_beside_the_drawing_are_of_the_same_light(compute: Compute) -> None:
    """Half a lobe each, over azimuths from the view's plane on: what is measured adds up to what is left after one mirror."""
    data = compute("validation/gaussian_surface")
    angles = np.outer(-np.diff(np.cos(data["theta"])), np.diff(data["phi"]))
    np.testing.assert_allclose(data["theta"], np.radians(np.arange(0, 91, 6)), rtol=1e-4)
    np.testing.assert_allclose(np.diff(data["phi"]), np.radians(15), rtol=1e-4)
    measured = (data["measured"] * angles).sum()
    smith = mf.Microfacet(mf.Smith(mf.Beckmann(0.7))).albedo(spherical(np.radians(60)))
    assert (data["smith"] * angles).sum() == pytest.approx(smith, abs=2e-3)
    assert measured == pytest.approx(read("lobes_07")["escaped"][:, THETA_O.index(60), 0].mean(), rel=1e-3)
    assert data["alpha"] == 0.7
    assert data["surfaces"] == 4
    assert data["rays"] == pytest.approx(4 * 192**2, rel=1e-4)
