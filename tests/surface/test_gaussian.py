"""Both ways to make a surface against the covariance, the slopes and the normal distribution they promise."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField

FIELDS = [
    GaussianField(128, 0.7, correlation=4, root=1),
    GaussianField(128, 0.8, 0.3, correlation=5, root=2),
    GaussianField(128, 0.4, 1.0, correlation=3, root=3, corrected=False),
]
COUNT = 24


def make(family: GaussianField, method: str, k: int) -> np.ndarray:
    return family.spectral(k) if method == "spectral" else family.gabor(k, density=30)


@pytest.fixture(scope="module", params=["spectral", "gabor"])
def method(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module", params=FIELDS, ids=str)
def family(request: pytest.FixtureRequest) -> GaussianField:
    field: GaussianField = request.param
    return field


@pytest.fixture(scope="module")
def surfaces(family: GaussianField, method: str) -> np.ndarray:
    return np.array([make(family, method, k) for k in range(COUNT)])


def agrees(samples: np.ndarray, expected: float, sigmas: float = 4) -> bool:
    """Whether the mean of independent samples, one for each surface, is the expected one."""
    return bool(abs(samples.mean() - expected) < sigmas * samples.std(ddof=1) / np.sqrt(len(samples)))


@pytest.mark.parametrize("lag", [(0, 0), (1, 0), (0, 1), (3, 0), (0, 4), (2, 2), (2, -2), (64, 64)])
def test_heights_have_the_autocovariance(family: GaussianField, surfaces: np.ndarray, lag: tuple[int, int]) -> None:
    product = (surfaces * np.roll(surfaces, lag, axis=(1, 2))).mean(axis=(1, 2))
    assert agrees(product, float(family.autocovariance(*lag)))


def test_facets_have_the_stated_alpha(family: GaussianField, surfaces: np.ndarray) -> None:
    """Beckmann's alpha is sqrt(2) times the root mean square slope; the two slopes of a facet are all but independent."""
    slopes = np.array([HeightField(z).slopes for z in surfaces])
    alpha_x, alpha_y = family.facet_alpha
    assert agrees(2 * (slopes[..., 0] ** 2).mean(axis=1), alpha_x**2)
    assert agrees(2 * (slopes[..., 1] ** 2).mean(axis=1), alpha_y**2)
    assert agrees(2 * (slopes[..., 0] * slopes[..., 1]).mean(axis=1), family.facet_correlation * alpha_x * alpha_y)


@pytest.mark.parametrize("what", ["height", "slope_x", "slope_y"])
def test_heights_and_slopes_are_normally_distributed(family: GaussianField, surfaces: np.ndarray, what: str) -> None:
    """Points two correlation lengths apart are all but independent; Kolmogorov and Smirnov would see 2 %."""
    values = {
        "height": surfaces,
        "slope_x": np.roll(surfaces, -1, 1) - surfaces,
        "slope_y": np.roll(surfaces, -1, 2) - surfaces,
    }
    alpha_x, alpha_y = family.facet_alpha
    scale = {"height": family.sigma, "slope_x": alpha_x / np.sqrt(2), "slope_y": alpha_y / np.sqrt(2)}[what]
    apart = [int(np.ceil(2 * length)) for length in family.lengths]
    assert scipy.stats.kstest((values[what][:, :: apart[0], :: apart[1]] / scale).ravel(), "norm").pvalue > 1e-3


def test_gabor_noise_of_few_kernels_is_not_normal() -> None:
    """The test above can fail: the excess kurtosis is 0.75/density, as promised."""
    family = GaussianField(256, 0.7, correlation=4)
    heights = np.array([family.gabor(k, density=1.0) for k in range(8)])
    kurtosis = np.mean(heights**4, axis=(1, 2)) / family.sigma**4
    assert agrees(kurtosis, 3.75, 5)
    assert kurtosis.mean() > 3.5


@given(st.floats(0.05, 2), st.floats(0.05, 2), st.floats(6, 40))
def test_the_correction_is_exact(alpha_x: float, alpha_y: float, correlation: float) -> None:
    if max(alpha_x / alpha_y, alpha_y / alpha_x) > 8:
        return
    corrected = GaussianField(1024, alpha_x, alpha_y, correlation)
    assert corrected.facet_alpha == pytest.approx((alpha_x, alpha_y), rel=1e-12, abs=0)
    plain = GaussianField(1024, alpha_x, alpha_y, correlation, corrected=False)
    assert plain.facet_alpha[0] == pytest.approx(alpha_x * (1 - 0.25 / plain.lengths[0] ** 2), rel=0.02)
    assert plain.facet_alpha[0] < alpha_x


def test_a_coarse_grid_flattens_by_a_known_amount() -> None:
    assert GaussianField(64, 0.7, correlation=2, corrected=False).facet_alpha[0] / 0.7 == pytest.approx(0.9406, abs=1e-4)
    assert GaussianField(256, 0.7, correlation=16, corrected=False).facet_alpha[0] / 0.7 == pytest.approx(0.99902, abs=1e-5)


def test_a_number_is_one_surface(method: str) -> None:
    family = GaussianField(64, 0.7, correlation=4, root=5)
    first, again, other = (make(family, method, k) for k in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.5
    assert not np.array_equal(first, make(GaussianField(64, 0.7, correlation=4, root=6), method, 3))


def test_gabor_noise_does_not_depend_on_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    family = GaussianField(256, 0.7, correlation=6)
    monkeypatch.setenv("MICROFACET_THREADS", "1")
    one = family.gabor(0, density=5)
    monkeypatch.setenv("MICROFACET_THREADS", "3")
    np.testing.assert_array_equal(one, family.gabor(0, density=5))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"size": 10.5, "alpha_x": 1}, "size must be a whole number.*10.5"),
        ({"size": 256.0, "alpha_x": 1}, "size must be a whole number of at least 2, got 256.0"),
        ({"size": None, "alpha_x": 1}, "size must be a whole number of at least 2, got None"),
        ({"size": float("nan"), "alpha_x": 1}, "size must be a whole number of at least 2, got nan"),
        ({"size": 256, "alpha_x": 1, "root": 1.0}, "root must be a whole number of at least 0, got 1.0"),
        ({"size": 256, "alpha_x": 1, "root": float("inf")}, "root must be a whole number of at least 0, got inf"),
        ({"size": 90, "alpha_x": 1}, "size must be at least 6 correlation lengths of 16.*90"),
        ({"size": 256, "alpha_x": 0}, "alpha_x.*0"),
        ({"size": 256, "alpha_x": 1, "alpha_y": float("nan")}, "alpha_y.*nan"),
        ({"size": 256, "alpha_x": 1, "correlation": -1}, "correlation.*-1"),
        ({"size": 256, "alpha_x": 1, "root": -1}, "root.*-1"),
        ({"size": 256, "alpha_x": 0.1, "alpha_y": 1, "correlation": 1}, "correlation must be larger.*1"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        GaussianField(**arguments)


def test_wrong_numbers_are_refused() -> None:
    family = GaussianField(64, 0.5, correlation=4)
    with pytest.raises(ValueError, match="k must be a whole number of at least 0, got -1"):
        family.spectral(-1)
    with pytest.raises(ValueError, match="k must be a whole number of at least 0, got None"):
        family.spectral(None)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"density.*0"):
        family.gabor(0, density=0)
