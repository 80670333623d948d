"""Models in bins against what is known of them without bins, and distances against their definitions."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from microfacet.brdf.compensation import Compensated
from microfacet.directions import spherical
from microfacet.surface import compare
from microfacet.surface.compare import (
    apart,
    coarse,
    folded,
    illuminated_fraction,
    in_plane,
    lobe_of,
    noise,
    normals_of,
    total_variation,
)
from microfacet.surface.measure import Plan, estimate_of

VIEWS = spherical(np.radians([10, 50, 75]), np.radians([0, 100, -40]))
PLAN = Plan(VIEWS, bins=(30, 36), reach=4.0, slopes=32)
NDFS = [mf.Beckmann(0.7), mf.Beckmann(0.8, 0.4)]


@pytest.mark.parametrize("ndf", NDFS, ids=["isotropic", "stretched"])
def test_a_binned_lobe_has_the_albedo(ndf: mf.Beckmann) -> None:
    for model in (mf.Smith(ndf), mf.VCavity(ndf)):
        for wo in VIEWS:
            assert lobe_of(model, wo, PLAN).sum() == pytest.approx(mf.Microfacet(model).albedo(wo), abs=5e-4)


def test_a_bin_holds_the_brdf_at_its_place() -> None:
    model, (theta, phi) = mf.Smith(mf.Beckmann(0.8, 0.4)), PLAN.lobe_edges
    turn = np.arctan2(VIEWS[1, 1], VIEWS[1, 0])
    wi = spherical((theta[20] + theta[21]) / 2, turn + (phi[30] + phi[31]) / 2)
    rho = mf.Microfacet(model).evaluate(VIEWS[1], wi) * wi[2]
    assert lobe_of(model, VIEWS[1], PLAN)[20, 30] / PLAN.solid_angle[20, 30] == pytest.approx(rho, rel=0.02)


@pytest.mark.parametrize("ndf", NDFS, ids=["isotropic", "stretched"])
def test_binned_visible_normals_fill_the_view(ndf: mf.Beckmann) -> None:
    for make in (mf.Smith, mf.VCavity):
        for wo in VIEWS:
            assert normals_of(make(ndf), wo, PLAN).sum() == pytest.approx(1, abs=2e-3)


def test_the_illuminated_fraction_of_smith_is_a_quotient() -> None:
    wo, wi = VIEWS[1], spherical(1.0, -0.5)
    for form in ("height", "direction"):
        model = mf.Smith(mf.Beckmann(0.7), form)
        up = [0, 0, 1]
        assert illuminated_fraction(model, wo, wi) == pytest.approx(model.G2(wo, wi, up) / model.G1(wo, up), rel=1e-9)


def test_the_illuminated_fraction_of_v_cavities_is_1_from_the_viewer() -> None:
    model = mf.VCavity(mf.Beckmann(0.7))
    assert illuminated_fraction(model, VIEWS[2], VIEWS[2]) == pytest.approx(1, abs=1e-12)
    assert 0.5 < illuminated_fraction(model, VIEWS[2], spherical(1.3, 1.0)) < 0.99


def test_total_variation_is_a_distance_of_shapes() -> None:
    one, other = np.array([[1.0, 3.0], [0.0, 0.0]]), np.array([[0.0, 0.0], [2.0, 2.0]])
    assert total_variation(one, 5 * one) == 0
    assert total_variation(one, other) == 1
    assert total_variation(one, one + other) == pytest.approx(0.5)


def test_folding_keeps_the_sum_and_makes_even() -> None:
    lobe = np.random.default_rng(1).uniform(size=(3, 6, 8))
    even = folded(lobe)
    np.testing.assert_allclose(even.sum(axis=(1, 2)), lobe.sum(axis=(1, 2)))
    np.testing.assert_array_equal(even, even[..., ::-1])


def test_coarse_bins_are_sums() -> None:
    lobe = np.arange(24.0).reshape(4, 6)
    sums = [[0 + 1 + 2 + 6 + 7 + 8, 3 + 4 + 5 + 9 + 10 + 11], [12 + 13 + 14 + 18 + 19 + 20, 15 + 16 + 17 + 21 + 22 + 23]]
    np.testing.assert_array_equal(coarse(lobe, 2, 3), sums)
    with pytest.raises(ValueError, match="divide 4 and 6, got 3 and 2"):
        coarse(lobe, 3, 2)


def test_the_plane_has_the_viewer_at_negative_angles() -> None:
    angles = PLAN.solid_angle
    lobe = np.zeros(angles.shape)
    lobe[5, 17:19] = 0.3  # at the viewer's azimuth
    lobe[9, [0, -1]] = 0.1  # away
    plane = in_plane(lobe, angles)
    assert set(np.flatnonzero(plane)) == {30 - 1 - 5, 30 + 9}
    assert plane[24] == pytest.approx(0.3 / angles[5, 0])
    np.testing.assert_allclose(in_plane(0.25 * angles, angles), 0.25)
    with pytest.raises(ValueError, match="even number"):
        in_plane(lobe[:, 1:], angles[:, 1:])


def test_a_right_model_is_as_far_as_noise_says() -> None:
    """Surfaces that scatter by themselves about the model: distance and prediction agree; about another model, not."""
    rng, model = np.random.default_rng(2), lobe_of(mf.Smith(mf.Beckmann(0.7)), VIEWS[1], PLAN)
    measured = model * (1 + 0.3 * rng.standard_normal((40, *model.shape)))
    found = apart(measured, model)
    assert found.value == pytest.approx(noise(measured), rel=0.1)
    other = lobe_of(mf.VCavity(mf.Beckmann(0.7)), VIEWS[1], PLAN)
    assert apart(measured, other).value > 2 * noise(measured)


def test_the_error_of_a_function_of_a_mean_covers_it() -> None:
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(200):
        found = estimate_of(lambda mean: mean[0] * mean[1], rng.normal([2, 3], 0.5, (25, 2)))
        hits += abs(found.value - 6) < 2 * found.error
    assert 0.90 < hits / 200 < 0.985
    with pytest.raises(ValueError, match="at least 2 surfaces, got 1"):
        estimate_of(np.sum, [1.0])


# --- bins -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", range(3))
def test_bins_hold_what_samples_leave_in_them(k: int) -> None:
    """A binned lobe and binned normals against drawn ones, in larger bins; azimuth counts from the view's."""
    wo, model = VIEWS[k], mf.Smith(NDFS[1])
    brdf, count = mf.Microfacet(model), 1 << 18
    u = np.random.default_rng(k).random((count, 2))
    wi = brdf.sample(wo, u)
    up = wi[:, 2] > 0
    weight = np.zeros(count)
    weight[up] = brdf.evaluate(wo, wi[up]) * wi[up, 2] / brdf.pdf(wo, wi[up])
    theta, phi = np.arccos(np.clip(wi[:, 2], -1, 1)), np.arctan2(wi[:, 1], wi[:, 0]) - np.arctan2(wo[1], wo[0])
    phi = (phi + np.pi) % (2 * np.pi) - np.pi
    found = coarse(np.histogram2d(theta, phi, PLAN.lobe_edges, weights=weight)[0], 5, 6) / count
    expected = coarse(lobe_of(model, wo, PLAN), 5, 6)
    assert (abs(found - expected) < 5 * np.sqrt(expected / count) + 2e-4).all()
    wm = model.sample_visible(wo, u)
    slopes = -wm[:, :2] / wm[:, 2:] / NDFS[1].slope_scale
    drawn = coarse(np.histogram2d(*slopes.T, [PLAN.slope_edges] * 2)[0], 8, 8) / count
    seen = coarse(normals_of(model, wo, PLAN), 8, 8)
    assert (abs(drawn - seen) < 5 * np.sqrt(seen / count) + 2e-4).all()


def test_walks_fall_into_bins_after_all_their_bounces() -> None:
    """All light of mirrors, the first bounce as the BRDF has it; azimuth counts from the view's."""
    walk, wo = mf.RandomWalk(mf.Smith(mf.Beckmann(1.0))), VIEWS[1]
    whole = compare.walked(walk, wo, PLAN, 1 << 17, 3)
    once = compare.binned(walk.single, wo, PLAN)
    assert whole.sum() == pytest.approx(1, abs=5e-3)
    assert (whole >= once).all()
    turned = spherical(np.radians(50), 0.0)
    other = compare.walked(walk, turned, PLAN, 1 << 17, 4)
    later, as_turned = (coarse(a - once, 10, 9) for a in (whole, other))
    assert (abs(later - as_turned) < 6 * np.sqrt((later + as_turned) / (1 << 17)) + 3e-4).all()
    assert (whole != compare.walked(walk, wo, PLAN, 1 << 17, 5)).any()


def test_a_binned_compensated_lobe_has_all_the_light() -> None:
    made = Compensated(mf.Microfacet(mf.Smith(mf.Beckmann(0.7))), "lobe")
    for wo in VIEWS[:2]:
        assert compare.binned(made, wo, PLAN).sum() == pytest.approx(1, abs=2e-3)


def test_all_physical_models_are_compared() -> None:
    found = compare.models(NDFS[0])
    assert list(found) == ["V-cavities", *(f"Smith, {form}" for form in compare.CORRELATIONS)]
    assert all(model.ndf is NDFS[0] for model in found.values())
    assert {model.correlation for name, model in found.items() if name != "V-cavities"} == set(compare.CORRELATIONS)


def test_the_illuminated_fraction_is_a_mean_over_the_facets_turned_to_both() -> None:
    """Against drawn visible normals, of those that face the light."""
    model, wo, wi = mf.VCavity(mf.Beckmann(0.8, 0.4)), VIEWS[2], spherical(1.3, 1.0)
    wm = mf.Smith(model.ndf).sample_visible(wo, np.random.default_rng(3).random((1 << 18, 2)))
    # drawn as Smith sees them; G1 of V-cavities weighs them again
    facing = (wm @ wi > 0) & (wm @ wo > 0)
    both, seen = model.G2(wo, wi, wm[facing]), model.G1(wo, wm[facing])
    assert illuminated_fraction(model, wo, wi) == pytest.approx(both.sum() / seen.sum(), rel=5e-3)
    assert illuminated_fraction(model, wo, wi, reach=2.0) != pytest.approx(illuminated_fraction(model, wo, wi), rel=1e-4)


def test_the_illuminated_fraction_of_a_ridged_surface_has_a_grid_as_narrow_as_its_slopes() -> None:
    """Across the ridges a grid as wide as along them would step over all slopes but one."""
    wo, wi = spherical(1.2, 0.4), spherical(1.3, 1.0)
    ridged = illuminated_fraction(mf.VCavity(mf.Beckmann(0.8, 0.01)), wo, wi)
    assert illuminated_fraction(mf.VCavity(mf.Beckmann(0.8, 0.01)), wo, wi, side=800) == pytest.approx(ridged, rel=5e-3)


# --- distances --------------------------------------------------------------------------------------------------------------


def test_misplaced_light_counts_what_is_missing() -> None:
    measured = np.array([[[0.5, 0.3], [0.1, 0.1]], [[0.3, 0.3], [0.1, 0.1]]])
    model = np.array([[0.2, 0.3], [0.3, 0.1]])
    found = compare.misplaced(measured, model)
    assert found.value == pytest.approx(0.5 * (0.2 + 0.2))
    assert found.error == pytest.approx(0.5 * 0.1)  # the first bin's, 0.1, halved
    assert compare.misplaced(measured, measured.mean(axis=0)).value == pytest.approx(0)
    assert compare.misplaced(measured, 0 * model).value == pytest.approx(0.5 * measured.mean(axis=0).sum())


def test_noise_is_the_mean_distance_of_gaussian_scatter() -> None:
    """Half the sum of the mean sizes of what is off: sqrt(2/pi) standard errors each."""
    rng = np.random.default_rng(4)
    mean = rng.uniform(1, 2, (6, 8))
    told, found = [], []
    for _ in range(60):
        lobes = mean + 0.1 * rng.standard_normal((12, *mean.shape))
        told.append(noise(lobes))
        found.append(total_variation(lobes.mean(axis=0), mean))
    assert np.mean(told) == pytest.approx(np.mean(found), rel=0.05)
