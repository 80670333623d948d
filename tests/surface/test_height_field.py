"""The tracer against rational arithmetic, against a walk through every cell, and against the area it must conserve."""

from __future__ import annotations

import math
from fractions import Fraction

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from microfacet.directions import spherical
from microfacet.surface import height_field, lanes
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField
from microfacet.surface.lanes import ESCAPED, LOST


def rough(size: int, seed: int, scale: float = 1.0) -> HeightField:
    """No smooth surface: every height is drawn for itself."""
    return HeightField(scale * np.random.default_rng(seed).standard_normal((size, size)))


def smooth(size: int, alpha: float = 0.7, k: int = 0, correlation: float = 8) -> HeightField:
    return HeightField(GaussianField(size, alpha, correlation=correlation).spectral(k))


def aimed(count: int, field: HeightField, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays from above everything, in all directions that go down."""
    rng = np.random.default_rng(seed)
    directions = -spherical(np.arccos(rng.uniform(0.15, 1, count)), rng.uniform(0, 2 * np.pi, count))
    origins = np.column_stack([rng.uniform(0, field.size, (count, 2)), np.full(count, field.highest + 1)])
    return origins, directions


def leaving(count: int, field: HeightField, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays from random points of the surface into the hemisphere over their facet."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0, field.size, (2, count))
    facets, z = field.locate(x, y)
    directions = spherical(np.arccos(rng.uniform(-1, 1, count)), rng.uniform(0, 2 * np.pi, count))
    down = np.sum(directions * field.normals(facets), axis=-1) < 0
    directions[down] *= -1
    return np.column_stack([x, y, z]), directions, facets


# --- two other tracers ------------------------------------------------------------------------------------------------


def exact_hit(heights: np.ndarray, origin: np.ndarray, direction: np.ndarray, own: int = -1) -> tuple[int, float]:
    """The first facet met, in rational arithmetic: every facet within two cells of the path is intersected."""
    n = len(heights)
    o, d = [Fraction(float(v)) for v in origin], [Fraction(float(v)) for v in direction]
    level = heights.min() if direction[2] < 0 else heights.max()
    length = (float(level) - origin[2]) / direction[2]
    best = (-1, Fraction(10**9))
    for i, j in _cells(origin, direction, length):
        z = {(a, b): Fraction(float(heights[(i + a) % n, (j + b) % n])) for a in (0, 1) for b in (0, 1)}
        for k in (0, 1):
            number = 2 * ((i % n) * n + j % n) + k
            if number == own and abs(i + 0.5 - origin[0]) < n / 2 and abs(j + 0.5 - origin[1]) < n / 2:
                continue
            b, c = (z[1, 0] - z[0, 0], z[1, 1] - z[1, 0]) if k == 0 else (z[1, 1] - z[0, 1], z[0, 1] - z[0, 0])
            against = d[2] - b * d[0] - c * d[1]
            if against == 0:
                continue
            t = -(o[2] - z[0, 0] - b * (o[0] - i) - c * (o[1] - j)) / against
            u, v = o[0] + t * d[0] - i, o[1] + t * d[1] - j
            inside = 0 <= v <= u <= 1 if k == 0 else 0 <= u <= v <= 1
            if inside and 0 <= t < best[1]:
                best = (number, t)
    return (best[0], float(best[1])) if best[0] >= 0 else (-1, math.inf)


def _cells(origin: np.ndarray, direction: np.ndarray, length: float) -> set[tuple[int, int]]:
    steps = 2 + int(2 * length * np.hypot(*direction[:2]))
    path = origin[:2] + np.linspace(0, length, steps)[:, None] * direction[:2]
    near = {(math.floor(x), math.floor(y)) for x, y in path}
    return {(i + a, j + b) for i, j in near for a in (-1, 0, 1) for b in (-1, 0, 1)}


@numba.njit(nogil=True, cache=True, error_model="numpy")
def plain_walk(z, o, d, own, facet, margin):
    """Facets met, and how far from 0 (in cells) the nearest of the signs was that decided so: no mirrors, no blocks."""
    n, highest = z.shape[0], z.max()
    for k in range(len(o)):
        facet[k], margin[k] = _one(z, n, highest, o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2], own[k])


@numba.njit(nogil=True, cache=True, error_model="numpy")
def _one(z, n, highest, x, y, h, dx, dy, dz, own):
    i, j = math.floor(x), math.floor(y)
    if own >= 0:
        i, j = (own >> 1) // n, (own >> 1) % n
        x, y = x - n * math.floor((x - i - 0.5) / n + 0.5), y - n * math.floor((y - j - 0.5) / n + 0.5)
    x, y = x - i, y - j  # the origin in its cell; cells count from there
    p, q, t, margin = 0, 0, 0.0, math.inf
    side = own & 1 if own >= 0 else int(y > x)
    while dz < 0 or h + t * dz <= highest:
        i0, j0 = (i + p) % n, (j + q) % n
        i1, j1 = (i0 + 1) % n, (j0 + 1) % n
        tx = ((p + (dx > 0)) - x) / dx if dx != 0 else math.inf
        ty = ((q + (dy > 0)) - y) / dy if dy != 0 else math.inf
        leave = min(tx, ty)
        out = 1 - int(dx > 0) if tx < ty else int(dy > 0)
        ground = _edge(z, i0, j0, i1, j1, dx, dy, tx < ty, y - q + tx * dy if tx < ty else x - p + ty * dx)
        if out != side:
            middle = ((y - q) - (x - p)) / (dx - dy)
            share = x - p + middle * dx
            gap = h + middle * dz - ((1 - share) * z[i0, j0] + share * z[i1, j1])
            if own < 0:
                margin = min(margin, abs(gap))
                if gap < 0:
                    return 2 * (i0 * n + j0) + side, margin
            own = -1
        gap = h + leave * dz - ground
        if own < 0:
            margin = min(margin, abs(gap))
            if gap < 0:
                return 2 * (i0 * n + j0) + out, margin
        own, t = -1, leave
        p += (1 if dx > 0 else -1) if tx < ty else 0
        q += 0 if tx < ty else (1 if dy > 0 else -1)
        side = 1 - out
    return -1, margin


@numba.njit(nogil=True, cache=True)
def _edge(z, i0, j0, i1, j1, dx, dy, along_x, share):
    """The height of the surface where a ray leaves a cell."""
    if along_x:
        row = i1 if dx > 0 else i0
        return (1 - share) * z[row, j0] + share * z[row, j1]
    column = j1 if dy > 0 else j0
    return (1 - share) * z[i0, column] + share * z[i1, column]


# --- every verdict ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("field", [rough(8, 1), rough(16, 2, 0.1), rough(16, 3, 5.0), smooth(64)])
def test_hits_are_those_of_rational_arithmetic(field: HeightField) -> None:
    origins, directions = aimed(25, field, 4)
    hits = field.trace(origins, directions)
    for k in range(len(origins)):
        assert (hits.facet[k], pytest.approx(hits.distance[k])) == exact_hit(field.heights, origins[k], directions[k])


@pytest.mark.parametrize("field", [rough(8, 5), rough(16, 6, 0.1), rough(16, 7, 5.0), smooth(64)])
def test_rays_from_the_surface_are_those_of_rational_arithmetic(field: HeightField) -> None:
    origins, directions, facets = leaving(25, field, 8)
    steep = abs(directions[:, 2]) > 0.2
    hits = field.trace(origins, directions, facets)
    for k in np.flatnonzero(steep):
        exact = exact_hit(field.heights, origins[k], directions[k], facets[k])
        assert (hits.facet[k], pytest.approx(hits.distance[k])) == exact


@pytest.mark.parametrize(
    "field", [rough(32, 9), smooth(256), smooth(512, 1.0, correlation=3), smooth(1024, 0.3, correlation=40)]
)
def test_skipping_blocks_changes_no_verdict(field: HeightField) -> None:
    origins, directions, facets = leaving(20_000, field, 10)
    above, down = aimed(20_000, field, 11)
    assert disagreements(field, origins, directions, facets) == 0
    assert disagreements(field, above, down, np.full(len(above), -1)) == 0


@pytest.mark.slow
def test_no_false_verdict_in_ten_million_rays() -> None:
    for k in range(10):
        field = smooth(1024, (0.4, 0.7, 1.0)[k % 3], k, correlation=16)
        above, down = aimed(500_000, field, k)
        hits = field.trace(above, down)
        wm = field.normals(hits.facet)
        mirrored = down - 2 * np.sum(down * wm, axis=-1, keepdims=True) * wm
        assert disagreements(field, above, down, np.full(len(above), -1)) == 0
        assert disagreements(field, field.points(above, down, hits.distance), mirrored, hits.facet) == 0
        assert field.escapes(field.points(above, down, hits.distance), -down, hits.facet).all()


def disagreements(field: HeightField, origins: np.ndarray, directions: np.ndarray, facets: np.ndarray) -> int:
    """Verdicts other than the plain walk's, where that one's own rounding leaves no doubt."""
    clear = abs(directions[:, 2]) > 1e-4
    plain, margin = np.empty(len(origins), np.int64), np.empty(len(origins))
    plain_walk(field.heights.astype(float), origins[clear], directions[clear], facets[clear], plain[: clear.sum()], margin)
    met = field.trace(origins, directions, facets).facet[clear]
    return int(np.sum((met != plain[: clear.sum()]) & (margin[: clear.sum()] > 1e-10)))


def test_what_is_seen_sees_back() -> None:
    """A false hit of the own facet or of a neighbour, or a leak, would break this; Embree without an offset fails 43 %."""
    for field in (rough(64, 12), smooth(512), smooth(512, correlation=2)):
        origins, directions = aimed(100_000, field, 13)
        hits = field.trace(origins, directions)
        assert hits.facet.min() >= 0
        assert field.escapes(field.points(origins, directions, hits.distance), -directions, hits.facet).all()


@pytest.mark.parametrize("theta", [0, 30, 60, 80, 89])
def test_visible_projected_area_is_the_cosine(theta: float) -> None:
    """The free test: for every continuous periodic surface, from every direction."""
    field, side = smooth(256, 1.0), 256
    rng = np.random.default_rng(14)
    errors = []
    for azimuth in rng.uniform(0, 2 * np.pi, 4):
        wo = spherical(math.radians(theta), azimuth)
        x, y = (np.stack(np.meshgrid(*2 * [np.arange(side)], indexing="ij")) + rng.uniform(size=(2, side, side))).reshape(2, -1)
        facets, z = field.locate(x, y)
        area = wo[2] - field.slopes[facets] @ wo[:2]
        front = area > 0
        seen = field.escapes(np.column_stack([x, y, z])[front], wo, facets[front])
        errors.append(np.sum(area[front] * seen) / side**2 - wo[2])
    assert abs(np.mean(errors)) < 2e-3
    assert np.max(np.abs(errors)) < 4e-3


# --- rays that are special --------------------------------------------------------------------------------------------


def test_a_vertical_ray_meets_the_facet_below() -> None:
    field = rough(16, 15)
    x, y = np.random.default_rng(16).uniform(-40, 40, (2, 1000))
    facets, z = field.locate(x, y)
    hits = field.trace(np.column_stack([x, y, z + 7]), [-0.0, 0, -1])
    np.testing.assert_array_equal(hits.facet, facets)
    np.testing.assert_allclose(hits.distance, 7, rtol=1e-13)
    assert field.escapes(np.column_stack([x, y, z]), [0, -0.0, 1], facets).all()


@pytest.mark.parametrize("direction", [(1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1), (2, 1)])
def test_rays_along_edges_and_through_nodes_do_not_leak(direction: tuple[float, float]) -> None:
    field = rough(16, 17)
    i, j = (g.ravel() for g in np.meshgrid(*2 * [np.arange(16.0)], indexing="ij"))
    for shift in (0.0, 0.5):
        origins = np.column_stack([i + shift, j + shift, np.full(i.size, field.highest + 0.25)])
        hits = field.trace(origins, (*direction, -1.0))
        points = field.points(origins, np.array([*direction, -1.0]), hits.distance)
        assert hits.facet.min() >= 0
        np.testing.assert_allclose(field.locate(points[:, 0], points[:, 1])[1], points[:, 2], atol=1e-13)


def test_a_ray_into_its_own_facet_meets_it_at_once() -> None:
    origins, directions, facets = leaving(1000, field := rough(16, 18), 19)
    hits = field.trace(origins, -directions, facets)
    np.testing.assert_array_equal(hits.facet, facets)
    assert not hits.distance.any()


def test_the_length_of_a_direction_only_scales_the_distance() -> None:
    field = smooth(64)
    origins, directions = aimed(1000, field, 20)
    one, other = field.trace(origins, directions), field.trace(origins, directions * 2.0**40)
    np.testing.assert_array_equal(one.facet, other.facet)
    np.testing.assert_allclose(one.distance, other.distance * 2.0**40, rtol=1e-12)


@pytest.mark.parametrize("level", [0.0, -0.0])
def test_a_horizontal_ray_above_or_in_a_valley(level: float) -> None:
    field = HeightField(np.tile(np.cos(2 * np.pi * np.arange(16) / 16), (16, 1)))
    assert field.trace([0, 8, 1.5], [1, 0, level]).facet == [ESCAPED]
    assert field.trace([0, 8, 0], [1, 0, level]).facet == [LOST]
    assert field.trace([0.5, 8, 0], [0, 1, level]).distance == pytest.approx(4.0)


def test_rays_that_start_at_the_highest_point() -> None:
    field = smooth(64)
    i, j = np.unravel_index(np.argmax(field.heights), (64, 64))
    top = [i, j, field.highest]
    assert field.trace(top, [0.3, 0.2, 0.1]).facet == [ESCAPED]
    assert field.trace(top, [0, 0, -1]).distance == pytest.approx(0, abs=1e-12)
    flat = HeightField(np.zeros((8, 8)))
    assert flat.trace([4.5, 4.25, 0], [1, 0, 1e-9], None).facet == [ESCAPED]
    assert flat.trace([4.5, 4.25, 0], [1, 0, 1e-9], [flat.locate(4.5, 4.25)[0]]).facet == [ESCAPED]


# --- independence -----------------------------------------------------------------------------------------------------


def test_results_do_not_depend_on_threads_order_or_company(monkeypatch: pytest.MonkeyPatch) -> None:
    field = smooth(1024)
    origins, directions = aimed(70_000, field, 21)
    monkeypatch.setenv("MICROFACET_THREADS", "1")
    one = field.trace(origins, directions)
    monkeypatch.setenv("MICROFACET_THREADS", "3")
    monkeypatch.setattr(height_field, "SORT", 20_000)
    shuffle = np.random.default_rng(22).permutation(len(origins))
    for rays in (shuffle, np.sort(shuffle), shuffle[:100], shuffle[:1]):
        other = field.trace(origins[rays], directions[rays])
        np.testing.assert_array_equal(one.facet[rays], other.facet)
        np.testing.assert_array_equal(one.distance[rays], other.distance)


@given(st.integers(-5, 5), st.integers(-5, 5))
def test_the_surface_repeats(a: int, b: int) -> None:
    field = rough(16, 23)
    origins, directions, facets = leaving(50, field, 24)
    here, there = (
        field.trace(origins, directions, facets),
        field.trace(origins + np.array([16 * a, 16 * b, 0]), directions, facets),
    )
    np.testing.assert_array_equal(here.facet, there.facet)


def test_no_node_is_above_the_plane_of_its_block() -> None:
    field = smooth(128)
    z = np.pad(field.heights.astype(float), ((0, 1), (0, 1)), mode="wrap")
    for shift in range(lanes.BASE, field.top + 1, lanes.STEP):
        blocks, side = 128 >> shift, 1 << shift
        words = field.planes.words[blocks**2 : 2 * blocks**2]
        heights = field.planes.height * words
        slopes = field.planes.slope * np.stack([words << 32, words << 48], axis=-1)
        place = np.arange(side + 1) - side / 2
        for block, (a, (b, c)) in enumerate(zip(heights, slopes, strict=True)):
            i, j = (block // blocks) * side, (block % blocks) * side
            gap = a + b * place[:, None] + c * place - z[i : i + side + 1, j : j + side + 1]
            assert 0 < gap.min() < 1e-3


# --- what a facet is ----------------------------------------------------------------------------------------------------


def test_located_points_lie_on_their_facets_plane() -> None:
    field = rough(8, 25)
    x, y = np.random.default_rng(26).uniform(0, 8, (2, 500))
    facets, z = field.locate(x, y)
    i, j, k = facets // 2 // 8, facets // 2 % 8, facets % 2
    np.testing.assert_array_equal([i, j], np.floor([x, y]))
    np.testing.assert_array_equal(k == 1, y - j > x - i)
    slope = field.slopes[facets]
    node = field.heights[i, j] + slope[:, 0] * (x - i) + slope[:, 1] * (y - j)
    np.testing.assert_allclose(z, node, atol=1e-14)


def test_normals_are_unit_and_average_to_the_vertical() -> None:
    field = rough(32, 27)
    normals = field.normals(np.arange(2 * 32**2))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, rtol=1e-14)
    np.testing.assert_allclose(np.mean(normals[:, :2] / normals[:, 2:], axis=0), 0, atol=1e-14)


# --- wrong arguments ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("heights", "says"),
    [
        (np.zeros((8, 16)), r"heights must have shape \(n, n\), got \(8, 16\)"),
        (np.zeros((12, 12)), "power of two.*got 12"),
        (np.zeros((4, 4)), "at least 8.*got 4"),
        (np.full((8, 8), np.nan), "heights must be finite, got nan"),
        (np.full((8, 8), 1e31), "below 1e30.*got 1e"),
    ],
)
def test_wrong_heights_are_refused(heights: np.ndarray, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        HeightField(heights)


@pytest.mark.parametrize(
    ("rays", "says"),
    [
        (([0, 0], [0, 0, -1]), r"origins and directions must have shape"),
        ((np.zeros((2, 3)), np.ones((3, 3))), r"origins and directions must have shape.*\(2, 3\), \(3, 3\)"),
        (([0, 0, np.nan], [0, 0, -1]), "origins must be finite, got nan"),
        (([0, 0, 1], [0, np.inf, -1]), "directions must be finite, got inf"),
        (([0, 0, 1], [0, 0, 0]), r"directions must have a length.*got \[0. 0. 0.\] at index 0"),
        (([1e9, 0, 1], [0, 0, -1]), "origins must lie within"),
        (([0, 0, 1], [0, 0, 1], [128]), "facets must be below 128, got 128"),
        (([0, 0, 1], [0, 0, 1], [0.5]), "facets must be whole numbers"),
        (([3.5, 0.2, 1], [0, 0, 1], [0]), r"facet 0 does not hold \[3.5 0.2 1. \] of ray 0"),
    ],
)
def test_wrong_rays_are_refused(rays: tuple, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        HeightField(np.zeros((8, 8))).trace(*rays)
