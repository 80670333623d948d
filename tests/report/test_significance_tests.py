"""Trials know their odds: a right statement passes, one that is off by a per cent or two is refuted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import microfacet as mf
import numpy as np
import pytest
from microfacet.brdf.microfacet import Microfacet
from microfacet.confidence import Estimate
from microfacet.directions import spherical
from microfacet.surface.compare import normals_of
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.measure import Measurement, Plan, shard
from report import significance_tests
from report.campaign import Entry
from report.significance_tests import SignificanceTest, p_value_of_mean, verdict
from scipy.stats import norm

SURFACES = 24


@pytest.fixture(scope="module")
def small() -> tuple[Entry, Measurement]:
    views = [significance_tests.ABOVE, *spherical(np.radians([60.0, 80.0]), 0.7)]
    entry = Entry(GaussianField(128, 0.7, root=11), Plan(np.array(views), side=96, bounces=0))
    return entry, shard(entry.family, entry.plan, 0, SURFACES)


@pytest.fixture
def campaign(small: tuple[Entry, Measurement], monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    entry, found = small
    monkeypatch.setattr(significance_tests, "ENTRIES", ("small",))
    monkeypatch.setattr(significance_tests, "CAMPAIGN", {"small": entry})
    monkeypatch.setattr(significance_tests, "read", lambda name: found)
    monkeypatch.setattr(significance_tests, "SAMPLES", 60_000)
    significance_tests.uniform.cache_clear()
    yield
    significance_tests.uniform.cache_clear()


def wider(plan: Plan, factor: float) -> Plan:
    """Bins that hold what bins of slopes so many times as large would."""
    return replace(plan, reach=factor * plan.reach)


def test_trials_are_of_statements() -> None:
    assert set(significance_tests.TESTS) <= set(mf.equations)


@pytest.mark.slow
@pytest.mark.parametrize("key", significance_tests.TESTS)
def test_every_trial_passes(key: str, campaign: None) -> None:
    what, tests = significance_tests.TESTS[key]
    mark = verdict(what, tests())
    assert mark.status == "pass", mark.detail
    assert mark.measured["count"] >= 1


@pytest.mark.usefixtures("campaign")
def test_an_area_off_by_two_per_cent_is_refuted() -> None:
    tests = significance_tests.over_views("seen", lambda family, wo: 1.02 * significance_tests.cosine(family, wo))
    mark = verdict("surfaces", tests)
    assert mark.status == "fail"
    assert "refuted" in mark.detail


@pytest.mark.usefixtures("campaign")
@pytest.mark.parametrize("wrong", [(mf.Beckmann, 1.15), (mf.GGX, 1.0)])
def test_slopes_of_another_distribution_are_refuted(wrong: tuple[type, float], monkeypatch: pytest.MonkeyPatch) -> None:
    kind, factor = wrong
    monkeypatch.setattr(
        significance_tests, "normals_of", lambda model, wo, plan: normals_of(mf.Smith(kind(0.7)), wo, wider(plan, factor))
    )
    assert verdict("surfaces", significance_tests.slopes_visible_from_above()).status == "fail"


def test_a_sampler_with_swapped_axes_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    swapped = mf.GGX(0.2, 0.5).sample
    monkeypatch.setattr(mf.GGX, "sample", lambda self, u: swapped(u))
    assert verdict("samples", significance_tests.sampled_by_area(mf.GGX(0.5, 0.2))).status == "fail"


def test_a_density_off_by_two_in_a_thousand_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    density = Microfacet.pdf
    assert (
        verdict("samples", significance_tests.mean_weights(mf.GGX(1.0), albedo=significance_tests.exact_albedo)).status
        == "pass"
    )
    monkeypatch.setattr(Microfacet, "pdf", lambda self, wo, wi: 1.002 * density(self, wo, wi))
    for albedo, ndf in ((Microfacet.albedo, mf.Beckmann(0.4)), (significance_tests.exact_albedo, mf.GGX(1.0))):
        assert verdict("samples", significance_tests.mean_weights(ndf, albedo=albedo)).status == "fail"


def test_odds_are_students() -> None:
    """With 5 surfaces a mean 2.776 standard errors off comes by chance once in 20."""
    assert p_value_of_mean(Estimate(np.array(1.0 + 2.776e-3), np.array(1e-3)), 1.0, 5) == pytest.approx(0.05, rel=1e-3)
    assert p_value_of_mean(Estimate(np.array(1.0), np.array(0.0)), 1.0, 5) == 1.0
    assert p_value_of_mean(Estimate(np.array(1.0), np.array(0.0)), 1.1, 5) == 0.0


def test_looking_often_makes_chance_likelier() -> None:
    assert verdict("surfaces", [SignificanceTest(0.01, "a"), SignificanceTest(0.5, "b")]).measured["odds"] == 0.02
    assert verdict("surfaces", [SignificanceTest(5e-7, "a")]).status == "fail"
    assert verdict("surfaces", [SignificanceTest(5e-7, "a")] * 10).status == "pass"


def test_what_is_no_number_is_refuted() -> None:
    assert verdict("surfaces", [SignificanceTest(0.5, "a"), SignificanceTest(float("nan"), "b")]).status == "fail"


def test_what_refutes_is_one_in_a_million() -> None:
    assert verdict("samples", [SignificanceTest(0.7e-6, "a")]).status == "fail"
    assert verdict("samples", [SignificanceTest(1.4e-6, "a")]).status == "pass"
    assert verdict("samples", [SignificanceTest(0.4e-6, "a"), SignificanceTest(1.0, "b")]).status == "fail"


def test_a_verdict_says_how_often_it_was_looked_and_how_finely() -> None:
    mark = verdict("samples", [SignificanceTest(0.7, "a", 0.02), SignificanceTest(0.6, "b", 0.003)])
    assert mark.measured == {"count": 2, "odds": 1.0, "error": 0.02}
    assert mark.detail == "samples: 2 comparisons, standard error at most 0.02; odds of one so far off by chance 1"
    assert (
        verdict("samples", [SignificanceTest(0.25, "a")]).detail
        == "samples: one comparison; odds of one so far off by chance 0.25"
    )
    refuted = verdict("samples", [SignificanceTest(0.5, "here"), SignificanceTest(0.0, "there")])
    assert refuted.detail == "samples: 2 comparisons; refuted: chance brings one so far off with odds of 0.0e+00, at there"
    assert verdict("samples", [SignificanceTest(0.5, "a"), SignificanceTest(-1.0, "b")]).measured["odds"] == 0


def test_odds_count_both_sides() -> None:
    above, below = (p_value_of_mean(Estimate(np.array(1 + shift), np.array(0.1)), 1.0, 3) for shift in (0.2, -0.2))
    assert above == pytest.approx(below) == pytest.approx(1 - 2 / np.sqrt(2**2 + 2))  # of Student's t with 2 degrees of freedom


@pytest.mark.parametrize("alpha", [(0.7, 0.7), (0.8, 0.3)])
@pytest.mark.parametrize("corrected", [True, False])
def test_facets_turned_to_the_viewer_are_a_mean_over_gaussian_slopes(alpha: tuple[float, float], corrected: bool) -> None:
    """E max(cos + sin s, 0) of a normal slope s along the view, whose variance is that of both slopes and what they share."""
    family = GaussianField(512, *alpha, corrected=corrected)
    ax, ay = family.facet_alpha
    shared = family.facet_correlation * ax * ay / 2
    covariance = np.array([[ax * ax / 2, shared], [shared, ay * ay / 2]])
    for wo in spherical(np.radians([10.0, 60.0, 85.0]), [0.3, 2.0, 4.0]):
        spread, cosine = np.sqrt(wo[:2] @ covariance @ wo[:2]), wo[2]
        expected = cosine * norm.cdf(cosine / spread) + spread * norm.pdf(cosine / spread)
        assert significance_tests.front_facing_area(family, wo) == pytest.approx(expected, rel=1e-12)
        assert significance_tests.cosine(family, wo) == cosine
    assert significance_tests.front_facing_area(family, significance_tests.ABOVE) == 1


def test_shares_are_pooled_into_strips_about_the_axes_and_sixteen_squares() -> None:
    shares = np.random.default_rng(3).random((2, 14, 14))
    inside = shares[:, 1:-1, 1:-1]
    strips = [inside[:, :, k : 12 - k].sum(axis=(1, 2)) for k in range(6)] + [
        inside[:, k : 12 - k].sum(axis=(1, 2)) for k in range(6)
    ]
    squares = [inside[:, 3 * i : 3 * i + 3, 3 * j : 3 * j + 3].sum(axis=(1, 2)) for i in range(4) for j in range(4)]
    np.testing.assert_allclose(significance_tests.pooled(shares), np.transpose([*strips, *squares]), rtol=1e-13)
