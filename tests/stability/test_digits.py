"""Textbook forms lose the digits that chapter 8 says they lose; the library's keep theirs."""

from __future__ import annotations

import faulty
import microfacet as mf
import numpy as np
import pytest
from microfacet.validation import accuracy

SINGLE, DOUBLE = np.float32, np.float64


def digits(method, quantity: str, ndf: mf.GGX, tangent: float, real: type) -> float:
    """Right digits at one angle; NaN where the precision cannot hold the value."""
    views = accuracy.directions(real, np.array([tangent]))
    exact = accuracy.QUANTITIES[quantity][1](type(ndf)(accuracy.rounded(ndf.alpha_x, real)), views[0])
    return float(accuracy.digits(method(ndf, views), [exact], real)[0])


@pytest.mark.parametrize(
    ("method", "quantity", "ndf", "tangent", "real", "least"),
    [
        (faulty.ggx_D_cosine, "D", mf.GGX(1e-3), 3e-4, SINGLE, 6),
        (faulty.ggx_D_cosine, "D", mf.GGX(1e-7), 1e-8, DOUBLE, 15),
        (faulty.beckmann_D_cosine, "D", mf.Beckmann(1e-3), 3e-4, SINGLE, 6),
        (faulty.beckmann_D_cosine, "D", mf.Beckmann(1e-7), 1e-8, DOUBLE, 15),
        (faulty.ggx_Lambda_difference, "Lambda", mf.GGX(0.01), 0.02, SINGLE, 6),
        (faulty.ggx_Lambda_difference, "Lambda", mf.GGX(1e-6), 0.02, DOUBLE, 15),
        (faulty.beckmann_Lambda_erf, "Lambda", mf.Beckmann(0.2), 1.0, SINGLE, 5),
        (faulty.beckmann_Lambda_erf, "Lambda", mf.Beckmann(0.1), 1.0, DOUBLE, 12),
        (faulty.walter_Lambda, "Lambda", mf.Beckmann(0.8), 1.0, DOUBLE, 15),
    ],
)
def test_a_printed_form_fails_where_the_library_does_not(method, quantity, ndf, tangent, real, least) -> None:
    with np.errstate(all="ignore"):
        assert digits(method, quantity, ndf, tangent, real) < 3
    assert digits(accuracy.QUANTITIES[quantity][0], quantity, ndf, tangent, real) > least


@pytest.mark.parametrize(("method", "quantity", "kind"), [
    (faulty.ggx_D_cosine, "D", mf.GGX),
    (faulty.beckmann_D_cosine, "D", mf.Beckmann),
    (faulty.ggx_Lambda_difference, "Lambda", mf.GGX),
    (faulty.beckmann_Lambda_erf, "Lambda", mf.Beckmann),
    (faulty.beckmann_Lambda_erfc, "Lambda", mf.Beckmann),
])  # fmt: skip
@pytest.mark.parametrize("real", [SINGLE, DOUBLE])
def test_where_nothing_cancels_the_printed_form_is_right(method, quantity, kind, real) -> None:
    """The exhibits are the equations, and not something else."""
    assert digits(method, quantity, kind(0.8), 1.5, real) > 0.75 * accuracy.MOST[real]


@pytest.mark.parametrize("real", [SINGLE, DOUBLE])
@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
def test_digits_of_the_library_over_the_whole_map(kind: type, real: type) -> None:
    """Of Beckmann's Lambda as many digits are lost as 2 a^2 has, where a^2 is at most 700 (in single, 90)."""
    assert np.nanmin(accuracy.map_of(accuracy.D, "D", kind, real)) > accuracy.MOST[real] - 1.3
    lost = 4 if kind is mf.Beckmann else 1.3
    assert np.nanmin(accuracy.map_of(accuracy.Lambda, "Lambda", kind, real)) > accuracy.MOST[real] - lost


def test_digits_are_counted_from_the_binary_value() -> None:
    third = mf.equations["visibility.smith.G1"].exact(1.0, 2.0)
    assert accuracy.digits(np.array([1 / 3]), [third], DOUBLE)[0] > 15.9
    assert accuracy.digits(np.array([0.333]), [third], DOUBLE)[0] == pytest.approx(3, abs=1e-3)
    assert accuracy.digits(np.array([np.nan]), [third], DOUBLE)[0] == 0
    assert np.isnan(accuracy.digits(np.array([0.0]), [third * 0 + 1e-320], DOUBLE)[0])
