"""Models in bins against what is known of them without bins, and distances against their definitions."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from microfacet.directions import spherical
from microfacet.surface.compare import (
    apart,
    coarse,
    contest,
    folded,
    in_plane,
    lit_of,
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


def test_the_lit_share_of_smith_is_a_quotient() -> None:
    wo, wi = VIEWS[1], spherical(1.0, -0.5)
    for form in ("height", "direction"):
        model = mf.Smith(mf.Beckmann(0.7), form)
        up = [0, 0, 1]
        assert lit_of(model, wo, wi) == pytest.approx(model.G2(wo, wi, up) / model.G1(wo, up), rel=1e-9)


def test_the_lit_share_of_v_cavities_is_all_from_the_viewer() -> None:
    model = mf.VCavity(mf.Beckmann(0.7))
    assert lit_of(model, VIEWS[2], VIEWS[2]) == pytest.approx(1, abs=1e-12)
    assert 0.5 < lit_of(model, VIEWS[2], spherical(1.3, 1.0)) < 0.99


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


def test_a_contest_names_the_nearer_one_or_nobody() -> None:
    found = {
        "names": np.array([["A", "B"]]),
        "alpha": np.array([0.4]),
        "theta_o": np.array([0.0, 60.0, 80.0]),
        "noise": np.zeros((1, 3)),
        "albedo": np.array([[[0.9, 0.001], [0.8, 0.001], [0.7, 0.01]]]),
        "model_albedo": np.array([[[0.9, 0.9], [0.801, 0.79], [0.72, 0.69]]]),
        "distance": np.array([[[[0, 0], [0, 0]], [[0.1, 0.001], [0.05, 0.001]], [[0.1, 0.03], [0.05, 0.03]]]]),
    }
    rows = contest(found, "A", "B", least=30)
    assert [row[1] for row in rows] == ["60°", "80°"]
    assert [row[5] for row in rows] == ["A", "–"]
    assert [row[8] for row in rows] == ["B", "–"]
    assert rows[0][2:5] == ["0.8000 ± 0.0010", "+0.0010", "-0.0100"]
