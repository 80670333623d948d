"""Light of later bounces made up for: all of it comes back for F = 1, and what is added is what is stated."""

from __future__ import annotations

from typing import Any

import microfacet as mf
import numpy as np
import pytest
import rays
from albedos import index, view
from microfacet.brdf.compensation import FORMS
from microfacet.directions import spherical
from samples import UP, hemisphere, views

pytestmark = pytest.mark.xdist_group("brdf")

SINGLES = [mf.Microfacet(mf.Smith(ndf)) for ndf in (mf.GGX(1.0), mf.GGX(0.02), mf.Beckmann(0.5), mf.GGX(0.5, 0.2))]
VIEWS = views(0, 40, 75, 89)


def furnace(brdf: Any, wo: np.ndarray) -> float:
    """The albedo by a rule over the hemisphere, for rough surfaces."""
    t, w = np.polynomial.legendre.leggauss(256)
    cosine, turn = (t + 1) / 2, 2 * np.pi * (np.arange(256) + 0.5) / 256
    wi = spherical(np.arccos(cosine)[:, None], turn)
    return float(np.sum(brdf.evaluate(wo, wi) * (w / 2 * cosine)[:, None]) * 2 * np.pi / 256)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("single", [SINGLES[0], SINGLES[2], SINGLES[3]], ids=repr)
def test_perfect_mirrors_return_all_light(single: mf.Microfacet, form: str) -> None:
    brdf = mf.Compensated(single, form)
    np.testing.assert_allclose(brdf.albedo(VIEWS), 1, rtol=1e-12)
    for wo in VIEWS[:3]:
        assert furnace(brdf, wo) == pytest.approx(1, abs=2e-4)
        assert furnace(single, wo) < 0.999


@pytest.mark.slow
@pytest.mark.parametrize("single", SINGLES, ids=repr)
def test_the_table_is_the_albedo(single: mf.Microfacet) -> None:
    brdf, wo, wi = mf.Compensated(single), hemisphere(200, 1), hemisphere(200, 2)
    lacking = (1 - single.albedo(wo)) * (1 - single.albedo(wi))
    factor = np.pi * (1 - brdf.mean_albedo)
    lobe = (brdf.evaluate(wo, wi) - single.evaluate(wo, wi)) * factor
    np.testing.assert_allclose(lobe, lacking, atol=2e-5, rtol=1e-9)


EQUAL = [(alpha, alpha) for alpha in (1e-8, 1e-6, 1e-4, 1e-3, 0.03, 1.0, 30.0, 1e3)]
STRETCHED = [(1e-8, 4e-8), (1e-4, 1e-3), (0.1, 0.5), (1.0, 0.01)]


def added(brdf: mf.Compensated, wo: np.ndarray) -> float:
    """The albedo of the lobe alone, by a rule that resolves cosines of any size."""
    t, w = np.polynomial.legendre.leggauss(96)
    v, turn = 5 * (t[:, None] + 1) / 2, 2 * np.pi * (np.arange(128) + 0.37) / 128
    wi = spherical(np.arctan(np.sqrt(np.expm1(2 * v * v))), turn)
    light = (brdf.evaluate(wo, wi) - brdf.brdf.evaluate(wo, wi)) * wi[..., 2] ** 2
    return float(np.sum(light * w[:, None] * v) * 10 * np.pi / 128)


@pytest.mark.parametrize("alphas", EQUAL + STRETCHED, ids=str)
def test_the_lobe_holds_what_is_missing_at_every_roughness(alphas: tuple[float, float]) -> None:
    """No light is created where hardly any is missing: 1 - E is 1e-16 at the smallest roughness."""
    single = mf.Microfacet(mf.Smith(mf.GGX(*alphas)))
    brdf, allowed = mf.Compensated(single), 5e-4 if alphas in STRETCHED else 1e-4
    for wo in (*views(0, 37, 80, azimuth=0.3), spherical(np.pi / 2 - alphas[1] / (1 + alphas[1]) ** 2)):
        assert added(brdf, wo) == pytest.approx(1 - float(single.albedo(wo)), abs=allowed)
    assert added(brdf, views(37)[0]) < 1 - single.albedo(views(37)[0]) + allowed * min(1, 1e3 * max(alphas))


@pytest.mark.parametrize("alphas", EQUAL + STRETCHED, ids=str)
def test_one_bounce_is_made_brighter_by_what_its_albedo_lacks(alphas: tuple[float, float]) -> None:
    """Which makes the albedo 1, also where one bounce keeps a billionth of the light."""
    single = mf.Microfacet(mf.Smith(mf.GGX(*alphas)))
    wo = views(0, 37, 80, 89)
    brighter = mf.Compensated(single, "scaled").evaluate(wo, wo * [-1, -1, 1]) / single.evaluate(wo, wo * [-1, -1, 1])
    np.testing.assert_allclose(brighter * single.albedo(wo), 1, atol=5e-3 if max(alphas) > 10 else 1e-3)


def random_single(g: np.random.Generator) -> mf.Microfacet:
    """One in five of unequal roughness."""
    first = float(10 ** g.uniform(-6, 0.5))
    second = float(first * 10 ** g.uniform(-3, 1)) if g.random() < 0.2 else first
    family, model = (mf.GGX, mf.Beckmann)[g.integers(2)], (mf.Smith, mf.VCavity)[g.integers(2)]
    reflectances = (mf.Dielectric(index(g)), mf.Conductor(index(g), float(10 ** g.uniform(-6, 1))), None)
    return mf.Microfacet(model(family(first, second)), reflectances[g.integers(3)])


def made(single: mf.Microfacet, form: str) -> Any:
    """None where the albedo is not known well enough, which is refused."""
    try:
        return mf.Compensated(single, form)
    except ValueError:
        return None


def mean_over_cosines(function: Any, kink: float = 0.0) -> float:
    """Of a function of the cosine over light from everywhere, by Gauss's rule in pieces even in the logarithm."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    ends = np.array([0, *np.logspace(-8, -1, 8), *np.linspace(0.19, 1, 10)])
    if kink > 0:
        beside = kink + np.concatenate([-np.logspace(-9, -1, 17), [0], np.logspace(-9, -1, 17)])
        ends = np.unique(np.concatenate([ends, beside[(beside > 0) & (beside < 1)]]))
    low, size = ends[:-1, None], np.diff(ends)[:, None]
    cosine = (low + size * (nodes + 1) / 2).ravel()
    return float(np.sum((weights * size).ravel() * cosine * function(cosine)))


def mean_ratios(single: mf.Microfacet, wo: np.ndarray, known: float, off: float) -> list[float]:
    """Errors of the mean albedo and of the compensated one over what is told of them."""
    whole, mirrors = mf.Compensated(single), mf.Microfacet(single.model)
    E = mean_over_cosines(lambda z: mirrors.albedo(spherical(np.arccos(z))))
    n = complex(*single.fresnel.parameters) if single.fresnel.parameters else 1.0
    F = mean_over_cosines(single.fresnel.F, np.sqrt(max((1 - n * n).real, 0.0)))  # total reflection begins there
    once, unsure = rays.albedo(single, wo, float(single.albedo(wo)), 1e-9)
    right = once + F**2 * E / (1 - F * (1 - E)) * (1 - known)
    value, told = whole.albedo_with_error(wo)
    return [abs(whole.mean_albedo - E) / whole.off, (abs(value - right) - unsure - off) / told]


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_what_is_told_bounds_the_error_of_series_and_means(part: int) -> None:
    """100 random cases in all parts. The albedo is that of another sum, in directions that the series was not made of."""
    ratios, refused = [], 0
    for k in range(part, 100, 4):
        g = np.random.default_rng(k)
        single = random_single(g)
        mirrors, wo = mf.Microfacet(single.model), view(None, g)
        known, off = rays.albedo(mirrors, wo, float(mirrors.albedo(wo)), 1e-9)
        if scaled := made(mirrors, "scaled"):
            way = wo * [-1, -1, 1]
            kept = float(mirrors.evaluate(wo, way) / scaled.evaluate(wo, way))
            ratios.append((abs(kept - known) - off) / (scaled.off * known))
        refused += scaled is None
        if single.model.ndf.isotropic and made(single, "lobe"):
            ratios += mean_ratios(single, wo, known, off)
    print(f"largest {max(ratios):.2g} of {len(ratios)}, refused {refused}")
    assert max(ratios) <= 1, ratios
    assert refused <= 3


def test_models_that_create_light_are_refused() -> None:
    for form in FORMS:
        with pytest.raises(ValueError, match="a model that reflects more light than it gets cannot be compensated"):
            mf.Compensated(mf.Microfacet(mf.SchlickSmith(mf.GGX(1.0), k=1e-3)), form)


def test_scaling_is_refused_where_the_albedo_is_not_known_well_enough() -> None:
    rough = mf.Microfacet(mf.Smith(mf.GGX(30.0, 3.0)))
    with pytest.raises(ValueError, match=r"the albedo of Smith.* is known to .* % only, too little for 'scaled'"):
        mf.Compensated(rough, "scaled")
    assert (mf.Compensated(rough).evaluate(VIEWS, UP) > 0).all()


def test_mean_albedo_at_the_exact_point() -> None:
    assert mf.Compensated(SINGLES[0]).mean_albedo == pytest.approx(4 / 3 * (1 - np.log(2)), rel=1e-6)


def test_only_the_lobe_lets_light_and_viewer_change_places() -> None:
    wo, wi = hemisphere(100, 3), hemisphere(100, 4)
    for form, allowed in (("lobe", True), ("scaled", False)):
        brdf = mf.Compensated(SINGLES[0], form)
        assert np.allclose(brdf.evaluate(wo, wi), brdf.evaluate(wi, wo), rtol=1e-9) == allowed


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_metals_gain_less_than_mirrors_and_stay_below_one(form: str) -> None:
    """And the albedo is the integral of the lobe; facets that reflect at grazing angles only gain next to nothing."""
    metal = mf.Microfacet(SINGLES[0].model, mf.Schlick(0.6))
    brdf, mirrors = mf.Compensated(metal, form), mf.Compensated(SINGLES[0], form)
    gain = brdf.albedo(VIEWS) - metal.albedo(VIEWS)
    assert ((gain > 0) & (gain < mirrors.albedo(VIEWS) - SINGLES[0].albedo(VIEWS)) & (brdf.albedo(VIEWS) < 1)).all()
    assert furnace(brdf, VIEWS[1]) == pytest.approx(float(brdf.albedo(VIEWS[1])), abs=2e-4)
    black = mf.Microfacet(SINGLES[0].model, mf.Schlick(1e-12))
    np.testing.assert_allclose(mf.Compensated(black, form).albedo(UP), black.albedo(UP), atol=2e-3)


@pytest.mark.slow
def test_nearer_to_the_walk_than_one_bounce() -> None:
    model = mf.Smith(mf.GGX(0.5))
    metal = mf.Microfacet(model, mf.Conductor(0.18, 3.4))
    whole = mf.RandomWalk(model, metal.fresnel).albedo(VIEWS[:3], 1 << 15)
    once = whole - metal.albedo(VIEWS[:3])
    assert (once > 0.05).all()
    for form in FORMS:
        assert (abs(whole - mf.Compensated(metal, form).albedo(VIEWS[:3])) < 0.25 * once).all()


def test_below_the_horizon_and_single_precision() -> None:
    brdf = mf.Compensated(SINGLES[0])
    assert brdf.evaluate([0.6, 0, -0.8], UP) == brdf.evaluate(UP, [0.6, 0, -0.8]) == 0
    single = brdf.evaluate(VIEWS.astype(np.float32), UP.astype(np.float32))
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, brdf.evaluate(VIEWS, UP), rtol=1e-3)


def test_wrong_arguments_are_named() -> None:
    with pytest.raises(ValueError, match="form must be one of lobe, scaled, got 'more'"):
        mf.Compensated(SINGLES[0], "more")
    with pytest.raises(ValueError, match="brdf must be a BRDF of one bounce"):
        mf.Compensated(SINGLES[0].model)  # type: ignore[arg-type]
