"""What a distribution can do is inherited, but for what was made for another D or another Lambda."""

from __future__ import annotations

from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.geometry.slopes import OF_D, OF_LAMBDA
from samples import UP, hemisphere, uniform

WO, WI = hemisphere(50, 1), hemisphere(50, 2)


class Remapped(mf.GGX):
    """GGX by a roughness that is squared."""

    def __init__(self, roughness: float) -> None:
        super().__init__(roughness * roughness)
        self.roughness = roughness


def flat(wm: tuple[float, float, float], p: Any) -> float:
    return (0.3183098861837907 if wm[2] > 0.0 else 0.0) + 0.0 * p.alpha_x


class Flat(mf.GGX):
    """Another D, 1/pi: nothing that was made for GGX holds of it."""

    kernel = staticmethod(flat)


def half_Lambda(w: tuple[float, float, float], p: Any) -> float:
    return 0.5 + 0.0 * p.alpha_x * w[0] * w[1] * w[2]


class Half(mf.Beckmann):
    """Another Lambda: a sampler of visible normals knows Beckmann's."""

    closed_Lambda = staticmethod(half_Lambda)


def test_a_subclass_is_as_quick_and_as_able_as_its_base() -> None:
    own, base = (mf.Microfacet(mf.Smith(ndf)) for ndf in (Remapped(0.5), mf.GGX(0.25)))
    assert own.evaluation == base.evaluation
    for name in ("evaluate", "pdf", "weight"):
        np.testing.assert_array_equal(getattr(own, name)(WO, WI), getattr(base, name)(WO, WI))
    np.testing.assert_array_equal(own.sample(WO, uniform(50)), base.sample(WO, uniform(50)))
    np.testing.assert_array_equal(own.albedo(WO[:5]), base.albedo(WO[:5]))
    steps = mf.RandomWalk(own.model).albedo(UP, walks=1000)
    assert steps == mf.RandomWalk(base.model).albedo(UP, walks=1000)


def test_another_D_keeps_nothing_of_its_base() -> None:
    ndf = Flat(0.3)
    assert {name: getattr(ndf, name) for name in OF_D} == dict.fromkeys(OF_D) | {
        "reach": np.inf,
        "statements": {},
        "regular": False,
    }
    np.testing.assert_allclose(ndf.D(WO), 1 / np.pi, rtol=1e-15)
    half = 1 / (1 + mf.Smith(ndf).G1(WO, UP) ** -1 - 1)
    assert (half < 1).all()
    with pytest.raises(ValueError, match=r"Flat\(0\.3, 0\.3\) has no sampler"):
        ndf.sample(uniform(3))
    with pytest.raises(ValueError, match="has no sampler"):
        mf.Microfacet(mf.VCavity(ndf)).sample(WO, uniform(50))
    with pytest.raises(ValueError, match="height-correlated"):
        mf.RandomWalk(mf.Smith(ndf))
    assert mf.validate(mf.Smith(ndf)).holds  # perfect hemispheres, by quadrature


def test_another_Lambda_keeps_the_rest_only() -> None:
    assert [getattr(Half(0.3), name) for name in OF_LAMBDA] == [None, None, None]
    assert Half.reach == mf.Beckmann.reach
    assert Half.sample_kernel is mf.Beckmann.sample_kernel
    model = mf.Smith(Half(0.3))
    np.testing.assert_allclose(model.G1(WO, UP), 1 / 1.5, rtol=1e-15)
    with pytest.raises(ValueError, match="has no sampler of visible normals"):
        model.sample_visible(WO, uniform(50))
    assert mf.Microfacet(model).sample(WO, uniform(50)).shape == (50, 3)


def test_what_a_class_names_itself_it_has() -> None:
    class Named(Flat):
        kernel = staticmethod(flat)
        closed_Lambda = staticmethod(half_Lambda)
        sample_visible_kernel = mf.GGX.sample_visible_kernel

    assert Named.closed_Lambda is half_Lambda
    assert Named.sample_visible_kernel is mf.GGX.sample_visible_kernel
    assert mf.NormalizedBlinnPhong.closed_Lambda is mf.BlinnPhong.closed_Lambda
    assert mf.NormalizedBlinnPhong.excess_kernel is None
