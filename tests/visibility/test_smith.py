"""Smith's masking: from its definition, by quadrature, in closed form, stretched, and at the edges."""

from __future__ import annotations

from typing import Any

import microfacet as mf
import mpmath
import numpy as np
import pytest
import references
from around import turned_away, turned_to
from hypothesis import given
from hypothesis import strategies as st
from microfacet.directions import spherical
from microfacet.geometry.roughness import SlopeScale
from microfacet.visibility.masking import ModelParameters
from microfacet.visibility.smith import CORRELATIONS, quadrature_Lambda, radial_Lambda
from samples import ANISOTROPIC, ISOTROPIC, NORMALISED, UP, hemisphere, views
from skewed import SKEWED

EPS = {real: float(np.finfo(real).eps) for real in (np.float64, np.float32)}
SEEN = views(10, 45, 75, 85)
CORRELATED = {name: mf.Smith(mf.GGX(0.5, 0.2), name) for name in CORRELATIONS}


def smith_Lambda(ndf: mf.Beckmann, wo: np.ndarray) -> np.ndarray:
    """As the library computes it, through G1 of a facet turned to the viewer."""
    return 1 / mf.Smith(ndf).G1(wo, wo) - 1


@pytest.mark.parametrize("ndf", [*NORMALISED, mf.Ward(0.4), mf.Ward(0.5, 0.2), mf.Ward(30.0, 3.0), SKEWED], ids=repr)
def test_Lambda_is_what_faces_away_over_the_cosine(ndf: mf.Beckmann) -> None:
    """The definition, on the sphere around the viewer. Ward's facets do not add up, but these it hides."""
    for wo in [*SEEN, *views(60, azimuth=-160)]:
        away = turned_away(wo)
        hidden = away.sum(-(away.directions @ wo) * ndf.D(away.directions)) / wo[2]
        assert smith_Lambda(ndf, wo) == pytest.approx(hidden, rel=2e-6, abs=1e-12)


@pytest.mark.parametrize("ndf", [*NORMALISED, mf.Ward(0.4)], ids=repr)
@pytest.mark.parametrize("theta", [30, 60, 85, 89])
def test_closed_forms_are_the_quadrature(ndf: mf.Beckmann, theta: float) -> None:
    """Both quadratures in plain Python: the half-plane of hidden slopes, and rings of them where azimuth does not matter."""
    wo = views(theta)[0]
    parameters = ModelParameters(ndf.parameters, SlopeScale(*ndf.slope_scale))
    for rule in (quadrature_Lambda, radial_Lambda) if ndf.isotropic else (quadrature_Lambda,):
        found = rule(type(ndf).kernel)(tuple(wo), parameters)
        assert smith_Lambda(ndf, wo) == pytest.approx(found, rel=2e-9, abs=1e-13)


@pytest.mark.parametrize("alpha", [1e-3, 1.0, 30.0, 1e3])
def test_lambda_of_ward_at_any_roughness(alpha: float) -> None:
    """Where he is rough, most of what is hidden has slopes near 1, far below alpha. By rings of slopes, at 30 digits; the
    other way is for unequal roughness, and takes none for equal that differs in the last digits."""
    for wo in views(30, 80, 89.99, azimuth=50):
        with mpmath.workdps(30):
            c = mpmath.mpf(wo[2]) / mpmath.hypot(wo[0], wo[1])
            rings = [0, *sorted({c, mpmath.mpf(1), mpmath.mpf(alpha), 3 * mpmath.mpf(alpha)}), 10 * alpha]
            exact = mpmath.quad(lambda t: _ring(t, c, alpha), rings) / c  # noqa: B023
        for other in (alpha, alpha * (1 + 1e-12)):
            assert smith_Lambda(mf.Ward(alpha, other), wo) == pytest.approx(float(exact), rel=1e-9, abs=2e-12)


def _ring(t: Any, c: Any, alpha: float) -> Any:
    """What Ward's slopes of length sqrt(c^2 + t^2) hide, per t."""
    square = c * c + t * t
    return 2 * mpmath.exp(-square / alpha**2) / (mpmath.pi * alpha**2 * (1 + square) ** 2) * (t - c * mpmath.atan(t / c)) * t


@pytest.mark.parametrize(("kind", "paper"), [(mf.GGX, references.ggx_Lambda), (mf.Beckmann, references.beckmann_Lambda)])
@given(theta=st.floats(0.05, np.pi / 2 - 1e-6), phi=st.floats(-3, 3), alpha_x=st.floats(0.05, 2), alpha_y=st.floats(0.05, 2))
def test_G1_is_the_papers(kind: type, paper: type, theta: float, phi: float, alpha_x: float, alpha_y: float) -> None:
    wo = spherical(theta, phi)
    expected = 1 / (1 + paper(references.a_of(*wo, alpha_x, alpha_y)))
    assert float(mf.Smith(kind(alpha_x, alpha_y)).G1(wo, wo)) == pytest.approx(float(expected), rel=4e-15, abs=0)


@pytest.mark.parametrize("n", [0.5, 8.0, 200.0])
@pytest.mark.parametrize("theta", [5, 45, 80, 89])
def test_blinn_phong_has_its_own_Lambda(n: float, theta: float) -> None:
    wo = views(theta)[0]
    expected = references.student_Lambda(1 / np.tan(np.radians(theta)), n)
    assert smith_Lambda(mf.NormalizedBlinnPhong(n), wo) == pytest.approx(expected, rel=1e-9, abs=3e-15)


def test_beckmanns_Lambda_in_its_place_breaks_the_furnace() -> None:
    """Blinn-Phong with the masking of the Beckmann that resembles it, alpha = sqrt(2/(n+2)): not one surface's pair."""
    ndf = mf.NormalizedBlinnPhong(8.0)
    borrowed = mf.Smith(mf.Beckmann((2 / 10) ** 0.5))
    wo = views(80)[0]
    seen = turned_to(wo)
    own, other = (
        seen.sum(model.G1(wo, seen.directions) * (seen.directions @ wo) * ndf.D(seen.directions)) / wo[2]
        for model in (mf.Smith(ndf), borrowed)
    )
    assert own == pytest.approx(1, abs=1e-9)
    assert abs(other - 1) > 0.01


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_Lambda_keeps_its_digits_near_normal_incidence(real: type) -> None:
    """(sqrt(1 + 1/a^2) - 1)/2 was 5 % wrong in single precision; erf(a) - 1 loses all digits beyond a = 5."""
    for a in (1.7, 5.5, 9.0, 100.0, 3e4):
        ggx, beckmann = (mf.equations[f"geometry.{name}.Lambda"].kernel(np.array([a], real))[0] for name in ("ggx", "beckmann"))
        assert float(ggx) == pytest.approx(float(references.ggx_Lambda(real(a))), rel=4 * EPS[real], abs=0)
        exact = references.beckmann_Lambda(real(a))
        if exact > np.finfo(real).tiny:
            assert float(beckmann) == pytest.approx(float(exact), rel=8 * EPS[real], abs=0)


@pytest.mark.parametrize("ndf", [*NORMALISED, mf.Beckmann(0.01), mf.GGX(3.0)], ids=repr)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_masking_is_a_share_and_falls_towards_the_horizon(ndf: mf.Beckmann, real: type) -> None:
    """Walter's rational fit puts Beckmann's masking above 1 for 1.548 < a < 1.6: here it may not be."""
    wo = spherical(np.linspace(0, np.pi / 2 - 1e-6, 2000), 0.6).astype(real)
    G1 = mf.Smith(ndf).G1(wo, wo)
    assert G1.dtype == real
    assert ((G1 >= 0) & (G1 <= 1)).all()
    assert (np.diff(G1) <= 4 * np.finfo(real).eps).all()
    assert G1[0] == 1


@pytest.mark.parametrize("model", [mf.Smith(ndf) for ndf in NORMALISED], ids=repr)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_a_hair_above_the_horizon_is_finite(model: mf.Smith, real: type) -> None:
    height = np.array([1e-3, 1e-6, 1e-12, 1e-19, 1e-25, 1e-37], real)
    wo = np.stack([np.sqrt(1 - height**2), np.zeros_like(height), height], axis=-1)
    value = model.G1(wo, wo)
    assert np.isfinite(value).all()
    assert ((value >= 0) & (value <= 1)).all()
    assert (np.diff(value) <= 0).all()


def test_masking_of_back_facing_and_of_lower_directions_is_zero() -> None:
    model = mf.Smith(mf.GGX(0.5, 0.2))
    wo = views(60)[0]
    m = hemisphere(300)
    facing = m @ wo > 0
    assert (~facing).sum() > 20
    np.testing.assert_array_equal(model.G1(wo, m) > 0, facing)
    np.testing.assert_array_equal(model.D_visible(wo, m) > 0, facing)
    np.testing.assert_array_equal(model.G1(wo * [1, 1, -1], m), 0)
    np.testing.assert_array_equal(model.D_visible(wo * [1, 1, -1], m), 0)
    np.testing.assert_array_equal(model.D_visible(wo, m * [1, 1, -1]), 0)


@pytest.mark.parametrize("model", [mf.Smith(ndf) for ndf in NORMALISED], ids=repr)
def test_visible_normals_project_to_the_view_and_are_a_distribution(model: mf.Smith) -> None:
    for wo in [UP, *views(30, 85, 89), *views(60, azimuth=170)]:
        seen = turned_to(wo)
        m, D = seen.directions, model.ndf.D(seen.directions)
        assert seen.sum(model.G1(wo, m) * (m @ wo) * D) == pytest.approx(wo[2], rel=1e-6)
        assert seen.sum(model.D_visible(wo, m)) == pytest.approx(1, rel=1e-6)


def test_visible_normals_by_their_definition() -> None:
    model = mf.Smith(ANISOTROPIC[1])
    wo, m = views(70)[0], hemisphere(200)
    expected = model.G1(wo, m) * np.maximum(m @ wo, 0) * model.ndf.D(m) / wo[2]
    np.testing.assert_allclose(model.D_visible(wo, m), expected, rtol=1e-13, atol=1e-250)


# --- anisotropy -------------------------------------------------------------------------------------------------------


def unstretched(wo: np.ndarray, ndf: mf.GGX) -> np.ndarray:
    v = wo * [ndf.alpha_x, ndf.alpha_y, 1]
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def unstretched_normal(m: np.ndarray, ndf: mf.GGX) -> np.ndarray:
    v = m / [ndf.alpha_x, ndf.alpha_y, 1]
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@pytest.mark.parametrize("kind", [mf.Smith, mf.VCavity])
@pytest.mark.parametrize("ndf", ANISOTROPIC, ids=repr)
def test_stretching_the_surface_with_the_viewer_changes_no_masking(kind: type, ndf: mf.GGX) -> None:
    wo, m = hemisphere(300, 1), hemisphere(300, 2)
    before, after = kind(type(ndf)(1.0)), kind(ndf)
    wo1, m1 = unstretched(wo, ndf), unstretched_normal(m, ndf)
    np.testing.assert_allclose(after.G1(wo, m), before.G1(wo1, m1), rtol=1e-12)
    slopes = (m[:, 2] / m1[:, 2]) ** 3 * ndf.alpha_x * ndf.alpha_y  # of solid angle: dwm = dslopes cos^3
    np.testing.assert_allclose(after.D_visible(wo, m) * slopes, before.D_visible(wo1, m1), rtol=1e-11, atol=1e-250)


def test_masking_depends_on_azimuth_where_the_surface_does() -> None:
    """sqrt(alpha_x alpha_y) in its place forgets the azimuth."""
    along, across = views(75, azimuth=0)[0], views(75, azimuth=90)[0]
    model = mf.Smith(mf.GGX(0.5, 0.2))
    assert model.G1(along, along) == pytest.approx(mf.Smith(mf.GGX(0.5)).G1(along, along), rel=1e-14, abs=0)
    assert model.G1(across, across) == pytest.approx(mf.Smith(mf.GGX(0.2)).G1(across, across), rel=1e-14, abs=0)
    assert model.G1(across, across) - model.G1(along, along) > 0.05


# --- masking and shadowing ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CORRELATIONS)
def test_G2_is_below_both_G1_and_does_not_tell_light_from_viewer(name: str) -> None:
    model = CORRELATED[name]
    wo, wi, m = hemisphere(500, 1), hemisphere(500, 2), hemisphere(500, 3)
    G2 = model.G2(wo, wi, m)
    np.testing.assert_allclose(G2, model.G2(wi, wo, m), rtol=4e-16)
    least = np.minimum(model.G1(wo, m), model.G1(wi, m))
    assert (least * (1 + 1e-15) >= G2).all()
    assert ((G2 > 0) == ((np.sum(wo * m, -1) > 0) & (np.sum(wi * m, -1) > 0))).all()
    np.testing.assert_array_equal(model.G2(wo, wi * [1, 1, -1], m), 0)
    np.testing.assert_array_equal(model.G2(wo * [1, 1, -1], wi, m), 0)


def test_G2_of_each_correlation_by_its_formula() -> None:
    ndf = mf.GGX(0.5, 0.2)
    wo, wi = hemisphere(300, 1), hemisphere(300, 2)
    Lo, Li = smith_Lambda(ndf, wo), smith_Lambda(ndf, wi)
    apart = np.abs(np.angle(np.exp(1j * (np.arctan2(wo[:, 1], wo[:, 0]) - np.arctan2(wi[:, 1], wi[:, 0])))))
    degree = 4.41 * apart / (4.41 * apart + 1)
    expected = {
        "none": 1 / ((1 + Lo) * (1 + Li)),
        "height": 1 / (1 + Lo + Li),
        "direction": degree / ((1 + Lo) * (1 + Li)) + (1 - degree) / (1 + np.maximum(Lo, Li)),
        "height-direction": 1 / (1 + np.maximum(Lo, Li) + degree * np.minimum(Lo, Li)),
    }
    for name, model in CORRELATED.items():
        np.testing.assert_allclose(model.G2(wo, wi, UP), expected[name], rtol=1e-13)


def test_from_the_same_side_what_is_seen_is_lit_if_correlation_by_direction_is_known() -> None:
    wo, wi = views(70)[0], views(40)[0]
    least = min(CORRELATED["height"].G1(w, UP) for w in (wo, wi))
    for name in ("direction", "height-direction"):
        assert CORRELATED[name].G2(wo, wi, UP) == pytest.approx(least, rel=1e-13, abs=0)
    for name in ("height", "none"):
        assert CORRELATED[name].G2(wo, wi, UP) < least * 0.98


def test_straight_above_nothing_is_hidden() -> None:
    for model in CORRELATED.values():
        assert model.G2(UP, UP, UP) == 1
        wi = views(70)[0]
        assert model.G2(UP, wi, UP) == pytest.approx(model.G1(wi, UP), rel=1e-15, abs=0)


@pytest.mark.parametrize("ndf", ISOTROPIC, ids=repr)
def test_height_correlation_is_the_default(ndf: mf.Beckmann) -> None:
    assert mf.Smith(ndf).correlation == "height"
    wo, wi = views(70, 30)
    Lo, Li = smith_Lambda(ndf, wo), smith_Lambda(ndf, wi)
    assert mf.Smith(ndf).G2(wo, wi, UP) == pytest.approx(1 / (1 + Lo + Li), rel=1e-13, abs=0)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize(
    "ndf", [mf.GGX(0.3, 0.1), mf.Beckmann(0.2), mf.Ward(0.4), mf.NormalizedBlinnPhong(20.0), mf.GGX([[0.1], [2.0]])], ids=repr
)
def test_Lambda_is_what_G1_says(ndf: mf.GGX, real: type) -> None:
    wo = np.concatenate([hemisphere(30), [[0, 0, 1], [1, 0, 0], [0.6, 0, -0.8]]]).astype(real)
    found, G1 = mf.Smith(ndf).Lambda(wo), mf.Smith(ndf).G1(wo, np.array([0, 0, 1], real))
    assert found.dtype == real
    np.testing.assert_allclose(1 / (1 + found), G1, rtol=4 * np.finfo(real).eps)
    assert (found[..., -3] == 0).all()
    assert np.isinf(found[..., -2:]).all()
    if type(ndf).closed_Lambda is None:
        with pytest.raises(ValueError, match=r"Ward\(.*\) has no closed form of Lambda: Smith"):
            ndf.Lambda(wo)
    else:
        np.testing.assert_array_equal(ndf.Lambda(wo), found)
