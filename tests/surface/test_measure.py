"""Measurements against what is known without measuring: conserved area and energy, and surfaces with a known answer."""

from __future__ import annotations

import numpy as np
import pytest
from microfacet.directions import spherical
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.measure import POINTS, RAYS, Plan, _surface, estimate, gather, shard

FAMILY = GaussianField(128, 0.7, 0.5, correlation=8)
VIEWS = spherical(np.radians([0, 45, 75]), np.radians([0, 30, -100]))
PLAN = Plan(VIEWS, side=64, lights=([0.0, 1.2], [0.0, np.pi / 2, np.pi]), bins=(9, 12))


@pytest.fixture(scope="module")
def measured() -> dict[str, np.ndarray]:
    return shard(FAMILY, PLAN, 0, 6)


def test_the_seen_area_is_the_cosine(measured: dict[str, np.ndarray]) -> None:
    for view, wo in enumerate(VIEWS):
        seen = estimate(measured["seen"][:, view].sum(axis=-1))
        assert abs(seen.value - wo[2]) <= 4 * seen.error + 1e-12


def test_light_is_conserved(measured: dict[str, np.ndarray]) -> None:
    """What leaves in bins is what leaves; it never exceeds what came in, and all but all of it leaves at last."""
    once, more = np.moveaxis(measured["lobe"].sum(axis=(-2, -1)), -1, 0)
    np.testing.assert_allclose(once, measured["escaped"][..., 0], atol=1e-12)
    np.testing.assert_allclose(more, measured["escaped"][..., 1:].sum(axis=-1), atol=1e-12)
    np.testing.assert_allclose(measured["normals"].sum(axis=(-2, -1)), 1, atol=1e-12)
    total = measured["escaped"].sum(axis=-1)
    assert total.max() <= 1 + 1e-12
    assert total.min() > 0.98


def test_a_light_at_the_viewer_lights_what_is_seen() -> None:
    """Full correlation: from the light's own place no shadow is seen."""
    plan = Plan([spherical(1.2, 0.4)], side=64, lights=([1.2], [0.0]))
    one = shard(FAMILY, plan, 0, 1)
    assert one["lit"][0, 0, 0, 0] == 1.0
    assert one["facing"][0, 0, 0, 0] == 1.0


def test_nothing_is_lit_that_faces_away(measured: dict[str, np.ndarray]) -> None:
    assert (measured["lit"] <= measured["facing"]).all()
    assert (measured["seen"] <= measured["faced"] + 1e-12).all()


def test_an_almost_flat_surface_is_a_mirror() -> None:
    plan = Plan([spherical(0.6, 1.0)], side=32, bins=(90, 36))
    one = shard(GaussianField(64, 1e-4, correlation=8), plan, 0, 1)
    theta, phi = (0.5 * (edges[1:] + edges[:-1]) for edges in plan.lobe_edges)
    at = np.unravel_index(one["lobe"][0, 0, 0].argmax(), (90, 36))
    assert one["escaped"][0, 0, 0] == 1.0
    assert theta[at[0]] == pytest.approx(0.6, abs=0.02)
    assert abs(phi[at[1]]) == pytest.approx(np.pi, abs=0.1)


def test_bins_of_directions_fill_the_hemisphere() -> None:
    assert PLAN.solid_angle.sum() == pytest.approx(2 * np.pi)
    theta, phi = PLAN.lobe_edges
    assert PLAN.solid_angle[2, 3] == pytest.approx((np.cos(theta[2]) - np.cos(theta[3])) * (phi[4] - phi[3]))


def test_without_bounces_there_is_no_lobe() -> None:
    one = shard(FAMILY, Plan(VIEWS, side=16, bounces=0), 0, 1)
    assert "lobe" not in one
    assert one["seen"].shape == (1, 3, 24)


def test_results_do_not_depend_on_the_number_of_shards(
    measured: dict[str, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "1")
    whole = gather([shard(FAMILY, PLAN, 4, 6), shard(FAMILY, PLAN, 0, 1), shard(FAMILY, PLAN, 1, 4)])
    assert whole.keys() == measured.keys()
    for name, values in whole.items():
        np.testing.assert_array_equal(values, measured[name])


def test_an_estimate_of_a_mean_has_its_standard_error() -> None:
    values = np.random.default_rng(1).standard_normal((50, 3))
    mean, error = estimate(values)
    np.testing.assert_allclose(mean, values.mean(axis=0))
    np.testing.assert_allclose(error, values.std(axis=0, ddof=1) / np.sqrt(50))


def test_the_error_of_a_ratio_covers_it() -> None:
    """Of 400 intervals of two standard errors, 90 to 98 % hold the ratio of the means."""
    rng = np.random.default_rng(2)
    below = rng.uniform(1, 2, (30, 400))
    ratio = estimate(0.3 * below + 0.1 * rng.standard_normal(below.shape), below)
    assert 0.90 < np.mean(abs(ratio.value - 0.3) < 2 * ratio.error) < 0.98


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"views": [[0, 0, -1]]}, "views must be unit vectors above the horizon"),
        ({"views": [0, 0, 1]}, r"views must be .* of shape \(v, 3\)"),
        ({"side": 0}, "side.*0"),
        ({"bounces": 1.5}, "bounces.*1.5"),
        ({"bins": (0, 4)}, "bins.*0"),
        ({"reach": -1}, "reach.*-1"),
        ({"lights": ([2.0], [0.0])}, "lights.*2.0"),
        ({"method": "fractal"}, "method must be one of spectral, gabor, got 'fractal'"),
    ],
)
def test_wrong_plans_are_refused(change: dict, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        Plan(**{"views": [[0, 0, 1]], **change})


def test_wrong_shards_are_refused(measured: dict[str, np.ndarray]) -> None:
    with pytest.raises(ValueError, match=r"first and last.*3 and 3"):
        shard(FAMILY, PLAN, 3, 3)
    with pytest.raises(ValueError, match="every surface once"):
        gather([measured, measured])
    with pytest.raises(ValueError, match="at least 2 surfaces, got 1"):
        estimate([1.0])


@pytest.mark.slow
def test_a_finer_grid_changes_nothing() -> None:
    """The same smooth surfaces on grids of 32, 16 and 4 cells to a correlation length, with the same rays.

    Paired, so that most of what is random cancels. 16 cells are enough, and 4 are not: so it would be seen.
    """
    views = spherical(np.radians([0, 60]), np.radians([10, 70]))
    plan = Plan(views, side=128, bounces=1, lights=([1.0], [0.0, 2.0, np.pi]))
    fine, enough, few = (GaussianField(32 * cells, 0.7, correlation=cells, root=77) for cells in (32, 16, 4))
    found = [[_surface(family, plan, k) for k in range(12)] for family in (fine, Sparse(fine, enough), Sparse(fine, few))]
    escaped, lit = (
        np.array([[one[name] for one in surfaces] for surfaces in found]).mean(axis=1) for name in ("escaped", "lit")
    )
    assert abs(escaped[1] - escaped[0]).max() < 1.5e-3
    assert abs(lit[1] - lit[0]).max() < 1.5e-3
    assert abs(lit[2] - lit[0]).max() > 4e-3


class Sparse:
    """The surfaces of a fine family on every other node, or on fewer, with the facets' roughness of a coarser one."""

    def __init__(self, fine: GaussianField, coarse: GaussianField) -> None:
        self.fine, self.coarse, self.facet_alpha, self.seed = fine, coarse, coarse.facet_alpha, coarse.seed

    def spectral(self, k: int) -> np.ndarray:
        step = self.fine.size // self.coarse.size
        return self.fine.spectral(k)[::step, ::step] * (self.coarse.sigma / self.fine.sigma)


def test_rays_points_and_heights_of_a_surface_are_drawn_from_numbers_of_their_own() -> None:
    seeds = [FAMILY.seed(k, *purpose) for k in (0, 1) for purpose in ((), (RAYS, 0), (POINTS, 0), (RAYS, 1), (POINTS, 1))]
    assert len({tuple(seed.generate_state(4)) for seed in seeds}) == len(seeds)
