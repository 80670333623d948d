"""The albedo, and its error, which is a bound: at points known exactly, and against sums of another kind."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import microfacet as mf
import numpy as np
import pytest
import rays
from albedos import CASES, KINDS, case, compared
from microfacet.brdf.compensation import mean_reflectance
from microfacet.directions import spherical
from microfacet.geometry.slopes import Distribution

PARTS = 8


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_the_error_told_bounds_the_distance_to_another_sum(part: int) -> None:
    """1,000 cases in all parts: in none is the truth outside. The other sum's own error is allowed for, and is mostly less."""
    pairs = [(kind, k) for kind in range(part, len(KINDS), PARTS) for k in range(CASES[kind])]
    found = np.array([compared(*case(*pair)) for pair in pairs])
    ratio, told, off = found.T
    print(f"{len(found)} cases, distance over bound: median {np.median(ratio):.2g}, largest {ratio.max():.2g}")
    print(f"right to 1e-6: {np.sum(ratio * told <= 1e-6)}, told to be so: {np.sum(told <= 1e-6)}")
    print(f"other sum better known: {np.sum(off < told)}")
    assert (ratio <= 1 + off / told).all(), [pair for pair, bad in zip(pairs, ratio > 1 + off / told, strict=True) if bad]
    assert np.mean(off < told) > 0.99
    assert np.mean(told <= 1e-6) > 0.97


def at(degrees: float, phi: float = 0.0) -> np.ndarray:
    return spherical(np.radians(degrees), phi)


UP = np.array([0.0, 0.0, 1.0])
GLASS = mf.Dielectric(1.5)
KNOWN = [  # by other programs, or by integrals over one variable
    ("total reflection", lambda: mf.Microfacet(mf.Smith(mf.GGX(0.3)), mf.Dielectric(0.23)), UP, 0.6451576500429814, 1e-13),
    ("unequal", lambda: mf.Microfacet(mf.Smith(mf.GGX(1, 10))), at(30), 0.016228, 5e-7),
    (
        "narrow",
        lambda: mf.Microfacet(mf.Smith(mf.GGX(13.806, 0.83)), GLASS),
        at(85.878, np.pi / 2),
        0.008297,
        1e-6,
    ),
    ("cavity", lambda: mf.Microfacet(mf.VCavity(mf.GGX(1))), UP, 0.375, 1e-15),
    ("flat", lambda: mf.Microfacet(mf.Smith(mf.GGX(1e-8)), mf.Dielectric(1.5)), UP, 0.04, 1e-15),
    ("anchor", lambda: mf.Microfacet(mf.Smith(mf.GGX(1))), at(60), 1 - 0.5 * np.log(3), 1e-15),
    # by the sum of rays.py
    (
        "steep cavities",
        lambda: mf.Microfacet(mf.VCavity(mf.GGX(144.90142527795788)), mf.Dielectric(0.3060287512569562)),
        np.array([-0.923936896469137, 0.3825379721852572, 0.0023045996117673465]),
        0.626909064722797,
        1e-14,
    ),
    (
        "steep, by azimuth",
        lambda: mf.Microfacet(mf.Smith(mf.GGX(236.38350140255963), "direction"), mf.Dielectric(3.7450236329482958)),
        np.array([0.4566049063590067, 0.8896030031121445, 0.010883765099308685]),
        0.00347742965057218,
        1e-15,
    ),
]


@pytest.mark.parametrize(("make", "wo", "right", "known"), [row[1:] for row in KNOWN], ids=[row[0] for row in KNOWN])
def test_the_albedo_is_right_where_it_is_known(make: Any, wo: np.ndarray, right: float, known: float) -> None:
    value, error = make().albedo_with_error(wo)
    assert abs(value - right) <= error + known
    assert error < 1e-6 * value


@pytest.mark.parametrize("pair", [(0, 3), (1, 14), (8, 7), (9, 2), (20, 19)], ids=str)
def test_a_few_random_cases_agree_with_another_sum(pair: tuple[int, int]) -> None:
    """What the slow test does for many. At the last, things change beside one ray within 1e-9 of an angle, and next to it
    another begins."""
    ratio, told, off = compared(*case(*pair))
    assert ratio <= 1 + off / told
    assert off < told


@pytest.mark.parametrize("z", [1e-8, 1e-3, 0.3, 0.999])
def test_the_other_sum_is_right_where_the_albedo_has_a_closed_form(z: float) -> None:
    """That of GGX at alpha = 1, for perfect mirrors."""
    right = 1 - z * np.log1p(1 / z)
    found, off = rays.albedo(mf.Microfacet(mf.Smith(mf.GGX(1))), np.array([np.sqrt((1 - z) * (1 + z)), 0, z]), right, 1e-13)
    assert abs(found - right) <= off + 1e-15
    assert off < 1e-13


def test_directions_below_the_horizon_reflect_nothing_for_certain() -> None:
    for brdf in (mf.Microfacet(mf.Smith(mf.GGX(0.3))), mf.Compensated(mf.Microfacet(mf.Smith(mf.GGX(0.3))))):
        value, error = brdf.albedo_with_error([[0, 0, -1], [1, 0, 0], [0, 0, 1]])
        assert (value[:2] == 0).all()
        assert (error[:2] == 0).all()
        assert value[2] > 0.8


def test_a_distribution_of_ones_own_with_kinks_tells_an_error_that_holds() -> None:
    """Its density ends in a kink at a slope: the rule does not know where. A rule for all slopes up to there does."""

    class Cut(Distribution):
        parameters, slope_scale, isotropic = (), (0.3, 0.3), True

        @staticmethod
        def kernel(x: float, y: float, z: float, p: Any) -> float:
            slope = sqrt(x * x + y * y) / z
            return 10.61032953945969 * max(1.0 - slope / 0.3, 0.0) / (z * z * z * z)  # 3/(0.09 pi)

    value, error = mf.Microfacet(mf.Implicit(Cut())).albedo_with_error(UP)
    s, w = np.polynomial.legendre.leggauss(60)
    slope = 0.15 * (s + 1)
    right = 0.15 * w @ (6 * slope / 0.09 * (1 - slope / 0.3) * (1 - slope**2) / (1 + slope**2))  # cos theta_i = cos 2 theta_m
    assert abs(value - right) <= error
    assert error < 0.01


class Same(mf.GGX):
    """Another name, and nothing else."""


class Heavier(mf.Beckmann):
    """Beckmann's class with the facets of GGX: neither Lambda nor the reach of his slopes is theirs."""

    kernel = staticmethod(mf.GGX.kernel)


class Wider(mf.GGX):
    """Three times rougher along y, though the class says that both axes are alike."""

    @staticmethod
    def kernel(wm: tuple[float, float, float], p: Any) -> float:
        x, y, z = wm
        u, v = x / p.alpha_x, y / (3.0 * p.alpha_x)
        square = u * u + v * v + z * z
        return 1.0 / (3.0 * pi * p.alpha_x * p.alpha_x * square * square)


@pytest.mark.parametrize("masked", [mf.Smith, mf.VCavity], ids=["smith", "v_cavity"])
@pytest.mark.parametrize(("derived", "plain"), [(Heavier(0.3), mf.GGX(0.3)), (Wider(0.3), mf.GGX(0.3, 0.9))], ids=str)
def test_a_derived_distribution_counts_by_its_kernel(masked: Any, derived: Any, plain: Any) -> None:
    wo = at(70, 0.6)
    value, error = mf.Microfacet(masked(derived), GLASS).albedo_with_error(wo)
    right, off = mf.Microfacet(masked(plain), GLASS).albedo_with_error(wo)
    assert abs(value - right) <= error + off
    assert error < 1e-3 * value


def test_a_derived_class_that_changes_nothing_is_known_as_well() -> None:
    class Alike(mf.VCavity):
        pass

    class Glass(mf.Dielectric):
        pass

    found = mf.Microfacet(Alike(Same(0.3)), Glass(0.7)).albedo_with_error(at(40, 0.6))
    assert found == mf.Microfacet(mf.VCavity(mf.GGX(0.3)), mf.Dielectric(0.7)).albedo_with_error(at(40, 0.6))


def test_single_precision_gives_the_same_and_tells_its_rounding() -> None:
    brdf, wo = mf.Microfacet(mf.Smith(mf.GGX(0.3))), at(60).astype(np.float32)
    value, error = brdf.albedo_with_error(wo)
    assert value.dtype == error.dtype == np.float32
    assert abs(float(value) - float(brdf.albedo(wo.astype(float)))) <= error


@pytest.mark.parametrize("eta", [0.25, 1 / 1.5, 1.5, 4.0])
def test_the_mean_reflectance_is_cut_where_it_becomes_total(eta: float) -> None:
    """Against sums of many equal steps on either side."""
    value, error = mean_reflectance(mf.Dielectric(eta))
    cut = np.sqrt(max(1 - eta**2, 0))
    s, w = np.polynomial.legendre.leggauss(400)
    t = (s + 1) / 2
    c = cut + (1 - cut) * t**2
    right = cut**2 + (1 - cut) * (w * t * 2 * c) @ mf.Dielectric(eta).F(np.minimum(c, 1))
    assert abs(value - right) <= error + 1e-12
    assert error < 1e-9


def test_compensation_tells_what_its_series_misses() -> None:
    """Directions between those that the series was made of and compared at."""
    brdf = mf.Compensated(mf.Microfacet(mf.Smith(mf.GGX(0.5)), mf.Dielectric(1 / 1.5)))
    assert abs(brdf.added - 0.30323097) < brdf.added_error + 5e-9
    wo = at(np.random.default_rng(1).uniform(0, 90, 200))
    scaled = mf.Compensated(mf.Microfacet(mf.Smith(mf.GGX(0.5))), "scaled")
    brighter = scaled.evaluate(wo, wo) / scaled.brdf.evaluate(wo, wo)
    kept = scaled.brdf.albedo(wo)
    assert (abs(1 / brighter - kept) <= scaled.off * kept).all()
