"""The library's own distributions and masking functions over their whole range: right ones hold, wrong ones fail."""

from __future__ import annotations

import microfacet as mf
import pytest
from microfacet.geometry.slopes import Distribution

SCALES = [(1e-8, 1e-8), (1e-8, 1e-4), (1e-8, 1e3), (1e-3, 1e-3), (0.01, 100.0), (1.0, 1.0), (10.0, 1e3), (1e3, 1e3)]
NORMALISED = [
    *(make(*scale) for make in (mf.GGX, mf.Beckmann) for scale in SCALES),
    *map(mf.NormalizedBlinnPhong, (1e-3, 1.0, 1e6)),
]
VIEWED = ("visible_area", "visible_norm", "weak_furnace")


@pytest.mark.parametrize("ndf", NORMALISED, ids=repr)
def test_right_models_hold(ndf: Distribution) -> None:
    for model in (mf.Smith(ndf), mf.VCavity(ndf), mf.Smith(ndf, "none")):
        found = mf.validate(model)
        assert found.holds, str(found)


@pytest.mark.parametrize("ndf", [*(mf.Ward(*scale) for scale in SCALES[3:]), mf.BlinnPhong(1e-3), mf.BlinnPhong(1e6)], ids=repr)
def test_distributions_without_norm_fail(ndf: Distribution) -> None:
    for model in (mf.Smith(ndf), mf.VCavity(ndf)):
        found = mf.validate(model)
        assert {found[name].verdict for name in ("projected_area", *VIEWED)} == {"fails"}, str(found)
        assert {found[name].verdict for name in ("positivity", "reciprocity")} == {"holds"}, str(found)


@pytest.mark.parametrize("ndf", [mf.GGX(1e-3), mf.GGX(10.0, 1e3), mf.Beckmann(0.01, 100.0), mf.Beckmann(1.0)], ids=repr)
def test_masking_of_no_surface_fails(ndf: Distribution) -> None:
    for model in (mf.Implicit(ndf), mf.Kelemen(ndf), mf.SchlickSmith(ndf)):
        found = mf.validate(model)
        assert {found[name].verdict for name in VIEWED} == {"fails"}, str(found)
        assert {found[name].verdict for name in ("projected_area", "positivity", "reciprocity")} == {"holds"}, str(found)
