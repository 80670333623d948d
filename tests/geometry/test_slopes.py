"""A normal is a slope: the map, its Jacobian, and a distribution of one's own."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, pi
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from around import whole_hemisphere
from microfacet.directions import half_vector, reflect, spherical
from microfacet.geometry.slopes import Distribution
from samples import hemisphere, sphere


def test_spherical_coordinates() -> None:
    np.testing.assert_allclose(spherical(0.0), [0, 0, 1], atol=0)
    np.testing.assert_allclose(spherical(np.pi / 2, np.pi / 2), [0, 1, 0], atol=1e-16)
    assert spherical(np.zeros((3, 1)), np.zeros(4)).shape == (3, 4, 3)


def test_stated_solid_angle_is_the_jacobian() -> None:
    """Area on the sphere that a small square of slopes covers, by differences."""

    def normal(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        z = 1 / np.sqrt(1 + x * x + y * y)
        return np.stack([-x * z, -y * z, z], axis=-1)

    x, y = np.random.default_rng(0).normal(size=(2, 100))
    h = 1e-5
    along, across = (normal(x + h, y) - normal(x - h, y)) / (2 * h), (normal(x, y + h) - normal(x, y - h)) / (2 * h)
    stated = mf.equations["geometry.slopes.solid_angle"].kernel(*normal(x, y).T)
    np.testing.assert_allclose(stated, np.linalg.norm(np.cross(along, across), axis=-1), rtol=1e-8)


def cone(wm: tuple[float, float, float], p: Any) -> float:
    """D of a distribution that the library does not know: P22 ~ exp(-s), s the slope's length in units of alpha."""
    x, y, z = wm
    if not z > 0.0:
        return 0.0
    tangent = ((x * x + y * y) ** 0.5) / z
    return exp(-tangent / p[0]) / (2.0 * pi * p[0] * p[0] * ((z * z) * (z * z)))


class Cone(Distribution):
    kernel: Callable[..., float] = staticmethod(cone)
    isotropic = True

    def __init__(self, alpha: float) -> None:
        self.parameters, self.slope_scale = (alpha,), (alpha, alpha)


def test_a_distribution_of_ones_own_needs_its_kernel_only() -> None:
    ndf = Cone(0.3)
    everything = whole_hemisphere(0.3)
    m = everything.directions
    assert everything.sum(m[:, 2] * ndf.D(m)) == pytest.approx(1, abs=1e-8)
    below = hemisphere(10) * [1, 1, -1]
    np.testing.assert_array_equal(ndf.D(below), 0)


class RoughCone(Cone):
    def __init__(self, alpha: float, spread: float) -> None:
        self.parameters, self.alpha, self.slope_scale = (alpha,), (alpha, alpha), (spread, spread)


def test_roughness_is_what_a_distribution_says_and_no_scale_of_slopes() -> None:
    with pytest.raises(ValueError, match=r"Cone\(0\.3\) has no roughness"):
        mf.SchlickSmith(Cone(0.3))
    assert mf.SchlickSmith(Cone(0.3), k=0.2).k == 0.2
    for scale in (0.1, 0.3, 1.0):
        assert mf.SchlickSmith(RoughCone(0.3, scale)).k == mf.SchlickSmith(mf.GGX(0.3)).k


def test_a_scale_of_slopes_guides_a_quadrature_and_changes_no_value() -> None:
    wo = spherical(np.radians(75), 0.3)
    one, other = (mf.Smith(RoughCone(0.3, scale)).G1(wo, [0, 0, 1]) for scale in (0.2, 0.6))
    assert one == pytest.approx(other, rel=1e-12)


def test_reflection_keeps_length_and_angle_and_undoes_itself() -> None:
    wo, wm = sphere(200, 1), sphere(200, 2)
    wi = reflect(wo, wm)
    np.testing.assert_allclose(np.linalg.norm(wi, axis=-1), 1, rtol=1e-14)
    np.testing.assert_allclose(np.sum(wi * wm, -1), np.sum(wo * wm, -1), atol=1e-15)
    np.testing.assert_allclose(reflect(wi, wm), wo, atol=1e-15)


def test_half_vector_is_the_mirror_that_joins_both() -> None:
    wo, wm = sphere(200, 1), sphere(200, 2)
    wm *= np.sign(np.sum(wo * wm, -1))[:, None]
    np.testing.assert_allclose(half_vector(wo, reflect(wo, wm)), wm, atol=1e-12)
    np.testing.assert_array_equal(half_vector(wo, -wo), 0)


@pytest.mark.parametrize("function", [reflect, half_vector])
def test_single_precision_stays(function: Callable[..., np.ndarray]) -> None:
    wo, wm = sphere(5, 1).astype(np.float32), sphere(5, 2).astype(np.float32)
    assert function(wo, wm).dtype == np.float32
    assert function(wo, wm.astype(np.float64)).dtype == np.float64
    with pytest.raises(ValueError, match=r"wo must have shape .*got shape \(5, 2\)"):
        function(wo[:, :2], wm)
