"""Stretching by the kernels: moved viewers and moved facets, and Monte Carlo slopes that know nothing of a proof."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from microfacet.statements import checks
from microfacet.statements.notation import alpha_x, wm
from microfacet.visibility import stretching
from samples import hemisphere, uniform, views

ALPHAS = np.array([0.5, 0.2])
KINDS = [mf.GGX, mf.Beckmann]


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def moved(wo: np.ndarray, wm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Viewer and normal on the surface of unit roughness, taken to the stretched one."""
    return unit(wo / [*ALPHAS, 1]), unit(wm * [*ALPHAS, 1])


@pytest.mark.parametrize("kind", KINDS)
@given(x=st.floats(-5, 5), y=st.floats(-5, 5))
def test_slopes_are_the_unit_ones_scaled(kind: type, x: float, y: float) -> None:
    stretched, unit_form = kind(*ALPHAS), kind(1.0)
    expected = unit_form.P22(x / ALPHAS[0], y / ALPHAS[1]) / ALPHAS.prod()
    assert stretched.P22(x, y) == pytest.approx(float(expected), rel=1e-12, abs=1e-290)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", [mf.Smith, mf.VCavity])
def test_what_is_hidden_stays_hidden(model: type, kind: type) -> None:
    wo, m = hemisphere(300, 1), hemisphere(300, 2)
    before, after = model(kind(1.0)).G1(wo, m), model(kind(*ALPHAS)).G1(*moved(wo, m))
    np.testing.assert_allclose(after, before, rtol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", [mf.Smith, mf.VCavity])
def test_shares_of_the_view_stay(model: type, kind: type) -> None:
    """Per area in slope space, where the map spreads by alpha_x alpha_y."""
    wo, m = hemisphere(300, 1), hemisphere(300, 2)
    wo_moved, m_moved = moved(wo, m)
    before = model(kind(1.0)).D_visible(wo, m) * m[:, 2] ** 3
    after = model(kind(*ALPHAS)).D_visible(wo_moved, m_moved) * m_moved[:, 2] ** 3
    np.testing.assert_allclose(after * ALPHAS.prod(), before, rtol=1e-10, atol=1e-250)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("azimuth", [0.0, 35.0, 110.0])
def test_slopes_along_the_view_have_the_width_alpha_o(kind: type, azimuth: float) -> None:
    """Sampled slopes, turned to the view: their share below a value is that of P2 with roughness alpha_o."""
    m = kind(*ALPHAS).sample(uniform(100_000, 4))
    wo = views(60, azimuth=azimuth)[0]
    along = wo[:2] / np.hypot(*wo[:2])
    slopes = -(m[:, :2] @ along) / m[:, 2]
    alpha_o = float(mf.equations["visibility.smith.alpha_o"].kernel(*wo, *ALPHAS))
    for share in (0.3, 1.0):
        below = float(np.mean(slopes < share * alpha_o))
        q = np.linspace(-400, share, 400_001) if kind is mf.GGX else np.linspace(-8, share, 20_001)
        exact = float(np.trapezoid(mf.equations[f"geometry.{kind.__name__.lower()}.P2"].kernel(q, np.ones_like(q)), q))
        assert below == pytest.approx(exact, abs=4.5 * 0.5 / np.sqrt(100_000) + 2e-6)


# --- the proofs can fail --------------------------------------------------------------------------------------------------


def red(key: str) -> bool:
    return checks.symbolic(mf.equations[key]).status == "fail"


@pytest.mark.parametrize("key", ["visibility.stretching.facing", "visibility.stretching.v_cavity"])
def test_normals_that_go_with_the_map_are_red(monkeypatch: pytest.MonkeyPatch, key: str) -> None:
    assert not red(key)
    monkeypatch.setattr(stretching, "moved_normal", stretching.moved_direction)
    assert red(key)


def test_a_spread_of_one_axis_only_is_red(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not red("visibility.stretching.visible_normals")
    monkeypatch.setattr(stretching, "moved_slopes", lambda: {stretching.x: alpha_x * stretching.x})
    assert red("visibility.stretching.visible_normals")


def test_swapped_axes_are_red(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not red("visibility.stretching.P2")
    swapped = sp.sin(stretching.phi_o) ** 2 * stretching.alpha_x**2 + sp.cos(stretching.phi_o) ** 2 * stretching.alpha_y**2
    monkeypatch.setattr(stretching, "ALONG", swapped)
    assert red("visibility.stretching.P2")
    pytest.importorskip("flint")
    assert checks.enclosed(mf.equations["visibility.stretching.P2"]).status == "fail"


def test_normals_are_stretched_as_slopes() -> None:
    """What the proofs move is what these tests move."""
    m = stretching.moved_normal(wm)
    assert [sp.simplify(-m[k] / m[2] / s) for k, s in enumerate((alpha_x, stretching.alpha_y))] == [
        -wm.x / wm.z,
        -wm.y / wm.z,
    ]
