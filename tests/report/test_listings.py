"""Programs printed in the report give what the library gives."""

from __future__ import annotations

from random import Random

import microfacet as mf
import numpy as np
import pytest
from report import listings
from report.listings import Vector

ROUGHNESS = [(0.001, 0.001), (0.1, 0.4), (1.0, 1.0), (3.0, 0.5)]


def directions(seed: int, n: int = 200) -> np.ndarray:
    """Unit vectors all over the sphere, a third of them near the horizon."""
    random = np.random.default_rng(seed)
    w = random.normal(size=(n, 3))
    w[::3, 2] *= 1e-3
    return w / np.linalg.norm(w, axis=1)[:, None]


@pytest.mark.parametrize("alpha", ROUGHNESS)
def test_brdf_density_and_weight_are_the_librarys(alpha: tuple[float, float]) -> None:
    brdf = mf.Microfacet(mf.Smith(mf.GGX(*alpha)))
    wo, wi = directions(1), directions(2)
    for name, expected in (("brdf", brdf.evaluate), ("pdf", brdf.pdf), ("weight", brdf.weight)):
        printed = [getattr(listings, name)(Vector(*o), Vector(*i), *alpha) for o, i in zip(wo, wi, strict=True)]
        np.testing.assert_allclose(printed, expected(wo, wi), rtol=1e-11)


@pytest.mark.parametrize("alpha", ROUGHNESS)
def test_visible_normals_are_the_librarys(alpha: tuple[float, float]) -> None:
    wo, u = abs(directions(3)), np.random.default_rng(4).random((200, 2))
    printed = [listings.visible_normal(Vector(*o), *pair, *alpha) for o, pair in zip(wo, u.tolist(), strict=True)]
    np.testing.assert_allclose(printed, mf.Smith(mf.GGX(*alpha)).sample_visible(wo, u), rtol=1e-9, atol=1e-12)


def test_facets_seen_from_below_are_turned_to_the_viewer() -> None:
    """All of the cap is drawn, also where its height is a difference of nearly equal numbers."""
    for z in (-0.9999999999, -0.5, -1e-9):
        wo = Vector((1 - z * z) ** 0.5, 0.0, z)
        for u2 in (0.0, 0.3, 1 - 2.0**-53):
            m = listings.visible_normal(wo, 0.1, u2, 0.5, 0.5)
            assert m.z > 0
            assert m.x * wo.x + m.y * wo.y + m.z * wo.z > -1e-15


@pytest.mark.parametrize(("alpha", "theta"), [((1.0, 1.0), 0.0), ((0.6, 0.3), 1.2)])
def test_the_walk_leaves_as_the_librarys_does(alpha: tuple[float, float], theta: float) -> None:
    """Shares by bounce, and where light leaves, within five standard errors."""
    wo, number, random = mf.spherical(theta, 0.4), 20000, Random(5).random
    walks = [listings.walk(Vector(*wo), *alpha, random) for _ in range(number)]
    left, bounces = np.array([w for w, _ in walks]), np.array([n for _, n in walks])
    known = mf.RandomWalk(mf.Smith(mf.GGX(*alpha))).albedo_by_bounce(wo, walks=1 << 18, orders=3)
    shares = np.array([(bounces == n).mean() for n in (1, 2, 3)])
    error = np.hypot(np.sqrt(shares * (1 - shares) / number), known.error)
    assert (abs(shares - known.value) < 5 * error).all()
    theirs = mf.RandomWalk(mf.Smith(mf.GGX(*alpha))).walk(wo, np.random.default_rng(6).random((number, 2))).wi
    spread = np.hypot(left.std(0), theirs.std(0)) / np.sqrt(number)
    assert (abs(left.mean(0) - theirs.mean(0)) < 5 * spread).all()


def test_light_along_the_horizon_passes_above_the_surface() -> None:
    assert listings.walk(Vector(1.0, 0.0, 0.0), 0.5, 0.5, Random(1).random) == (Vector(-1.0, 0.0, 0.0), 0)
