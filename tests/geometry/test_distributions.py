"""Distributions of normals against the papers' formulae at 60 digits, and what each integrates to."""

from __future__ import annotations

import microfacet as mf
import mpmath
import numpy as np
import pytest
import references
from around import whole_hemisphere
from hypothesis import given
from hypothesis import strategies as st
from microfacet.directions import spherical
from microfacet.families import key_of
from microfacet.statements import notation
from samples import ANISOTROPIC, FAMILIES, NORMALISED, POWERS, STRETCHED, hemisphere
from scipy import integrate

PAPER = {kind: getattr(references, f"{key_of(kind)}_D") for kind in FAMILIES}  # by hand for a new family, from its paper
ALPHA = st.floats(1e-3, 5)
POLAR = st.one_of(st.floats(0, np.pi / 2 - 1e-5), st.floats(0, 1e-3))
AZIMUTH = st.floats(-np.pi, np.pi)
EPS = {np.float64: np.finfo(np.float64).eps, np.float32: np.finfo(np.float32).eps}


def given_numbers(ndf: mf.Beckmann) -> tuple[float, ...]:
    return ndf.shown if isinstance(ndf, mf.BlinnPhong) else (ndf.alpha_x, ndf.alpha_y)


def assert_as_printed(ndf: mf.Beckmann, m: np.ndarray, ulps: float) -> None:
    """D at one normal of either precision; parameters are rounded to the precision before the formula sees them."""
    real = m.dtype.type
    exact = PAPER[type(ndf)](*m, *map(real, given_numbers(ndf)))
    if np.finfo(real).tiny < exact < np.finfo(real).max:
        assert abs(mpmath.mpf(float(ndf.D(m))) - exact) <= ulps * EPS[real] * exact


@pytest.mark.parametrize("kind", STRETCHED)
@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(theta=POLAR, phi=AZIMUTH, alpha_x=ALPHA, alpha_y=ALPHA)
def test_stretched_distributions_are_the_papers(
    kind: type, real: type, theta: float, phi: float, alpha_x: float, alpha_y: float
) -> None:
    """Down to alpha = 0.001 and to the horizon, in single precision too, where textbook forms cancel."""
    assert_as_printed(kind(alpha_x, alpha_y), spherical(theta, phi).astype(real), 10)


@pytest.mark.parametrize("kind", POWERS)
@pytest.mark.parametrize("real", [np.float64, np.float32])
@given(theta=POLAR, n=st.floats(0.5, 1000))
def test_powers_of_the_cosine_are_the_papers(kind: type, real: type, theta: float, n: float) -> None:
    assert_as_printed(kind(n), spherical(theta).astype(real), 10)


@pytest.mark.parametrize("ndf", NORMALISED, ids=repr)
def test_facets_project_to_the_whole_surface(ndf: mf.Beckmann) -> None:
    all_normals = whole_hemisphere(max(ndf.slope_scale))
    assert all_normals.sum(all_normals.directions[:, 2] * ndf.D(all_normals.directions)) == pytest.approx(1, abs=1e-10)


def projected(ndf: mf.Beckmann) -> float:
    """The projected area of a distribution without preferred azimuth, by an adaptive rule on the sphere."""

    def ring(theta: float) -> float:
        return 2 * np.pi * np.sin(theta) * np.cos(theta) * ndf.D(spherical(theta))

    points = [np.arctan(ndf.slope_scale[0]), 0.1]
    return integrate.quad(ring, 0, np.pi / 2, points=points, epsabs=1e-11, epsrel=1e-11, limit=200)[0]


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
def test_norm_over_roughness(kind: type, alpha: float) -> None:
    assert projected(kind(alpha)) == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("n", [0.5, 2 * np.pi - 2, 8.0, 1000.0])
def test_blinn_phong_projects_to_two_pi_over_n_plus_two(n: float) -> None:
    assert projected(mf.BlinnPhong(n)) == pytest.approx(2 * np.pi / (n + 2), rel=1e-9)
    assert projected(mf.NormalizedBlinnPhong(n)) == pytest.approx(1, rel=1e-9)


def test_blinn_phong_passes_at_one_exponent_only() -> None:
    assert projected(mf.BlinnPhong(2 * np.pi - 2)) == pytest.approx(1, abs=1e-9)
    assert abs(projected(mf.BlinnPhong(4.0)) - 1) > 0.04
    assert abs(projected(mf.BlinnPhong(4.5)) - 1) > 0.03


@pytest.mark.parametrize(("alpha", "printed"), [(0.1, 0.980577), (0.5, 0.698470), (1.0, 0.403653)])
def test_ward_loses_part_of_the_surface(alpha: float, printed: float) -> None:
    """x e^x E_2(x) at x = alpha^-2."""
    x = alpha**-2
    expected = float(x * mpmath.exp(x) * mpmath.expint(2, x))
    assert projected(mf.Ward(alpha)) == pytest.approx(expected, rel=1e-9)
    assert expected == pytest.approx(printed, abs=5e-7)
    stated = mf.equations["geometry.ward.projected_area"].equals
    assert expected == pytest.approx(float(stated.subs(notation.alpha, alpha)), rel=1e-13, abs=0)


def area(ndf: mf.Beckmann) -> float:
    def ring(theta: float) -> float:
        return 2 * np.pi * np.sin(theta) * ndf.D(spherical(theta))

    return integrate.quad(ring, 0, np.pi / 2, points=[np.arctan(ndf.slope_scale[0])], epsabs=1e-11, epsrel=1e-11, limit=200)[0]


@pytest.mark.parametrize("alpha", [0.1, 0.5, 0.999])
def test_area_of_the_microsurface(alpha: float) -> None:
    ggx, beckmann = (mf.equations[f"geometry.{name}.area"] for name in ("ggx", "beckmann"))
    assert area(mf.GGX(alpha)) == pytest.approx(float(ggx.exact(alpha)), rel=1e-9)
    assert area(mf.Beckmann(alpha)) == pytest.approx(float(beckmann.exact(alpha)), rel=1e-9)


def test_ggx_at_roughness_one_is_a_sphere() -> None:
    """D = 1/pi everywhere; the area is that of a hemisphere over its disc, exactly 2."""
    np.testing.assert_allclose(mf.GGX(1.0).D(hemisphere(50)), 1 / np.pi, rtol=1e-15)
    assert area(mf.GGX(1.0)) == pytest.approx(2, abs=1e-10)


@pytest.mark.parametrize("ndf", [*ANISOTROPIC, mf.Ward(0.2, 0.5)], ids=repr)
def test_symmetry_of_stretched_distributions(ndf: mf.Beckmann) -> None:
    """Every facet has its mirror images; exchanging the axes and both roughnesses changes nothing, one alone does."""
    m = hemisphere(200)
    value = ndf.D(m)
    for sign in ([-1, 1, 1], [1, -1, 1], [-1, -1, 1]):
        np.testing.assert_array_equal(ndf.D(m * sign), value)
    exchanged = type(ndf)(ndf.alpha_y, ndf.alpha_x)
    np.testing.assert_allclose(exchanged.D(m[:, [1, 0, 2]]), value, rtol=1e-13)
    assert not np.allclose(exchanged.D(m), value, rtol=0.1)


def test_slopes_and_normals_are_one_distribution() -> None:
    """D = P22/cos^4 at the slopes of the normal; the slope has the opposite sign."""
    m = hemisphere(200)
    for ndf in ANISOTROPIC:
        slopes = -m[:, :2] / m[:, 2:]
        np.testing.assert_allclose(ndf.P22(*slopes.T) / m[:, 2] ** 4, ndf.D(m), rtol=1e-12, atol=1e-200)


def test_root_mean_square_slope_of_beckmann() -> None:
    """alpha/sqrt 2 along each axis; GGX has no finite one: its share beyond a bound falls as the square only."""
    all_normals = whole_hemisphere(0.5)
    m = all_normals.directions
    share = m[:, 2] * mf.Beckmann(0.2, 0.5).D(m)
    for axis, alpha in ((0, 0.2), (1, 0.5)):
        assert all_normals.sum(share * (m[:, axis] / m[:, 2]) ** 2) == pytest.approx(alpha**2 / 2, rel=1e-9)
    tail = [
        integrate.quad(lambda t: 2 * np.pi * np.sin(t) * np.cos(t) * mf.GGX(0.4).D(spherical(t)), np.arctan(s), np.pi / 2)[0]
        for s in (100, 200)
    ]
    assert tail[0] / tail[1] == pytest.approx(4, rel=1e-3)


@pytest.mark.parametrize("ndf", [*ANISOTROPIC, mf.Ward(0.3), mf.BlinnPhong(8.0), mf.NormalizedBlinnPhong(8.0)], ids=repr)
def test_nothing_lies_below_the_horizon(ndf: mf.Beckmann) -> None:
    m = hemisphere(50) * [1, 1, -1]
    np.testing.assert_array_equal(ndf.D(m), 0)
    np.testing.assert_array_equal(ndf.pdf(m), 0)
    assert ndf.D([1.0, 0.0, 0.0]) == 0
    assert ndf.D([1.0, 0.0, -0.0]) == 0


@pytest.mark.parametrize("alpha", [1e-4, 1e-3])
def test_narrow_ggx_in_single_precision(alpha: float) -> None:
    """cos^2 (alpha^2 - 1) + 1 cancels there; at these angles it was wrong by any factor."""
    theta = (np.linspace(0, 5, 30) * alpha).astype(np.float32)
    m = np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=-1)
    single = mf.GGX(alpha).D(m)
    expected = [float(references.ggx_D(*v, np.float32(alpha), np.float32(alpha))) for v in m]
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, expected, rtol=2e-6)


EXTREME = [mf.GGX(1e-4), mf.Beckmann(1e-4), mf.NormalizedBlinnPhong(1e4), mf.GGX(10.0), mf.Beckmann(10.0)]


@pytest.mark.parametrize("ndf", EXTREME, ids=repr)
def test_extreme_roughness_stays_finite(ndf: mf.Beckmann) -> None:
    grazing, upright = spherical(np.pi / 2 - np.logspace(-12, -1, 30)), spherical(np.logspace(-12, 0, 30))
    m = np.vstack([hemisphere(50), grazing, upright, [[0, 0, 1]]])
    for real in (np.float64, np.float32):
        value = ndf.D(m.astype(real))
        assert np.isfinite(value).all()
        assert (value >= 0).all()


@pytest.mark.parametrize("ndf", [*NORMALISED, mf.Ward(0.3), mf.Ward(0.3, 0.30001), mf.BlinnPhong(1e-3)], ids=repr)
def test_a_distribution_says_whether_azimuth_matters(ndf: mf.Beckmann) -> None:
    values = ndf.D(spherical(0.5, np.linspace(-np.pi, np.pi, 101)))
    assert ndf.isotropic is bool(np.ptp(values) < 1e-12 * values.max())
