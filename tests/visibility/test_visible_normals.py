"""Sampling visible normals: the density claimed is the density drawn, from straight above to grazing, in both precisions."""

from __future__ import annotations

import microfacet as mf
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from microfacet.directions import spherical
from microfacet.validation.chi_square import p_value
from samples import LAST, LAST_SINGLE, UP, uniform, views
from sampling import density_times_area

SURFACES = [
    mf.GGX(0.4),
    mf.GGX(0.5, 0.2),
    mf.GGX(0.01),
    mf.GGX(0.01, 0.6),
    mf.Beckmann(0.4),
    mf.Beckmann(0.2, 0.5),
    mf.Beckmann(0.01),
    mf.Beckmann(0.05),
]
MODELS = [mf.Smith(ndf) for ndf in SURFACES]
VIEWS = [UP, *views(30, 60, 85, 89), *views(85, azimuth=-100)]
INSIDE = st.floats(0.01, 0.99)
DEGREES = [0, 1e-4, 30, 85, 89, 89.99]


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@given(
    u1=INSIDE,
    u2=INSIDE,
    theta=st.one_of(st.just(0.0), st.floats(0, 1.57), st.floats(1.45, 1.57)),
    phi=st.floats(-3, 3),
    alpha_x=st.floats(0.01, 2),
    alpha_y=st.floats(0.01, 2),
)
def test_sampler_has_its_density(
    kind: type, u1: float, u2: float, theta: float, phi: float, alpha_x: float, alpha_y: float
) -> None:
    """Pointwise, by the Jacobian: an isotropic lobe, swapped axes or a jump in the sampler would show anywhere."""
    model, wo = mf.Smith(kind(alpha_x, alpha_y)), spherical(theta, phi)
    product = density_times_area(lambda u: model.sample_visible(wo, u), lambda m: model.D_visible(wo, m), np.array([u1, u2]))
    assert product == pytest.approx(1, abs=2e-6)


@pytest.mark.parametrize("model", MODELS, ids=repr)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_counts_follow_the_density(model: mf.Smith, real: type) -> None:
    for k, wo in enumerate(VIEWS):
        normals = model.sample_visible(wo.astype(real), uniform(60_000, k, real))
        assert normals.dtype == real
        kept = normals[normals @ wo.astype(real) > 0] if real is np.float32 else normals
        assert len(normals) - len(kept) < 10  # rounding puts few single-precision normals at the very edge
        assert p_value(kept, lambda m, wo=wo: model.D_visible(wo, m), wo, model.ndf.slope_scale) > 1e-5


def test_counts_tell_wrong_densities_apart() -> None:
    """The test above can fail."""
    model, wo = mf.Smith(mf.GGX(0.5, 0.2)), views(60)[0]
    normals = model.sample_visible(wo, uniform(60_000))
    for wrong in (mf.Smith(mf.GGX(0.2, 0.5)), mf.Smith(mf.GGX(0.1**0.5)), mf.Smith(mf.GGX(0.53, 0.2))):
        assert p_value(normals, lambda m, wrong=wrong: wrong.D_visible(wo, m), wo, model.ndf.slope_scale) < 1e-6


@pytest.mark.parametrize("model", MODELS, ids=repr)
@pytest.mark.parametrize(("real", "last"), [(np.float64, LAST), (np.float32, LAST_SINGLE)])
def test_corners_of_the_unit_square_give_normals(model: mf.Smith, real: type, last: float) -> None:
    """Also at normal incidence, where the direction across the view is not defined."""
    corners = np.array([(a, b) for a in (0, 1e-7, 0.5, last) for b in (0, 1e-7, 0.5, last)], real)
    for theta in DEGREES:
        wo = spherical(np.radians(theta), 0.6).astype(real)
        normals = model.sample_visible(wo, corners)
        assert np.isfinite(normals).all()
        np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, rtol=4 * np.finfo(real).eps)
        assert (normals[:, 2] >= 0).all()
        assert (normals @ wo >= -4 * np.finfo(real).eps).all()


@pytest.mark.parametrize("model", [mf.Smith(mf.GGX(0.5, 0.2)), mf.Smith(mf.Beckmann(0.2, 0.5))], ids=repr)
def test_close_numbers_give_close_normals(model: mf.Smith) -> None:
    """A sampler put together from pieces jumps between them."""
    fine = (np.arange(4000) + 0.5) / 4000
    for wo in (UP, *views(0.001, 30, 89)):
        for axis in (0, 1):
            u = np.full((len(fine), 2), 0.37)
            u[:, axis] = fine
            steps = np.linalg.norm(np.diff(model.sample_visible(wo, u), axis=0), axis=-1)[40:-40]
            smooth = np.maximum(steps[2:], steps[:-2])
            assert (steps[1:-1] < 1.2 * smooth + 1e-9).all()


@pytest.mark.parametrize("model", [mf.Smith(mf.GGX(0.5, 0.2)), mf.Smith(mf.Beckmann(0.2, 0.5))], ids=repr)
def test_below_the_horizon_there_is_nothing_to_sample(model: mf.Smith) -> None:
    wo = np.array([[0.6, 0, -0.8], [1.0, 0, 0], [0, 0, -1]])
    np.testing.assert_array_equal(model.sample_visible(wo, [0.3, 0.7]), 0)


def test_beckmanns_slope_is_found_to_rounding() -> None:
    """Seen share of slopes below the one returned = u, by the error function at 60 digits."""
    model = mf.Smith(mf.Beckmann(1.0))
    for theta in (0.3, 1.2, 1.55):
        for u in (0.001, 0.3, 0.7, 0.999):
            m = model.sample_visible(spherical(theta), np.array([u, 0.5]))
            with mpmath.workdps(60):
                cot = 1 / mpmath.tan(mpmath.mpf(float(np.arctan2(np.sin(theta), np.cos(theta)))))

                def share(q: float, cot: mpmath.mpf = cot) -> mpmath.mpf:
                    q = mpmath.mpf(q)
                    return cot * mpmath.erfc(-q) / 2 + mpmath.exp(-q * q) / (2 * mpmath.sqrt(mpmath.pi))

                assert float(share(float(-m[0] / m[2])) / share(cot)) == pytest.approx(u, rel=1e-12)
            assert m[1] == pytest.approx(0, abs=1e-15)


def test_other_distributions_have_no_sampler() -> None:
    with pytest.raises(ValueError, match="has no sampler of visible normals"):
        mf.Smith(mf.Ward(0.3)).sample_visible(UP, [0.5, 0.5])
