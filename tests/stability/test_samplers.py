"""Samplers that fail at their edges, and the library's, which does not."""

from __future__ import annotations

import faulty
import microfacet as mf
import numpy as np
import pytest
from microfacet.directions import spherical
from microfacet.validation import accuracy
from samples import LAST, LAST_SINGLE, UP, uniform

EDGES = {np.float64: (0.0, 1e-300, 1e-12, 0.5, LAST), np.float32: (0.0, 1e-38, 1e-7, 0.5, LAST_SINGLE)}
THETA = [0, 1e-12, 1e-8, 1e-5, 1e-3, 0.5, 1.5, 1.57, np.pi / 2 - 1e-7]


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@pytest.mark.parametrize("alpha", [(1e-8, 1e-8), (1e-8, 1e-4), (1e-4, 1.0), (0.3, 0.3), (10.0, 1e-3), (1e3, 1e3), (1e-1, 1e3)])
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_the_library_samples_at_every_edge(kind: type, alpha: tuple[float, float], real: type) -> None:
    """Roughness from 1e-8 to 1e3, ratios up to 1e4, the pole, the horizon, numbers at 0 and below 1."""
    model, edges = mf.Smith(kind(*alpha)), np.array([(a, b) for a in EDGES[real] for b in EDGES[real]], real)
    for wo in spherical(THETA, 0.6).astype(real):
        m = model.sample_visible(wo, edges)
        assert np.isfinite(m).all()
        np.testing.assert_allclose(np.linalg.norm(m.astype(float), axis=-1), 1, rtol=8 * np.finfo(real).eps)
        assert (m[:, 2] >= 0).all()


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_a_sine_taken_from_the_cosine_divides_by_zero(real: type) -> None:
    views = spherical([1e-9, 1e-10], 0.6).astype(real)
    u = np.full((2, 2), 0.3, real)
    with np.errstate(all="ignore"):
        assert np.isnan(faulty.beckmann_turned(mf.Beckmann(0.1), views, u)).all()
    assert np.isfinite(mf.Smith(mf.Beckmann(0.1)).sample_visible(views, u)).all()


@pytest.mark.parametrize(("method", "ndf"), [(faulty.beckmann_turned, mf.Beckmann(0.3)), (faulty.ggx_cap, mf.GGX(0.3))])
def test_away_from_the_edges_the_exhibits_are_the_samplers(method, ndf) -> None:
    u = 0.1 + 0.8 * uniform(200)
    wo = np.broadcast_to(spherical(1.0, 0.6), (200, 3))
    np.testing.assert_allclose(method(ndf, wo, u), mf.Smith(ndf).sample_visible(wo, u), atol=1e-9)


def test_a_cap_measured_from_the_equator_loses_the_lobe_next_to_the_mirror() -> None:
    """The azimuths of normals with u2 next to 0: those as published have lost the distance from the axis."""
    u = np.stack([np.full(50, 0.3), np.linspace(0.2, 3, 50) * 1e-7], axis=-1).astype(np.float32)
    wo = np.broadcast_to(UP.astype(np.float32), (50, 3))
    drawn = {"published": faulty.ggx_cap(mf.GGX(1.0), wo, u), "library": mf.Smith(mf.GGX(1.0)).sample_visible(wo, u)}
    sine = {name: np.hypot(*m[:, :2].T) for name, m in drawn.items()}
    exact = np.sqrt(u[:, 1].astype(float))
    assert np.abs(sine["published"] / exact - 1).max() > 0.1
    np.testing.assert_allclose(sine["library"], exact, rtol=1e-6)


def test_newtons_steps_have_a_floor() -> None:
    """Each step squares the error until rounding stops it; 0.1 % of the seen area after one."""
    u = (np.arange(500) + 0.5) / 500
    exact = faulty.beckmann_newton(1.0, u, 20)
    errors = [np.abs(faulty.beckmann_newton(1.0, u, k) - exact).max() for k in range(1, 6)]
    assert errors[0] > 1e-4
    assert errors[1] > 1e-9
    assert errors[4] < 1e-12


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_normals_give_their_numbers_back(kind: type, real: type) -> None:
    """From 1e-8 beside the pole to 1e-8 above the horizon: a wrong azimuth shows as well as a wrong height."""
    views, numbers = accuracy.directions(real, accuracy.TANGENT[::4]), np.array([(0.3, 0.01), (0.9, 0.99)], real)
    for alpha in ((1e-8, 1e-8), (1e-4, 1.0), (0.1, 0.1), (1e3, 0.1)):
        ndf = kind(*(accuracy.rounded(one, real) for one in alpha))
        normals = mf.Smith(ndf).sample_visible(views[:, None], numbers)
        for wo, row in zip(views, normals, strict=True):
            back = [accuracy.numbers_back(ndf, wo, u, m) for u, m in zip(numbers, row, strict=True)]
            assert min(back) > accuracy.MOST[real] - 2.5, (alpha, wo)


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
def test_a_number_is_as_far_off_as_it_is_from_the_nearer_end(kind: type) -> None:
    """Who draws with other numbers gets them back, and is told by how much they differ: of u2, or of 1 - u2 if that is less."""
    ndf, wo = kind(0.4), spherical(0.7, 0.3)
    for u2, off in ((1e-5, 1e-8), (0.3, 3e-4), (1 - 1e-5, -1e-8)):  # a thousandth of what is less
        m = mf.Smith(ndf).sample_visible(wo, [0.3, u2 + off])
        assert accuracy.numbers_back(ndf, wo, np.array([0.3, u2]), m) == pytest.approx(3, abs=0.02)
    m = mf.Smith(ndf).sample_visible(wo, [0.3 + 1e-4, 0.3])
    assert accuracy.numbers_back(ndf, wo, np.array([0.3, 0.3]), m) == pytest.approx(4, abs=0.02)
