"""The spheres' scene in its parts: the sky and lights, the pixels, the light that is gathered, the curve that shows it."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import microfacet as mf
import numpy as np
import pytest

FIGURES = Path(__file__).parents[2] / "figures"


@pytest.fixture(scope="module")
def scene() -> dict[str, Any]:
    return runpy.run_path(str(FIGURES / "overview/spheres_data.py"))


def even_directions(count: int) -> np.ndarray:
    """Evenly over the sphere: equal steps of height and golden turns."""
    z, phi = 1 - (np.arange(count) + 0.5) * 2 / count, np.pi * (3 - np.sqrt(5)) * np.arange(count)
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(phi), z, sine * np.sin(phi)], axis=-1)


def test_the_ground_is_below_and_the_sky_above(scene: dict[str, Any]) -> None:
    """Half of each on the horizon; the sky is brighter towards the zenith, from 0.7 to 1.2 of its colour."""
    down = scene["environment"](np.array([0.0, -1.0, 0.0]))
    np.testing.assert_allclose(down, scene["GROUND"], atol=1e-4)
    dark = np.array([-0.1, 0.0, -1.0]) / np.hypot(0.1, 1)  # away from all lights
    np.testing.assert_allclose(scene["environment"](dark), (0.7 * scene["SKY"] + scene["GROUND"]) / 2, atol=1e-4)
    for y in (0.3, 0.5):
        w = np.array([0.0, y, -np.sqrt(1 - y * y)])
        np.testing.assert_allclose(scene["environment"](w), scene["SKY"] * (0.7 + 0.5 * y), rtol=2e-3)


def test_a_light_is_as_bright_as_told_and_as_wide(scene: dict[str, Any]) -> None:
    """It has its radiance in the middle, and 1/e of it where the cosine is 1/narrow less than 1."""
    for towards, narrow, radiance in scene["LIGHTS"]:
        axis = np.array(towards) / np.linalg.norm(towards)
        side = np.cross(axis, [0.0, 0.0, 1.0])
        side /= np.linalg.norm(side)
        cosine = 1 - 1 / narrow
        off = cosine * axis + np.sqrt(1 - cosine**2) * side
        others = [w for w in scene["LIGHTS"] if w[0] != towards]
        for w, share in ((axis, 1.0), (off, np.exp(-1))):
            below = 1 / (1 + np.exp(-25 * w[1]))
            rest = below * scene["SKY"] * (0.7 + 0.5 * w[1]) + (1 - below) * scene["GROUND"]
            for d, n, r in others:
                rest = rest + np.exp(n * (w @ np.array(d) / np.linalg.norm(d) - 1)) * np.array(r)
            np.testing.assert_allclose(scene["environment"](w) - rest, share * np.array(radiance), rtol=1e-9)


def test_the_metal_is_that_of_the_other_figures(scene: dict[str, Any]) -> None:
    for name in ("enough/enough_map", "enough/enough_example"):
        text = (FIGURES / f"{name}_data.py").read_text("utf-8")
        assert "METAL = mf.Conductor(0.2, 3.9)" in text
    np.testing.assert_allclose(scene["METAL"].F(1.0), mf.Conductor(0.2, 3.9).F(1.0))


def test_light_directions_sum_to_one_over_the_sphere(scene: dict[str, Any]) -> None:
    density = scene["light_density"](even_directions(400_000))
    assert density.mean() * 4 * np.pi == pytest.approx(1, rel=1e-4)


def test_light_directions_follow_their_density(scene: dict[str, Any]) -> None:
    """The mean cosine to each light's axis, which a third of the directions are drawn around; and all around it alike."""
    u = (np.stack(np.meshgrid(np.arange(300), np.arange(60), indexing="ij"), axis=-1).reshape(-1, 2) + 0.5) / [300, 60]
    w = scene["light_directions"](u)
    np.testing.assert_allclose(np.linalg.norm(w, axis=-1), 1)
    thirds = np.split(w, 3)
    for part, (towards, narrow, _) in zip(thirds, scene["LIGHTS"], strict=True):
        axis = np.array(towards) / np.linalg.norm(towards)
        mean = part.mean(axis=0)
        langevin = 1 / np.tanh(narrow) - 1 / narrow  # von Mises and Fisher's
        assert np.linalg.norm(mean) == pytest.approx(langevin, rel=2e-3)
        np.testing.assert_allclose(mean / np.linalg.norm(mean), axis, atol=1e-6)


def test_pixels_cover_a_disc(scene: dict[str, Any]) -> None:
    normal, cover = scene["disc"]()
    size = scene["SIZE"]
    assert cover.sum() * (2.02 / size) ** 2 == pytest.approx(np.pi, rel=1e-3)
    assert ((cover >= 0) & (cover <= 1)).all()
    np.testing.assert_allclose(cover, cover.T)
    np.testing.assert_allclose(cover, cover[::-1])
    assert cover[0].max() < 1 < 1.02 * cover.max()
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1)
    assert len(normal) == (cover > 0).sum()
    assert normal[0, 1] > 0.9  # rows run from the top
    row = normal[len(normal) // 2 - 40 : len(normal) // 2 + 40, 0]
    steps = np.diff(row)
    np.testing.assert_allclose(steps[(steps > 0) & (abs(row[1:]) < 0.95)], 2.02 / size, rtol=1e-6)
    assert np.hypot(*normal[:, :2].T).max() <= 0.999 * (1 + 1e-12)
    np.testing.assert_allclose(normal.mean(axis=0)[:2], 0, atol=1e-12)


def test_axes_run_along_latitude_and_meridian(scene: dict[str, Any]) -> None:
    axes = scene["frames"](np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8]]))
    np.testing.assert_allclose(axes[:, :, 1], [[0, 1, 0]] * 3, atol=1e-12)  # only the second axis is upright on the equator
    np.testing.assert_allclose(axes[0], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(axes[1, 0], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(axes @ np.swapaxes(axes, 1, 2), [np.eye(3)] * 3, atol=1e-12)


def test_steps_of_the_samples_fill_the_square(scene: dict[str, Any]) -> None:
    """By the plastic number g, where g^3 = g + 1."""
    g = 1 / scene["STEP"][0]
    assert g**3 == pytest.approx(g + 1)
    assert scene["STEP"][1] == pytest.approx(1 / g**2)


@pytest.mark.parametrize("ndf", [mf.GGX(0.5), mf.Beckmann(0.4, 0.2)], ids=repr)
def test_what_is_gathered_is_the_light_of_the_sky(scene: dict[str, Any], ndf: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Under a sky whose three colours grow along the three axes, by another sum over directions."""

    def sky(w: np.ndarray) -> np.ndarray:
        return 1 + w

    shade = scene["shade"].__globals__
    monkeypatch.setitem(shade, "environment", sky)
    normal = np.array([[0.3, 0.4, np.sqrt(0.75)]])
    axes = np.repeat(scene["frames"](normal), 150, axis=0)
    brdf, guide = mf.Microfacet(mf.Smith(ndf)), mf.Microfacet(mf.Smith(mf.GGX(*ndf.slope_scale)))
    found = scene["shade"](brdf, guide, axes, np.random.default_rng(2).random((150, 2)), 64)
    wi = even_directions(200_000)
    wi = wi[wi[:, 2] > 0]
    light = sky(np.einsum("ij,ni->nj", axes[0], wi)) * (brdf.evaluate(axes[0, :, 2], wi) * wi[:, 2])[:, None]
    exact = light.sum(axis=0) * 4 * np.pi / 200_000
    error = found.std(axis=1, ddof=1) / np.sqrt(150)
    assert (abs(found.mean(axis=1) - exact) < 5 * error + 1e-3).all()
    assert (error < 0.02).all()
    first, second = found
    assert abs(np.corrcoef(first[:, 0], second[:, 0])[0, 1]) < 0.6  # halves are other samples


def test_a_picture_shows_light_by_the_curve_of_srgb(scene: dict[str, Any]) -> None:
    """Undone by the standard's own inverse, IEC 61966-2-1."""
    size = scene["SIZE"]
    cover = np.zeros((size, size))
    cover[3, :50] = 1.0
    cover[4, :2] = [0.5, 0.25]
    light = np.geomspace(1e-4, 5, 52 * 3).reshape(52, 3)
    image = scene["picture"](light, cover)
    assert image.dtype == np.uint8
    assert image.shape == (size, size, 4)
    shown = image[cover > 0, :3] / 255
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(linear, 1 - np.exp(-scene["EXPOSURE"] * light), atol=0.006)
    np.testing.assert_array_equal(image[cover == 0], 0)
    np.testing.assert_array_equal(image[4, :3, 3], [128, 64, 0])
    assert image[3, 0, 3] == 255


def test_noise_is_the_difference_of_both_halves(scene: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Of independent halves of relative scatter s, their mean has s/sqrt(2): half the root mean square difference."""
    calls: list[tuple[float, float, int]] = []
    compute = scene["compute"].__globals__

    def shade(brdf: Any, guide: Any, axes: np.ndarray, shift: np.ndarray, samples: int) -> np.ndarray:
        assert isinstance(brdf, mf.Compensated)  # the model that chapter 9 finds to be enough
        calls.append((brdf.model.ndf.alpha_x, brdf.model.ndf.alpha_y, samples))
        assert guide.model.ndf.slope_scale == brdf.model.ndf.slope_scale
        assert isinstance(guide.model.ndf, mf.GGX)
        assert shift.shape == (len(axes), 2)
        scatter = np.random.default_rng(len(calls)).standard_normal((2, len(axes), 3))
        return 0.5 + 0.05 * scatter

    monkeypatch.setitem(compute, "shade", shade)
    data = compute["compute"]()
    np.testing.assert_allclose(data["noise"], 0.1 / np.sqrt(2), rtol=0.02)
    expected = [(*pair, samples) for pair, samples in zip(data["alphas"].tolist(), data["samples"].tolist(), strict=True)]
    assert calls == expected * 2
    assert data["images"].shape == (2, len(data["alphas"]), scene["SIZE"], scene["SIZE"], 4)
    assert tuple(data["samples"]) == scene["SAMPLES"]
