"""Conventions of roughness against their sources' formulae at 50 digits."""

from __future__ import annotations

import microfacet as mf
import mpmath as mp
import numpy as np
import pytest
from microfacet.geometry.roughness import CONVENTIONS

ROUGHNESS = np.concatenate([np.geomspace(1e-4, 1, 41), [0.5]])
PBRT3 = ("1.62142", "0.819955", "0.1734", "0.0171201", "0.000640711")


def stated(convention: str, roughness: float) -> mp.mpf:
    r = mp.mpf(roughness)
    x = mp.log(max(r, mp.mpf("0.001")))
    return {
        "squared": r * r,
        "alpha": r,
        "pbrt-v3": mp.fsum(mp.mpf(factor) * x**k for k, factor in enumerate(PBRT3)),
        "pbrt-v4": mp.sqrt(r),
        "phong": mp.sqrt(2 / (r + 2)),
    }[convention]


@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_alpha_is_as_the_convention_says(convention: str, real: type) -> None:
    given = ROUGHNESS.astype(real)
    found = mf.alpha_from_roughness(given, convention)
    assert found.dtype == real
    with mp.workdps(50):
        right = [float(stated(convention, float(r))) for r in given]
    np.testing.assert_allclose(found, right, rtol=(60 if convention == "pbrt-v3" else 2) * np.finfo(real).eps)


def test_single_values_and_what_they_are_for() -> None:
    assert mf.alpha_from_roughness(0.5) == 0.25
    assert mf.GGX(mf.alpha_from_roughness(0.5)) == mf.GGX(0.25)
    assert mf.alpha_from_roughness(98, "phong") == pytest.approx(np.sqrt(2 / 100), rel=1e-15)
    alpha = mf.alpha_from_roughness(30.0, "phong")
    assert 2 / alpha**2 - 2 == pytest.approx(30, rel=1e-14)


def test_conventions_disagree() -> None:
    found = [float(mf.alpha_from_roughness(0.3, name)) for name in CONVENTIONS]
    assert min(abs(a - b) for k, a in enumerate(found) for b in found[:k]) > 0.01


def test_anisotropy_stretches_and_keeps_the_product() -> None:
    amount = np.linspace(0, 1, 11)
    along, across = mf.stretched_alpha(0.25, amount)
    np.testing.assert_allclose(along * across, 0.25**2, rtol=1e-15)
    np.testing.assert_allclose(across / along, 1 - 0.9 * amount, rtol=1e-14)
    assert mf.GGX(*mf.stretched_alpha(0.25, 0)) == mf.GGX(0.25)
    assert all(part.dtype == np.float32 for part in mf.stretched_alpha(np.float32(0.2), np.float32(0.5)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.5, "linear"), "convention must be one of squared, alpha, pbrt-v3, pbrt-v4, phong, got 'linear'"),
        ((0.0,), r"roughness must be in \(0, 1\] by the convention 'squared', got 0 to 0"),
        (([0.5, 1.5],), r"roughness must be in \(0, 1\] .* got 0.5 to 1.5"),
        ((-1, "phong"), "roughness must be above 0 by the convention 'phong', got -1"),
        ((np.nan,), "roughness must be finite, got nan"),
        (("rough",), "roughness must be an array of numbers, got 'rough'"),
    ],
)
def test_what_is_no_roughness(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mf.alpha_from_roughness(*arguments)


@pytest.mark.parametrize(("alpha", "amount", "name"), [(0, 0.5, "alpha"), (0.3, 2, "anisotropic"), (0.3, -1, "anisotropic")])
def test_what_cannot_be_stretched(alpha: float, amount: float, name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} must"):
        mf.stretched_alpha(alpha, amount)
