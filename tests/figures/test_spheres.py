"""The pictures of spheres: their pixels, their light and the bytes that are made of it."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@pytest.fixture(scope="module")
def spheres() -> dict[str, Any]:
    return runpy.run_path(str(Path(__file__).parents[2] / "figures/overview/spheres_data.py"))


def test_pixels_cover_a_disc_and_have_the_normals_of_a_sphere(spheres: dict[str, Any]) -> None:
    """The picture is a little wider than the sphere; rows run downwards."""
    size = spheres["SIZE"]
    normal, cover = spheres["disc"]()
    pixel = 2.02 / size
    assert cover.shape == (size, size)
    assert cover.sum() * pixel**2 == pytest.approx(np.pi, rel=2e-4)
    assert {cover.min(), cover.max()} == {0, 1}
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-14)
    assert (normal[:, 2] > 0).all()
    row, column = np.nonzero(cover)
    x, y = (column + 0.5) * pixel - 1.01, 1.01 - (row + 0.5) * pixel
    radius = np.hypot(x, y)
    inner = radius < 0.999
    np.testing.assert_allclose(normal[inner, :2], np.stack([x, y], axis=-1)[inner], atol=1e-12)
    np.testing.assert_allclose(normal[~inner, :2] * radius[~inner, None], 0.999 * np.stack([x, y], axis=-1)[~inner], atol=1e-12)
    assert 0 < (~inner).sum() < 0.1 * len(normal)
    partly = (cover > 0) & (cover < 1)
    distance = (1 - np.hypot(*np.meshgrid(*2 * [(np.arange(size) + 0.5) * pixel - 1.01])))[partly] / pixel
    np.testing.assert_allclose(cover[partly], distance + 0.5, atol=1e-9)  # half of a pixel whose middle is on the rim


def test_a_light_is_brightest_in_its_middle_and_falls_with_the_cosine(
    spheres: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    environment = spheres["environment"]
    axis, across = np.array([0.48, 0.6, 0.64]), np.array([0.8, 0.0, -0.6])
    angle = np.linspace(0, 3, 7)
    w = np.cos(angle)[:, None] * axis + np.sin(angle)[:, None] * across
    monkeypatch.setitem(environment.__globals__, "LIGHTS", ())
    dark = environment(w)
    monkeypatch.setitem(environment.__globals__, "LIGHTS", ((tuple(3 * axis), 7.0, (1.0, 2.0, 5.0)),) * 2)
    np.testing.assert_allclose(environment(w) - dark, 2 * np.exp(7 * (np.cos(angle) - 1))[:, None] * [1, 2, 5], atol=1e-12)


def test_the_sky_is_above_the_ground(spheres: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Both meet at the horizon, half and half; the sky is brightest at the zenith."""
    environment = spheres["environment"]
    monkeypatch.setitem(environment.__globals__, "LIGHTS", ())
    sky, ground = spheres["SKY"], spheres["GROUND"]
    zenith, low, horizon, nadir = (environment(np.array([[np.sqrt(1 - y * y), y, 0]]))[0] for y in (1, 0.4, 0, -1))
    shares = zenith / sky
    np.testing.assert_allclose(shares, shares[0])
    np.testing.assert_allclose(nadir, ground, rtol=1e-9)
    assert (low < zenith).all()
    above = 2 * horizon - ground  # what the sky alone would have there
    np.testing.assert_allclose((low - above) / 0.4, zenith - above, rtol=1e-3)  # it falls evenly with the height


def test_bytes_are_light_exposed_and_in_the_curve_of_srgb(spheres: dict[str, Any]) -> None:
    """Decoded again by IEC 61966-2-1, they are what an exposure leaves, to a byte; outside there is nothing."""
    normal, cover = spheres["disc"]()
    light = np.geomspace(1e-4, 20, 3 * len(normal)).reshape(-1, 3)
    image = spheres["picture"](light, cover)
    np.testing.assert_array_equal(image[..., 3], np.round(255 * cover))
    assert (image[cover == 0] == 0).all()
    value = image[cover > 0][:, :3] / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    step = np.where(value <= 0.04045, 1 / 12.92, 2.4 / 1.055 * ((value + 0.055) / 1.055) ** 1.4) / 255
    assert (abs(linear - (1 - np.exp(-spheres["EXPOSURE"] * light))) < 0.51 * step + 1e-5).all()


def test_every_sample_of_a_half_counts_and_no_other(spheres: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The first half of the samples goes into the first sum, the other into the second; both are means."""

    class Even:
        def evaluate(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
            return np.full(len(wi), 1 / np.pi) / np.where(wi[:, 2] == 0, 1, wi[:, 2])

    class Guide:
        calls = 0

        def sample(self, wo: np.ndarray, u: np.ndarray) -> np.ndarray:
            self.calls += 1
            return np.broadcast_to([0.0, 0.6, 0.8], wo.shape)

        def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
            return np.full(len(wi), 2.0)

    counted = [0]

    def environment(w: np.ndarray) -> np.ndarray:
        counted[0] += 1
        return np.full((*w.shape[:-1], 3), float(counted[0]))

    names = spheres["shade"].__globals__
    monkeypatch.setitem(names, "environment", environment)
    monkeypatch.setitem(names, "light_density", lambda w: np.full(len(w), 4.0))
    guide, axes = Guide(), spheres["frames"](np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8]]))
    samples = 96
    halves = spheres["shade"](Even(), guide, axes, np.zeros((2, 2)), samples)
    assert guide.calls == samples // 2
    weight = 1 / np.pi / ((2 + 4) / 2)
    means = [weight * (1 + samples / 2) / 2, weight * (1 + samples / 2 + samples) / 2]
    np.testing.assert_allclose(halves, np.broadcast_to(np.reshape(means, (2, 1, 1)), halves.shape), rtol=1e-12)
