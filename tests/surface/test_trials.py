"""Trials know their odds: a right statement passes, one that is off by a per cent or two is refuted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import microfacet as mf
import numpy as np
import pytest
from microfacet.brdf.specular import Microfacet
from microfacet.directions import spherical
from microfacet.surface import trials
from microfacet.surface.campaign import Entry
from microfacet.surface.compare import normals_of
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.measure import Estimate, Measurement, Plan, shard
from microfacet.surface.trials import Look, off, verdict

SURFACES = 24


@pytest.fixture(scope="module")
def small() -> tuple[Entry, Measurement]:
    views = [trials.ABOVE, *spherical(np.radians([60.0, 80.0]), 0.7)]
    entry = Entry(GaussianField(128, 0.7, root=11), Plan(np.array(views), side=96, bounces=0))
    return entry, shard(entry.family, entry.plan, 0, SURFACES)


@pytest.fixture
def campaign(small: tuple[Entry, Measurement], monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    entry, found = small
    monkeypatch.setattr(trials, "ENTRIES", ("small",))
    monkeypatch.setattr(trials, "CAMPAIGN", {"small": entry})
    monkeypatch.setattr(trials, "read", lambda name: found)
    monkeypatch.setattr(trials, "SAMPLES", 60_000)
    trials.uniform.cache_clear()
    yield
    trials.uniform.cache_clear()


def wider(plan: Plan, factor: float) -> Plan:
    """Bins that hold what bins of slopes so many times as large would."""
    return replace(plan, reach=factor * plan.reach)


def test_trials_are_of_statements() -> None:
    assert set(trials.TRIALS) <= set(mf.equations)


@pytest.mark.slow
@pytest.mark.parametrize("key", trials.TRIALS)
def test_every_trial_passes(key: str, campaign: None) -> None:
    what, looks = trials.TRIALS[key]
    mark = verdict(what, looks())
    assert mark.status == "pass", mark.detail
    assert mark.measured["count"] >= 1


@pytest.mark.usefixtures("campaign")
def test_an_area_off_by_two_per_cent_is_refuted() -> None:
    looks = trials.over_views("seen", lambda family, wo: 1.02 * trials.cosine(family, wo))
    mark = verdict("surfaces", looks)
    assert mark.status == "fail"
    assert "refuted" in mark.detail


@pytest.mark.usefixtures("campaign")
@pytest.mark.parametrize("wrong", [(mf.Beckmann, 1.15), (mf.GGX, 1.0)])
def test_slopes_of_another_distribution_are_refuted(wrong: tuple[type, float], monkeypatch: pytest.MonkeyPatch) -> None:
    kind, factor = wrong
    monkeypatch.setattr(trials, "normals_of", lambda model, wo, plan: normals_of(mf.Smith(kind(0.7)), wo, wider(plan, factor)))
    assert verdict("surfaces", trials.slopes_seen_from_above()).status == "fail"


def test_a_sampler_with_swapped_axes_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    swapped = mf.GGX(0.2, 0.5).sample
    monkeypatch.setattr(mf.GGX, "sample", lambda self, u: swapped(u))
    assert verdict("samples", trials.drawn(mf.GGX(0.5, 0.2))).status == "fail"


def test_a_density_off_by_two_in_a_thousand_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    density = Microfacet.pdf
    assert verdict("samples", trials.weighed(mf.GGX(1.0), albedo=trials.exact_albedo)).status == "pass"
    monkeypatch.setattr(Microfacet, "pdf", lambda self, wo, wi: 1.002 * density(self, wo, wi))
    for albedo, ndf in ((Microfacet.albedo, mf.Beckmann(0.4)), (trials.exact_albedo, mf.GGX(1.0))):
        assert verdict("samples", trials.weighed(ndf, albedo=albedo)).status == "fail"


def test_odds_are_students() -> None:
    """With 5 surfaces a mean 2.776 standard errors off comes by chance once in 20."""
    assert off(Estimate(np.array(1.0 + 2.776e-3), np.array(1e-3)), 1.0, 5) == pytest.approx(0.05, rel=1e-3)
    assert off(Estimate(np.array(1.0), np.array(0.0)), 1.0, 5) == 1.0
    assert off(Estimate(np.array(1.0), np.array(0.0)), 1.1, 5) == 0.0


def test_looking_often_makes_chance_likelier() -> None:
    assert verdict("surfaces", [Look(0.01, "a"), Look(0.5, "b")]).measured["odds"] == 0.02
    assert verdict("surfaces", [Look(5e-7, "a")]).status == "fail"
    assert verdict("surfaces", [Look(5e-7, "a")] * 10).status == "pass"


def test_what_is_no_number_is_refuted() -> None:
    assert verdict("surfaces", [Look(0.5, "a"), Look(float("nan"), "b")]).status == "fail"
