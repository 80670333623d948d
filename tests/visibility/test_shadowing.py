"""How masking and shadowing depend on each other: what holds for any two Lambdas."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate

LAMBDA = st.floats(0, 1e4)
SHARE = st.floats(0, 1)


def stated(name: str, *arguments: float) -> float:
    return mf.equations[f"visibility.shadowing.{name}"].scalar(*arguments)


@given(o=LAMBDA, i=LAMBDA, blend=SHARE)
def test_order_from_separable_to_fully_correlated(o: float, i: float, blend: float) -> None:
    """Whatever is correlated shadows less: separable <= by height <= by height and direction <= the smaller G1."""
    least = 1 / (1 + max(o, i))
    separable, height = stated("separable", o, i), stated("height", o, i)
    direction, both = stated("direction", o, i, blend), stated("height_direction", o, i, blend)
    slack = 1 + 1e-14
    assert separable <= height * slack
    assert height <= both * slack
    assert both <= least * slack
    assert separable <= direction * slack
    assert direction <= least * slack


@given(o=LAMBDA, i=LAMBDA, blend=SHARE)
def test_light_and_viewer_may_change_places(o: float, i: float, blend: float) -> None:
    for name in ("separable", "height"):
        assert stated(name, o, i) == pytest.approx(stated(name, i, o), rel=1e-15, abs=0)
    for name in ("direction", "height_direction"):
        assert stated(name, o, i, blend) == pytest.approx(stated(name, i, o, blend), rel=1e-15, abs=0)


@given(o=LAMBDA, blend=SHARE)
def test_without_shadowing_masking_is_left(o: float, blend: float) -> None:
    for value in (
        stated("separable", o, 0.0),
        stated("height", o, 0.0),
        stated("direction", o, 0.0, blend),
        stated("height_direction", o, 0.0, blend),
    ):
        assert value == pytest.approx(1 / (1 + o), rel=1e-14, abs=0)


@given(o=LAMBDA, i=LAMBDA)
def test_limits_of_the_blend(o: float, i: float) -> None:
    least = 1 / (1 + max(o, i))
    assert stated("direction", o, i, 0.0) == pytest.approx(least, rel=1e-14, abs=0)
    assert stated("direction", o, i, 1.0) == pytest.approx(stated("separable", o, i), rel=1e-14, abs=0)
    assert stated("height_direction", o, i, 0.0) == pytest.approx(least, rel=1e-14, abs=0)
    assert stated("height_direction", o, i, 1.0) == pytest.approx(stated("height", o, i), rel=1e-14, abs=0)


@given(first=st.floats(0, 3.14), second=st.floats(0, 3.14))
def test_blend_grows_with_the_angle_between_azimuths(first: float, second: float) -> None:
    first, second = sorted((first, second))
    assert 0 <= stated("lambda", first) <= stated("lambda", second) < 1


def test_known_values_of_the_blend() -> None:
    """4.41 per radian: half way at 13 degrees, 0.93 for opposite azimuths."""
    assert stated("lambda", 0.0) == 0
    assert stated("lambda", 1 / 4.41) == pytest.approx(0.5, rel=1e-15, abs=0)
    assert stated("lambda", np.pi) == pytest.approx(0.93267, abs=1e-5)


@given(o=st.floats(0.01, 50), i=st.floats(0.01, 50))
def test_height_correlation_is_an_average_over_heights(o: float, i: float) -> None:
    """u^Lambda_o u^Lambda_i over the share u of the surface that lies lower."""
    average = integrate.quad(lambda u: u**o * u**i, 0, 1)[0]
    assert stated("height", o, i) == pytest.approx(average, rel=1e-7)
