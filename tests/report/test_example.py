"""Whole percentages of what diagrams show."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report.example import percentages


@given(st.lists(st.floats(0, 1e6), min_size=1, max_size=40).filter(lambda row: sum(row) > 1e-6))
def test_percentages_add_up_to_100(shares: list[float]) -> None:
    whole = percentages(shares)
    assert whole.sum() == 100
    assert np.all(np.abs(whole - 100 * np.array(shares) / np.sum(shares)) < 1 + 1e-6)


def test_whole_percentages_stay() -> None:
    np.testing.assert_array_equal(percentages(np.array([0.07, 0.29, 0.0, 0.64])), [7, 29, 0, 64])


@pytest.mark.parametrize("shares", [[0.5, -0.1], [0.0]])
def test_shares_that_are_none_are_named(shares: list[float]) -> None:
    with pytest.raises(ValueError, match=f"fractions must be .*{shares[-1]:g}"):
        percentages(shares)
