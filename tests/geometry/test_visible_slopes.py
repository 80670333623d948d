"""Beckmann's visible slopes: the share below the slope returned is the number it was drawn with, to rounding, everywhere."""

from __future__ import annotations

from itertools import product

import mpmath
import numpy as np
import pytest
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import packed
from microfacet.geometry.visible_slopes import LEAST, NOTHING, gaussian_slope, guess, visible_gaussian_slope
from microfacet.special_functions import exponential_within, logarithm_about, scaled_erfc
from samples import LAST, LAST_SINGLE

ALONG = Batch(packed(visible_gaussian_slope, 3, 0), [1, 1, 1])
ACROSS = Batch(packed(gaussian_slope, 1, 0), [1])
EXPONENTIAL = Batch(packed(exponential_within, 1, 0), [1])
LOGARITHM = Batch(packed(logarithm_about, 1, 0), [1])
SCALED = Batch(packed(scaled_erfc, 1, 0), [1])

REALS = [np.float64, np.float32]
RESIDUAL = {np.float64: 1e-15, np.float32: 5e-7}  # of the share
TAIL = {np.float64: 1e-13, np.float32: 1e-4}  # relative, down to shares of 1e-28
EDGES = (NOTHING, 1e-12, 1e-6, 1e-3, 1 - 1e-3, 1 - 1e-6, 1 - 1e-12)  # of s: from straight above to the horizon


def shares(real: type) -> np.ndarray:
    """Both ends by powers of ten, the middle evenly."""
    ends = 10.0 ** -np.arange(1, 29 if real is np.float64 else 13)
    below = 1 - 10.0 ** -np.arange(1, 16 if real is np.float64 else 7)
    last = LAST if real is np.float64 else LAST_SINGLE
    return np.unique(np.concatenate([ends, np.linspace(0.02, 0.98, 17), below, [last]]).astype(real))


def views(real: type) -> tuple[np.ndarray, np.ndarray]:
    """s and z = 1 - s, both to all their digits."""
    c = np.concatenate([np.linspace(0.1, 9, 14), 10.0 ** np.arange(2, 6)])
    s = np.concatenate([1 / (1 + c), EDGES[:-3]])
    z = np.concatenate([1e-30 * np.ones(1), 10.0 ** -np.arange(1, 9)])
    pairs = np.array([(a, 1 - a) for a in s] + [(1 - b, b) for b in z], real)
    return pairs[:, 0], pairs[:, 1]


def visible(x: mpmath.mpf, s: mpmath.mpf, z: mpmath.mpf) -> mpmath.mpf:
    return z * mpmath.erfc(-x) / 2 + s * mpmath.exp(-x * x) / (2 * mpmath.sqrt(mpmath.pi))


def exact(value: float) -> mpmath.mpf:
    return mpmath.mpf(float(value))


@pytest.mark.parametrize("real", REALS)
def test_the_share_below_is_the_number(real: type) -> None:
    """By the error function at 50 digits: absolutely to rounding, and relatively in the lower tail."""
    u, (all_s, all_z) = shares(real), views(real)
    for s, z, found in zip(all_s, all_z, ALONG([all_s[:, None], all_z[:, None], u[None]]), strict=True):
        with mpmath.workdps(50):
            area = visible(exact(z) / exact(s), exact(s), exact(z))
            for share, x in zip(u, found, strict=True):
                off = abs(visible(exact(x), exact(s), exact(z)) / area - exact(share))
                assert off <= RESIDUAL[real], (s, z, share)
                assert off <= TAIL[real] * exact(share) or share > 0.5, (s, z, share)


@pytest.mark.parametrize("real", REALS)
def test_the_share_below_across_is_the_number(real: type) -> None:
    """Relatively in both tails: by the nearer end."""
    u = shares(real)
    for share, x in zip(u, ACROSS([u]), strict=True):
        with mpmath.workdps(50):
            tail = min(exact(share), 1 - exact(share))
            off = abs(mpmath.erfc(abs(exact(x))) / 2 - tail)
            assert off <= min(RESIDUAL[real], TAIL[real] * tail), share
            assert (x < 0) == (share < 0.5) or share == 0.5


@pytest.mark.parametrize("real", REALS)
def test_slopes_at_the_edges(real: type) -> None:
    """Numbers that are 0 count as the least; no slope lies beyond the edge of visibility by more than its rounding."""
    last = LAST if real is np.float64 else LAST_SINGLE
    u = np.array([0, 1e-38, LEAST, 0.5, last], real)
    for s, z in [(s, max(1 - s, NOTHING)) for s in EDGES] + [(1.0, 1e-30), (NOTHING, 1.0)]:
        found = ALONG([np.full(5, s, real), np.full(5, z, real), u])
        assert np.isfinite(found).all()
        assert found[0] == found[1] == found[2]
        assert (np.diff(found) >= 0).all()
        assert found[-1] <= z / s + 4 * np.finfo(real).eps * max(1, z / s)
    assert np.isfinite(ACROSS([u])).all()


@pytest.mark.parametrize("real", REALS)
def test_slopes_grow_with_the_number(real: type) -> None:
    u = np.linspace(0, LAST if real is np.float64 else LAST_SINGLE, 20_001).astype(real)
    for s in (1e-9, 0.1, 0.2, 0.3, 0.5, 0.9, 1 - 1e-6):
        step = np.diff(ALONG([np.full(u.size, s, real), np.full(u.size, 1 - s, real), u]))
        assert step.min() >= -8 * np.finfo(real).eps
    assert np.diff(ACROSS([u])).min() >= -8 * np.finfo(real).eps


def test_the_guess_is_near_enough_for_two_steps() -> None:
    """Its distance from the edge of visibility is positive and that of its slope, and the slope is near the one found."""
    for c, u in product((0.01, 0.5, 1.5, 3.0, 8.0), (1e-20, 1e-3, 0.3, 0.9, 0.999)):
        s, z = 1 / (1 + c), c / (1 + c)
        x, d = guess(s, z, c, float(np.exp(-c * c / 2)), u)
        assert d == pytest.approx(z - s * x, rel=1e-9)
        assert x == pytest.approx(visible_gaussian_slope(s, z, u), abs=0.15)


# --- the functions ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("real", REALS)
def test_functions_against_fifty_digits(real: type) -> None:
    """exp to two ulps for |x| below 80, exp(x^2) erfc(x) to four from 0 to 9, log to a relative 2e-7 also next to 1."""
    eps = np.finfo(real).eps
    random = np.random.default_rng(0)
    x = np.concatenate([random.uniform(-80, 80, 1000), [0.0, 80.0, -80.0]]).astype(real)
    a = np.concatenate([random.uniform(0, 9, 1000), [0.0, 9.0]]).astype(real)
    v = np.concatenate([10.0 ** random.uniform(-30, 1, 1000), [LAST_SINGLE, 1 + 1e-6, 0.70710678, 0.7071068]]).astype(real)
    with mpmath.workdps(50):
        for points, batch, function, bound in (
            (x, EXPONENTIAL, mpmath.exp, 2 * eps),
            (a, SCALED, lambda t: mpmath.exp(t * t) * mpmath.erfc(t), 4 * eps),
            (v, LOGARITHM, mpmath.log, 2e-7 if real is np.float64 else 4e-7),
        ):
            right = [function(exact(p)) for p in points]
            worst = max(abs(exact(w) / r - 1) for w, r in zip(batch([points]), right, strict=True))
            assert worst <= bound, function


def test_functions_in_plain_python_are_those_of_loops() -> None:
    x = np.linspace(0.1, 9, 50)
    for function, batch in ((exponential_within, EXPONENTIAL), (logarithm_about, LOGARITHM), (scaled_erfc, SCALED)):
        np.testing.assert_allclose([function(float(v)) for v in x], batch([x]), rtol=1e-15)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose([logarithm_about(float(v)) for v in x], LOGARITHM([1.0001 * x]), rtol=1e-15)
