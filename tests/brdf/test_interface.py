"""One interface: whatever is a BRDF has the same methods, which fit one another."""

from __future__ import annotations

from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.brdf.cosine_table import CosineTable
from microfacet.directions import spherical
from microfacet.material.fresnel import Fresnel
from microfacet.validation.chi_square import p_value_of_counts
from numpy.typing import ArrayLike, NDArray
from samples import LAST, LAST_SINGLE, UP, uniform, views
from sampling import density_times_area

pytestmark = pytest.mark.xdist_group("brdf")

METAL = mf.Conductor(0.2, 3.9)
ROUGH = mf.Smith(mf.GGX(0.8, 0.5))
ONCE = [mf.Microfacet(ROUGH, METAL), mf.Microfacet(mf.VCavity(mf.Beckmann(0.6))), mf.Microfacet(mf.Smith(mf.Ward(0.5)), METAL)]
MADE_UP = [
    mf.Compensated(ONCE[0]),
    mf.Compensated(ONCE[0], "scaled"),
    mf.Compensated(ONCE[1]),
    mf.Compensated(mf.Microfacet(mf.Smith(mf.GGX(1.0)), mf.Dielectric(1.5))),
    mf.Compensated(mf.Microfacet(mf.Smith(mf.Beckmann(0.02)))),
]
MATT = mf.Diffuse(mf.Smith(mf.Beckmann(0.4)), 0.7)
WALKS = [mf.RandomWalk(ROUGH, METAL), mf.RandomWalk(mf.Smith(mf.Beckmann(0.7)))]
EXACT = [*ONCE, *MADE_UP, MATT]
EVEN = CosineTable()
ALL = [*EXACT, *WALKS]
VIEWS = views(0, 50, 80)


@pytest.mark.parametrize("brdf", ALL, ids=repr)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_shapes_and_precisions_are_the_same_everywhere(brdf: mf.BRDF, real: type) -> None:
    assert isinstance(brdf, mf.BRDF)
    wo, wi, u = VIEWS.astype(real)[:, None], views(20, 70).astype(real), uniform(2, 1, real)
    for found in (brdf.evaluate(wo, wi), brdf.pdf(wo, wi), brdf.weight(wo, wi)):
        assert found.shape == (3, 2)
        assert found.dtype == real
        assert (found >= 0).all()
    sampled = brdf.sample(wo, u)
    assert sampled.shape == (3, 2, 3)
    assert sampled.dtype == real
    value, error = brdf.albedo_with_error(wo[:, 0])
    np.testing.assert_array_equal(brdf.albedo(wo[:, 0]), value)
    assert value.shape == error.shape == (3,)
    assert np.ndim(brdf.evaluate(UP, UP)) == np.ndim(brdf.pdf(UP, UP)) == np.ndim(brdf.weight(UP, UP)) == 0
    assert np.ndim(brdf.albedo(UP)) == 0
    assert brdf.sample(UP, [0.3, 0.4]).shape == (3,)


@pytest.mark.parametrize("brdf", ALL, ids=repr)
def test_nothing_below_the_horizon(brdf: mf.BRDF) -> None:
    down = VIEWS * [1, 1, -1]
    for wo, wi in ((down, VIEWS), (VIEWS, down), (down, down)):
        np.testing.assert_array_equal(brdf.evaluate(wo, wi), 0)
        np.testing.assert_array_equal(brdf.weight(wo, wi), 0)
    np.testing.assert_array_equal(brdf.pdf(down, VIEWS), 0)
    np.testing.assert_array_equal(brdf.albedo(down), 0)
    np.testing.assert_array_equal(brdf.sample(down, uniform(3)), 0)


def cells(count: int = 6, turns: int = 8, nodes: int = 6) -> tuple[NDArray[Any], NDArray[Any]]:
    """Directions in cells even in the square of the cosine and in azimuth, (count, turns, nodes^2, 3), and weights of a sum."""
    t, w = np.polynomial.legendre.leggauss(nodes)
    t, w, edges = (t + 1) / 2, w / 2, np.sqrt(np.arange(count + 1) / count)
    size = np.diff(edges)[:, None]
    cosine, azimuth = edges[:-1, None] + size * t, 2 * np.pi * (np.arange(turns)[:, None] + t) / turns
    theta, phi = np.broadcast_arrays(np.arccos(cosine)[:, None, :, None], azimuth[None, :, None, :])
    weight = (size * w)[:, None, :, None] * (w * 2 * np.pi / turns)
    shape = (count, turns, nodes * nodes)
    return spherical(theta, phi).reshape(*shape, 3), np.broadcast_to(weight, theta.shape).reshape(shape)


def counted(wi: NDArray[Any], count: int = 6, turns: int = 8) -> NDArray[Any]:
    """How many lie in each cell."""
    up = wi[wi[:, 2] > 0].astype(float)
    azimuth = np.arctan2(up[:, 1], up[:, 0]) % (2 * np.pi)
    edges = [np.linspace(0, 1, count + 1), np.linspace(0, 2 * np.pi, turns + 1)]
    return np.asarray(np.histogram2d(np.minimum(up[:, 2] ** 2, 1), azimuth, bins=edges)[0])


def odds(wi: NDArray[Any], pdf: Any, lost: bool) -> float:
    """Of counts at least as far from the density's integrals over the cells; lost: whether some go below the horizon."""
    directions, weight = cells()
    expected, counts = len(wi) * (pdf(directions) * weight).sum(axis=-1), counted(wi)
    rest = len(wi) - np.array([expected.sum(), counts.sum()])
    if not lost:
        assert abs(rest).max() < 2e-3 * len(wi)
        return p_value_of_counts(counts, expected * counts.sum() / expected.sum())
    return p_value_of_counts(np.append(counts, rest[1]), np.append(expected, rest[0]))


ROUGH_ENOUGH = [brdf for brdf in EXACT if brdf not in (MATT, MADE_UP[-1])]


@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("brdf", ROUGH_ENOUGH, ids=repr)
def test_counts_follow_the_density(brdf: mf.BRDF, real: type) -> None:
    for k, wo in enumerate(VIEWS):
        wi = brdf.sample(wo.astype(real), uniform(100_000, k, real))
        assert odds(wi, lambda wi, wo=wo: brdf.pdf(wo, wi), lost=True) > 1e-5


def test_counts_tell_a_wrong_mixture() -> None:
    """The test above can fail: samples of one bounce, or of the cosine, are not those of the mixture."""
    whole, wo = MADE_UP[0], VIEWS[1]
    for wi in (ONCE[0].sample(wo, uniform(100_000)), EVEN.sample(wo, uniform(100_000))):
        assert odds(wi, lambda wi: whole.pdf(wo, wi), lost=True) < 1e-6


@pytest.mark.parametrize("brdf", WALKS, ids=repr)
def test_walks_end_as_often_as_their_density_says(brdf: mf.RandomWalk) -> None:
    """The density is a mean over walks as well: its error, of some 1e-3 per cell, counts beside that of counts."""
    directions, weight = cells(nodes=4)
    for k, wo in enumerate(VIEWS):
        wi = brdf.sample(wo, uniform(100_000, k))
        value, error = brdf.pdf_with_error(wo, directions, walks=512)
        expected, unsure = (value * weight).sum(axis=-1), np.sqrt(((error / 5 * weight) ** 2).sum(axis=-1))
        counts = counted(wi) / len(wi)
        sigma = np.sqrt(expected / len(wi) + unsure**2)
        apart = (counts - expected) / sigma
        assert (apart**2).sum() < 1.6 * apart.size
        assert abs(apart).max() < 5


@pytest.mark.parametrize("brdf", ALL, ids=repr)
def test_the_mean_of_weights_is_the_albedo(brdf: mf.BRDF) -> None:
    count = 300 if brdf is MATT else 1000 if brdf in WALKS else 20_000
    for k, wo in enumerate(VIEWS):
        weight = brdf.weight(wo, brdf.sample(wo, uniform(count, 10 + k)))
        albedo, error = brdf.albedo_with_error(wo)
        spread = max(float(weight.std()), 1e-6) / np.sqrt(count)
        off = getattr(brdf, "off", 0.0)
        assert abs(weight.mean() - albedo) < 4.5 * spread + error + off


@pytest.mark.parametrize("brdf", ALL, ids=repr)
def test_value_density_and_weight_fit_one_another(brdf: mf.BRDF) -> None:
    rng = np.random.default_rng(2)
    wo, wi = (spherical(np.arccos(rng.random(50)), 2 * np.pi * rng.random(50)) for _ in range(2))
    wi = np.concatenate([wi, brdf.sample(wo, uniform(50, 3))])
    wo = np.concatenate([wo, wo])
    up = wi[:, 2] > 0
    value, density, weight = (method(wo[up], wi[up]) for method in (brdf.evaluate, brdf.pdf, brdf.weight))
    np.testing.assert_allclose(weight * density, value * wi[up, 2], rtol=1e-6, atol=1e-13)
    np.testing.assert_array_equal(value > 0, density > 0)


@pytest.mark.parametrize("form", ["lobe", "scaled"])
@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("alpha", [(1e-8, 1e-8), (1e-4, 1e-3), (0.3, 0.3), (30.0, 30.0)])
def test_value_and_density_of_compensated_vanish_together(form: str, real: type, alpha: tuple[float, float]) -> None:
    brdf, rng = mf.Compensated(mf.Microfacet(mf.Smith(mf.GGX(*alpha))), form), np.random.default_rng(4)
    height = 10 ** rng.uniform(-8, 0, (2, 5000))
    wo, wi = (spherical(np.arccos(z), 2 * np.pi * rng.random(5000)).astype(real) for z in height)
    wi = np.concatenate([wi, brdf.sample(wo, uniform(5000, 1, real))])
    wo = np.concatenate([wo, wo])
    value, density, weight = brdf.evaluate(wo, wi), brdf.pdf(wo, wi), brdf.weight(wo, wi)
    for found in (value, density, weight):
        assert (np.isfinite(found) & (found >= 0)).all()
    up = wi[:, 2] > 0
    np.testing.assert_array_equal(value[up] > 0, density[up] > 0)
    if form == "lobe":
        assert weight.max() < 20


@pytest.mark.parametrize(("real", "last"), [(np.float64, LAST), (np.float32, LAST_SINGLE)])
@pytest.mark.parametrize("brdf", [*MADE_UP, MATT, *WALKS], ids=repr)
def test_corners_of_the_unit_square_give_directions(brdf: mf.BRDF, real: type, last: float) -> None:
    corners = np.array([(a, b) for a in (0, 0.5, last) for b in (0, 0.5, last)], real)
    for wo in views(0, 30, 85, 89.99).astype(real):
        wi = brdf.sample(wo, corners)
        np.testing.assert_allclose(np.linalg.norm(wi, axis=-1), 1, rtol=8 * np.finfo(real).eps)
        assert np.isfinite(brdf.weight(wo, wi)).all()


@pytest.mark.parametrize("table", [EVEN, CosineTable([1.0, 3.0, 0.2, 5.0])], ids=["even", "four"])
def test_a_table_is_sampled_with_its_density(table: CosineTable) -> None:
    near_steps = 0
    for u in 0.01 + 0.98 * uniform(40, 5):
        product = density_times_area(lambda u: table.sample(UP, u), lambda wi: table.pdf(UP, wi), u, step=1e-6)
        near_steps += abs(product - 1) > 1e-6
    assert near_steps <= 1
    directions, weight = cells(400, 2)
    assert (table.pdf(UP, directions) * weight).sum() == pytest.approx(1, abs=1e-3)


# --- a BRDF of one's own --------------------------------------------------------------------------------------------------


class Lambert(mf.BRDF):
    """A matt plane, with as few methods as a subclass must give."""

    def evaluate(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        return np.asarray(np.where((np.asarray(wo)[..., 2] > 0) & (np.asarray(wi)[..., 2] > 0), 0.5 / np.pi, 0.0))

    def sample(self, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
        return EVEN.sample(wo, u)

    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        return EVEN.pdf(wo, wi)

    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        albedo = np.where(np.asarray(wo)[..., 2] > 0, 0.5, 0.0)
        return albedo, np.zeros_like(albedo)


def test_a_subclass_has_what_follows() -> None:
    brdf = Lambert()
    np.testing.assert_allclose(brdf.weight(VIEWS, views(10, 20, 30)), 0.5)
    assert brdf.weight(UP, -UP) == 0
    assert brdf.albedo(UP) == 0.5
    assert brdf == Lambert()


def test_a_subclass_that_gives_too_little_is_refused_by_name() -> None:
    class Half(Lambert):
        albedo_with_error = mf.BRDF.albedo_with_error

    with pytest.raises(TypeError, match="albedo_with_error"):
        Half()  # type: ignore[abstract]


class Grey(Fresnel):
    """Half of the light, at every angle."""

    parameters = (0.5,)

    @staticmethod
    def kernel(c: float, p: Any) -> float:
        return p[0]


def test_what_a_walk_weighs_is_what_facets_leave_of_it() -> None:
    """After n bounces 0.5^n; by direction, the BRDF over that of perfect mirrors, which lies between 0 and 0.5."""
    brdf = mf.RandomWalk(ROUGH, Grey())
    wi, weight, bounces = brdf.walk(VIEWS[1], uniform(300, 6))
    np.testing.assert_allclose(weight, np.where(wi[:, 2] > 0, 0.5**bounces, 0))
    by_direction = brdf.weight(VIEWS[1], wi)
    assert ((by_direction > 0) & (by_direction <= 0.5 + 1e-12)).all()
    assert by_direction.mean() == pytest.approx(weight.mean(), abs=5 * weight.std() / np.sqrt(300))
