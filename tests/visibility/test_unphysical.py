"""Masking functions that no surface has: by how much they miss the visible area, table 2 of the talk."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
import references
from around import turned_to
from samples import UP, hemisphere, views

DEGREES = (0, 30, 60, 80, 89)
BECKMANN = mf.Beckmann(0.4)
TABLE = {
    mf.Implicit(BECKMANN): (1, 0.8660, 0.5019, 0.2189, 0.1218),
    mf.Kelemen(BECKMANN): (1.0747, 1.0747, 1.0491, 0.7808, 0.5629),
    mf.SchlickSmith(BECKMANN): (1, 0.9530, 0.7609, 0.5004, 0.3678),
}
MODELS = [*TABLE, mf.SchlickSmith(BECKMANN, k=0.2)]


def visible_share(model: mf.Smith, wo: np.ndarray) -> float:
    """Integral of G1 <wo, wm> D over cos theta_o, on the sphere around the viewer."""
    seen = turned_to(wo)
    m = seen.directions
    return seen.sum(model.G1(wo, m) * (m @ wo) * model.ndf.D(m)) / wo[2]


@pytest.mark.parametrize(("model", "printed"), TABLE.items(), ids=repr)
def test_table_of_masking_functions(model: mf.Smith, printed: tuple[float, ...]) -> None:
    shares = [visible_share(model, wo) for wo in views(*DEGREES)]
    np.testing.assert_allclose(shares, printed, atol=5.1e-5)


def test_implicit_keeps_one_plus_Lambda_times_the_cosine() -> None:
    for wo in views(*DEGREES[1:]):
        exact = (1 + references.beckmann_Lambda(references.a_of(*wo, 0.4, 0.4))) * wo[2]
        assert visible_share(mf.Implicit(BECKMANN), wo) == pytest.approx(float(exact), rel=1e-9)


def test_at_normal_incidence_two_wrong_ones_pass() -> None:
    assert visible_share(mf.Implicit(BECKMANN), UP) == pytest.approx(1, abs=1e-9)
    assert visible_share(mf.SchlickSmith(BECKMANN), UP) == pytest.approx(1, abs=1e-9)
    assert abs(visible_share(mf.Kelemen(BECKMANN), UP) - 1) > 0.07


def test_schlick_with_half_alpha_is_smith_for_ggx_at_roughness_one() -> None:
    ndf = mf.GGX(1.0)
    wo, wi, m = hemisphere(300, 1), hemisphere(300, 2), hemisphere(300, 3)
    schlick = mf.SchlickSmith(ndf, k=0.5)
    np.testing.assert_allclose(schlick.G1(wo, m), mf.Smith(ndf).G1(wo, m), rtol=1e-14)
    np.testing.assert_allclose(schlick.G2(wo, wi, m), mf.Smith(ndf, "none").G2(wo, wi, m), rtol=1e-14)


def test_default_k() -> None:
    assert mf.SchlickSmith(mf.GGX(0.3, 0.1)).k == pytest.approx(0.3 * (2 / np.pi) ** 0.5, rel=1e-15, abs=0)


def test_formulae() -> None:
    wo, wi, m = hemisphere(500, 1), hemisphere(500, 2), hemisphere(500, 3)
    seen, lit = np.sum(wo * m, -1), np.sum(wi * m, -1)
    both = (seen > 0) & (lit > 0)
    o, i, k = wo[:, 2], wi[:, 2], 0.2
    expected = {
        MODELS[0]: (o, o * i),
        MODELS[1]: (o / seen, o * i / (seen * lit)),
        MODELS[3]: (o / (o * (1 - k) + k), o / (o * (1 - k) + k) * (i / (i * (1 - k) + k))),
    }
    for model, (G1, G2) in expected.items():
        np.testing.assert_allclose(model.G1(wo, m), np.where(seen > 0, G1, 0), rtol=1e-14)
        np.testing.assert_allclose(model.G2(wo, wi, m), np.where(both, G2, 0), rtol=1e-14)


@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_nothing_is_seen_from_below(model: mf.Smith) -> None:
    wo, wi, m = hemisphere(50, 1), hemisphere(50, 2), hemisphere(50, 3)
    np.testing.assert_array_equal(model.G1(wo * [1, 1, -1], m), 0)
    np.testing.assert_array_equal(model.G2(wo * [1, 1, -1], wi, m), 0)
    np.testing.assert_array_equal(model.G2(wo, wi * [1, 1, -1], m), 0)
    np.testing.assert_array_equal(model.D_visible(wo, m * [1, 1, -1]), 0)
