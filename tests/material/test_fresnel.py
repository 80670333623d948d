"""Fresnel reflectance against complex amplitudes at 60 digits, and where its values are known."""

from __future__ import annotations

import microfacet as mf
import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from microfacet.material import fresnel
from microfacet.material.fresnel import Fresnel

EPS = {real: float(np.finfo(real).eps) for real in (np.float64, np.float32)}


def amplitudes(cosine: float, index: complex) -> tuple[mp.mpc, mp.mpc]:
    """Snell's law for a complex index, then s and p."""
    with mp.workdps(60):
        c, n = mp.mpf(float(cosine)), mp.mpc(index)
        refracted = mp.sqrt(1 - (1 - c * c) / n**2)
        return (c - n * refracted) / (c + n * refracted), (n * c - refracted) / (n * c + refracted)


def reflected(cosine: float, index: complex) -> mp.mpf:
    """The mean of both polarisations; at grazing incidence all, and of equal indices nothing."""
    with mp.workdps(60):
        if index == 1 or cosine == 0:
            return mp.mpf(index != 1)
        return sum(abs(r) ** 2 for r in amplitudes(cosine, index)) / 2


def worst_error(material: Fresnel, cosines: np.ndarray, index: complex) -> float:
    """In epsilons of the precision, of values that it can hold."""
    real = cosines.dtype.type
    values = material.F(cosines)
    assert values.dtype == real
    assert ((values >= 0) & (values <= 1)).all()
    worst = 0.0
    for cosine, value in zip(cosines, values, strict=True):
        right = reflected(cosine, index)
        if right > np.finfo(real).tiny:
            worst = max(worst, float(abs(mp.mpf(float(value)) - right) / right) / EPS[real])
    return worst


def hard_cosines(real: type, eta: float, k: float) -> np.ndarray:
    """From 0 to 1, near either, and on both sides of total reflection and of Brewster's angle, at any distance."""
    steps = np.concatenate([-np.geomspace(1e-17, 1e-2, 9), np.geomspace(1e-17, 1e-2, 9)])
    near = [np.sqrt(max(0.0, 1 + k * k - eta * eta)), 1 / np.sqrt(1 + eta * eta), 1.0, np.sqrt(abs(eta - 1) + k)]
    there = [np.array([0, np.finfo(real).tiny, 1]), np.geomspace(1e-30, 1, 20), *(at * (1 + steps) for at in near)]
    return np.clip(np.concatenate(there), 0, 1).astype(real)


INDICES = st.one_of(
    st.floats(-10, 8).map(lambda x: 10**x),
    st.floats(0.1, 4),
    st.floats(-16, -1).map(lambda x: 1 + 10**x),
    st.floats(-16, -1).map(lambda x: 1 - 10**x),
    st.sampled_from([1e-10, 1.0, 1e8]),
)
ABSORPTIONS = st.one_of(st.just(0.0), st.floats(-20, 8).map(lambda x: 10**x), st.floats(0.01, 10))
PROMISED = 8.0


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(eta=INDICES)
def test_dielectrics_keep_their_digits_everywhere(real: type, eta: float) -> None:
    eta = float(real(eta))
    assert worst_error(mf.Dielectric(eta), hard_cosines(real, eta, 0), mp.mpf(eta)) <= PROMISED


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(eta=INDICES, k=ABSORPTIONS)
@example(eta=1.0, k=1e-20)
def test_conductors_keep_their_digits_everywhere(real: type, eta: float, k: float) -> None:
    eta, k = float(real(eta)), max(float(real(k)), 1e-20 * (k > 0))
    exact_k = float(real(k))
    assert worst_error(mf.Conductor(eta, k), hard_cosines(real, eta, k), mp.mpc(eta, exact_k)) <= PROMISED


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_indices_near_zero_reflect_nearly_all(real: type) -> None:
    for eta, printed in ((1e-4, 0.99960008), (1e-8, 0.99999996)):
        value = float(mf.Dielectric(eta).F(real(1)))
        assert value == pytest.approx(((1 - eta) / (1 + eta)) ** 2, rel=2 * EPS[real], abs=0)
        assert value == pytest.approx(printed, rel=EPS[real], abs=5e-9)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(eta=INDICES)
def test_total_reflection_is_exact(real: type, eta: float) -> None:
    """Of dielectrics, and of conductors that absorb nothing, up to the last cosine below the critical one."""
    eta = float(real(eta))
    cosines = hard_cosines(real, eta, 0)
    beyond = cosines[[mp.mpf(float(c)) ** 2 + mp.mpf(eta) ** 2 < 1 for c in cosines]]
    np.testing.assert_array_equal(mf.Dielectric(eta).F(beyond), 1)
    np.testing.assert_array_equal(mf.Conductor(eta, 0).F(beyond), 1)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(eta=INDICES)
def test_a_conductor_that_absorbs_nothing_is_a_dielectric(real: type, eta: float) -> None:
    cosines = hard_cosines(real, eta, 0)
    np.testing.assert_allclose(mf.Conductor(eta, 0).F(cosines), mf.Dielectric(eta).F(cosines), rtol=2 * PROMISED * EPS[real])


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


def test_schlick_meets_fresnel_at_both_ends() -> None:
    F = mf.Schlick(0.04)
    assert F.F(1.0) == pytest.approx(0.04, rel=1e-15, abs=0)
    assert F.F(0.0) == 1
    c = np.linspace(0, 1, 101)
    np.testing.assert_allclose(F.F(c), 0.04 + 0.96 * (1 - c) ** 5, rtol=1e-14)
    np.testing.assert_allclose(F.F(c), mf.Dielectric(1.5).F(c), atol=0.05)


SHARES = st.one_of(st.floats(0, 1), st.sampled_from([0.0, 1.0]), st.floats(-12, 0).map(lambda x: 10**x))


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(F0=SHARES, F90=SHARES)
def test_schlick_with_any_ends(real: type, F0: float, F90: float) -> None:
    c = np.concatenate([[0], np.geomspace(1e-12, 1, 40)]).astype(real)
    value = mf.Schlick(F0, F90).F(c)
    assert value.dtype == real
    assert ((value >= 0) & (value <= 1)).all()
    with mp.workdps(400):
        ends = [mp.mpf(float(real(F))) for F in (F0, F90)]
        right = [float(ends[0] + (ends[1] - ends[0]) * (1 - mp.mpf(float(x))) ** 5) for x in c]
    np.testing.assert_allclose(value, right, rtol=PROMISED * EPS[real], atol=np.finfo(real).tiny)


def test_schlick_rises_to_all_light_unless_told_otherwise() -> None:
    assert mf.Schlick(0.04) == mf.Schlick(0.04, 1) != mf.Schlick(0.04, 0.5)
    np.testing.assert_array_equal(mf.Schlick(0, 0).F(np.linspace(0, 1, 11)), 0)
    assert mf.Schlick(0).F(1.0) == 0


def tinted(c: mp.mpf, F0: float, tint: float, F90: float) -> mp.mpf:
    """By its definition: Schlick's, less a multiple of c (1 - c)^6 that is found from the value at 1/7."""

    def schlick(x: mp.mpf) -> mp.mpf:
        return mp.mpf(F0) + (mp.mpf(F90) - mp.mpf(F0)) * (1 - x) ** 5

    edge = mp.mpf(1) / 7
    return schlick(c) - (1 - mp.mpf(tint)) * schlick(edge) * (c * (1 - c) ** 6) / (edge * (1 - edge) ** 6)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(F0=SHARES, tint=SHARES, F90=SHARES)
def test_a_tint_is_taken_if_and_only_if_all_of_it_is_a_reflectance(real: type, F0: float, tint: float, F90: float) -> None:
    c = np.concatenate([np.linspace(0, 1, 401), np.geomspace(1e-9, 0.1, 20)]).astype(real)
    with mp.workdps(50):
        right = np.array([float(tinted(mp.mpf(float(x)), F0, tint, F90)) for x in c])
    try:
        value = mf.F82Tint(F0, tint, F90).F(c)
    except ValueError:
        cosine, lowest = fresnel.lowest_f82(F0, tint, F90)
        with mp.workdps(50):
            assert lowest == pytest.approx(float(tinted(mp.mpf(cosine), F0, tint, F90)), rel=1e-9, abs=1e-14)
        assert lowest < 0
        return
    assert right.min() >= -1e-15
    assert ((value >= 0) & (value <= 1)).all()
    np.testing.assert_allclose(value, right, rtol=0, atol=16 * EPS[real] * max(F0, F90) + 1e-15)


@pytest.mark.parametrize(("F0", "F90"), [(0.0, 1.0), (0.04, 1.0), (0.04, 0.5), (0.3, 0.3), (0.3, 0.1), (0.01, 0.02)])
def test_the_darkest_tint_that_is_taken_lets_the_reflectance_touch_zero(F0: float, F90: float) -> None:
    dark, light = -1e-9, 1.0
    while light - dark > 1e-12:
        tint = (dark + light) / 2
        try:
            mf.F82Tint(F0, max(tint, 0), F90)
            light = tint
        except ValueError:
            dark = tint
    c = np.linspace(0, 1, 100_001)
    edge, off = F0 + (F90 - F0) * (6 / 7) ** 5, c * (1 - c) ** 6 * 7 * (7 / 6) ** 6
    least = (F0 + (F90 - F0) * (1 - c) ** 5 - (1 - max(light, 0)) * edge * off).min()
    assert least == pytest.approx(0, abs=1e-8)


def test_a_tint_is_a_factor_at_82_degrees() -> None:
    for F0, tint, F90 in ((0.9, 0.5, 1.0), (0.6, 0.9, 0.8), (0.5, 0.0, 0.5)):
        metal, plain = mf.F82Tint(F0, tint, F90), mf.Schlick(F0, F90)
        assert metal.F(1 / 7) == pytest.approx(tint * plain.F(1 / 7), rel=1e-14, abs=1e-15)
        assert (metal.F(0.0), metal.F(1.0)) == (plain.F(0.0), plain.F(1.0))
    assert np.degrees(np.arccos(1 / 7)) == pytest.approx(82, abs=0.3)
    c = np.linspace(0, 1, 101)
    np.testing.assert_array_equal(mf.F82Tint(0.4, 1.0, 0.7).F(c), mf.Schlick(0.4, 0.7).F(c))


def test_a_tint_too_dark_is_refused_with_the_place() -> None:
    with pytest.raises(
        ValueError, match=r"tint must be lighter for F0 = 0 and F90 = 1: .* falls to -.* at cosine 0\.\d+, got 0$"
    ):
        mf.F82Tint(0, 0)


MATERIALS = {
    "glass": mf.Dielectric(1.5),
    "out of glass": mf.Dielectric(0.7),
    "gold": mf.Conductor(0.2, 3.0),
    "silver after Schlick": mf.Schlick(0.9),
    "black but for grazing light": mf.Schlick(0),
    "a metal with a tint": mf.F82Tint(0.9, 0.6),
    "glass as a conductor": mf.Conductor(1.5, 0),
}


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_reflectance_is_a_share(name: str, real: type) -> None:
    value = MATERIALS[name].F(np.linspace(0, 1, 501, dtype=real))
    assert value.dtype == real
    assert ((value >= 0) & (value <= 1)).all()


@pytest.mark.parametrize("wrong", [-0.1, 1.1, np.nan, [0.5, np.inf], 1.0001, -1e-4])
def test_cosines_outside_their_range(wrong: object) -> None:
    with pytest.raises(ValueError, match=r"cosine must (lie in \[0, 1\]|be finite)"):
        mf.Schlick(0.5).F(wrong)


def test_cosines_that_rounding_has_moved_count_as_0_and_1() -> None:
    F = mf.Dielectric(1.5).F
    assert (F(np.float32(1.0000001)), F(-1e-8)) == (F(np.float32(1)), F(0.0))
    assert F(np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize("wrong", [1j, "a", None, np.ma.masked, np.ma.array([0.5, 0.5], mask=[False, True])])
def test_cosines_are_real_numbers(wrong: object) -> None:
    with pytest.raises(ValueError, match="cosine must be an array of numbers, got"):
        mf.Schlick(0.5).F(wrong)


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_indices_within_their_limits_give_shares(real: type) -> None:
    """Also at the ends, next to 1, and at cosines as small as the precision has."""
    cosines = np.concatenate([[0, np.finfo(real).tiny], np.geomspace(1e-12, 1, 25), 1 - np.geomspace(1e-7, 0.5, 9)])
    indices = [*np.geomspace(*fresnel.INDEX, 19), 1 - 1e-16, 1 + 1e-15, 1 - 1e-8, 1 + 1e-4, 1.5]
    made = [*map(mf.Dielectric, indices), *(mf.Conductor(eta, k) for eta in indices for k in [0, 1e-20, *indices])]
    for material in made:
        value = material.F(cosines.astype(real))
        assert ((value >= 0) & (value <= 1)).all(), material.parameters


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: mf.Dielectric(0), "eta must be a finite number above 0, got 0"),
        (lambda: mf.Dielectric(np.nan), "eta must be a finite number above 0, got nan"),
        (lambda: mf.Conductor(1.0, -2), r"k must be 0 or lie between 1e-20 and 1e\+08, got -2"),
        (lambda: mf.Conductor(1.0, "k"), "k must be a number, got 'k'"),
        (lambda: mf.Conductor("gold", 1), "eta must be a number above 0, got 'gold'"),
        (lambda: mf.Dielectric(1e300), r"eta must lie between 1e-10 and 1e\+08, got 1e\+300"),
        (lambda: mf.Conductor(1e10, 1), r"eta must lie between 1e-10 and 1e\+08, got 1e\+10"),
        (lambda: mf.Conductor(1, 1e-300), r"k must be 0 or lie between 1e-20 and 1e\+08, got 1e-300"),
        (lambda: mf.Conductor(1, np.nan), "k must be 0 or lie between .* got nan"),
        (lambda: mf.Schlick("1"), "F0 must be a number, got '1'"),
        (lambda: mf.Schlick(True), "F0 must be a number, got True"),
        (lambda: mf.Schlick(np.nan), r"F0 must lie in \[0, 1\], got nan"),
        (lambda: mf.Schlick(0.5, -0.1), r"F90 must lie in \[0, 1\], got -0.1"),
        (lambda: mf.F82Tint(0.5, 1.2), r"tint must lie in \[0, 1\], got 1.2"),
        (lambda: mf.Schlick(1.5), r"F0 must lie in \[0, 1\], got 1.5"),
    ],
)
def test_wrong_indices(make: type, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("kappa", [0.0, 0.5])
def test_where_total_reflection_begins_at_normal_incidence_nothing_is_divided_by_zero(kappa: float) -> None:
    """1 + kappa^2 = eta^2: there the square is that of the cosine. In Python, where 0/0 is an error."""
    eta = 1.0 if kappa == 0 else float(np.sqrt(1.25))
    if kappa == 0:
        assert fresnel.beyond_critical(0.375, eta, kappa) == 0.375**2
    assert fresnel.beyond_critical(0.375, eta, kappa) == pytest.approx(0.375**2, rel=1e-15)
