"""Both cosines 0, opposite directions, vectors of other lengths, rays that start on a facet."""

from __future__ import annotations

import runpy
from pathlib import Path

import faulty
import microfacet as mf
import numpy as np
import pytest
from microfacet.directions import half_vector, spherical
from microfacet.validation import accuracy

SCRIPT = runpy.run_path(str(Path(faulty.__file__).with_name("edges_data.py")))
COSINES = (1e-2, 1e-8, 1e-12, 1e-18)


def facing(cosine: float, real: type) -> tuple[np.ndarray, np.ndarray]:
    sine = np.sqrt(1 - cosine * cosine)
    return np.array([sine, 0, cosine], real), np.array([-sine, 0, cosine], real)


@pytest.mark.parametrize("ndf", [mf.GGX(0.3), mf.GGX(1e-4), mf.Beckmann(0.3)], ids=repr)
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_both_cosines_next_to_zero(ndf: mf.GGX, real: type) -> None:
    """Mirrored at the horizon all digits of the BRDF are right, as long as the cosines squared are numbers."""
    brdf, seen = mf.Microfacet(mf.Smith(ndf)), type(ndf)(accuracy.rounded(ndf.alpha_x, real))
    for cosine in COSINES:
        wo, wi = facing(cosine, real)
        exact = SCRIPT["exact_rho"](seen, wo, wi)
        assert accuracy.digits(np.array([brdf.evaluate(wo, wi)]), [exact], real)[0] > accuracy.MOST[real] - 1


def test_squares_first_divide_zero_by_zero() -> None:
    wo, wi = facing(1e-12, np.float32)
    with np.errstate(all="ignore"):
        assert np.isnan(faulty.rho_squares_first(mf.GGX(0.3), wo, wi))
    wo, wi = facing(0.5, np.float32)
    assert faulty.rho_squares_first(mf.GGX(0.3), wo, wi) == pytest.approx(mf.Microfacet(mf.Smith(mf.GGX(0.3))).evaluate(wo, wi))


@pytest.mark.parametrize("alpha", [(1e-8, 1e-8), (1e-4, 1.0), (1e3, 1e3), (1e-1, 1e3)])
@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_nothing_is_nan(kind: type, alpha: tuple[float, float], real: type) -> None:
    """Roughness from 1e-8 to 1e3, ratios to 1e4, from the pole to 1e-8 above the horizon, opposite directions too."""
    brdf, views = mf.Microfacet(mf.Smith(kind(*alpha))), accuracy.directions(real)[::4]
    wo, wi = views[:, None], np.concatenate([views, views * np.array([-1, -1, 1], real), -views])[None]
    for values in (brdf.evaluate(wo, wi), brdf.pdf(wo, wi), brdf.model.G1(wo, views), brdf.model.D_visible(wo, views)):
        assert not np.isnan(values).any()
        assert (values >= 0).all()
    np.testing.assert_array_equal(brdf.evaluate(views, -views), 0)
    np.testing.assert_array_equal(half_vector(views, -views), 0)


def test_a_vector_slightly_too_long_ruins_the_cosine_form_only() -> None:
    m = (1 + 1e-6) * spherical([0.001], 0.6)
    ndf, exact = mf.GGX(1e-3), mf.GGX(1e-3).D(spherical([0.001], 0.6))
    assert abs(faulty.ggx_D_cosine(ndf, m) / exact - 1) > 0.5
    assert abs(ndf.D(m) / exact - 1) < 5e-6


def test_rays_of_the_library_leave_their_facet() -> None:
    """No offset is right at every scale; without one, every ray is decided as in double precision by brute force."""
    found = SCRIPT["rays"]()
    assert found["library"] == 0
    assert found["wrong"].max(axis=1).min() > 0.05
    near, far = found["wrong"][0], found["wrong"][-1]
    assert far[np.argmax(near == 0)] > 0.3, "what is enough at the origin is not enough far from it"
    assert near[-1] > 0.05, "and an offset of many cells misses hits"


def test_a_frame_by_a_plain_quotient_fails_at_the_lower_pole() -> None:
    n = np.array([[1e-5, 0, -1], [0, 0, -1], [0.6, 0, 0.8]], np.float32)
    with np.errstate(all="ignore"):
        plain = faulty.skew(faulty.frame_plain, n)
    assert (plain[:2] > 0.5).all()
    assert plain[2] < 1e-6
    assert (faulty.skew(faulty.frame_signed, n) < 1e-6).all()


def test_light_sent_into_the_surface_counts_as_lost() -> None:
    brdf, wo = mf.Microfacet(mf.Smith(mf.GGX(1.0))), np.array([0, 0, 1.0])
    wi = brdf.sample(wo, np.random.default_rng(0).random((5000, 2)))
    down = wi[:, 2] < 0
    assert np.mean(down) == pytest.approx(0.5, abs=0.05)
    np.testing.assert_array_equal(brdf.evaluate(wo, wi[down]), 0)
    assert (brdf.pdf(wo, wi[down]) > 0).all(), "their density counts, or it would not sum to 1"


def test_no_roughness_is_refused() -> None:
    with np.errstate(all="ignore"):
        assert np.isnan(faulty.ggx_D_cosine(type("Flat", (), {"alpha_x": 0.0}), np.array([[0.0, 0.0, 1.0]]))).all()
    with pytest.raises(ValueError, match="alpha_x must be a finite number above 0"):
        mf.GGX(0.0)
