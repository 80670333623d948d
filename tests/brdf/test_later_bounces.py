"""Walks that go on after the first bounce: as many as quadrature says, and such as all walks have among them."""

from __future__ import annotations

from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.brdf.later_bounces import SecondFacets
from microfacet.directions import spherical
from samples import uniform

pytestmark = pytest.mark.xdist_group("brdf")

COUNT, SIGMAS = 1 << 17, 4.5
PLACES = [  # alpha_x, alpha_y, polar angle and azimuth of the view in degrees
    (1e-6, 1e-6, 30, 0),
    (1e-4, 1e-4, 0, 0),
    (1e-4, 1e-4, 89, 0),
    (0.002, 0.002, 0, 0),
    (0.005, 0.005, 30, 0),
    (0.3, 0.3, 0, 0),
    (0.3, 0.3, 80, 0),
    (1.0, 1.0, 40, 0),
    (1.0, 0.01, 60, 30),
    (0.01, 0.2, 89, 70),
    (10.0, 1.0, 30, 0),
]


def model_of(kind: Any, place: tuple[float, ...]) -> tuple[mf.Smith, np.ndarray]:
    return mf.Smith(kind(*place[:2])), spherical(*np.radians(place[2:]))


@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
def test_weights_have_the_chance_to_go_on_as_their_mean(kind: Any, place: tuple[float, ...]) -> None:
    """Against one less the albedo of mirrors, by quadrature: wrong densities, weights or chances do not have this mean."""
    model, wo = model_of(kind, place)
    weight = SecondFacets(model, wo).draw(COUNT, np.random.default_rng(3)).weight
    once, error = mf.Microfacet(model).albedo_with_error(wo)
    scatter = weight.std() / np.sqrt(COUNT)
    assert abs(weight.mean() - (1 - once)) < SIGMAS * scatter + error + 1e-12
    assert scatter <= 0.02 * weight.mean()  # and few walks do not carry it all
    assert (weight >= 0).all()


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@pytest.mark.parametrize("place", [(0.6, 0.6, 50, 0), (0.9, 0.3, 20, 60), (0.4, 0.4, 80, 0)], ids=str)
def test_they_end_as_those_do_that_go_on_among_all_walks(kind: Any, place: tuple[float, ...]) -> None:
    """Where they leave, after how many bounces, and what metal leaves of their light."""
    model, wo = model_of(kind, place)
    walk = mf.RandomWalk(model, mf.Conductor(0.2, 3.9))
    wi, light, bounces = walk.walk(wo, uniform(1 << 18, 5))
    more = bounces > 1
    among = [f[more] for f in functions(wi, light, bounces)]
    found = walk.later(wo, COUNT, 6)
    share = found.counts / found.counts.mean()
    for values, drawn in zip(among, functions(found.wi, found.weight, found.bounces), strict=True):
        error = np.hypot(values.std() / np.sqrt(values.size), (share * (drawn - drawn.mean())).std() / np.sqrt(COUNT))
        assert abs((share * drawn).mean() - values.mean()) < SIGMAS * error


def functions(wi: np.ndarray, light: np.ndarray, bounces: np.ndarray) -> list[np.ndarray]:
    return [wi[:, 0], wi[:, 1], wi[:, 2], wi[:, 2] ** 2, light, (bounces == 2) * 1.0, (bounces == 3) * 1.0, bounces * 1.0]


@pytest.mark.parametrize("fresnel", [None, mf.Conductor(0.2, 3.9), mf.Dielectric(1.5)], ids=["mirror", "metal", "glass"])
@pytest.mark.parametrize("place", [(0.005, 0.005, 0, 0), (0.3, 0.3, 80, 0), (1.0, 0.1, 60, 30)], ids=str)
def test_the_albedo_is_off_by_no_more_than_it_says(fresnel: Any, place: tuple[float, ...]) -> None:
    """By walks of another seed and kind, and for mirrors by energy; and the error shrinks with the walks."""
    model, wo = model_of(mf.GGX, place)
    walk = mf.RandomWalk(model, fresnel)
    truth = walk.albedo_by_bounce(wo, 1 << 20, 9)
    value, error = walk.albedo_with_error(wo)
    whole = truth.value.sum() + truth.more
    assert abs(value - whole) < error + SIGMAS * np.hypot(np.linalg.norm(truth.error), truth.more_error)
    if fresnel is None:
        assert abs(value - 1) <= error < 1e-4
    else:
        few, many = (walk.albedo_with_error(wo, count) for count in (1 << 8, 1 << 18))
        quadrature = mf.Microfacet(model, fresnel).albedo_with_error(wo)[1] + mf.Microfacet(model).albedo_with_error(wo)[1]
        assert (error - quadrature) / 2 > many.error - quadrature
        assert abs(few.value - many.value) <= few.error
        assert few.error <= 1 - mf.Microfacet(model).albedo(wo) + 1e-6


def test_few_walks_are_as_near_as_they_say() -> None:
    """Of many seeds none is farther off; and most by no more than the scatter."""
    wo = spherical(0.9)
    walk = mf.RandomWalk(mf.Smith(mf.GGX(0.2)), mf.Conductor(0.2, 3.9))
    truth, known = walk.albedo_with_error(wo, 1 << 20, 1)
    for count in (2, 20, 2000):
        found = [walk.albedo_with_error(wo, count, seed) for seed in range(100)]
        assert all(abs(value - truth) <= error + known for value, error in found)
    assert np.std([value for value, _ in found]) < found[0].error / 3


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
def test_later_bounces_keep_what_is_totally_reflected(alpha: float) -> None:
    """From glass to air reflectance has a kink; what later bounces return is as near as is said all the same."""
    wo = spherical(0.6)
    walk = mf.RandomWalk(mf.Smith(mf.GGX(alpha)), mf.Dielectric(1 / 1.5))
    (value, error), (once, known) = walk.albedo_with_error(wo), walk.single.albedo_with_error(wo)
    truth = walk.albedo_by_bounce(wo, 1 << 20, 3, orders=1)
    assert abs((value - once) - truth.more) < error - known + SIGMAS * truth.more_error
    assert error - known < 0.01


@pytest.mark.parametrize("eta", [0.23, 1 / 1.5])
@pytest.mark.parametrize("degrees", [0.0, 70.0])
def test_total_reflection_leaves_the_albedo_that_walks_have(eta: float, degrees: float) -> None:
    """All bounces at once: the quadrature of the first must be right across the kink too."""
    wo = spherical(np.radians(degrees))
    walk = mf.RandomWalk(mf.Smith(mf.GGX(0.3)), mf.Dielectric(eta))
    value, error = walk.albedo_with_error(wo)
    truth = walk.albedo_by_bounce(wo, 1 << 20, 3, orders=1)
    whole, scatter = truth.value[0] + truth.more, float(np.hypot(truth.error[0], truth.more_error))
    assert abs(value - whole) < error + SIGMAS * scatter
    assert error < 2e-3
