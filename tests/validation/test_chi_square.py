"""The chi-square test of normals: its odds are those of the three tests that it consists of."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from microfacet.directions import spherical
from microfacet.validation.chi_square import SlopeCells, p_value, p_value_of_counts

MODEL, WO = mf.Smith(mf.GGX(0.5, 0.3)), spherical(1.0, 0.4)


def test_odds_are_three_times_the_smallest_of_three() -> None:
    """Along the view, across it, and over all cells."""
    below_1 = 0
    for seed in range(8):
        normals = MODEL.sample_visible(WO, np.random.default_rng(seed).random((5000, 2)))
        cells = SlopeCells(WO, MODEL.ndf.slope_scale)
        counts, expected = cells.counts(normals), len(normals) * cells.integrals(lambda m: MODEL.D_visible(WO, m))
        tests = [p_value_of_counts(*(table.sum(axis) for table in (counts, expected))) for axis in ((), 0, 1)]
        found = p_value(normals, lambda m: MODEL.D_visible(WO, m), WO, MODEL.ndf.slope_scale)
        assert found == pytest.approx(min(1.0, 3 * min(tests)), rel=1e-12)
        below_1 += found < 1
    assert below_1 >= 4


def test_normals_of_another_surface_are_refused() -> None:
    normals = mf.Smith(mf.GGX(0.45, 0.3)).sample_visible(WO, np.random.default_rng(1).random((20000, 2)))
    assert p_value(normals, lambda m: MODEL.D_visible(WO, m), WO, MODEL.ndf.slope_scale) < 1e-6


def test_a_normal_that_cannot_be_seen_has_no_odds() -> None:
    normals = MODEL.sample_visible(WO, np.random.default_rng(2).random((5000, 2)))
    normals[0] = -WO
    assert p_value(normals, lambda m: MODEL.D_visible(WO, m), WO, MODEL.ndf.slope_scale) == 0
