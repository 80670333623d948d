"""Fresnel reflectance against complex amplitudes at 60 digits, and where its values are known."""

from __future__ import annotations

import microfacet as mf
import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from microfacet.material import fresnel

COSINES = st.floats(1e-6, 1)
INDEX = st.floats(0.1, 4)
EPS = {real: float(np.finfo(real).eps) for real in (np.float64, np.float32)}


def amplitudes(cosine: float, index: complex) -> tuple[mp.mpc, mp.mpc]:
    """Snell's law for a complex index, then s and p."""
    with mp.workdps(60):
        c, n = mp.mpf(float(cosine)), mp.mpc(index)
        refracted = mp.sqrt(1 - (1 - c * c) / n**2)
        return (c - n * refracted) / (c + n * refracted), (n * c - refracted) / (n * c + refracted)


def unpolarised(cosine: float, index: complex) -> float:
    with mp.workdps(60):
        return float(sum(abs(r) ** 2 for r in amplitudes(cosine, index)) / 2)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(cosine=COSINES, eta=INDEX)
def test_dielectric(real: type, cosine: float, eta: float) -> None:
    """For eta < 1 too; next to the angle of total reflection the value changes as a square root."""
    cosine, eta = real(cosine), real(eta)
    margin = abs(float(eta) ** 2 - 1 + float(cosine) ** 2)
    if margin > 1e-3 and abs(eta - 1) > 1e-3:
        value = mf.Dielectric(eta).F(cosine)
        assert value.dtype == real
        assert float(value) == pytest.approx(unpolarised(cosine, mp.mpf(float(eta))), rel=1e4 * EPS[real])


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(cosine=COSINES, eta=INDEX, k=st.floats(0.05, 10))
def test_conductor(real: type, cosine: float, eta: float, k: float) -> None:
    cosine, eta, k = real(cosine), real(eta), real(k)
    value = mf.Conductor(eta, k).F(cosine)
    assert value.dtype == real
    assert float(value) == pytest.approx(unpolarised(cosine, mp.mpc(float(eta), float(k))), rel=1e2 * EPS[real])


def test_normal_incidence_grazing_and_brewster() -> None:
    for eta in (1.5, 1 / 1.5, 2.4):
        F = mf.Dielectric(eta).F
        assert F(1.0) == pytest.approx(((eta - 1) / (eta + 1)) ** 2, rel=1e-13, abs=0)
        assert F(0.0) == 1
    brewster = np.cos(np.arctan(1.5))
    s, p = amplitudes(brewster, 1.5)
    assert abs(p) < 1e-15
    assert mf.Dielectric(1.5).F(brewster) == pytest.approx(float(abs(s) ** 2) / 2, rel=1e-13, abs=0)


def test_total_reflection_begins_where_snell_says() -> None:
    eta = 1 / 1.5
    critical = np.sqrt(1 - eta**2)
    np.testing.assert_array_equal(mf.Dielectric(eta).F(np.linspace(0, critical - 1e-12, 50)), 1)
    assert mf.Dielectric(eta).F(critical + 1e-3) < 0.9


def test_equal_indices_reflect_nothing() -> None:
    np.testing.assert_array_equal(mf.Dielectric(1.0).F(np.linspace(0.01, 1, 20)), 0)


def test_a_conductor_that_absorbs_nothing_is_a_dielectric() -> None:
    c = np.linspace(0.01, 1, 50)
    np.testing.assert_allclose(mf.Conductor(1.5, 1e-10).F(c), mf.Dielectric(1.5).F(c), rtol=1e-9)


def test_schlick_meets_fresnel_at_both_ends() -> None:
    F = mf.Schlick(0.04)
    assert F.F(1.0) == pytest.approx(0.04, rel=1e-15, abs=0)
    assert F.F(0.0) == 1
    c = np.linspace(0, 1, 101)
    np.testing.assert_allclose(F.F(c), 0.04 + 0.96 * (1 - c) ** 5, rtol=1e-14)
    np.testing.assert_allclose(F.F(c), mf.Dielectric(1.5).F(c), atol=0.05)


MATERIALS = {
    "glass": mf.Dielectric(1.5),
    "out of glass": mf.Dielectric(0.7),
    "gold": mf.Conductor(0.2, 3.0),
    "silver after Schlick": mf.Schlick(0.9),
}


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_reflectance_is_a_share(name: str, real: type) -> None:
    value = MATERIALS[name].F(np.linspace(0, 1, 501, dtype=real))
    assert value.dtype == real
    assert ((value >= 0) & (value <= 1 + 4 * EPS[real])).all()


@pytest.mark.parametrize("wrong", [-0.1, 1.1, np.nan, [0.5, np.inf]])
def test_cosines_outside_their_range(wrong: object) -> None:
    with pytest.raises(ValueError, match=r"cosine must lie in \[0, 1\]"):
        mf.Schlick(0.5).F(wrong)


@pytest.mark.parametrize("wrong", [1j, "a", None, np.ma.masked, np.ma.array([0.5, 0.5], mask=[False, True])])
def test_cosines_are_real_numbers(wrong: object) -> None:
    with pytest.raises(ValueError, match="cosine must be an array of numbers, got"):
        mf.Schlick(0.5).F(wrong)


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_indices_within_their_limits_give_shares(real: type) -> None:
    """Also at the ends, next to 1, and at cosines as small as the precision has."""
    cosines = np.concatenate([[0, np.finfo(real).tiny], np.geomspace(1e-12, 1, 25), 1 - np.geomspace(1e-7, 0.5, 9)])
    indices = [*np.geomspace(*fresnel.INDEX, 19), 1 - 1e-16, 1 + 1e-15, 1 - 1e-8, 1 + 1e-4, 1.5]
    made = [*map(mf.Dielectric, indices), *(mf.Conductor(eta, k) for eta in indices for k in indices)]
    for material in made:
        value = material.F(cosines.astype(real))
        assert ((value >= 0) & (value <= 1 + 4 * EPS[real])).all(), material.parameters


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: mf.Dielectric(0), "eta must be a finite number above 0, got 0"),
        (lambda: mf.Dielectric(np.nan), "eta must be a finite number above 0, got nan"),
        (lambda: mf.Conductor(1.0, -2), "k must be a finite number above 0, got -2"),
        (lambda: mf.Conductor("gold", 1), "eta must be a number above 0, got 'gold'"),
        (lambda: mf.Dielectric(1e300), r"eta must lie between 1e-10 and 1e\+08, got 1e\+300"),
        (lambda: mf.Conductor(1e10, 1), r"eta must lie between 1e-10 and 1e\+08, got 1e\+10"),
        (lambda: mf.Conductor(1, 1e-300), r"k must lie between 1e-10 and 1e\+08, got 1e-300"),
        (lambda: mf.Schlick("1"), "F0 must be a number above 0, got '1'"),
        (lambda: mf.Schlick(1.5), r"F0 must lie in \(0, 1\], got 1.5"),
    ],
)
def test_wrong_indices(make: type, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()
