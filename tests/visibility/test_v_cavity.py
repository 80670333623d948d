"""V-cavities: one groove traced by hand, and distributions with and without opposite facets."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from around import turned_to
from microfacet.directions import spherical
from samples import UP, hemisphere, views
from skewed import SKEWED

MODEL = mf.VCavity(mf.GGX(0.5, 0.2))


def seen_share_of_a_groove(theta: float, tilt: float, count: int = 200_000) -> float:
    """Of the facet that rises to the left of a groove's bottom, the share seen from the right at angle theta, by rays.

    The groove's walls rise to height 1 on both sides, both with this tilt; further grooves follow on both sides.
    """
    width = 1 / np.tan(tilt)
    x = -width * (np.arange(count) + 0.5) / count
    z = -x / width
    if theta <= 0:
        return float(np.mean(np.ones(count)))
    at_rim = z + (width - x) / np.tan(theta)
    return float(np.mean(at_rim >= 1))


@pytest.mark.parametrize("theta", [0.1, 0.7, 1.2, 1.5])
@pytest.mark.parametrize("tilt", [0.1, 0.6, 1.0, 1.4])
def test_one_groove(theta: float, tilt: float) -> None:
    """The left wall's normal leans to the right, towards the viewer."""
    wo, wm = spherical(theta), spherical(tilt)
    if wo @ wm > 0:
        assert MODEL.G1(wo, wm) == pytest.approx(seen_share_of_a_groove(theta, tilt), abs=1e-5)


def test_masking_is_the_smaller_of_one_and_the_open_share() -> None:
    wo, m = hemisphere(500, 1), hemisphere(500, 2)
    cosine = np.sum(wo * m, -1)
    with np.errstate(divide="ignore"):
        expected = np.where(cosine > 0, np.minimum(1, 2 * m[:, 2] * wo[:, 2] / cosine), 0)
    np.testing.assert_allclose(MODEL.G1(wo, m), expected, rtol=1e-14)


def test_masking_and_shadowing_is_the_smaller_of_both() -> None:
    wo, wi, m = hemisphere(500, 1), hemisphere(500, 2), hemisphere(500, 3)
    G2 = MODEL.G2(wo, wi, m)
    np.testing.assert_allclose(G2, np.minimum(MODEL.G1(wo, m), MODEL.G1(wi, m)), rtol=1e-14)
    np.testing.assert_array_equal(G2, MODEL.G2(wi, wo, m))
    np.testing.assert_array_equal(MODEL.G2(wo, wi * [1, 1, -1], m), 0)
    np.testing.assert_array_equal(MODEL.G2(wo * [1, 1, -1], wi, m), 0)
    np.testing.assert_array_equal(MODEL.G1(wo * [1, 1, -1], m), 0)
    np.testing.assert_array_equal(MODEL.G1(wo, m * [1, 1, -1]), 0)


@pytest.mark.parametrize("ndf", [mf.GGX(0.4), mf.Beckmann(0.2, 0.5), mf.NormalizedBlinnPhong(8.0)], ids=repr)
def test_opposite_facets_make_the_visible_area_right(ndf: mf.Beckmann) -> None:
    """The kink where masking sets in limits this rule on the sphere."""
    model = mf.VCavity(ndf)
    for wo in [UP, *views(30, 60, 85)]:
        seen = turned_to(wo, 128)
        assert seen.sum(model.D_visible(wo, seen.directions)) == pytest.approx(1, abs=3e-4)


def test_without_opposite_facets_it_is_wrong() -> None:
    model = mf.VCavity(SKEWED)
    errors = []
    for wo in [*views(60, azimuth=0), *views(60, azimuth=180)]:
        seen = turned_to(wo, 128)
        errors.append(seen.sum(model.D_visible(wo, seen.directions)) - 1)
    assert min(errors) < -0.01
    assert max(errors) > 0.01


def test_visible_normals_have_no_sampler() -> None:
    with pytest.raises(ValueError, match=r"VCavity.*has no sampler"):
        MODEL.sample_visible(UP, [0.5, 0.5])
