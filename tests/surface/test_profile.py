"""The polyline's visibility against exact rational arithmetic and against the areas it must conserve."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from microfacet.surface.profile import (
    Pieces,
    Profile,
    angle,
    direction,
    mirror,
)
from report.example import example

TILT = np.radians([-89.9, -75, -60, -30, -1, 0, 1e-9, 12, 45, 60, 80, 89.9])
PROFILES = [
    Profile.gaussian(alpha, facets, waves, seed)
    for seed, (alpha, facets, waves) in enumerate([(0.1, 3, 1), (0.5, 7, 4), (1.0, 12, 6), (2.0, 50, 9), (0.8, 400, 30)])
]


def painter(profile: Profile, slope: Fraction) -> list[Fraction]:
    """Visible fraction of each facet: cut the view into slabs; in each, the nearest facet wins."""
    x, z = ([Fraction(float(v)) for v in values] for values in (profile.x, profile.z))
    n = len(x) - 1
    reach = int(abs(slope) * (max(z) - min(z))) + 2
    facets = []
    for shift in range(-reach, reach + 1):
        for i in range(n):
            s = [x[j] + shift - slope * z[j] for j in (i, i + 1)]
            facets.append((i, shift, s, (z[i], z[i + 1])))
    cuts = sorted({value for *_, s, _ in facets for value in s})
    seen = [Fraction(0)] * n
    for low, high in pairwise(cuts):
        middle, over = (low + high) / 2, []
        for i, shift, s, height in facets:
            if min(s) < middle < max(s):
                u = (middle - s[0]) / (s[1] - s[0])
                over.append(
                    (
                        height[0] + u * (height[1] - height[0]),
                        i,
                        shift,
                        (high - low) / abs(s[1] - s[0]),
                    )
                )
        if over and max(over)[2] == 0:
            _, i, _, fraction = max(over)
            seen[i] += fraction
    return seen


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("theta", TILT)
def test_visible_lengths_add_up_to_the_cosine(profile: Profile, theta: float) -> None:
    wo = direction(theta)
    assert profile.visible(wo).projected(wo).sum() == pytest.approx(np.cos(theta), rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("profile", PROFILES)
def test_facets_project_to_one_on_the_plane(profile: Profile) -> None:
    up = direction(0.0)
    assert profile.whole.projected(up).sum() == pytest.approx(1, abs=1e-14)
    np.testing.assert_array_equal(profile.visible(up).fraction, 1)


@pytest.mark.parametrize("profile", PROFILES[:4])
@pytest.mark.parametrize("slope", [Fraction(-5), Fraction(-7, 8), Fraction(1, 3), Fraction(7, 4), Fraction(12)])
def test_visible_fractions_against_exact_arithmetic(profile: Profile, slope: Fraction) -> None:
    fraction = profile.visible(direction(np.arctan(float(slope)))).fraction
    np.testing.assert_allclose(fraction, np.array(painter(profile, slope), dtype=float), atol=2e-12)


heights = st.lists(st.integers(0, 8), min_size=2, max_size=6)


@given(heights=heights, numerator=st.integers(-40, 40))
def test_lattice_profiles_against_exact_arithmetic(heights: list[int], numerator: int) -> None:
    """Nodes on a lattice: many facets are hidden to the very vertex, or seen edge-on, where only the length counts."""
    n = len(heights)
    profile = Profile(np.arange(n + 1) / n, np.array([*heights, heights[0]]) / 8)
    wo = direction(np.arctan2(numerator, 8))
    exact = np.array(painter(profile, Fraction(numerator, 8)), dtype=float)
    expected = exact * profile.whole.projected(wo)
    np.testing.assert_allclose(profile.visible(wo).projected(wo), expected, atol=1e-14)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("theta", [-70, -20, 35, 80])
def test_rays_from_visible_parts_escape_and_others_do_not(profile: Profile, theta: float) -> None:
    wo = direction(np.radians(theta))
    visible = profile.visible(wo)
    for part, blocked in (
        (visible, False),
        *((rest, True) for rest in profile.whole.without(visible)),
    ):
        for facet in np.flatnonzero(part.fraction > 1e-9):
            free = not np.isfinite(profile.hit(facet, part.middle[facet], wo))
            front = profile.normals[facet] @ wo > 0
            assert (not free or not front) if blocked else free


@pytest.mark.parametrize("theta", [-75, -40, 0, 60])
def test_escaping_reflections_against_rays(theta: float) -> None:
    profile, wo = example(48), direction(np.radians(theta))
    seen, wi = profile.visible(wo), mirror(wo, profile.normals)
    free = seen.both(profile.escaping(wi))
    blocked = seen.without(free)
    total = sum(part.projected(wo).sum() for part in (free, *blocked))
    assert total == pytest.approx(np.cos(np.radians(theta)), abs=1e-14)
    for part, lost in ((free, False), (blocked[0], True), (blocked[1], True)):
        for facet in np.flatnonzero(part.fraction > 1e-9):
            assert np.isfinite(profile.hit(facet, part.middle[facet], wi[facet])) == lost


def test_mirror_keeps_the_width_of_a_beam() -> None:
    profile, wo = example(), direction(np.radians(60))
    seen, wi = profile.visible(wo), mirror(wo, profile.normals)
    np.testing.assert_allclose(np.hypot(wi[:, 0], wi[:, 1]), 1)
    np.testing.assert_allclose(angle(wi) + np.radians(60), 2 * angle(profile.normals), atol=1e-12)
    np.testing.assert_allclose(seen.projected(wi), seen.projected(wo), atol=1e-15)


def test_slopes_have_the_promised_root_mean_square() -> None:
    profile = Profile.gaussian(0.7, 4000, waves=9, seed=3)
    slope = profile.edges[:, 1] / profile.edges[:, 0]
    assert np.sqrt(np.mean(slope**2)) == pytest.approx(0.7 / np.sqrt(2), rel=1e-4)


def test_one_seed_is_one_curve() -> None:
    coarse, fine = Profile.gaussian(0.8, 12, seed=5), Profile.gaussian(0.8, 48, seed=5)
    np.testing.assert_allclose(np.diff(coarse.z), np.diff(fine.z[::4]), atol=1e-14)
    np.testing.assert_array_equal(Profile.gaussian(0.8, 12, seed=5).z, coarse.z)
    moved = Profile.gaussian(0.8, 12, seed=5, jitter=0.6)
    many = Profile.gaussian(0.8, 4096, seed=5)
    np.testing.assert_allclose(moved.z - moved.z[0], np.interp(moved.x, many.x, many.z) - many.z[0], atol=1e-6)
    assert 0 < np.abs(moved.x - coarse.x).max() < 0.3 / 12


@pytest.mark.parametrize("theta", [-70, 0, 33, 60])
def test_repeating_keeps_what_is_seen(theta: float) -> None:
    wo = direction(np.radians(theta))
    once, often = example(), example().repeat(5)
    np.testing.assert_allclose(often.visible(wo).fraction, np.tile(once.visible(wo).fraction, 5), atol=1e-11)


def test_a_flat_surface_hides_nothing() -> None:
    flat = Profile(np.array([0.0, 1.0]), np.array([0.0, 0.0]))
    for theta in TILT:
        np.testing.assert_array_equal(flat.visible(direction(theta)).fraction, 1)


def test_hand_made_cavity() -> None:
    """Slopes of 1: at 45 degrees one side vanishes; at arctan 3 half of the other is left."""
    cavity = Profile(np.array([0.0, 0.5, 1.0]), np.array([0.5, 0.0, 0.5]))
    np.testing.assert_allclose(cavity.visible(direction(np.arctan(1.0))).fraction, [1, 0], atol=1e-15)
    np.testing.assert_allclose(cavity.visible(direction(np.arctan(3.0))).fraction, [0.5, 0], atol=1e-15)
    np.testing.assert_allclose(cavity.visible(direction(-np.arctan(3.0))).fraction, [0, 0.5], atol=1e-15)


@pytest.mark.parametrize(
    ("wo", "says"),
    [
        ((np.nan, 1.0), r"wo must be finite, got .*nan"),
        ((np.inf, 0.0), r"wo must be finite, got .*inf"),
        ((1.0, 0.0), r"wo must point above the horizon, z > 0, got .*1\., 0\."),
        ((0.6, -0.8), r"wo must point above the horizon, z > 0, got .*-0\.8"),
        ((0.0, 2.0), r"wo must have length 1, got .*2\."),
        ((0.0, 0.0, 1.0), r"wo must have the shape \(2,\), got shape \(3,\)"),
        (1.0, r"wo must have the shape \(2,\), got shape \(\)"),
    ],
)
def test_bad_directions_are_named(wo: object, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        example().visible(wo)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("x", "z", "says"),
    [
        ([0, 1], [0, np.nan], "z must be finite, got .*nan"),
        ([0, 1], [0, 1], "z must end at the height it starts from, got .*0.* and .*1"),
        ([0, 0.5, 0.5, 1], [0, 1, 2, 0], "x must rise strictly from 0 to 1, got .*0.5"),
        ([0, 2], [0, 0], "x must rise strictly from 0 to 1, got .*2"),
        ([0, 0.5, 1], [0, 0], r"x and z must have one shape, got \(3,\) and \(2,\)"),
        ([0], [0], r"x must have the shape .* got shape \(1,\)"),
    ],
)
def test_bad_profiles_are_named(x: list[float], z: list[float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        Profile(np.array(x), np.array(z))


def test_other_bad_input_is_named() -> None:
    profile = example()
    bad = np.full((12, 2), np.nan)
    for call, says in (
        (lambda: Profile.gaussian(-1, 4), "alpha must be finite and >= 0, got -1"),
        (lambda: Profile.gaussian(np.nan, 4), "alpha must be finite and >= 0, got nan"),
        (lambda: Profile.gaussian(1, 0), "facets=0"),
        (lambda: Profile.gaussian(1, 4, jitter=1.0), r"jitter must lie in \[0, 1\), got 1.0"),
        (lambda: profile.repeat(0), "times must be at least 1, got 0"),
        (
            lambda: profile.escaping(direction(0.1)),
            r"wi must be finite, of shape \(12, 2\), got shape \(2,\)",
        ),
        (lambda: profile.escaping(bad), "wi must be finite.*nan"),
        (lambda: direction(np.inf), "theta must be a finite angle in radians, got inf"),
    ):
        with pytest.raises(ValueError, match=says):
            call()


def test_pieces_without_a_piece() -> None:
    profile = Profile(np.array([0.0, 0.5, 1.0]), np.zeros(3))
    outer = Pieces(profile, np.array([0.1, 0.0]), np.array([0.9, 1.0]))
    inner = Pieces(profile, np.array([0.2, 0.5]), np.array([0.5, 0.5]))
    before, behind = outer.without(inner)
    np.testing.assert_allclose(before.fraction, [0.1, 1.0])
    np.testing.assert_allclose(behind.fraction, [0.4, 0.0])
