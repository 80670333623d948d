"""The complete BRDF: by its parts, reciprocal, sampled by its density, its albedo by three roads."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from around import reflected, turned_away
from hypothesis import given
from hypothesis import strategies as st
from microfacet.directions import half_vector, spherical
from microfacet.geometry.ggx import inverse_square
from samples import LAST, LAST_SINGLE, UP, hemisphere, sphere, uniform, views
from sampling import density_times_area

GGX = mf.Microfacet(mf.Smith(mf.GGX(0.5, 0.2)))
BECKMANN = mf.Microfacet(mf.Smith(mf.Beckmann(0.2, 0.5)))
CAVITIES = mf.Microfacet(mf.VCavity(mf.GGX(0.5, 0.2)))
GLASS = mf.Microfacet(GGX.model, mf.Dielectric(1.5))
BRDFS = [GGX, BECKMANN, CAVITIES, GLASS]
ROUND = mf.Microfacet(mf.Smith(mf.GGX(1.0)))
INSIDE = st.floats(0.01, 0.99)


@pytest.mark.parametrize("brdf", BRDFS, ids=repr)
def test_value_is_that_of_its_parts(brdf: mf.Microfacet) -> None:
    wo, wi = hemisphere(500, 1), hemisphere(500, 2)
    h = half_vector(wo, wi)
    F = 1.0 if brdf is not GLASS else brdf.fresnel.F(np.sum(wo * h, -1))
    expected = F * brdf.model.G2(wo, wi, h) * brdf.model.ndf.D(h) / (4 * wo[:, 2] * wi[:, 2])
    np.testing.assert_allclose(brdf.evaluate(wo, wi), expected, rtol=1e-11, atol=1e-250)


def test_value_of_ggx_by_the_papers() -> None:
    """From the angles alone, without anything of the library."""
    ax, ay = 0.5, 0.2
    wo, wi = hemisphere(500, 1), hemisphere(500, 2)
    h = wo + wi
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    D = 1 / (np.pi * ax * ay * ((h[:, 0] / ax) ** 2 + (h[:, 1] / ay) ** 2 + h[:, 2] ** 2) ** 2)
    Lo, Li = ((np.sqrt(1 + ((ax * w[:, 0]) ** 2 + (ay * w[:, 1]) ** 2) / w[:, 2] ** 2) - 1) / 2 for w in (wo, wi))
    np.testing.assert_allclose(GGX.evaluate(wo, wi), D / (1 + Lo + Li) / (4 * wo[:, 2] * wi[:, 2]), rtol=1e-11)


def test_the_inverse_of_a_square_loses_next_to_nothing() -> None:
    """Half an ulp, where 1/(alpha alpha) loses one and a half; and neither overflow nor underflow."""
    import mpmath

    alphas = 10 ** np.random.default_rng(0).uniform(-9.9, 9.9, 500)
    with mpmath.workdps(50):
        for alpha in map(float, alphas):
            factor, inverse = inverse_square(alpha)
            assert factor == 1
            assert abs(inverse * mpmath.mpf(alpha) ** 2 - 1) <= 0.5001 * np.finfo(float).eps
    for alpha in (1e-300, 1e-160, 1e-20, 1e160, 1e300):
        factor, inverse = inverse_square(alpha)
        assert (factor * alpha) ** 2 * inverse == pytest.approx(1, rel=1e-15)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("alpha", [1e-11, 9e-11, 2e-10, 9e9, 2e10, 1e11])
def test_extreme_roughness_overflows_nowhere(alpha: float, real: type) -> None:
    """Upright half vectors, on both sides of where a roughness is scaled before it is squared."""
    theta = np.array([0.0, 0.3])
    wo = spherical(theta, 0.2).astype(real)
    value = mf.Microfacet(mf.Smith(mf.GGX(alpha))).evaluate(wo, wo * np.array([-1, -1, 1], real))
    expected = 1 / (4 * np.pi * alpha**2 * np.cos(theta) * np.hypot(np.cos(theta), alpha * np.sin(theta)))
    np.testing.assert_allclose(value, expected, rtol=1e-5 if real == np.float32 else 1e-14)


@pytest.mark.parametrize("brdf", BRDFS, ids=repr)
def test_reciprocal_and_nowhere_negative(brdf: mf.Microfacet) -> None:
    wo, wi = hemisphere(2000, 1), hemisphere(2000, 2)
    value = brdf.evaluate(wo, wi)
    np.testing.assert_allclose(value, brdf.evaluate(wi, wo), rtol=1e-14)
    assert (value >= 0).all()


@pytest.mark.parametrize("brdf", BRDFS, ids=repr)
def test_nothing_through_the_surface(brdf: mf.Microfacet) -> None:
    """Both directions must lie above; on the horizon the value is 0, and so it is where no facet joins the two."""
    wo, wi = hemisphere(100, 1), hemisphere(100, 2)
    down = np.array([1, 1, -1])
    for o, i in ((wo * down, wi), (wo, wi * down), (wo * down, wi * down), (wo, -wo), ([1.0, 0, 0], wi), (wo, [1.0, 0, 0])):
        np.testing.assert_array_equal(brdf.evaluate(o, i), 0)
    assert brdf.evaluate([1.0, 0, 0], [-1.0, 0, 0]) == 0
    assert brdf.evaluate([1.0, 0, 0], [0, 1.0, 0]) == 0
    np.testing.assert_array_equal(brdf.pdf(wo * down, wi), 0)
    np.testing.assert_array_equal(brdf.pdf(wo, -wo), 0)
    np.testing.assert_array_equal(brdf.sample(wo * down, uniform(100)), 0)
    np.testing.assert_array_equal(brdf.albedo(wo[:3] * down), 0)


@pytest.mark.parametrize("brdf", BRDFS, ids=repr)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_next_to_the_horizon_all_is_finite(brdf: mf.Microfacet, real: type) -> None:
    height = np.array([1e-2, 1e-4, 1e-7, 1e-9], real)
    wo = np.stack([np.sqrt(1 - height**2), 0 * height, height], -1)
    wi = wo * np.array([-1, 1, 1], real)
    for o, i in ((wo, wi), (wo, wo), (wo, UP.astype(real)), (UP.astype(real), wi)):
        assert np.isfinite(brdf.evaluate(o, i)).all()
        assert np.isfinite(brdf.pdf(o, i)).all()


# --- sampling -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("brdf", [GGX, BECKMANN, CAVITIES], ids=repr)
@given(u1=INSIDE, u2=INSIDE, theta=st.floats(0, 1.5), phi=st.floats(-3, 3))
def test_sampler_has_its_density(brdf: mf.Microfacet, u1: float, u2: float, theta: float, phi: float) -> None:
    """Pointwise, through the reflection; also for a model that samples all normals, seen or not."""
    wo = spherical(theta, phi)
    product = density_times_area(lambda u: brdf.sample(wo, u), lambda wi: brdf.pdf(wo, wi), np.array([u1, u2]))
    assert product == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize("brdf", [GGX, BECKMANN, CAVITIES], ids=repr)
def test_density_integrates_to_one_over_the_sphere(brdf: mf.Microfacet) -> None:
    """Over half vectors that are seen and, for a model that samples all normals, those turned away, which reflect down."""
    for wo in views(20, 60, 85):
        total = reflected(wo, lambda wi, wo=wo: brdf.pdf(wo, wi))
        if brdf is CAVITIES:
            away = turned_away(wo)
            cosine = away.directions @ wo
            down = 2 * cosine[:, None] * away.directions - wo
            total += away.sum(-4 * cosine * brdf.pdf(wo, down))
        assert total == pytest.approx(1, rel=1e-6)


@pytest.mark.parametrize("brdf", [GGX, BECKMANN], ids=repr)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_weight_of_a_sample_is_G2_over_G1(brdf: mf.Microfacet, real: type) -> None:
    """F G2/G1 at most 1: visible normals leave no spikes. Directions below the horizon count as lost."""
    for wo in views(0, 60, 85).astype(real):
        wi = brdf.sample(wo, uniform(5000, 3, real))
        assert wi.dtype == real
        up = wi[wi[:, 2] > 1e-3]
        h = half_vector(wo, up)
        weight = brdf.evaluate(wo, up) * up[:, 2] / brdf.pdf(wo, up)
        slack = 2e-2 if real is np.float32 else 1e-7
        np.testing.assert_allclose(weight, brdf.model.G2(wo, up, h) / brdf.model.G1(wo, h), rtol=slack)
        np.testing.assert_array_equal(brdf.evaluate(wo, wi[wi[:, 2] <= 0]), 0)


@pytest.mark.parametrize("brdf", [GGX, BECKMANN, CAVITIES], ids=repr)
@pytest.mark.parametrize(("real", "last"), [(np.float64, LAST), (np.float32, LAST_SINGLE)])
def test_corners_of_the_unit_square_give_directions(brdf: mf.Microfacet, real: type, last: float) -> None:
    corners = np.array([(a, b) for a in (0, 0.5, last) for b in (0, 0.5, last)], real)
    for wo in views(0, 30, 85, 89.99).astype(real):
        wi = brdf.sample(wo, corners)
        assert np.isfinite(wi).all()
        np.testing.assert_allclose(np.linalg.norm(wi, axis=-1), 1, rtol=8 * np.finfo(real).eps)
        assert np.isfinite(brdf.pdf(wo, wi)).all()


# --- albedo -------------------------------------------------------------------------------------------------------------


def test_albedo_of_ggx_at_roughness_one() -> None:
    """E(mu) = 1 - mu ln(1 + 1/mu): what single scattering loses is exactly known; the average is 4/3 (1 - ln 2)."""
    wo = spherical(np.arccos(np.array([1e-4, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0])))
    mu = wo[:, 2]
    value, error = ROUND.albedo_with_error(wo)
    exact = 1 - mu * np.log1p(1 / mu)
    np.testing.assert_allclose(value, exact, rtol=1e-10)
    assert (np.abs(value - exact) <= error + 1e-15).all()
    nodes, weights = np.polynomial.legendre.leggauss(40)
    nodes = (nodes + 1) / 2
    mean = np.sum(weights * nodes * ROUND.albedo(spherical(np.arccos(nodes))))  # twice the integral of E mu
    assert mean == pytest.approx(4 / 3 * (1 - np.log(2)), rel=1e-6)


def estimate(brdf: mf.Microfacet, wo: np.ndarray, count: int = 200_000) -> tuple[float, float]:
    """The albedo by Monte Carlo, and its standard error."""
    wi = brdf.sample(wo, uniform(count, 5))
    with np.errstate(invalid="ignore", divide="ignore"):
        weight = np.where(wi[:, 2] > 0, brdf.evaluate(wo, wi) * wi[:, 2] / brdf.pdf(wo, wi), 0)
    return float(weight.mean()), float(weight.std() / np.sqrt(count))


@pytest.mark.parametrize("brdf", BRDFS, ids=repr)
def test_albedo_by_monte_carlo(brdf: mf.Microfacet) -> None:
    for wo in views(0, 40, 75, 87):
        mean, error = estimate(brdf, wo)
        assert abs(brdf.albedo(wo) - mean) < 4.5 * error + 1e-12
        assert error < 3e-3


def test_albedo_by_a_rule_on_the_sphere() -> None:
    """The edge where reflections go down is not a coordinate line here: few digits, but nothing in common."""
    for wo in views(0, 60):
        total = reflected(wo, lambda wi, wo=wo: GGX.evaluate(wo, wi) * np.maximum(wi[:, 2], 0), 200)
        assert GGX.albedo(wo) == pytest.approx(total, abs=1e-3)


@pytest.mark.parametrize("brdf", BRDFS, ids=repr)
def test_albedo_is_a_share_and_its_error_is_small(brdf: mf.Microfacet) -> None:
    value, error = brdf.albedo_with_error(views(0, 30, 60, 80, 89))
    assert ((value > 0) & (value <= 1)).all()
    assert (error < 1e-3).all()


def test_what_a_dielectric_reflects_is_less() -> None:
    wo = views(0, 60, 85)
    assert (GLASS.albedo(wo) < GGX.albedo(wo)).all()
    np.testing.assert_allclose(GLASS.albedo(UP), 0.04, atol=0.01)


def test_single_scattering_fails_the_white_furnace() -> None:
    """By 1 - ln 2 at most, for this surface: what is lost bounces on."""
    assert 1 - ROUND.albedo(UP) == pytest.approx(np.log(2), rel=1e-10)


def test_narrow_lobes_are_not_missed() -> None:
    """A grid coarser than alpha loses the peak."""
    for alpha in (1e-3, 1e-2):
        smooth = mf.Microfacet(mf.Smith(mf.GGX(alpha)))
        for wo in views(0, 45, 80):
            value, error = smooth.albedo_with_error(wo)
            assert value == pytest.approx(1, abs=10 * alpha**2 * np.log(1 / alpha) / wo[2])
            assert error < 1e-6


@pytest.mark.parametrize("wrong", [None, "GGX", mf.GGX(0.3)])
def test_a_model_is_wanted(wrong: object) -> None:
    with pytest.raises(ValueError, match="model must be a model of masking"):
        mf.Microfacet(wrong)
    with pytest.raises(ValueError, match="fresnel must be None, Dielectric, Conductor or Schlick"):
        mf.Microfacet(GGX.model, 1.5)


def test_pdf_where_the_viewer_is_the_light() -> None:
    wo = sphere(50, 4)
    assert np.isfinite(GGX.pdf(wo, wo)).all()
    assert np.isfinite(GGX.evaluate(wo, wo)).all()
