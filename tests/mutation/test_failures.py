"""Failures that users of other renderers met, put into this library one by one: a test of ours, as it stands, must go red.

One test each. `ours` are the modules of the tests that must notice.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from math import erf, exp, sqrt
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import microfacet as mf
import numpy as np
import pytest
import suite
from microfacet.compiler.kernels import Pair, Vector
from microfacet.directions import spherical
from microfacet.geometry import ggx, slopes
from microfacet.geometry.beckmann import beckmann_Lambda
from microfacet.geometry.blinn_phong import Power
from microfacet.geometry.roughness import Alphas
from microfacet.geometry.visible_normals import sample_beckmann, sample_ggx, unstretched
from microfacet.geometry.visible_slopes import (
    LARGEST_EDGE,
    edge_factor,
    fifth_order,
    guess,
    third_order,
    visible_gaussian_slope,
)
from microfacet.statements import checks
from microfacet.surface.height_field import HeightField, Hits
from microfacet.validation import chi_square
from microfacet.visibility.masking import ModelParameters
from microfacet.visibility.smith import sampler_of_distribution
from mutants import rebound
from samples import LAST

pytestmark = pytest.mark.slow
TESTS = Path(__file__).parent.parent
PI, SQRT_PI = 3.141592653589793, 1.7724538509055161


def ours(path: str) -> ModuleType:
    """A module of tests by its place under tests/, under the name that pytest gives it: compiled functions are kept by it."""
    name = f"tests.{path.replace('/', '.')}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, TESTS / f"{path}.py")
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


def red(path: str, *arguments: Any, **named: Any) -> bool:
    """Whether a test of ours, `place/file:name`, fails with these parameters."""
    module, name = path.split(":")
    test = getattr(ours(module), f"test_{name}")
    test = test.hypothesis.inner_test if hasattr(test, "hypothesis") else test
    try:
        with np.errstate(all="ignore"):
            test(*arguments, **named)
    except (AssertionError, pytest.fail.Exception):
        return True
    return False


class SampledBy(mf.Smith):
    """Smith's model with a sampler of its own."""

    def __init__(self, ndf: mf.GGX, kernel: Callable[..., Any]) -> None:
        super().__init__(ndf)
        self.kernel = kernel

    @property
    def sampler(self) -> Callable[..., Any]:
        return sampler_of_distribution(self.kernel)


class Right(mf.GGX):
    """A distribution of its own class, and nothing wrong."""


def again(f: float, x: float, d: float, s: float) -> float:
    return third_order(f, x, d, s)


def test_what_carries_the_faults_is_sound(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same tests hold with the same classes where the kernel is right."""
    slope = "visibility/test_visible_normals:beckmanns_slope_is_found_to_rounding"
    assert not red("visibility/test_smith:Lambda_is_what_faces_away_over_the_cosine", Right(0.5, 0.2))
    assert not red("visibility/test_visible_normals:close_numbers_give_close_normals", SampledBy(mf.GGX(0.5, 0.2), sample_ggx))
    monkeypatch.setattr(mf, "Smith", lambda ndf: SampledBy(ndf, rebound(sample_beckmann, third_order, again)))
    assert not red(slope)


def numeric(key: str, kernel: Callable[..., float], real: type) -> bool:
    """Whether the numeric mark of a statement is red with this kernel."""
    with suite.broken(key, computed_by=kernel) as it:
        return checks.worst_error(it, real)[0] > it.within[real is np.float32]


# --- digits -------------------------------------------------------------------------------------------------------------


def ggx_D_by_cosine(x: float, y: float, z: float, alpha_x: float, alpha_y: float) -> float:
    below = (z * z) * (alpha_x * alpha_x - 1.0) + 1.0
    return alpha_x * alpha_x / (PI * below * below)


def kernel_D_by_cosine(wm: Vector, p: Alphas) -> float:
    return ggx_D_by_cosine(wm[0], wm[1], wm[2], p.alpha_x, p.alpha_y)


class GGXByCosine(mf.GGX):
    kernel = staticmethod(kernel_D_by_cosine)


def test_ggx_by_the_cosine_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert numeric("geometry.ggx.D", ggx_D_by_cosine, np.float32)
    monkeypatch.setattr(mf, "GGX", GGXByCosine)
    assert red("geometry/test_distributions:narrow_ggx_in_single_precision", 1e-3)


def ggx_Lambda_by_difference(a: float) -> float:
    return 0.5 * (sqrt(1.0 + 1.0 / (a * a)) - 1.0)


def beckmann_Lambda_by_difference(a: float) -> float:
    return 0.5 * (erf(a) - 1.0) + exp(-a * a) / (2.0 * a * SQRT_PI)


@pytest.mark.parametrize(
    ("key", "kernel", "real"),
    [
        ("geometry.ggx.Lambda", ggx_Lambda_by_difference, np.float32),
        ("geometry.beckmann.Lambda", beckmann_Lambda_by_difference, np.float64),
    ],
)
def test_Lambda_as_a_difference(key: str, kernel: Callable[..., float], real: type) -> None:
    assert numeric(key, kernel, real)
    with suite.broken(key, computed_by=kernel):
        assert red("visibility/test_smith:Lambda_keeps_its_digits_near_normal_incidence", real)


# --- masking ------------------------------------------------------------------------------------------------------------


def walter_Lambda(w: Vector, p: Alphas) -> float:
    x, y = p.alpha_x * w[0], p.alpha_y * w[1]
    a = w[2] / sqrt(x * x + y * y)
    if not a < 1.6:
        return 0.0
    return (1.0 + 2.276 * a + 2.577 * a * a) / (3.535 * a + 2.181 * a * a) - 1.0


class Walter(mf.Beckmann):
    """Beckmann with Walter's rational fit of its masking."""

    closed_Lambda = staticmethod(walter_Lambda)


def test_rational_fit_of_masking() -> None:
    """Above 1 for 1.548 < a < 1.6."""
    assert red("visibility/test_smith:masking_is_a_share_and_falls_towards_the_horizon", Walter(0.4), np.float64)
    assert red("visibility/test_smith:Lambda_is_what_faces_away_over_the_cosine", Walter(0.4))


def test_rational_fit_beside_an_exact_sampler(monkeypatch: pytest.MonkeyPatch) -> None:
    """The density integrates to 0.997 to 1.003. Counts do not tell; the integral and the Jacobian do."""
    model = SampledBy(Walter(0.4), sample_beckmann)
    assert red("visibility/test_smith:visible_normals_project_to_the_view_and_are_a_distribution", model)
    monkeypatch.setattr(mf, "Smith", lambda ndf: SampledBy(ndf, sample_beckmann))
    at = {"u1": 0.3, "u2": 0.6, "theta": 1.2, "phi": 0.5, "alpha_x": 0.5, "alpha_y": 0.5}
    assert red("visibility/test_visible_normals:sampler_has_its_density", kind=Walter, **at)


ggx_Lambda = ggx.ggx_Lambda


def azimuthless_Lambda(w: Vector, p: Alphas) -> float:
    return ggx_Lambda(abs(w[2]) / sqrt(p.alpha_x * p.alpha_y * (w[0] * w[0] + w[1] * w[1])))


class Azimuthless(mf.GGX):
    closed_Lambda = staticmethod(azimuthless_Lambda)


def test_anisotropic_masking_that_ignores_azimuth(monkeypatch: pytest.MonkeyPatch) -> None:
    """sqrt(alpha_x alpha_y) in place of alpha_o."""
    assert red("visibility/test_smith:Lambda_is_what_faces_away_over_the_cosine", Azimuthless(0.5, 0.2))
    assert red("validation/test_equations:physical_models_hold", mf.Smith(Azimuthless(0.5, 0.2)))
    monkeypatch.setattr(mf, "GGX", Azimuthless)
    assert red("visibility/test_smith:masking_depends_on_azimuth_where_the_surface_does")


def squared_Lambda(w: Vector, p: Alphas) -> float:
    return ggx_Lambda(abs(w[2]) / (p.alpha_x * p.alpha_x * sqrt(w[0] * w[0] + w[1] * w[1])))


class Squared(mf.GGX):
    closed_Lambda = staticmethod(squared_Lambda)


def borrowed_Lambda(w: Vector, p: Power) -> float:
    return beckmann_Lambda(abs(w[2]) / sqrt(2.0 / (p.n + 2.0) * (w[0] * w[0] + w[1] * w[1])))


class Borrowed(mf.NormalizedBlinnPhong):
    closed_Lambda = staticmethod(borrowed_Lambda)


@pytest.mark.parametrize("ndf", [Squared(0.4), Borrowed(8.0)], ids=["roughness squared twice", "the Lambda of another"])
def test_masking_of_another_surface(ndf: mf.GGX) -> None:
    assert red("visibility/test_smith:Lambda_is_what_faces_away_over_the_cosine", ndf)
    assert red("visibility/test_smith:visible_normals_project_to_the_view_and_are_a_distribution", mf.Smith(ndf))


def unsided(Lambda_o: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
    return 1.0 / (1.0 + Lambda_o)


class Unsided(mf.Smith):
    G1_of_facet = staticmethod(unsided)


def test_no_test_of_the_side(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mf, "Smith", Unsided)
    assert red("visibility/test_smith:masking_of_back_facing_and_of_lower_directions_is_zero")


# --- samplers -----------------------------------------------------------------------------------------------------------


def by_sine(wo: Vector, u: Pair, p: Alphas) -> Vector:
    vx, _, vz = unstretched(wo, p)
    sine = sqrt(1.0 - vz * vz)
    mx, my, mz = sample_beckmann(wo, u, p)
    return mx + 0.0 * vx / sine, my, mz


def test_azimuth_from_a_sine_that_vanishes() -> None:
    """The stretched cosine rounds to 1: 0/0."""
    model = SampledBy(mf.Beckmann(0.4), by_sine)
    assert red("visibility/test_visible_normals:corners_of_the_unit_square_give_normals", model, np.float64, LAST)


def no_step(f: float, x: float, d: float, s: float) -> float:
    return 0.0


def guessed_above(s: float, z: float, u: float) -> float:
    """The lower half of the numbers solved for, the upper half guessed."""
    c = min(z / s, LARGEST_EDGE)
    x, _ = guess(s, z, c, edge_factor(c), u)
    return visible_gaussian_slope(s, z, u) if u < 0.5 else x


def test_sampler_put_together_from_pieces() -> None:
    pieces = rebound(sample_beckmann, visible_gaussian_slope, guessed_above)
    assert red("visibility/test_visible_normals:close_numbers_give_close_normals", SampledBy(mf.Beckmann(0.2, 0.5), pieces))


@pytest.mark.parametrize("step", [fifth_order, third_order])
def test_steps_towards_a_root_that_are_too_few(step: FunctionType, monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = rebound(sample_beckmann, step, no_step)
    monkeypatch.setattr(mf, "Smith", lambda ndf: SampledBy(ndf, kernel))
    assert red("visibility/test_visible_normals:beckmanns_slope_is_found_to_rounding")


def isotropic(wo: Vector, u: Pair, p: Alphas) -> Vector:
    alpha = sqrt(p.alpha_x * p.alpha_y)
    return sample_ggx(wo, u, Alphas(alpha, alpha))


def swapped(wo: Vector, u: Pair, p: Alphas) -> Vector:
    return sample_ggx(wo, u, Alphas(p.alpha_y, p.alpha_x))


@pytest.mark.parametrize("kernel", [isotropic, swapped])
def test_anisotropic_lobe_sampled_by_another(kernel: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Each axis has its own chi-square; the Jacobian sees it anywhere."""
    model = SampledBy(mf.GGX(0.5, 0.2), kernel)
    assert red("visibility/test_visible_normals:counts_follow_the_density", model, np.float64)
    monkeypatch.setattr(mf, "Smith", lambda ndf: SampledBy(ndf, kernel))
    at = {"u1": 0.3, "u2": 0.6, "theta": 1.0, "phi": 0.5, "alpha_x": 0.5, "alpha_y": 0.2}
    assert red("visibility/test_visible_normals:sampler_has_its_density", kind=mf.GGX, **at)


def from_below(wo: Vector, u: Pair, p: Alphas) -> Vector:
    vx, vy, vz = unstretched(wo, p)
    return sample_ggx((vx, vy, abs(vz) / (1.0 + vz)), u, p)


def test_frame_that_divides_by_z_plus_one() -> None:
    """Near -z."""
    model = SampledBy(mf.GGX(0.5, 0.2), from_below)
    assert red("visibility/test_visible_normals:below_the_horizon_there_is_nothing_to_sample", model)


def test_expected_counts_integrated_too_coarsely(monkeypatch: pytest.MonkeyPatch) -> None:
    """A right sampler is rejected: the remedy is finer cells."""
    fine = chi_square.SlopeCells.integrals
    model = mf.Smith(mf.Beckmann(0.05))
    assert not red("visibility/test_visible_normals:counts_follow_the_density", model, np.float64)
    monkeypatch.setattr(chi_square.SlopeCells, "integrals", lambda cells, density: fine(cells, density, 1))
    assert red("visibility/test_visible_normals:counts_follow_the_density", model, np.float64)


# --- edges of the domain --------------------------------------------------------------------------------------------------


def test_roughness_of_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slopes, "roughness", lambda name, value: float(value))
    assert red("test_public_face:roughness_that_is_none", mf.GGX, 0)


class Unguarded(mf.Microfacet):
    """Smith over GGX by numpy; `above` says where the value counts."""

    above: Callable[[np.ndarray, np.ndarray], np.ndarray] = staticmethod(lambda o, i: (o > 0) & (i > 0))

    def evaluate(self, wo: Any, wi: Any) -> Any:
        o, i = np.broadcast_arrays(np.asarray(wo, float), np.asarray(wi, float))
        h = (o + i) / np.linalg.norm(o + i, axis=-1, keepdims=True)
        D, ax, ay = self.normals(h), self.model.ndf.alpha_x, self.model.ndf.alpha_y
        Lo, Li = ((np.sqrt(1 + ((ax * w[..., 0]) ** 2 + (ay * w[..., 1]) ** 2) / w[..., 2] ** 2) - 1) / 2 for w in (o, i))
        value = D / (1 + Lo + Li) / (4 * o[..., 2] * i[..., 2])
        return np.where(type(self).above(o[..., 2], i[..., 2]), value, 0)

    def normals(self, h: np.ndarray) -> np.ndarray:
        ax, ay = self.model.ndf.alpha_x, self.model.ndf.alpha_y
        return 1 / (np.pi * ax * ay * ((h[..., 0] / ax) ** 2 + (h[..., 1] / ay) ** 2 + h[..., 2] ** 2) ** 2)


class KeptBelow(Unguarded):
    """Light from below counts as if it came from above."""

    above = staticmethod(lambda o, i: o > 0)

    def evaluate(self, wo: Any, wi: Any) -> Any:
        return super().evaluate(wo, np.abs(np.asarray(wi)) * [1, 1, 1])


class AtTheHorizon(Unguarded):
    """0/0 where both cosines are 0."""

    above = staticmethod(lambda o, i: (o >= 0) & (i >= 0))


class WithoutAFacet(Unguarded):
    """A half vector of nothing."""

    def pdf(self, wo: Any, wi: Any) -> Any:
        o, i = np.broadcast_arrays(np.asarray(wo, float), np.asarray(wi, float))
        h = (o + i) / np.linalg.norm(o + i, axis=-1, keepdims=True)
        return np.where(o[..., 2] > 0, self.model.G1(o, o) * self.normals(h) / (4 * o[..., 2]), 0)


@pytest.mark.parametrize("kind", [KeptBelow, AtTheHorizon, WithoutAFacet])
def test_what_is_not_guarded(kind: type) -> None:
    brdf = mf.Smith(mf.GGX(0.5, 0.2))
    assert not red("brdf/test_microfacet:nothing_through_the_surface", Unguarded(brdf))
    assert red("brdf/test_microfacet:nothing_through_the_surface", kind(brdf))


def test_half_vector_of_opposite_directions(monkeypatch: pytest.MonkeyPatch) -> None:
    def naive(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        return (wo + wi) / np.linalg.norm(wo + wi, axis=-1, keepdims=True)

    monkeypatch.setattr(ours("geometry/test_slopes"), "half_vector", naive)
    assert red("geometry/test_slopes:half_vector_is_the_mirror_that_joins_both")


class Lifted(HeightField):
    """Rays start a fixed distance above their facet, which is not told to the tracer."""

    def trace(self, origins: Any, directions: Any, facets: Any = None) -> Hits:
        if facets is None:
            return super().trace(origins, directions)
        return super().trace(np.asarray(origins) + np.array([0, 0, 1e-3]), directions)


def test_rays_with_an_absolute_epsilon() -> None:
    """A thousandth of a cell: they pass over small facets, as they did where this was reported."""
    heights = ours("surface/test_height_field").rough(32, 9).heights
    assert red("surface/test_height_field:skipping_blocks_changes_no_verdict", Lifted(heights))


# --- quadrature -----------------------------------------------------------------------------------------------------------


class Gridded(mf.Microfacet):
    """Albedo by a grid over the hemisphere, even in angles."""

    def albedo_with_error(self, wo: Any) -> tuple[Any, Any]:
        theta, phi = np.meshgrid((np.arange(256) + 0.5) * np.pi / 512, np.arange(512) * np.pi / 256, indexing="ij")
        wi = spherical(theta, phi)
        weights = np.sin(theta) * np.cos(theta) * (np.pi / 512) * (np.pi / 256)
        return float(np.sum(self.evaluate(np.asarray(wo), wi) * weights)), 0.0


def test_grid_coarser_than_the_lobe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mf, "Microfacet", Gridded)
    assert red("brdf/test_microfacet:narrow_lobes_are_not_missed")


class Unmapped(mf.Beckmann):
    """A lobe that does not tell a quadrature how narrow it is."""

    def __init__(self, alpha: float) -> None:
        super().__init__(alpha)
        self.slope_scale = (1.0, 1.0)


def test_rule_that_misses_the_peak() -> None:
    """A wrong hint at how narrow a lobe is changes no verdict: right models still hold, wrong ones fail."""
    assert not red("validation/test_equations:physical_models_hold", mf.Smith(Unmapped(0.01)))
    assert mf.validate(mf.Implicit(Unmapped(0.01)))["visible_area"].verdict == "fails"


def test_no_integral_is_left_to_an_adaptive_rule() -> None:
    """Those of one library are silently wrong on (-inf, b], and miss narrow peaks."""
    texts = [path.read_text() for path in (TESTS.parent / "lib").rglob("*.py")]
    assert len(texts) > 30
    assert not any(rule in text for text in texts for rule in ("scipy.integrate", "cubature", "nquad"))
