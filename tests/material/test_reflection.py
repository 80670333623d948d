"""Mirror facets: the Jacobian by differences, and the weak white furnace."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from around import reflected
from microfacet.directions import half_vector
from samples import UP, hemisphere, sphere, views


def test_stated_jacobian_of_the_half_vector() -> None:
    """Area that half vectors cover when light moves over a small square."""
    wo, wi = hemisphere(200, 1), sphere(200, 2)
    facing = np.sum(wo * wi, -1) > -0.98
    wo, wi = wo[facing], wi[facing]
    first = np.cross(wi, [0.3, 0.5, 0.8])
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second, h = np.cross(wi, first), 1e-5

    def moved(axis: np.ndarray) -> np.ndarray:
        return (half_vector(wo, np.cos(h) * wi + np.sin(h) * axis) - half_vector(wo, np.cos(h) * wi - np.sin(h) * axis)) / (
            2 * h
        )

    area = np.linalg.norm(np.cross(moved(first), moved(second)), axis=-1)
    stated = mf.equations["material.reflection.jacobian"].kernel(np.sum(wi * half_vector(wo, wi), -1))
    np.testing.assert_allclose(stated, area, rtol=1e-7)


@pytest.mark.parametrize("ndf", [mf.GGX(0.4), mf.GGX(0.5, 0.2), mf.Beckmann(0.4), mf.GGX(1.0)], ids=repr)
def test_weak_white_furnace(ndf: mf.GGX) -> None:
    """G1 D/(4 cos theta_o) over the whole sphere of light; the density of the BRDF's samples is the same thing."""
    model = mf.Smith(ndf)
    brdf = mf.Microfacet(model)
    for wo in (UP, *views(60, 85)):

        def furnace(wi: np.ndarray, wo: np.ndarray = wo) -> np.ndarray:
            h = half_vector(wo, wi)
            return model.G1(wo, h) * ndf.D(h) / (4 * wo[2])

        assert reflected(wo, furnace) == pytest.approx(1, rel=1e-6)
        assert reflected(wo, lambda wi, wo=wo: brdf.pdf(wo, wi)) == pytest.approx(1, rel=1e-6)


def test_the_upper_hemisphere_alone_loses_light() -> None:
    """GGX at alpha = 1, where G1 D/(4 cos) = 1/(2 pi (1 + mu)): the share that goes down is mu/(1 + mu)."""
    model = mf.Smith(mf.GGX(1.0))
    for wo in views(10, 50, 80):
        upper = reflected(wo, lambda wi, wo=wo: np.where(wi[:, 2] > 0, mf.Microfacet(model).pdf(wo, wi), 0), 200)
        assert 1 - upper == pytest.approx(wo[2] / (1 + wo[2]), abs=2e-3)
        wi = hemisphere(100)
        np.testing.assert_allclose(mf.Microfacet(model).pdf(wo, wi), 1 / (2 * np.pi * (1 + wo[2])), rtol=1e-13)
