"""What the figures of models draw is what the library computes, and their numbers hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytestmark = pytest.mark.slow  # the data of all models' figures are computed here

Compute = Callable[[str], dict[str, Any]]


def test_projected_areas_are_the_closed_forms(compute: Compute) -> None:
    data = compute("geometry/distributions")
    assert list(data["verdict"]) == ["fails", "holds", "fails", "holds", "holds"]
    np.testing.assert_allclose(data["integral"][0], np.pi * data["alpha"] ** 2, rtol=1e-6)
    ward = dict(zip(np.round(data["alpha"], 7), data["integral"][2], strict=True))
    assert ward[0.1] == pytest.approx(0.980577, abs=1e-6)
    assert ward[0.5] == pytest.approx(0.698470, abs=1e-6)


def test_areas_grow_and_ggx_doubles(compute: Compute) -> None:
    data = compute("geometry/area")
    assert data["ggx_checked"][-1] == pytest.approx(2, abs=1e-9)
    for name in ("beckmann", "ggx"):
        np.testing.assert_allclose(
            np.interp(data["checked"][:-1], data["alpha"], data[name]), data[f"{name}_checked"][:-1], atol=1e-3
        )
        assert data[f"{name}_apart"] <= 1e-11
        middle = np.interp(data["shown"], data["checked"], data[f"{name}_checked"])
        assert np.trapezoid(data[f"{name}_density"], data["theta"]) == pytest.approx(middle, rel=1e-3)


def test_surfaces_have_the_area_of_beckmann(compute: Compute) -> None:
    data = compute("geometry/area")
    closed = np.interp(data["made"][:-1], data["alpha"], data["beckmann"])
    assert (abs(data["made_area"][:-1] - closed) < 4 * data["made_error"][:-1] + 1e-4).all()
    assert (2 * data["made_error"] < 0.03).all()  # half as high as a cross


def test_masking_functions_at_the_reference_angles(compute: Compute) -> None:
    data = compute("visibility/masking_functions")
    assert np.all(data["verdict"][:, :2] == "holds")
    assert np.all(data["verdict"][0, 2:] == "fails")
    assert data["verdict"][1, -1] == "holds"  # Schlick-Smith halved is Smith for GGX at alpha = 1
    at = np.searchsorted(data["theta"], [0, 30, 60, 80, 89])
    known = {
        2: (1, 0.8660, 0.5019, 0.2189, 0.1218),
        3: (1.0747, 1.0747, 1.0491, 0.7808, 0.5629),
        4: (1, 0.9530, 0.7609, 0.5004, 0.3678),
    }
    for row, values in known.items():
        np.testing.assert_allclose(data["share"][0, row, at], values, atol=6e-5)


def test_fresnel_keeps_its_landmarks(compute: Compute) -> None:
    data = compute("material/fresnel")
    assert data["outside"][0] == pytest.approx(0.04, abs=1e-6)
    assert data["inside"][0] == pytest.approx(0.04, abs=1e-6)
    assert np.all(data["inside"][data["theta"] > data["critical"]] == 1)
    for name in ("outside", "inside", "metal_0", "metal_1"):
        assert np.all((data[name] >= 0) & (data[name] <= 1))
        assert data[name][-1] == pytest.approx(1, abs=1e-9)
    assert np.abs(data["outside_schlick"] - data["outside"]).max() < 0.04


def test_wrong_lobes_pass_the_weak_tests(compute: Compute) -> None:
    data = compute("brdf/lobes")
    assert np.all(data["classic"] == "holds")
    assert list(data["physical"]) == ["holds"] * 3 + ["fails"] * 2
    assert np.all(data["lobe"] >= 0)
    assert np.all(data["albedo"] < 1)


def test_stretched_distributions_keep_the_first_equation(compute: Compute) -> None:
    data = compute("anisotropy/anisotropic_normals")
    assert np.all(data["beckmann_keeps"])
    assert np.all(data["ggx_keeps"])
    assert not np.any(data["ward_keeps"])
    np.testing.assert_allclose(data["ward_area"], data["ward_area"].T, atol=1e-8)


def test_stretching_halves_one_slope_only(compute: Compute) -> None:
    data = compute("anisotropy/stretching")
    np.testing.assert_allclose(data["before_slopes"], data["after_slopes"] * [[data["stretch"]], [1]], rtol=1e-4)
    np.testing.assert_allclose(data["before_measured"], data["before_alphas"], rtol=0.1)


def test_alpha_o_is_the_half_width_of_the_ellipse(compute: Compute) -> None:
    data = compute("anisotropy/alpha_o")
    turn = np.radians(np.linspace(0, 360, 20001))
    ellipse = data["alphas"][:, None] * np.array([np.cos(turn), np.sin(turn)])
    for phi, along in zip(np.radians(data["phi"]), data["alpha_o"], strict=True):
        assert np.max(np.cos(phi) * ellipse[0] + np.sin(phi) * ellipse[1]) == pytest.approx(along, rel=1e-6)
    assert max(data["ggx_apart"], data["beckmann_apart"]) <= 1e-11


def test_residual_map_tells_right_from_wrong(compute: Compute) -> None:
    data = compute("anisotropy/residual_map")
    assert data["holding"] == data["tried"]
    assert data["worst"] <= 1e-9
    assert data["smith"].max() == data["v_cavity"].max() == data["floor"]
    assert data["mean"].max() > 0.5
    _, phi = np.unravel_index(np.argmin(data["mean"][5:]), data["mean"][5:].shape)
    assert abs(data["phi"][phi] - 22.2) <= 6  # where alpha_o is the mean roughness
