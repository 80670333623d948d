"""Random walks in Smith's model: all light comes back, the first bounce is the BRDF, and the rest is what it lacks."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from typing import Any

import microfacet as mf
import mpmath
import numpy as np
import pytest
from microfacet.brdf.random_walk import Bounces
from microfacet.brdf.walk import LONGEST, STRIDE
from microfacet.compiler.batch import Batch
from microfacet.directions import spherical
from microfacet.geometry.facets import TRIES, gaussian_excess, gaussian_seen, ggx_facet
from microfacet.geometry.roughness import Alphas
from microfacet.material.fresnel import Fresnel
from microfacet.streams import GOLDEN, WORD, _mixed, drawn, stream
from samples import UP, hemisphere, uniform, views
from scipy import integrate, stats

pytestmark = pytest.mark.xdist_group("brdf")

NDFS = [mf.GGX(1.0), mf.Beckmann(1.0), mf.GGX(0.5, 0.2), mf.Beckmann(0.2, 0.6)]
WALKS = [mf.RandomWalk(mf.Smith(ndf)) for ndf in NDFS]
VIEWS = views(0, 30, 60, 80, 89)
COUNT, SIGMAS = 1 << 17, 4.5  # walks; standard errors that a right result hardly ever exceeds


@cache
def counted(k: int) -> Bounces:
    return WALKS[k].albedo_by_bounce(VIEWS, COUNT, orders=5)


@pytest.mark.parametrize("k", range(len(NDFS)), ids=map(repr, NDFS))
def test_every_walk_ends_and_loses_nothing(k: int) -> None:
    found = counted(k)
    np.testing.assert_array_equal(found.under_way, 0)
    np.testing.assert_allclose(found.value.sum(axis=-1) + found.more, 1, rtol=1e-12)


@pytest.mark.parametrize("k", range(len(NDFS)), ids=map(repr, NDFS))
def test_the_first_bounce_has_the_albedo_of_the_brdf(k: int) -> None:
    """By quadrature, with G2 correlated by height; the separable G2 would be far off."""
    found = counted(k)
    error = np.maximum(found.error[:, 0], 1 / COUNT)
    assert (abs(found.value[:, 0] - WALKS[k].single.albedo(VIEWS)) < SIGMAS * error).all()
    separable = mf.Microfacet(mf.Smith(NDFS[k], "none")).albedo(VIEWS)
    assert (abs(found.value[:, 0] - separable) > 3 * SIGMAS * error).any()


@pytest.mark.parametrize("k", [0, 1, 2], ids=map(repr, NDFS[:3]))
def test_the_first_bounce_of_connections_is_the_brdf(k: int) -> None:
    wo, wi = VIEWS[:4, None], views(10, 50, 70, azimuth=160)
    once, _ = WALKS[k].connections(wo, wi, 1 << 14)
    exact = WALKS[k].single.evaluate(wo, wi)
    assert (abs(once.value - exact) < SIGMAS * once.error + 1e-3 * exact).all()


@pytest.mark.parametrize("k", range(len(NDFS)), ids=map(repr, NDFS))
def test_the_lobe_of_later_bounces_holds_what_the_first_lacks(k: int) -> None:
    """The furnace, by directions: it fails if densities, areas or chances of leaving do not fit one another."""
    t, w = np.polynomial.legendre.leggauss(24)
    cosine, turn = (t + 1) / 2, 2 * np.pi * (np.arange(32) + 0.5) / 32
    wi, weight = spherical(np.arccos(cosine)[:, None], turn), (w / 2 * cosine)[:, None] * 2 * np.pi / 32
    for wo in VIEWS[[0, 2]]:
        _, later = WALKS[k].connections(wo, wi, 512)
        value, error = np.sum(weight * later.value), np.sqrt(np.sum((weight * later.error) ** 2))
        assert value == pytest.approx(1 - float(WALKS[k].single.albedo(wo)), abs=SIGMAS * error)
        assert error < 0.01


@pytest.mark.parametrize("k", [0, 1], ids=map(repr, NDFS[:2]))
def test_light_and_viewer_may_change_places(k: int) -> None:
    wo, wi = VIEWS[1:4, None], views(10, 50, 70, azimuth=160)
    there, back = WALKS[k].connections(wo, wi, 1 << 14, 1)[1], WALKS[k].connections(wi, wo, 1 << 14, 2)[1]
    assert (abs(there.value - back.value) < SIGMAS * np.hypot(there.error, back.error)).all()
    assert (there.error < 0.1 * there.value).all()


@pytest.mark.parametrize("k", [0, 2], ids=map(repr, [NDFS[0], NDFS[2]]))
def test_samples_leave_as_connections_say(k: int) -> None:
    """Walks that end near a direction after more than one bounce, against what walks send there."""
    wo, axis, half = views(40)[0], spherical(0.7, 2.5), np.cos(np.radians(10))
    wi, weight, bounces = WALKS[k].walk(wo, uniform(1 << 18, 5))
    np.testing.assert_allclose(np.linalg.norm(wi, axis=-1), 1, rtol=1e-12)
    assert (wi[:, 2] > 0).all()
    np.testing.assert_array_equal(weight, 1)
    count = int(((wi @ axis > half) & (bounces > 1)).sum())
    height, turn = np.meshgrid(half + (1 - half) * (np.arange(8) + 0.5) / 8, 2 * np.pi * (np.arange(16) + 0.5) / 16)
    near = _around(axis, height.ravel(), turn.ravel())
    _, later = WALKS[k].connections(wo, near, 2048)
    share = 2 * np.pi * (1 - half) * later.value * near[:, 2]
    error = np.hypot(np.sqrt(count) / (1 << 18), np.sqrt(np.mean(share**2) / 2048 * 10 / len(near)) + 2e-3 * share.mean())
    assert count / (1 << 18) == pytest.approx(share.mean(), abs=SIGMAS * error)


def _around(axis: np.ndarray, height: np.ndarray, turn: np.ndarray) -> np.ndarray:
    first = np.cross(axis, [0, 0, 1])
    first /= np.linalg.norm(first)
    across = np.sqrt(1 - height**2)[:, None] * (np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * np.cross(axis, first))
    return np.asarray(height[:, None] * axis + across)


# --- the second bounce, by quadrature -----------------------------------------------------------------------------------


def Lambda(alpha: float, z: np.ndarray) -> np.ndarray:
    """Of GGX, for cosines: of a direction or its opposite."""
    return np.asarray((np.sqrt(1 + alpha**2 * (1 - z**2) / z**2) - 1) / 2)


def D(alpha: float, z: np.ndarray) -> np.ndarray:
    return np.asarray((z > 0) * alpha**2 / np.pi / ((alpha**2 - 1) * z**2 + 1) ** 2)


def mirrored(alpha: float, came: np.ndarray, goes: np.ndarray) -> np.ndarray:
    """Density of directions after a reflection, for rays (n, 1, 3) from above or below; heitz2016, eq. 25."""
    half = goes - came
    area = np.abs(came[..., 2]) * (Lambda(alpha, came[..., 2]) + (came[..., 2] < 0))
    return D(alpha, half[..., 2] / np.linalg.norm(half, axis=-1)) / (4 * area)


def sphere(cosines: int, turns: int, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    t, w = np.polynomial.legendre.leggauss(cosines)
    cosine, turn = (low + high) / 2 + (high - low) / 2 * t, 2 * np.pi * (np.arange(turns) + 0.5) / turns
    w = (w * (high - low) / 2)[:, None] * np.full(turns, 2 * np.pi / turns)
    return spherical(np.arccos(cosine)[:, None], turn).reshape(-1, 3), w.ravel()


def leaves_second(alpha: float, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """What leaves after just two bounces, per solid angle: over all directions between, and over both heights.

    The integrals over heights are those of the chances to get from the top to u, from there to u', and from there out.
    """
    total = np.zeros(len(wi))
    seen, lit = Lambda(alpha, wo[2]), Lambda(alpha, wi[:, 2])
    for low, high in ((-1, 0), (0, 1)):
        between, weight = sphere(60, 90, low, high)
        hidden = Lambda(alpha, between[:, 2])[:, None]
        heights = hidden / (1 + seen + hidden) if low == 0 else (1 + hidden) / (1 + hidden + lit)
        first = mirrored(alpha, -wo, between)
        total += np.sum(
            (weight * first)[:, None] * heights * (1 + seen) / (1 + seen + lit) * mirrored(alpha, between[:, None], wi), axis=0
        )
    return total


def test_heights_of_two_facets_have_the_integrals_used_here() -> None:
    seen, hidden, lit = 0.3, 0.8, 0.5
    up = integrate.dblquad(
        lambda v, u: (1 + seen) * u**seen * hidden * u**hidden / v ** (hidden + 1) * v**lit, 0, 1, lambda u: u, lambda u: 1
    )[0]
    assert up == pytest.approx(hidden / (1 + seen + hidden) * (1 + seen) / (1 + seen + lit), rel=1e-6)
    down = integrate.dblquad(
        lambda v, u: (1 + seen) * u**seen * (1 + hidden) * v**hidden / u ** (1 + hidden) * v**lit, 0, 1, 0, lambda u: u
    )[0]
    assert down == pytest.approx((1 + hidden) / (1 + hidden + lit) * (1 + seen) / (1 + seen + lit), rel=1e-6)


@pytest.mark.parametrize(("alpha", "degrees"), [(0.7, 0), (0.7, 45), (1.0, 70)])
def test_the_second_bounce_is_its_integral(alpha: float, degrees: float) -> None:
    """Of Smith's two bounces, in eight parts of the hemisphere, against where walks end."""
    wo, walk = spherical(np.radians(degrees)), mf.RandomWalk(mf.Smith(mf.GGX(alpha)))
    found, _, bounces = walk.walk(wo, uniform(1 << 18, 12))
    found, total = found[bounces == 2], 0.0
    for low, high in ((0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1)):
        wi, weight = sphere(6, 16, low, high)
        expected = weight * leaves_second(alpha, wo, wi)
        total += expected.sum()
        for side in (-1, 1):
            mean = expected[wi[:, 0] * side > 0].sum()
            share = ((found[:, 2] > low) & (found[:, 2] <= high) & (found[:, 0] * side > 0)).sum() / (1 << 18)
            assert share == pytest.approx(mean, abs=SIGMAS * np.sqrt(mean / (1 << 18)) + 2e-3 * mean)
    assert len(found) / (1 << 18) == pytest.approx(total, abs=SIGMAS * np.sqrt(total / (1 << 18)) + 1e-3 * total)


# --- values and their errors ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ndf", [mf.GGX(0.005), mf.GGX(0.05), mf.GGX(0.5, 0.05), mf.Beckmann(0.5)], ids=repr)
@pytest.mark.parametrize("fresnel", [None, mf.Conductor(0.2, 3.9)], ids=["mirror", "metal"])
def test_values_are_off_by_no_more_than_they_say(ndf: Any, fresnel: Any) -> None:
    """Few walks against many, also in directions that few walks find; never is nothing found where there is something."""
    walk = mf.RandomWalk(mf.Smith(ndf), fresnel)
    wo, wi = views(5, 50, 80)[:, None], views(0, 30, 60, azimuth=130)
    once = walk.single.evaluate(wo, wi)
    truth = walk.connections(wo, wi, 1 << 16, 1)[1]
    within = []
    for seed in range(8):
        value, error = walk.evaluate_with_error(wo, wi, 256, 10 + seed)
        within.append(abs(value - once - truth.value) <= error + SIGMAS * truth.error + 1e-14 * once)
        assert (error > 0).all()
    assert np.mean(within) >= 0.98
    many = walk.evaluate_with_error(wo, wi, 1 << 14, 3)
    assert np.median(many.error / error) < 0.3


def test_hardly_any_plain_walk_finds_what_is_found() -> None:
    """Of a smooth surface one walk in 40 000 goes on; of a few hundred, each counts."""
    walk = mf.RandomWalk(mf.Smith(mf.GGX(0.005)))
    first, second = (walk.connections(UP, spherical(np.radians(10)), 1 << 14, seed)[1] for seed in (1, 2))
    assert abs(first.value - second.value) < SIGMAS * np.hypot(first.error, second.error)
    assert first.value > 0


@pytest.mark.parametrize("part", [0, 1], ids=["first bounce", "later ones"])
def test_the_standard_error_of_connections_is_the_scatter_of_other_walks(part: int) -> None:
    found = [WALKS[0].connections(VIEWS[2], spherical(0.3), 64, seed)[part] for seed in range(400)]
    values, errors = (np.array([getattr(one, name) for one in found]) for name in ("value", "error"))
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(values.std(), rel=0.2)


def test_the_error_of_a_value_holds_its_largest_part() -> None:
    """Of two walks one sends nearly all: the scatter is as large, and 38 times its half is added."""
    walk = WALKS[0]
    wo, wi = VIEWS[2], spherical(0.3)
    found = walk._connected(wo, wi, 2, 5)
    scatter = walk.connections(wo, wi, 2, 5)[1].error
    value, error = walk.evaluate_with_error(wo, wi, 2, 5)
    assert found[4] >= found[1]
    assert error == pytest.approx(np.sqrt(2 * np.log(3e5)) * scatter + 3 * np.log(3e5) * found[4] / 2)
    assert value == pytest.approx(walk.single.evaluate(wo, wi) + found[1])


def test_single_precision_has_values_and_errors_of_its_own() -> None:
    wo, wi = VIEWS[2].astype(np.float32), spherical(0.3).astype(np.float32)
    value, error = WALKS[0].evaluate_with_error(wo, wi, 64)
    assert (value.dtype, error.dtype) == (np.float32, np.float32)


@pytest.mark.parametrize("ndf", [mf.GGX(1e3), mf.GGX(1e-8), mf.Beckmann(1e3), mf.GGX(1.0, 1e-4)], ids=repr)
def test_walks_leave_upwards_from_the_edges_of_the_domain(ndf: Any) -> None:
    """No ray on its way down leaves, however steep; and directions stay unit vectors."""
    low = np.array([np.sqrt(1 - 1e-16), 0, 1e-8])
    wo = np.array([[0, 0, 1], low, [1e-8, 0, 1]])[:, None]
    wi, weight, bounces = mf.RandomWalk(mf.Smith(ndf)).walk(wo, uniform(500, 3))
    out = weight > 0
    np.testing.assert_allclose(np.linalg.norm(wi[out], axis=-1), 1, atol=1e-9)
    assert (wi[out][:, 2] > 0).all()
    np.testing.assert_array_equal(wi[~out], 0)
    assert (bounces[~out] == LONGEST).all()
    assert (bounces[out] >= 1).all()


def test_what_a_walk_weighs_is_a_product_over_its_bounces() -> None:
    _, weight, bounces = mf.RandomWalk(mf.Smith(NDFS[0]), Grey()).walk(VIEWS[2], uniform(4000, 3))
    np.testing.assert_array_equal(weight, 0.5**bounces)
    assert bounces.max() > 4


def test_later_bounces_of_grey_facets_are_halved_once_each() -> None:
    """By order: of walks that leave after two bounces a quarter is left."""
    found = mf.RandomWalk(mf.Smith(NDFS[0]), Grey()).later(VIEWS[2], 4000, 3)
    np.testing.assert_array_equal(found.weight, 0.5**found.bounces)
    assert found.bounces.min() == 2


# --- facets ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ndf", NDFS, ids=repr)
@pytest.mark.parametrize("degrees", [20.0, 75.0, 90.0, 105.0, 150.0])
def test_facets_are_met_in_proportion_to_what_they_show(ndf: Any, degrees: float) -> None:
    """The mean of a function of the normal, against its integral over slopes."""
    v = spherical(np.radians(degrees), 0.8)
    kernel: Any = type(ndf).facet_kernel

    def facet(u: tuple[float, float], p: Any) -> tuple[float, float, float]:
        return kernel(p[1], u, stream(u[0], u[1], 0), 3, p[0])

    found = Batch(facet, [2], 3)([uniform(1 << 16, 9)], (ndf.parameters, tuple(map(float, v))))
    assert (found @ v > -1e-12).all()
    assert (found[:, 2] > 0).all()
    m, shows = _slopes(ndf, v)
    for function in (lambda m: m[..., 2], lambda m: np.abs(m[..., 0] - 0.3 * m[..., 1]), lambda m: (m @ v) ** 2):
        expected = float(np.sum(shows * function(m)) / shows.sum())
        values = function(found)
        assert values.mean() == pytest.approx(expected, abs=SIGMAS * values.std() / 256 + 2e-3 * abs(expected))


def _slopes(ndf: Any, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normals over slopes whose length is a tangent, and what their facets show to v."""
    t, w = np.polynomial.legendre.leggauss(400)
    angle, turn = np.pi / 4 * (t + 1), 2 * np.pi * (np.arange(720) + 0.5) / 720
    r = np.tan(angle)[:, None]
    slopes = ndf.slope_scale[0] * r * np.cos(turn), ndf.slope_scale[1] * r * np.sin(turn)
    z = 1 / np.sqrt(1 + slopes[0] ** 2 + slopes[1] ** 2)
    m = np.stack([-slopes[0] * z, -slopes[1] * z, z], axis=-1)
    area = np.maximum(m @ v, 0) * ndf.D(m) * z**3 * r / np.cos(angle)[:, None] ** 2 * w[:, None]
    return m, area


@pytest.mark.parametrize("c", [0.05, 0.6, 0.9, 3.0])
def test_slopes_by_rejection_have_their_density(c: float) -> None:
    keys = [stream(float(a), float(b), 0) for a, b in uniform(4000, 3)]
    for draw, density, low, high in (
        (gaussian_excess, lambda y: y * np.exp(-y * y - 2 * c * y), 0.0, 8.0),
        (gaussian_seen, lambda x: (c - x) * np.exp(-x * x), -8.0, c),
    ):
        whole = integrate.quad(density, low, high)[0]
        share = np.vectorize(lambda x, f=density, a=low, s=whole: integrate.quad(f, a, x)[0] / s)
        assert stats.kstest([draw(c, key, 0) for key in keys], share).pvalue > 1e-4


# --- random numbers -------------------------------------------------------------------------------------------------------


def test_random_numbers_are_the_same_compiled() -> None:
    def number(u1: float, u2: float, p: Any) -> tuple[float, float]:
        return drawn(stream(u1, u2, 3), 7), drawn(stream(u1, u2, 4), 1025)

    u = uniform(50, 2)
    expected = [number(float(a), float(b), ()) for a, b in u]
    np.testing.assert_array_equal(Batch(number, [1, 1], 2)([*u.T]), expected)


def test_random_numbers_are_those_of_splitmix64() -> None:
    """The first numbers of seed 1234567, as its authors' program and others print them."""
    told = [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431, 16408922859458223821]
    assert [_mixed((1234567 + GOLDEN * (k + 1)) & WORD) for k in range(5)] == told
    assert drawn(1234567, 0) == ((told[0] >> 12) + 0.5) / 2**52
    names = {stream(u1, u2, k) for u1 in (0.0, 0.25) for u2 in (0.0, 0.25) for k in (0, 1)}
    assert len(names) == 8
    assert 3 + 3 * TRIES <= STRIDE  # no number is used for two things


def test_random_numbers_are_even_and_streams_apart() -> None:
    rows = np.array([[drawn(stream(0.25, k / 64, 0), j) for j in range(200)] for k in range(64)])
    assert stats.kstest(rows.ravel(), "uniform").pvalue > 1e-3
    assert abs(np.corrcoef(rows)[~np.eye(64, dtype=bool)]).max() < 5 / np.sqrt(200)
    assert len(np.unique(rows)) == rows.size


def test_how_many_walks_go_in_a_row_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    steps = mf.RandomWalk(mf.Smith(mf.GGX(0.8, 0.4)), mf.Schlick(0.3))
    wo, wi = hemisphere(5, 3), hemisphere(5, 4)
    value, error = steps.evaluate_with_error(wo, wi, walks=1000, seed=3)
    for at_once in (1, 64, 999, 1000):
        monkeypatch.setattr("microfacet.brdf.random_walk.IN_A_ROW", at_once)
        other, other_error = steps.evaluate_with_error(wo, wi, walks=1000, seed=3)
        np.testing.assert_allclose(other, value, rtol=1e-12)
        np.testing.assert_allclose(other_error, error, rtol=1e-12)


COUNTING = """
import microfacet as mf, numpy as np
walk = mf.RandomWalk(mf.Smith(mf.GGX(0.5, 0.2)))
print(walk.albedo_by_bounce([[0, 0.6, 0.8], [0, 0, 1]], 1 << 17, 3).value.tolist())
print(walk.evaluate([0, 0.6, 0.8], [[0, 0, 1]] * 3, 1 << 10, 3).tolist())
"""


@pytest.mark.slow
def test_threads_do_not_matter_and_seeds_do() -> None:
    told = []
    for threads in ("1", "3"):
        environment = {**os.environ, "MICROFACET_THREADS": threads}
        run = subprocess.run([sys.executable, "-c", COUNTING], env=environment, capture_output=True, text=True, check=True)
        told.append(run.stdout)
    assert told[0] == told[1]
    one, other = (WALKS[2].albedo_by_bounce(UP, 1 << 12, seed).value for seed in (0, 1))
    assert (one != other).any()


# --- reflectance ----------------------------------------------------------------------------------------------------------


def half(c: float, p: Any) -> float:
    return 0.5


class Grey(Fresnel):
    kernel = staticmethod(half)
    parameters = ()


def test_a_grey_facet_counts_once_a_bounce() -> None:
    """With the same reflectance at every angle, shares are those of mirrors times its powers."""

    grey = mf.RandomWalk(mf.Smith(NDFS[0]), Grey()).albedo_by_bounce(VIEWS, COUNT, orders=5)
    np.testing.assert_allclose(grey.value, counted(0).value * 0.5 ** np.arange(1, 6), rtol=1e-12)


def test_metals_lose_more_with_every_bounce() -> None:
    gold = mf.RandomWalk(mf.Smith(NDFS[0]), mf.Conductor(0.18, 3.4))
    found, mirrors = gold.albedo_by_bounce(VIEWS, COUNT, orders=4), counted(0)
    ratio = found.value[:3] / mirrors.value[:3, :4]
    assert (np.diff(ratio, axis=-1) < 0).all()
    whole = gold.albedo(VIEWS, COUNT)
    total = found.value.sum(axis=-1) + found.more
    assert (abs(whole - total) < SIGMAS * np.hypot(found.error[:, 0], 1e-5)).all()
    assert ((whole > 0.5) & (whole < 1)).all()


# --- the public face ------------------------------------------------------------------------------------------------------


def test_nothing_comes_from_below() -> None:
    wi, weight, bounces = WALKS[0].walk([0.6, 0, -0.8], [0.3, 0.4])
    assert (*wi, weight, bounces) == (0, 0, 0, 0, 0)
    value, error = WALKS[0].evaluate_with_error([[0.6, 0, 0.8], [0.6, 0, -0.8]], [[0, 0.6, -0.8], [0, 0, 1]], 16)
    np.testing.assert_array_equal([value, error], 0)


def test_precision_and_shapes_follow_the_arguments() -> None:
    wi, weight, bounces = WALKS[0].walk(VIEWS[:, None].astype(np.float32), uniform(3, 1).astype(np.float32))
    assert (wi.dtype, weight.dtype, bounces.dtype) == (np.float32, np.float32, np.int64)
    assert (wi.shape, weight.shape, bounces.shape) == ((5, 3, 3), (5, 3), (5, 3))
    assert WALKS[0].evaluate(VIEWS[:, None], VIEWS[None, :2], 8).shape == (5, 2)
    assert counted(0).value.shape == (5, 5)
    assert WALKS[0].albedo(UP, 16).shape == ()


@pytest.mark.parametrize("wrong", [mf.VCavity(mf.GGX(0.3)), mf.Smith(mf.Ward(0.3)), mf.Smith(mf.GGX(0.3), "none"), None])
def test_other_models_are_refused(wrong: Any) -> None:
    with pytest.raises(ValueError, match="model must be Smith"):
        mf.RandomWalk(wrong)


def test_wrong_arguments_are_named() -> None:
    for wrong in (1, 2.5, True, "many"):
        with pytest.raises(ValueError, match="walks must be a whole number of at least 2, got"):
            WALKS[0].albedo_by_bounce(UP, wrong)
    with pytest.raises(ValueError, match=r"u must lie in \[0, 1\)"):
        WALKS[0].sample(UP, [0.5, 1.0])
    for wrong in (-1, 0.5, "x"):
        for call in (lambda s: WALKS[0].albedo(UP, 16, s), lambda s: WALKS[0].evaluate(UP, UP, 16, s)):
            with pytest.raises(ValueError, match="seed must be a whole number of at least 0, got"):
                call(wrong)
    with pytest.raises(ValueError, match="orders must be a whole number"):
        WALKS[0].albedo_by_bounce(UP, 16, orders=0)


def test_the_error_covers_light_that_is_still_under_way() -> None:
    """Of so rough a surface hardly any walk ends, and yet all light comes back."""
    rough = mf.RandomWalk(mf.Smith(mf.GGX(1e3)))
    assert rough.albedo_by_bounce(VIEWS[1], 50).under_way > 0.9
    value, error = rough.albedo_with_error(VIEWS[1], 50)
    assert abs(value - 1) <= error


def test_the_walks_need_their_longest() -> None:
    """No walk of these comes near the number of bounces after which it would be given up."""
    _, _, bounces = WALKS[0].walk(UP, uniform(1 << 16, 4))
    assert 5 < bounces.max() < LONGEST / 10


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("sine", [1e-3, 1e-5, 0.6])
@pytest.mark.parametrize("u2", [1e-12, 0.3, 1 - 2.0**-40])
def test_a_facet_of_ggx_keeps_its_digits_next_to_both_poles(side: float, sine: float, u2: float) -> None:
    """Mirror directions fill the cap c > -z evenly in height, dupuy2023: once more to 50 digits, without rearranging."""
    u1, alpha = 0.2, (0.7, 0.4)
    v = np.array([0.8 * sine, 0.6 * sine, side * np.sqrt(1 - sine * sine)])
    with mpmath.workdps(50):
        x, y, z = (mpmath.mpf(float(c)) * a for c, a in zip(v, (*map(mpmath.mpf, alpha), 1), strict=True))
        length = mpmath.sqrt(x * x + y * y + z * z)
        x, y, z = x / length, y / length, z / length
        height = (1 - mpmath.mpf(u2)) * (1 + z) - z
        radius = mpmath.sqrt(1 - height**2)
        turn = 2 * mpmath.pi * mpmath.mpf(u1)
        m = [alpha[0] * (radius * mpmath.cos(turn) + x), alpha[1] * (radius * mpmath.sin(turn) + y), height + z]
        exact = [float(c / mpmath.sqrt(sum(d * d for d in m))) for c in m]
    np.testing.assert_allclose(ggx_facet(tuple(v), (u1, u2), 0, 0, Alphas(*alpha)), exact, rtol=1e-12)
