"""Matt facets: against a sum over the sphere, in the limits, and against Oren and Nayar."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from around import whole_hemisphere
from matt import by_lines
from microfacet.brdf import diffuse
from microfacet.directions import spherical
from microfacet.statements import checks
from samples import UP, hemisphere, views

SMITH, CAVITIES = mf.Smith(mf.Beckmann(0.5)), mf.VCavity(mf.GGX(0.5, 0.2))
MODELS = [SMITH, CAVITIES]
LIGHT = spherical(np.radians([10.0, 40.0, 65.0]), np.radians([200.0, 35.0, 110.0]))


def by_normals(model: Any, wo: np.ndarray, wi: np.ndarray) -> float:
    """The definition, over the sphere, with no edge at its place: few digits."""
    patch = whole_hemisphere(0.5, 200, 800)
    m = patch.directions
    seen, lit = np.maximum(m @ wo, 0), np.maximum(m @ wi, 0)
    return patch.sum(seen * lit * model.G2(wo, wi, m) * model.ndf.D(m)) / (np.pi * wo[2] * wi[2])


@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_value_by_its_definition(model: Any) -> None:
    brdf = mf.Diffuse(model)
    for wo in views(0, 50, 75):
        value, error = brdf.evaluate_with_error(wo, LIGHT)
        expected = [by_normals(model, wo, wi) for wi in LIGHT]
        np.testing.assert_allclose(value, expected, rtol=3e-4)
        assert (error < 1e-4 * value).all()


@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_reciprocal_nowhere_negative_and_nothing_through_the_surface(model: Any) -> None:
    brdf = mf.Diffuse(model)
    wo, wi = hemisphere(40, 1), hemisphere(40, 2)
    value, back = brdf.evaluate(wo, wi), brdf.evaluate(wi, wo)
    np.testing.assert_allclose(value, back, rtol=1e-9)
    assert (value > 0).all()
    down = np.array([1, 1, -1])
    for o, i in ((wo * down, wi), (wo, wi * down), ([1.0, 0, 0], wi)):
        np.testing.assert_array_equal(brdf.evaluate(o, i), 0)


def test_without_roughness_a_matt_plane() -> None:
    brdf = mf.Diffuse(mf.Smith(mf.Beckmann(1e-5)))
    np.testing.assert_allclose(brdf.evaluate(views(0, 40, 70), LIGHT), 1 / np.pi, rtol=1e-4)
    assert brdf.albedo(views(40)[0]) == pytest.approx(1, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_no_more_light_leaves_than_arrives(model: Any) -> None:
    """What is missing meets a second facet, as it does for mirrors."""
    value, error = mf.Diffuse(model).albedo_with_error(views(0, 60))
    assert ((value > 0.5) & (value < 1)).all()
    assert (error < 1e-3).all()


def test_facets_that_keep_some_light() -> None:
    half, whole = mf.Diffuse(CAVITIES, 0.5), mf.Diffuse(CAVITIES)
    wo = views(30)[0]
    np.testing.assert_allclose(half.evaluate(wo, LIGHT), whole.evaluate(wo, LIGHT) / 2, rtol=1e-15)


def test_single_precision_in_gives_single_precision_out() -> None:
    brdf = mf.Diffuse(CAVITIES)
    value = brdf.evaluate(UP.astype(np.float32), LIGHT.astype(np.float32))
    assert value.dtype == np.float32
    np.testing.assert_allclose(value, brdf.evaluate(UP, LIGHT), rtol=1e-4)


def test_brighter_against_the_light_than_from_it() -> None:
    """Oren and Nayar's observation: looking along the light, one sees the lit sides."""
    along, against = views(60, azimuth=35)[0], views(60, azimuth=215)[0]
    light = views(60, azimuth=35)[0]
    brdf = mf.Diffuse(SMITH)
    assert brdf.evaluate(along, light) > 1.3 * brdf.evaluate(against, light)


def test_oren_and_nayars_fit_is_near_their_cavities() -> None:
    """Small angles of spread sigma are Beckmann slopes of alpha = sqrt(2) sigma; with V-cavities, and some 10 % apart."""
    fit = mf.equations["brdf.diffuse.oren_nayar"].kernel
    sigma = np.radians(20)
    brdf = mf.Diffuse(mf.VCavity(mf.Beckmann(np.sqrt(2) * sigma)))
    for theta_o, theta_i, phi in ((0.2, 0.7, 0.0), (0.9, 0.5, 0.0), (0.6, 0.6, 1.5), (1.1, 1.1, 0.0)):
        exact = float(brdf.evaluate(spherical(theta_o), spherical(theta_i, phi)))
        assert float(fit(theta_o, theta_i, phi, sigma)) == pytest.approx(exact, rel=0.1)


def test_albedo_of_a_facet_may_be_of_single_precision() -> None:
    assert mf.Diffuse(SMITH, np.float32(0.5)).facet_albedo == 0.5


def test_single_precision_is_as_near_as_it_says() -> None:
    """Albedo and BRDF, of facets that are matt and of mirrors, from straight above to grazing, where the BRDF is large."""
    views = spherical(np.radians([0, 20, 60, 85, 89.9]), 0.6).astype(np.float32)
    matt, mirrors = mf.Diffuse(SMITH), mf.Microfacet(SMITH)
    calls = [matt.albedo_with_error, mirrors.albedo_with_error, lambda wo: matt.evaluate_with_error(wo[:, None], wo)]
    for call in calls:
        value, error = call(views)
        assert value.dtype == error.dtype == np.float32
        assert (abs(value - call(views.astype(float))[0]) <= error).all()


@pytest.mark.parametrize("wrong", [0, 1.5, -1, np.nan, "white", True])
def test_albedo_of_a_facet_is_a_share(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"albedo must (lie in \(0, 1\]|be a (finite )?number above 0), got"):
        mf.Diffuse(SMITH, wrong)
    with pytest.raises(ValueError, match="model must be a model of masking"):
        mf.Diffuse(mf.GGX(0.3))  # type: ignore[arg-type]


@pytest.mark.parametrize("key", ["rho", "flat", "energy", "lambert"])
def test_a_statement_off_by_a_millionth_is_red(monkeypatch: pytest.MonkeyPatch, key: str) -> None:
    statement = mf.equations[f"brdf.diffuse.{key}"]
    monkeypatch.setitem(statement.__dict__, "equals", statement.equals * 1000001 / 1000000)
    assert checks.symbolic(statement).status == "fail"


# --- all roughnesses, all directions --------------------------------------------------------------------------------------

RIGHT = 1e-6  # relative, of the value


def anything(count: int, seed: int) -> Iterator[tuple[Any, np.ndarray, np.ndarray]]:
    """Models and pairs of directions: roughness from 1e-8 to 1e3, ratios up to 1e4, heights down to 1e-8.

    Many pairs both graze; many lie in one plane, on one side or opposite, or nearly so.
    """
    g = np.random.default_rng(seed)
    for _ in range(count):
        alpha = 10 ** g.uniform(-8, 3)
        other = np.clip(alpha * 10 ** g.uniform(-4, 4), 1e-8, 1e3) if g.integers(2) else alpha
        make, masking = (mf.GGX, mf.Beckmann)[g.integers(2)], (mf.Smith, mf.VCavity)[int(g.integers(8) == 0)]
        heights = [(1.0, g.uniform(0, 1), 10 ** g.uniform(-8, 0), 1e-8)[g.choice(4, p=(0.05, 0.35, 0.4, 0.2))] for _ in "oi"]
        azimuth = g.uniform(0, 2 * np.pi)
        apart = (0.0, np.pi, g.uniform(0, 2 * np.pi), np.pi + 10 ** g.uniform(-10, 0))[g.integers(4)]
        wo, wi = (_at(height, turn) for height, turn in zip(heights, (azimuth, azimuth + apart), strict=True))
        yield masking(make(alpha, other)), wo, wi


def _at(height: float, azimuth: float) -> np.ndarray:
    """A direction whose height keeps its digits near the horizon."""
    across = np.sqrt((1 - height) * (1 + height))
    return np.array([across * np.cos(azimuth), across * np.sin(azimuth), height])


def off_by(cases: Iterable[tuple[Any, np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """How far values are off another sum, over the error told, and over the value."""
    found = []
    for model, wo, wi in cases:
        value, error = mf.Diffuse(model).evaluate_with_error(wo, wi)
        off = abs(value - by_lines(model, wo, wi))
        found.append((off / error, off / value))
    ratios, relative = np.array(found).T
    print(f"off over told: median {np.median(ratios):.2g}, largest {ratios.max():.2g}")
    print(f"off, relative: median {np.median(relative):.2g}, largest {relative.max():.2g}")
    return ratios, relative


def test_six_digits_and_a_bound() -> None:
    smooth = [case for case in anything(30, 6) if isinstance(case[0], mf.Smith)]
    ratios, relative = off_by(smooth)
    assert ratios.max() < 1
    assert relative.max() < RIGHT


@pytest.mark.slow
def test_six_digits_and_a_bound_of_many() -> None:
    ratios, relative = off_by(anything(300, 2))
    assert ratios.max() < 1
    assert relative.max() < RIGHT


def test_both_directions_graze() -> None:
    grazing = [
        (model, _at(1e-8, 0.3), _at(1e-8, 0.3 + apart))
        for model in (mf.Smith(mf.GGX(0.3)), mf.Smith(mf.Beckmann(1e-8, 1e-4)), mf.Smith(mf.GGX(10.0)))
        for apart in (0.0, 0.4, np.pi)
    ]
    ratios, relative = off_by(grazing)
    assert ratios.max() < 1
    assert relative.max() < RIGHT


def test_rules_of_fewer_digits_are_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the panels' halving, values are off by more than they may be, and the error says so."""
    monkeypatch.setattr(diffuse, "ROUNDS", 0)
    ratios, relative = off_by(case for case in anything(30, 6) if isinstance(case[0], mf.Smith))
    assert relative.max() > RIGHT
    assert ratios.max() < 1


def test_single_precision_is_the_double_one_rounded() -> None:
    """Of directions that single precision holds, values are off the other sum by no more than is told."""
    for model, wo, wi in anything(20, 8):
        near = [w.astype(np.float32) for w in (wo, wi)]
        value, error = mf.Diffuse(model).evaluate_with_error(*near)
        exact, apart = mf.Diffuse(model).evaluate_with_error(*(w.astype(float) for w in near))
        assert value.dtype == error.dtype == np.float32
        assert abs(float(value) - exact) <= error + apart


def test_a_flat_matt_plane_sends_on_all_that_it_gets() -> None:
    value, error = mf.Diffuse(mf.Smith(mf.Beckmann(1e-8))).albedo_with_error(views(0, 40))
    assert (abs(value - 1) <= error).all()
    assert (error < 1e-7).all()
