"""The furnace: brightness against closed forms and against samples; a sphere of brightness 1 cannot be seen."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import microfacet as mf
import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "figures/validation"


@pytest.fixture(scope="module")
def data() -> dict[str, Any]:
    found: dict[str, Any] = runpy.run_path(str(FOLDER / "furnace_data.py"))["compute"]()
    return found


@pytest.fixture(scope="module")
def script() -> dict[str, Any]:
    return runpy.run_path(str(FOLDER / "furnace.py"))


def of(data: dict[str, Any], name: str, row: int) -> np.ndarray:
    light: np.ndarray = data["light"][row, list(data["name"]).index(name)]
    return light


def test_masking_alone_meets_its_closed_forms(data: dict[str, Any]) -> None:
    """With one G1 for all facets that are turned to the viewer it is G1 (1 + Lambda); Kelemen's counts areas."""
    theta, alpha = data["theta"], float(data["alpha"])
    Lambda = (np.sqrt(1 + (alpha * np.tan(theta)) ** 2) - 1) / 2
    cosine, k = np.cos(theta), alpha * np.sqrt(2 / np.pi)
    for name in ("Smith", "V-cavities"):
        np.testing.assert_allclose(of(data, name, 0), 1, atol=1e-6)
    np.testing.assert_allclose(of(data, "Implicit", 0), cosine * (1 + Lambda), atol=2e-8)
    np.testing.assert_allclose(of(data, "Schlick-Smith", 0), cosine / (cosine * (1 - k) + k) * (1 + Lambda), atol=2e-8)
    root = np.sqrt(1 - alpha**2)
    assert of(data, "Kelemen", 0)[0] == pytest.approx(1 + alpha**2 * np.arctanh(root) / root, abs=2e-8)


def test_one_bounce_is_a_mean_over_visible_normals(data: dict[str, Any]) -> None:
    """Of Smith's normals, weighted by G2/G1; those whose light goes down count nothing."""
    random = np.random.default_rng(0)
    smith, ndf = mf.Smith(mf.GGX(float(data["alpha"]))), mf.GGX(float(data["alpha"]))
    for name, model in (
        ("Smith", smith),
        ("V-cavities", mf.VCavity(ndf)),
        ("Implicit", mf.Implicit(ndf)),
        ("Kelemen", mf.Kelemen(ndf)),
    ):
        for k in (0, 60, 80):
            wo = np.broadcast_to(mf.spherical(data["theta"][k]), (200_000, 3))
            wm = smith.sample_visible(wo, random.random((200_000, 2)))
            wi = mf.reflect(wo, wm)
            up = wi[:, 2] > 0
            weight = np.zeros(len(wo))
            weight[up] = model.G2(wo[up], wi[up], wm[up]) / smith.G1(wo[up], wm[up])
            assert abs(weight.mean() - of(data, name, 1)[k]) < 5 * weight.std() / np.sqrt(len(wo)) + 2e-6


def test_a_sphere_as_bright_as_its_surroundings_vanishes(script: dict[str, Any]) -> None:
    theta = np.linspace(0, np.pi / 2, 91)
    np.testing.assert_array_equal(script["sphere"](theta, np.ones(91)), 1)
    seen = script["sphere"](theta, np.cos(theta))
    middle = script["SIDE"] // 2
    assert seen[middle, middle] == 1
    assert seen[0, 0] == 1
    across = np.linspace(-1.25, 1.25, script["SIDE"])
    inside = abs(across) < 0.97
    np.testing.assert_allclose(seen[middle][inside], np.sqrt(1 - across[inside] ** 2), atol=2e-3)


def test_shades_are_in_order_and_the_surroundings_half_way(script: dict[str, Any]) -> None:
    assert script["shown"](np.array(1.0)) == 0.5
    assert (np.diff(script["shown"](np.linspace(0, 5, 50))) > 0).all()
    assert script["span"](np.array([0.25, 1.0])) == "0.25 to 1.00"
    assert script["span"](np.array([1.0, 1.0])) == "1.00"
