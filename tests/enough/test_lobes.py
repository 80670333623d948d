"""Lobes in bins: rules against integrals that know no bins, walks against other walks, bounds against what they bound."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.confidence import ODDS, RARE, mean_bound, student
from microfacet.enough import lobes
from microfacet.enough.candidates import maskings
from microfacet.enough.lobes import COLUMNS, ROWS, SIDE, Reference, Ruled, bins, lobe_of, nodes, ruled, surface, walked
from microfacet.enough.scene import Point, Scene
from microfacet.surface.height_field import Hits
from microfacet.surface.lanes import ESCAPED
from samples import uniform
from scipy import integrate, stats

METAL, GLASS, WATER = mf.Conductor(0.2, 3.9), mf.Dielectric(1.5), mf.Dielectric(1 / 1.33)
WALKS = 1 << 15


def total(lobes: np.ndarray) -> np.ndarray:
    return lobes.sum(axis=(1, 2))


# --- rules ----------------------------------------------------------------------------------------------------------------


def test_bins_hold_equal_shares_of_the_normals_of_ggx() -> None:
    """Seen straight from above, each bin holds one in 96 of the visible normals, if all of it mirrors light up."""
    point, brdf = Point(0.1, 0.1, 0, 0), mf.Microfacet(mf.Smith(mf.GGX(0.1)))
    shares = lobe_of(lambda wo, wi: brdf.pdf(wo, wi) / wi[:, 2], Scene(0.1), point)
    np.testing.assert_allclose(shares[:-1], 1 / (ROWS * COLUMNS), rtol=1e-6)
    down = 0.1**2 / (1 + 0.1**2)  # steeper than 45 degrees
    np.testing.assert_allclose(shares[-1], (1 / ROWS - down) / COLUMNS, rtol=1e-6)


@pytest.mark.parametrize("point", [Point(0.5, 0.5, 40, 0), Point(0.6, 0.1, 60, 30), Point(0.1, 0.4, 20, 110)])
def test_a_direction_falls_into_the_bin_whose_nodes_surround_it(point: Point) -> None:
    (wi, weight, *_), fine = nodes(point), lobes.NODES
    up = weight > 1e-12  # rows beyond the last light are empty
    assert up.mean() > 0.7
    expected = np.arange(ROWS * COLUMNS).reshape(ROWS, 1, COLUMNS, 1) + np.zeros((1, fine, 1, fine), int)
    np.testing.assert_array_equal(bins(point, wi[up]), expected.ravel()[up])


PLACES = [(1e-4, 1e-4), (0.01, 0.01), (0.05, 0.05), (0.3, 0.3), (1, 1), (1, 0.1), (0.01, 1), (0.01, 1e-4)]
VIEWS = [(0, 0), (30, 0), (80, 90), (89, 45)]


@pytest.mark.slow
@pytest.mark.parametrize("fresnel", [None, METAL, GLASS], ids=["mirror", "metal", "glass"])
@pytest.mark.parametrize("masking", maskings())
def test_rules_are_as_near_as_they_say(masking: str, fresnel: Any) -> None:
    """Against the albedo by another rule."""
    for kind in (mf.GGX, mf.Beckmann):
        for alpha in PLACES:
            brdf = mf.Microfacet(maskings()[masking][1](kind(*alpha)), fresnel)
            for view in VIEWS:
                point = Point(*alpha, *view)
                found = ruled(brdf.evaluate, Scene(max(alpha), fresnel=fresnel), point)
                albedo, error = brdf.albedo_with_error(point.wo)
                assert abs(found.lobe.sum() - albedo) <= found.error().sum() + 1.5 * error + 1e-12
                assert found.error().sum() < 0.01


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.8])
@pytest.mark.parametrize("eta", [0.23, 0.4, 1 / 1.33])
def test_a_kink_is_within_the_error(kind: Any, alpha: float, eta: float) -> None:
    """Total reflection seen straight from above, against an integral over the slope that is split there."""
    scene = Scene(alpha, fresnel=mf.Dielectric(eta))
    brdf = mf.Microfacet(mf.Smith(kind(alpha)), scene.material)
    found, up = ruled(brdf.evaluate, scene, Point(alpha, alpha, 0, 0)), np.array([0.0, 0.0, 1.0])

    def ring(lean: float) -> float:  # of facets that lean so; the light leaves at twice the angle
        wi = np.array([math.sin(2 * lean), 0, math.cos(2 * lean)])
        return float(brdf.evaluate(up, wi)) * wi[2] * 2 * math.pi * math.sin(2 * lean) * 2

    kink = math.acos(math.sqrt(1 - eta**2))
    breaks = sorted({min(x, math.pi / 4) for x in (math.atan(alpha), math.atan(3 * alpha), kink)} - {math.pi / 4})
    albedo = integrate.quad(ring, 0, math.pi / 4, points=breaks, limit=500, epsabs=1e-10)[0]
    assert abs(found.lobe.sum() - albedo) <= found.error().sum() + 1e-8
    assert len(found.coarse) > 1
    assert found.error().sum() < 0.02


def test_what_two_lobes_share_is_no_error_of_their_difference() -> None:
    one, other = (Ruled(a, np.array([a + 1, a - 3])) for a in np.ones((2, ROWS, COLUMNS)))
    np.testing.assert_array_equal(one.error(other), 0)
    np.testing.assert_array_equal(one.error(), 3)
    np.testing.assert_array_equal(one.error(Ruled(other.lobe, other.coarse + 0.5)), 0.5)


def test_a_range_of_lights_and_its_rest_are_the_whole() -> None:
    rng = np.random.default_rng(1)
    theta, reach = rng.uniform(0, 90, 1000), rng.uniform(0, 10, 1000)
    near, far, whole = (Scene(0.5, light=r).illuminated_fraction(theta, reach) for r in ((0, 37), (37, 90), (0, 90)))
    np.testing.assert_array_equal(whole, 1)
    np.testing.assert_allclose(near + far, 1, atol=1e-12)
    assert ((near == 1) == (theta + reach <= 37)).all()
    half = Scene(0.5, light=(30, 37)).illuminated_fraction(np.array([37.0, 30.0, 33.0, 20.0]), np.array([1.0, 2.0, 0.0, 0.0]))
    np.testing.assert_allclose(half, [0.5, 0.5, 1, 0])


@pytest.mark.parametrize("light", [(0, 30), (20, 20.5), (50, 90), (0, 1e-9), (89.9999, 90)])
def test_light_in_a_range_is_what_samples_leave_there(light: tuple[float, float]) -> None:
    point, scene = Point(0.4, 0.4, 30, 0), Scene(0.4, light=light)
    brdf = mf.Microfacet(mf.Smith(mf.GGX(0.4)))
    wi = brdf.sample(point.wo, uniform(1 << 18, 4))
    weight = np.where(
        scene.illuminates(wi), brdf.weight(point.wo, wi) if hasattr(brdf, "weight") else weight_of(brdf, point.wo, wi), 0
    )
    found = ruled(brdf.evaluate, scene, point)
    error = found.error().sum() + 5 * weight.std() / 512 + 40 / (1 << 18)
    assert abs(found.lobe.sum() - weight.mean()) <= error
    assert found.error().sum() < 0.01


def weight_of(brdf: mf.Microfacet, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    return np.asarray(brdf.evaluate(wo, wi) * np.maximum(wi[:, 2], 0) / np.maximum(brdf.pdf(wo, wi), 1e-300))


# --- bounds ---------------------------------------------------------------------------------------------------------------


def test_constants_of_confidence_are_those_of_the_sources() -> None:
    assert ODDS == 1e-5
    assert pytest.approx(3 * math.log(3e5)) == RARE
    for parts in (2, 8, 32):
        assert 2 * stats.t.sf(student(parts), parts - 1) == pytest.approx(ODDS, rel=1e-6)
    assert mean_bound(4.0, 5.0, 100) == pytest.approx(math.sqrt(2 * math.log(3e5) * 0.04) + 0.05 * RARE)


def test_bounds_of_means_hold_for_what_is_rare() -> None:
    """Of draws that hardly ever find anything, none in ten thousand means is farther off than is said."""
    rng = np.random.default_rng(5)
    for often in (1e-4, 1e-3, 0.05, 0.5, 0.999):
        hits = rng.binomial(2000, often, 10_000) / 2000
        assert (abs(hits - often) <= mean_bound(hits * (1 - hits), 1.0, 2000)).all()
    assert mean_bound(0.25, 1.0, 1e6) < 6 * 0.5e-3


def reference(parts: np.ndarray, **more: Any) -> Reference:
    return Reference(parts, "walks", **more)


def multinomial(seed: int, share: np.ndarray, each: int = 500, parts: int = 32) -> np.ndarray:
    found = np.random.default_rng(seed).multinomial(each, share.ravel(), parts) / each
    return np.asarray(found.reshape(parts, ROWS, COLUMNS))


@pytest.mark.parametrize("narrow", [0.0, 3.0, 12.0])
def test_lobes_of_known_shares_are_within_their_bounds(narrow: float) -> None:
    share = np.exp(-narrow * np.linspace(0, 1, ROWS * COLUMNS)).reshape(ROWS, COLUMNS)
    share /= share.sum()
    one = np.arange(ROWS * COLUMNS).reshape(ROWS, COLUMNS) == 90
    height = np.linspace(-1, 2, ROWS * COLUMNS).reshape(ROWS, COLUMNS)
    off = []
    for seed in range(300):
        found = reference(multinomial(seed, share), drawn=1.0, rare=RARE / 16000, lossless=True)
        assert found.bound(total) < 1e-12
        for weigh in (one, height):
            of = partial(np.einsum, "ij,nij->n", weigh * 1.0)
            assert abs(of(found.lobe[None])[0] - (weigh * share).sum()) <= found.bound(of)
        apart = 0.5 * abs(found.lobe - share).sum()
        assert apart <= found.misplaced()
        off.append(apart / (found.misplaced() - RARE / 16000))
    assert 0.3 < np.mean(off) < 0.9  # it is near to what it bounds


def test_a_bound_counts_what_was_never_found() -> None:
    """Parts in which nothing was found scatter by nothing; and what is known of the light that was followed limits it."""
    nothing = np.zeros((32, ROWS, COLUMNS))
    rare = reference(nothing, drawn=0.2, rare=0.1)
    assert rare.bound(total) == pytest.approx(0.02)
    assert rare.misplaced() == pytest.approx(0.02)
    capped = reference(np.random.default_rng(1).uniform(0, 1e3, nothing.shape), drawn=0.2, rare=0.1, unknown=0.03)
    assert capped.bound(total) == pytest.approx(0.23)
    assert capped.misplaced() == pytest.approx(0.23)
    twice = reference(nothing, drawn=0.2, rare=0.1, unknown=0.03).bound(lambda lobes: -2 * total(lobes))
    assert twice == pytest.approx(0.1)
    assert reference(nothing, drawn=0.2, rare=0.1, lossless=True).bound(total) == 0
    assert reference(nothing, drawn=0.2, rare=0.1, lossless=True).bound(lambda lobes: lobes[:, 0, 0]) == pytest.approx(0.02)


def test_a_scatter_counts_in_student_s_measure() -> None:
    parts = np.zeros((4, ROWS, COLUMNS))
    parts[:, 2, 3] = [1, 2, 3, 4]
    spread = np.std([1, 2, 3, 4], ddof=1) / 2
    found = reference(parts, drawn=1e9)
    assert found.bound(total) == pytest.approx(student(4) * spread)
    apart = np.array([0.75, 0.25, 0.25, 0.75]) / math.sqrt(3)
    assert found.misplaced() == pytest.approx(0.5 + student(4) * np.std(apart, ddof=1) * math.sqrt(1.25) + apart.mean() - 0.5)


# --- the most complete model ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("alpha", [1e-4, 0.002, 0.005, 0.3, 1.0])
@pytest.mark.parametrize("walks", [2, 33, 1 << 12])
def test_mirrors_send_all_light_out_however_few_the_walks(alpha: float, walks: int) -> None:
    point = Point(alpha, alpha, 30, 0)
    found = walked(Scene(alpha), point, walks)
    rule = found.once.error().sum()
    assert abs(found.lobe.sum() - 1) <= rule + found.bound(total) + 1e-12
    albedo, off = mf.Microfacet(mf.Smith(mf.GGX(alpha))).albedo_with_error(point.wo)
    assert found.bound(total) < 1.01 * off + 1e-9
    assert np.ptp(total(found.lobes)) < 1e-12  # in each part as well, whatever its weights add up to
    assert found.lobe.sum() - found.once.lobe.sum() > 0.9 * (1 - albedo)


@pytest.mark.parametrize("fresnel", [METAL, GLASS, WATER], ids=["metal", "glass", "water"])
@pytest.mark.parametrize("point", [Point(0.3, 0.3, 60, 0), Point(1, 1, 20, 0), Point(0.9, 0.3, 40, 30)])
def test_later_bounces_fall_where_all_walks_put_them(fresnel: Any, point: Point) -> None:
    """Bin by bin, against walks of which most leave at once; and fewer walks are as near as they say."""
    scene = Scene(max(point[:2]), fresnel=fresnel)
    found, few = (walked(scene, point, walks) for walks in (1 << 17, 200))
    count = 1 << 19
    wi, light, bounces = mf.RandomWalk(mf.Smith(mf.GGX(*point[:2])), fresnel).walk(point.wo, uniform(count, 8))
    more = bounces > 1
    by_walks = np.bincount(bins(point, wi[more]), light[more], ROWS * COLUMNS).reshape(ROWS, COLUMNS) / count
    square = np.bincount(bins(point, wi[more]), light[more] ** 2, ROWS * COLUMNS).reshape(ROWS, COLUMNS) / count
    if point.isotropic:
        by_walks, square = ((a + a[:, ::-1]) / 2 for a in (by_walks, square))
    later = found.lobe - found.once.lobe
    each = np.array([found.bound(lambda lobes, b=b: lobes.reshape(len(lobes), -1)[:, b]) for b in range(ROWS * COLUMNS)])
    assert (abs(later - by_walks) <= each.reshape(ROWS, COLUMNS) + 5 * np.sqrt(square / count) + RARE / count).all()
    assert abs(later.sum() - by_walks.sum()) <= found.bound(total) + 5 * math.sqrt(square.sum() / count)
    apart = 0.5 * abs(few.lobe - found.lobe).sum()
    assert apart <= few.misplaced() + found.misplaced()
    assert found.misplaced() < few.misplaced() / 3
    assert abs(few.lobe.sum() - found.lobe.sum()) <= few.bound(total) + found.bound(total)
    assert found.bound(total) < few.bound(total) / 5


def test_light_still_under_way_is_unknown() -> None:
    """Of so rough a surface hardly any walk ends."""
    found = walked(Scene(1e3), Point(1e3, 1e3, 30, 0), 64)
    assert found.lobe.sum() < 0.2
    assert found.bound(total) + found.lobe.sum() >= 1 - 1e-6
    metal = walked(Scene(1e3, fresnel=METAL), Point(1e3, 1e3, 30, 0), 64)
    assert metal.unknown < 1e-3  # there it is used up


def test_one_bounce_needs_no_walk() -> None:
    found = walked(Scene(0.3, bounces="one"), Point(0.3, 0.3, 40, 0), 2)
    assert found.bound(total) == found.misplaced() == 0
    np.testing.assert_array_equal(found.lobe, found.once.lobe)
    assert found.label == "Smith's model"


@pytest.mark.slow
def test_rays_start_one_in_each_square_of_a_grid() -> None:
    """Evenly within it, so that all of a surface is seen alike."""

    class Pierced:
        size, highest = 512, 3.0

        def trace(self, origins: np.ndarray, directions: np.ndarray, facets: np.ndarray) -> Hits:
            self.origins = origins
            return Hits(np.full(len(origins), ESCAPED), np.full(len(origins), np.inf))

    field: Any = Pierced()
    lobes._traced(field, Scene(0.5, normals="beckmann"), Point(0.5, 0.5, 40.0, 0.0), 0)
    places = field.origins[:, :2] * SIDE / field.size
    squares = np.floor(places)
    assert len(np.unique(squares, axis=0)) == SIDE**2
    assert (squares.min(), squares.max()) == (0, SIDE - 1)
    assert stats.kstest((places - squares).ravel(), "uniform").pvalue > 1e-4
    assert (field.origins[:, 2] == field.highest).all()


def test_surfaces_say_what_rays_may_have_missed() -> None:
    point = Point(0.3, 0.3, 0, 0)
    found = surface(Scene(0.3, normals="beckmann", fresnel=METAL), point, 2)
    assert found.rare == pytest.approx(RARE / (2 * SIDE**2))
    assert found.bound(total) >= found.rare
    assert not found.lossless
    assert found.label == "2 ray-traced surfaces"
    mirrors = surface(Scene(0.3, normals="beckmann"), point, 2)
    assert mirrors.bound(total) < 1e-12
    assert found.unknown == mirrors.unknown == 0
