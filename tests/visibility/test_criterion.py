"""Which masking functions belong to a surface: the conditions by numbers, on slopes that are known."""

from __future__ import annotations

from typing import Any

import microfacet as mf
import mpmath
import numpy as np
import pytest
from microfacet.directions import spherical

SLOPES = {
    "ggx": (lambda q: 1 / (2 * (1 + q**2) ** 1.5), lambda r: 1 / (mpmath.pi * (1 + r**2) ** 2)),
    "beckmann": (lambda q: mpmath.exp(-(q**2)) / mpmath.sqrt(mpmath.pi), lambda r: mpmath.exp(-(r**2)) / mpmath.pi),
}


def xLambda(density: Any, x: Any) -> Any:
    """f of a distribution of slopes, by quadrature."""
    return mpmath.quad(lambda q: (q - x) * density(q), [x, x + 1, x + 4, mpmath.inf])


@pytest.mark.parametrize("name", SLOPES)
def test_f_of_a_distribution_is_convex_and_its_second_derivative_is_the_density(name: str) -> None:
    density, _ = SLOPES[name]
    for x in (0.1, 0.7, 2.0):
        second = mpmath.diff(lambda x: xLambda(density, x), x, 2, h=1e-3)
        assert float(second) == pytest.approx(float(density(x)), rel=1e-5)
    assert float((xLambda(density, 1e-6) - xLambda(density, 0)) / 1e-6) == pytest.approx(-0.5, abs=1e-6)
    assert float(xLambda(density, 50)) < 0.01


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
def test_it_is_the_cotangent_times_lambda(kind: Any) -> None:
    density, _ = SLOPES["ggx" if kind is mf.GGX else "beckmann"]
    for theta in (0.3, 0.8, 1.4):
        f = kind(1.0).Lambda(spherical(theta)) / np.tan(theta)
        assert f == pytest.approx(float(xLambda(density, 1 / np.tan(theta))), rel=1e-10)


@pytest.mark.parametrize("name", SLOPES)
def test_abels_inverse_gives_back_the_density_in_the_plane(name: str) -> None:
    density, plane = SLOPES[name]
    for r in (0.2, 1.0, 1.7):
        back = -mpmath.quad(lambda w, r=r: mpmath.diff(density, mpmath.hypot(r, w)) / mpmath.hypot(r, w), [0, 1, 4, mpmath.inf])
        assert float(back / mpmath.pi) == pytest.approx(float(plane(r)), rel=1e-8)


@pytest.mark.parametrize("k", [0.05, 0.3, 0.5])
def test_schlicks_function_shows_the_whole_of_its_surface(k: float) -> None:
    """Of a share 2k with the slopes of GGX and a level rest: the visible area is the cosine, for every view."""
    ndf, theta = mf.GGX(1.0), np.radians([5.0, 40.0, 75.0, 89.0])
    wo = spherical(theta)
    G1 = mf.SchlickSmith(ndf, k).G1(wo, [0, 0, 1])
    tilted = np.cos(theta) / mf.Smith(ndf).G1(wo, [0, 0, 1])  # the area that facets turned to the viewer show, unmasked
    np.testing.assert_allclose(G1 * (2 * k * tilted + (1 - 2 * k) * np.cos(theta)), np.cos(theta), rtol=1e-13)


def test_beyond_one_half_more_than_all_facets_would_be_tilted() -> None:
    """Implicit masking is the case k = 1: the level share would be -1."""
    x = 1e-7
    cosine = x / np.sqrt(1 + x * x)
    for k, share in ((0.25, 0.5), (0.5, 0.0), (1.0, -1.0)):
        f = [x * (k * (1 - cosine) / cosine), k]  # at x and at 0
        assert 1 + 2 * (f[0] - f[1]) / x == pytest.approx(share, abs=1e-6)


def fast(alpha: Any, cosine: Any) -> Any:
    """G1 of game engines."""
    return 1 / (1 + alpha / 2 * (1 / cosine - 1))


def test_the_fast_masking_of_engines_shows_up_to_a_fifth_too_little() -> None:
    rng = np.random.default_rng(3)
    ratios = []
    for alpha in [*10 ** rng.uniform(-8, 0, 60), 1.0]:
        cosine = np.minimum(alpha * 10 ** rng.uniform(-3, 3, 200), 1.0)
        wo = spherical(np.arccos(cosine))
        ratios.append(fast(alpha, wo[:, 2]) / mf.Smith(mf.GGX(alpha)).G1(wo, [0, 0, 1]))
    ratio = np.concatenate(ratios)
    assert (ratio > 0.8 - 1e-9).all()
    assert (ratio < 1 + 1e-9).all()
    assert ratio.min() < 0.801
    np.testing.assert_allclose(ratios[-1], 1, rtol=1e-12)
    wo = spherical(np.arccos(0.75e-6))
    assert fast(1e-6, wo[2]) / mf.Smith(mf.GGX(1e-6)).G1(wo, [0, 0, 1]) == pytest.approx(0.8, rel=1e-5)


@pytest.mark.parametrize("perceptual", [0.1, 0.5, 0.9, 1.0])
def test_remapped_masking_shows_the_stated_part_next_to_the_horizon(perceptual: float) -> None:
    """Karis' k and Disney's alpha, by the models' own values."""
    stated = mf.equations["visibility.criterion.remapped"].equals.doit()
    exact = float(stated.subs(dict.fromkeys(stated.free_symbols, perceptual)))
    wo, up = spherical(np.pi / 2 - 1e-9), np.array([0.0, 0.0, 1.0])
    ggx = mf.Smith(mf.GGX(perceptual**2)).G1(wo, up)
    for model in (mf.SchlickSmith(mf.GGX(1.0), (perceptual + 1) ** 2 / 8), mf.Smith(mf.GGX((1 + perceptual) ** 2 / 4))):
        assert float(model.G1(wo, up) / ggx) == pytest.approx(exact, rel=1e-6)
