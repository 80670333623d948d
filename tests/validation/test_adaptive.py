"""The area seen of a surface whose distribution of normals is any function: right, and its error honest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import microfacet as mf
import numpy as np
import pytest
from microfacet.geometry.panels import falling, rule
from microfacet.geometry.slopes import Distribution, spread
from microfacet.validation.adaptive import seen_area
from microfacet.validation.equations import residuals
from samples import UP, views
from skewed import SKEWED, skewed

Function = Callable[[np.ndarray], np.ndarray]
SEEN = views(0, 30, 60, 85, 89.9)
TWELVE = 1e-12


def ggx(alpha_x: float, alpha_y: float) -> Function:
    return lambda m: 1 / (np.pi * alpha_x * alpha_y * ((m[:, 0] / alpha_x) ** 2 + (m[:, 1] / alpha_y) ** 2 + m[:, 2] ** 2) ** 2)


def beckmann(alpha_x: float, alpha_y: float) -> Function:
    def D(m: np.ndarray) -> np.ndarray:
        square = ((m[:, 0] / alpha_x) ** 2 + (m[:, 1] / alpha_y) ** 2) / m[:, 2] ** 2
        return np.asarray(np.exp(-square) / (np.pi * alpha_x * alpha_y * m[:, 2] ** 4))

    return D


def mixed(m: np.ndarray) -> np.ndarray:
    return np.asarray(0.3 * ggx(0.05, 0.05)(m) + 0.7 * beckmann(0.6, 0.3)(m))


def cavities(wo: np.ndarray) -> Function:
    """G1 of V-cavities in whole arrays."""
    return lambda m: np.minimum(1, 2 * m[:, 2] * wo[2] / np.maximum(m @ wo, 1e-300))


SMOOTH = {
    **{f"GGX {alpha}": ggx(*alpha) for alpha in ((1e-3, 1e-3), (0.4, 0.4), (2.0, 2.0), (0.05, 0.6))},
    **{f"Beckmann {alpha}": beckmann(*alpha) for alpha in ((1e-3, 1e-3), (0.4, 0.4), (2.0, 2.0), (0.05, 0.6))},
}


@pytest.mark.parametrize("name", SMOOTH)
def test_twelve_digits_of_a_smooth_function(name: str) -> None:
    for wo in SEEN:
        found = seen_area(SMOOTH[name], wo, cavities(wo))
        assert abs(found.value - 1) <= found.error < TWELVE + 1e-13
        assert found.evaluations < 20000


@pytest.mark.parametrize("wo", SEEN, ids=str)
def test_two_lobes_of_unlike_size(wo: np.ndarray) -> None:
    found = seen_area(mixed, wo, cavities(wo))
    assert abs(found.value - 1) <= found.error < 1e-8
    assert abs(found.value - 1) < 1e-13
    longer = seen_area(mixed, wo, cavities(wo), most=200000)
    assert abs(longer.value - 1) <= longer.error < TWELVE + 1e-13


# --- a table with kinks -------------------------------------------------------------------------------------------------

ENDS = np.array([0.0, 0.15, 0.5, 1.1])  # polar angles between which it is linear
VALUES = np.array([6.0, 5.0, 0.4, 0.0])


def norm() -> float:
    """The projected area of the table: linear pieces against sin 2 theta, in closed form."""
    rise = np.diff(VALUES) / np.diff(ENDS)
    start = VALUES[:-1] - rise * ENDS[:-1]

    def antiderivative(t: np.ndarray) -> Any:
        return -(start + rise * t) * np.cos(2 * t) / 2 + rise * np.sin(2 * t) / 4

    return float(np.pi * np.sum(antiderivative(ENDS[1:]) - antiderivative(ENDS[:-1])))


def table(m: np.ndarray) -> np.ndarray:
    return np.interp(np.arctan2(np.hypot(m[:, 0], m[:, 1]), m[:, 2]), ENDS, VALUES) / norm()


@pytest.mark.parametrize("wo", SEEN, ids=str)
def test_kinks_are_closed_in_on(wo: np.ndarray) -> None:
    found = seen_area(table, wo, cavities(wo))
    assert abs(found.value - 1) <= found.error < 1e-6
    longer = seen_area(table, wo, cavities(wo), most=200000)
    assert abs(longer.value - 1) <= longer.error < 1e-9


def test_the_error_is_told_whatever_may_be_spent() -> None:
    for D in (mixed, table, SMOOTH["GGX (0.05, 0.6)"]):
        for most in (3000, 10000, 30000):
            for wo in SEEN:
                found = seen_area(D, wo, cavities(wo), most=most)
                assert abs(found.value - 1) <= found.error


# --- what else it gives -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ndf", [mf.GGX(0.3, 0.1), mf.Beckmann(0.5), mf.Ward(0.4, 0.2), SKEWED], ids=repr)
def test_without_masking_it_is_lambda(ndf: Distribution) -> None:
    """What is seen, less the facets' whole projection, is what is hidden: the library's own Lambda."""
    flat = seen_area(ndf).value
    for wo in SEEN[1:]:
        found = seen_area(ndf, wo)
        assert found.value - flat == pytest.approx(1 / mf.Smith(ndf).G1(wo, wo) - 1, abs=3e-12 * found.value)


def test_a_skewed_function_fails_with_cavities() -> None:
    wo = views(60, azimuth=0)[0]
    found = seen_area(SKEWED.D, wo, cavities(wo))
    assert abs(found.value - 1) > 0.01 > 1e6 * found.error


def test_a_distribution_need_not_say_its_scale() -> None:
    class Silent(Distribution):
        kernel: ClassVar[Callable[..., float]] = staticmethod(skewed)

        def __init__(self) -> None:
            self.parameters = SKEWED.parameters

    silent = Silent()
    assert silent.slope_scale == pytest.approx((0.6, 0.3), rel=0.5)
    wo = views(60)[0]
    assert mf.Smith(silent).G1(wo, wo) == pytest.approx(mf.Smith(SKEWED).G1(wo, wo), rel=1e-11)
    for values, bounds in residuals(mf.Smith(silent), SEEN).values():
        assert (np.abs(values) + bounds < 1e-9).all()


@pytest.mark.parametrize("make", [ggx, beckmann])
@pytest.mark.parametrize("alpha", [(1e-3, 1e-3), (0.4, 0.4), (2.0, 2.0), (1e-3, 1.0)])
def test_spread_finds_the_scale(make: Callable[..., Function], alpha: tuple[float, float]) -> None:
    found = spread(make(*alpha))
    assert found == pytest.approx(alpha, rel=0.4)
    assert (found[0] == found[1]) is (alpha[0] == alpha[1])


def test_the_error_follows_how_coefficients_fall() -> None:
    """Of polynomials the rule is exact for it is 0, of a kink about its size wherever it lies, of smooth functions far less."""
    nodes, weights, functionals = rule()
    low = nodes[None, :] ** np.arange(len(nodes) - 8)[:, None]
    assert np.abs(low @ functionals).max() < 1e-14
    at = np.linspace(0.02, 0.98, 1000)
    kinks = np.abs(nodes - at[:, None])
    errors = np.abs(kinks @ weights - (at**2 + (1 - at) ** 2) / 2)
    told = falling(functionals.T @ kinks.T[None])[0]
    assert (errors < 5 * told).all()
    assert np.mean(errors < told) > 0.98
    assert told.max() < 0.02
    assert falling(functionals.T @ np.exp(-nodes)[None, :, None])[0, 0] < 1e-15


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((mixed, [0, 0.6, -0.8]), "wo must be one direction above the horizon"),
        ((mixed, SEEN), "wo must be one direction above the horizon"),
        ((lambda m: 0 * m[:, 0],), "a distribution of normals must have a finite norm above 0, got about 0"),
        ((lambda m: np.nan * m[:, 0], UP, None, 1e-9, 9000, (1, 1)), "D and G1 must be finite at all normals, got nan"),
        ((mf.GGX(0.3), UP, lambda m: np.inf * m[:, 2]), "D and G1 must be finite at all normals, got inf"),
        ((5, UP), r"D must be a distribution such as GGX\(0.3\) or a function of normals, got 5"),
        ((mixed, UP, 1.0), "G1 must be None or a function of normals, got 1.0"),
        ((mixed, UP, None, np.nan), "tolerance must be a finite number above 0, got nan"),
        ((mixed, UP, None, -1), "tolerance must be a finite number above 0, got -1"),
        ((mixed, UP, None, "x"), "tolerance must be a number above 0, got 'x'"),
        ((mixed, UP, None, 1e-9, 0), "most must be a whole number of at least 1, got 0"),
        ((mixed, UP, None, 1e-9, np.nan), "most must be a whole number of at least 1, got nan"),
        ((mixed, UP, None, 1e-9, 9000, (-1, 1)), "scale must be a finite number above 0, got -1"),
        ((mixed, UP, None, 1e-9, 9000, (0, 0)), "scale must be a finite number above 0, got 0"),
        ((mixed, UP, None, 1e-9, 9000, 0.3), "scale must be two numbers above 0, got 0.3"),
        ((mixed, UP, None, 1e-9, 9000, ()), r"scale must be two numbers above 0, got \(\)"),
        ((lambda m: np.nan * m[:, 0],), "a distribution of normals must have a finite norm above 0, got about nan"),
    ],
)
def test_wrong_arguments(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        seen_area(*arguments)
