"""Sampling all normals, regardless of the viewer."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from around import whole_hemisphere
from hypothesis import given
from hypothesis import strategies as st
from microfacet.validation.chi_square import p_value
from samples import LAST, LAST_SINGLE, NORMALISED, UP, uniform
from sampling import density_times_area

NARROW = [mf.GGX(0.01), mf.Beckmann(0.01, 0.3), mf.NormalizedBlinnPhong(5e3)]
INSIDE = st.floats(0.01, 0.99)


@pytest.mark.parametrize("ndf", [*NORMALISED, *NARROW], ids=repr)
@given(u1=INSIDE, u2=INSIDE)
def test_sampler_has_its_density(ndf: mf.Beckmann, u1: float, u2: float) -> None:
    assert density_times_area(ndf.sample, ndf.pdf, np.array([u1, u2])) == pytest.approx(1, abs=1e-7)


@pytest.mark.parametrize("ndf", NORMALISED, ids=repr)
def test_density_is_that_of_projected_facets_and_integrates_to_one(ndf: mf.Beckmann) -> None:
    everything = whole_hemisphere(max(ndf.slope_scale))
    density = ndf.pdf(everything.directions)
    assert everything.sum(density) == pytest.approx(1, abs=1e-10)
    np.testing.assert_allclose(density, everything.directions[:, 2] * ndf.D(everything.directions), rtol=1e-10, atol=1e-290)


@pytest.mark.parametrize("ndf", [mf.Ward(0.5), mf.BlinnPhong(3.0)], ids=repr)
def test_distributions_without_norm_are_sampled_by_normalised_ones(ndf: mf.Beckmann) -> None:
    everything = whole_hemisphere(max(ndf.slope_scale))
    assert everything.sum(ndf.pdf(everything.directions)) == pytest.approx(1, abs=1e-10)


@pytest.mark.parametrize("ndf", [*NORMALISED, *NARROW], ids=repr)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_counts_follow_the_density(ndf: mf.Beckmann, real: type) -> None:
    normals = ndf.sample(uniform(200_000, 1, real))
    assert normals.dtype == real
    assert p_value(normals, ndf.pdf, UP, ndf.slope_scale) > 1e-4


def test_counts_tell_swapped_axes_and_an_isotropic_lobe_apart() -> None:
    """The test above can fail: the right sampler against the wrong density."""
    ndf = mf.GGX(0.5, 0.2)
    normals = ndf.sample(uniform(200_000))
    for wrong in (mf.GGX(0.2, 0.5), mf.GGX(0.1**0.5), mf.GGX(0.52, 0.2), mf.Beckmann(0.5, 0.2)):
        assert p_value(normals, wrong.pdf, UP, ndf.slope_scale) < 1e-6


@pytest.mark.parametrize("ndf", [*NORMALISED, *NARROW, mf.GGX(1e-4), mf.GGX(10.0)], ids=repr)
@pytest.mark.parametrize(("real", "last"), [(np.float64, LAST), (np.float32, LAST_SINGLE)])
def test_corners_of_the_unit_square_give_normals(ndf: mf.Beckmann, real: type, last: float) -> None:
    """At the largest u a normal may lie on the horizon to rounding, but it is one, and finite."""
    corners = np.array([(a, b) for a in (0, 0.5, last) for b in (0, 0.5, last)], real)
    normals = ndf.sample(corners)
    assert np.isfinite(normals).all()
    assert (normals[:, 2] >= 0).all()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, rtol=4 * np.finfo(real).eps)
    np.testing.assert_allclose(normals[0], [0, 0, 1], atol=1e-30)
