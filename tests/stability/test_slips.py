"""What belongs to one surface beside what belongs to another, and questions that are not asked."""

from __future__ import annotations

import runpy
from pathlib import Path

import faulty
import microfacet as mf
import numpy as np
import pytest
from microfacet.directions import spherical

SCRIPT = runpy.run_path(str(Path(faulty.__file__).with_name("slips_data.py")))
UP = np.array([0.0, 0.0, 1.0])


def test_masking_of_another_surface_breaks_the_visible_area() -> None:
    """By as much as G1 is off, seen from the side; from straight above by nothing. The library's pairs keep it."""
    found = SCRIPT["areas"]()
    for name in ("mean_along", "mean_across", "twice", "borrowed"):
        assert abs(found[name] - 1).max() > 0.3, name
        assert abs(found[name][0] - 1) < 1e-3, name
    assert found["right"] < 1e-12


@pytest.mark.parametrize(("method", "polar"), [("axes_swapped", False), ("one_roughness", True)])
def test_samples_of_another_surface_are_caught_along_the_axes(method: str, polar: bool) -> None:
    """Swapped axes are not, by polar angles alone."""
    ndf, wo, u = SCRIPT["STRETCHED"], spherical(np.radians(60.0), 0.5), np.random.default_rng(1).random((20000, 2))
    drawn = getattr(faulty, method)
    assert (SCRIPT["ring_odds"](drawn(ndf, UP, u)) < 1e-3) is polar
    density = mf.Smith(ndf).D_visible
    assert SCRIPT["p_value"](drawn(ndf, wo, u), lambda m: density(wo, m), wo, ndf.slope_scale) < 1e-6
    right = mf.Smith(ndf).sample_visible
    assert SCRIPT["ring_odds"](right(UP, u)) > 1e-3
    assert SCRIPT["p_value"](right(wo, u), lambda m: density(wo, m), wo, ndf.slope_scale) > 1e-3


def test_no_light_comes_through_the_surface() -> None:
    """Where nobody asks on which side it is, it does; above the horizon that makes no difference."""
    ndf, wo = mf.GGX(0.5), SCRIPT["VIEW"]
    above, below = (spherical(np.radians(t), np.pi) for t in ([10.0, 60.0, 85.0], [95.0, 110.0, 130.0]))
    brdf = mf.Microfacet(mf.Smith(ndf, "none"))
    np.testing.assert_allclose(faulty.rho_both_sides(ndf, wo, above), brdf.evaluate(wo, above), rtol=1e-12)
    assert (faulty.rho_both_sides(ndf, wo, below) > 0.1).all()
    np.testing.assert_array_equal(brdf.evaluate(wo, below), 0)
