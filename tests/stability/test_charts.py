"""What the charts of failing methods plot, against sums and limits found in another way."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import faulty
import microfacet as mf
import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import erf, erfc

pytestmark = pytest.mark.slow  # all the charts' data are computed here

Array = NDArray[np.float64]


def chart(name: str) -> dict[str, Any]:
    found: dict[str, Any] = runpy.run_path(str(Path(faulty.__file__).with_name(f"{name}_data.py")))["compute"]()
    return found


def ggx_Lambda(theta: Array | float, alpha: float) -> Array:
    return (np.sqrt(1 + (alpha * np.tan(theta)) ** 2) - 1) / 2


def beckmann_G1(theta: Array | float, alpha: float) -> Array:
    a = 1 / (alpha * np.tan(theta))
    return 2 / (1 + erf(a) + np.exp(-(a**2)) / (a * np.sqrt(np.pi)))


def ggx_D(m: Array, alpha: float) -> Array:
    return alpha**2 / (np.pi * ((alpha**2 - 1) * m[..., 2] ** 2 + 1) ** 2)


def even_directions(count: int) -> Array:
    z, phi = 1 - (np.arange(count) + 0.5) * 2 / count, np.pi * (3 - np.sqrt(5)) * np.arange(count)
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1)


# --- slips ------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def slips() -> dict[str, Any]:
    return chart("slips")


def test_masking_of_another_surface_is_off_by_a_quotient(slips: dict[str, Any]) -> None:
    theta = np.radians(slips["degrees"])
    assert slips["degrees"].tolist() == list(range(1, 90))
    mean = np.sqrt(0.6 * 0.1)
    expected = {
        "mean_along": (1 + ggx_Lambda(theta, 0.6)) / (1 + ggx_Lambda(theta, mean)),
        "mean_across": (1 + ggx_Lambda(theta, 0.1)) / (1 + ggx_Lambda(theta, mean)),
        "twice": (1 + ggx_Lambda(theta, 0.3)) / (1 + ggx_Lambda(theta, 0.3**2)),
        "borrowed": beckmann_G1(theta, 0.3) * (1 + ggx_Lambda(theta, 0.3)),
    }
    for name, values in expected.items():
        np.testing.assert_allclose(slips[name], values, rtol=6e-4, err_msg=name)  # four digits are kept
    assert slips["right"] < 1e-11
    limits = {"mean_along": np.sqrt(0.6 / 0.1), "mean_across": np.sqrt(0.1 / 0.6), "twice": 1 / 0.3, "borrowed": np.sqrt(np.pi)}
    for name, limit in limits.items():
        assert float(slips[f"{name}_limit"]) == pytest.approx(limit, rel=6e-4)
        assert (np.abs(slips[name] - 1) <= abs(limit - 1) * 1.0006).all(), name


def test_slopes_of_samples_are_those_of_their_surface(slips: dict[str, Any]) -> None:
    """GGX's density along one axis is 1/(2 (1 + x^2)^(3/2)), in units of the roughness that the sampler has."""
    x = slips["slopes"]
    for name, wide in (("right", 1.0), ("swapped", 0.1 / 0.6), ("one", np.sqrt(0.06) / 0.6)):
        q = np.linspace(-0.025, 0.025, 11)
        density = (1 / (2 * wide * (1 + ((x[:, None] + q) / wide) ** 2) ** 1.5)).mean(axis=1)
        np.testing.assert_allclose(slips[f"density_{name}"], density, atol=0.02 * density.max(), err_msg=name)


def test_tests_of_samples_reject_what_they_look_at(slips: dict[str, Any]) -> None:
    """Rings see another roughness but not swapped axes; the other test sees both; the right sampler passes at its level."""
    assert slips["rejected_one"].tolist() == [1, 1]
    assert slips["rejected_swapped"][0] < 0.1
    assert slips["rejected_swapped"][1] == 1
    assert (slips["rejected_right"] < 0.1).all()
    assert np.allclose(slips["rejected_right"] * slips["tests"], np.round(slips["rejected_right"] * slips["tests"]))


def test_light_through_the_surface_is_a_share_of_the_lobe(slips: dict[str, Any]) -> None:
    """Both lobes by the formula; the light below the horizon by an even sum over directions."""
    view = np.array([np.sin(np.radians(80)), 0, np.cos(np.radians(80))])
    lights = np.radians(slips["lights"])
    wi = np.stack([-np.sin(lights), 0 * lights, np.cos(lights)], axis=-1)
    h = view + wi
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    G = 1 / (1 + ggx_Lambda(np.radians(80), 0.5)) / (1 + ggx_Lambda(lights, 0.5))
    rho = ggx_D(h, 0.5) * G / (4 * view[2] * abs(wi[:, 2])) * abs(wi[:, 2])
    above = (wi[:, 2] > 0) & (h[:, 2] > 0)
    np.testing.assert_allclose(slips["sides"], np.where(above, rho, 0), rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(slips["both"][above], rho[above], rtol=1e-3, atol=1e-6)
    assert slips["both"][wi[:, 2] < -0.05].max() > 0.1 * rho[above].max()
    w = even_directions(400_000)
    up = w[w[:, 2] > 0]
    m = view + up
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    light = ggx_D(m, 0.5) / (1 + ggx_Lambda(np.radians(80), 0.5)) / (1 + ggx_Lambda(np.arccos(up[:, 2]), 0.5)) / (4 * view[2])
    albedo = light.sum() * 4 * np.pi / len(w)
    down = w[w[:, 2] < 0]
    lost = (faulty.rho_both_sides(mf.GGX(0.5), view, down) * -down[:, 2]).sum() * 4 * np.pi / len(w)
    assert slips["through"] == pytest.approx(lost / albedo, rel=0.02)


def test_mirrors_from_above_send_half_of_the_light_down(slips: dict[str, Any]) -> None:
    """GGX of alpha 1: half of what is seen from above is steeper than 45 degrees. At 80 degrees, by a sum over facets."""
    assert slips["down"][0] == pytest.approx(0.5, abs=0.015)
    wo = np.array([np.sin(np.radians(80)), 0, np.cos(np.radians(80))])
    m = even_directions(400_000)
    m = m[m[:, 2] > 0]
    seen = np.maximum(m @ wo, 0) * ggx_D(m, 1.0)
    wi_z = 2 * (m @ wo) * m[:, 2] - wo[2]
    assert slips["down"][1] == pytest.approx(seen[wi_z < 0].sum() / seen.sum(), abs=0.015)


def test_a_plain_frame_fails_where_the_cosine_is_lost(slips: dict[str, Any]) -> None:
    """1 + z of single precision keeps nothing below a slope of some 1e-4."""
    assert slips["frame"] > 0.5
    assert slips["frame_signed"] < 1e-6
    assert 1e-5 < slips["frame_from"] < 1e-2


# --- edges ------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def edges() -> dict[str, Any]:
    return chart("edges")


def test_at_the_horizon_the_library_keeps_what_others_lose(edges: dict[str, Any]) -> None:
    low = edges["cosines"] < 1e-12
    assert edges["cosines"][0] == pytest.approx(1e-18)
    assert (edges["library"] > 5.5).all()
    assert not (edges["squares"][low] > 1).any()
    assert not (edges["floor"][low] > 1).any()
    assert edges["squares"][-1] > 4
    assert edges["floor"][-1] > 4


def test_a_longer_normal_is_a_steeper_one_to_the_cosine(edges: dict[str, Any]) -> None:
    """The relative error of D by z alone and by all components, of a vector longer by a millionth, at the slope alpha."""
    for k in (0, 20, 40):
        a, e = float(edges["alpha"][k]), float(edges["longer"])
        with mpmath.workdps(40):
            z = mpmath.cos(mpmath.atan(a))
            right, wrong = (((a**2 - 1) * cosine**2 + 1) ** -2 for cosine in (z, z * (1 + mpmath.mpf(e))))
            off = float(abs(wrong / right - 1))
        assert edges["cosine"][k] == pytest.approx(off, rel=0.02, abs=1e-7)
        assert edges["components"][k] == pytest.approx(4 * e, rel=0.3)  # a length to the fourth power
    assert edges["cosine"][0] > 0.5


def test_rays_by_an_offset_are_wrong_at_every_scale(edges: dict[str, Any]) -> None:
    assert edges["rays_library"] == 0
    assert 0.1 < edges["rays_blocked"] < 0.9
    assert 100 < edges["rays_rays"] <= 400
    wrong = edges["rays_wrong"]
    assert wrong.shape == (3, len(edges["offsets"]))
    assert edges["shifts"].tolist() == [0, 1e3, 1e6]
    assert wrong[:, -1].max() <= edges["rays_blocked"] + 1e-3  # an offset past everything: all hits are missed
    best = [edges["offsets"][row.argmin()] for row in wrong]
    assert best[0] < best[1] < best[2]


# --- integrals ----------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def integrals() -> dict[str, Any]:
    return chart("integrals")


def test_errors_of_rules_over_roughness(integrals: dict[str, Any]) -> None:
    alpha = integrals["alpha"]
    assert alpha[[0, -1]].tolist() == [1e-4, 1]
    np.testing.assert_allclose(integrals["truncated"], np.maximum(1 / (1 + (10 / alpha) ** 2), 1e-16), rtol=0.02, atol=1e-9)
    for name in ("beckmann", "ggx"):
        assert integrals[f"library_{name}"].max() < 1e-11
        assert integrals[f"midpoint_{name}"][0] > 0.5
    assert integrals["adaptive"][0] > 0.5
    assert integrals["adaptive"][-1] < 1e-3
    assert min(values.min() for key, values in integrals.items() if key.startswith(("library", "midpoint"))) >= 1e-16


def test_the_density_with_walters_masking_is_a_quotient(integrals: dict[str, Any]) -> None:
    theta = np.radians(integrals["theta"])
    a = 1 / (0.3 * np.tan(theta))
    walter = np.where(a < 1.6, (3.535 * a + 2.181 * a**2) / (1 + 2.276 * a + 2.577 * a**2), 1)
    np.testing.assert_allclose(integrals["density_sum"], walter / beckmann_G1(theta, 0.3), rtol=6e-5)
    assert integrals["off"] == pytest.approx(1 - integrals["density_sum"].min(), rel=1e-3)


def test_power_is_what_tests_do(integrals: dict[str, Any]) -> None:
    """A test of the right shares rejects at its level, whatever the number of samples; of others, more with more."""
    np.testing.assert_allclose(integrals["power_right"], 0.01, rtol=1e-3)
    for name in ("walter", "coarse", "right"):
        made, power = integrals[f"made_{name}"], integrals[f"power_{name}"][::5]
        scatter = np.sqrt(power * (1 - power) / 200)
        assert (abs(made - power) < 5 * scatter + 0.06).all(), name
    assert integrals["power_walter"][-1] > 0.99
    assert integrals["samples"][[0, -1]].tolist() == [1e4, 1e8]
    at = int(np.argmin(abs(integrals["samples"] / integrals["seen_from"] - 1)))
    assert integrals["power_walter"][at] > 0.5 >= integrals["power_walter"][at - 1]
    assert integrals["sum_true"] == pytest.approx(1, abs=1e-4)
    assert abs(integrals["sum_coarse"] - 1) > 0.5e-4


def test_one_sided_integrals(integrals: dict[str, Any]) -> None:
    """Of exp(-(x - 1)^2) up to 1/2."""
    exact = np.sqrt(np.pi) / 2 * erfc(0.5)
    assert integrals["mirrored"] == pytest.approx(exact, abs=1e-5)
    assert integrals["reflected_error"] == pytest.approx(abs(integrals["reflected"] - exact), abs=1e-4)
    assert abs(integrals["mirrored_error"]) < 1e-8
    for value, error in (("estimate", "error"), ("half", "half_error")):
        assert abs(integrals[value] - 1) > 0.4
        assert integrals[error] < 1e-4


# --- digits and samplers ------------------------------------------------------------------------------------------------------


def test_maps_of_digits() -> None:
    """The library has its digits everywhere; the textbook's forms lose all of them somewhere, from where the chart says."""
    for name, kinds in {
        "digits_D": ("ggx_textbook", "beckmann_textbook"),
        "digits_Lambda": ("ggx_root", "beckmann_erf"),
    }.items():
        data = chart(name)
        for kind in kinds:
            for real, most in (("float64", 13), ("float32", 5)):
                lost, kept = data[f"{kind}_{real}"], data[f"{kind.split('_')[0]}_library_{real}"]
                assert np.nanmin(kept) > most - 1
                assert np.nanmin(lost) < data["few"] == 3
                assert lost.shape == (len(data["alpha"]), len(data["tangent"]))
            if name == "digits_D":
                real = "float32"
                inside = data["alpha"][:, None] >= data["tangent"]
                failing = data["alpha"][((data[f"{kind}_{real}"] < 3) & inside).any(axis=1)]
                assert data[f"{kind}_{real}_from"] == pytest.approx(failing.max(initial=0.0), rel=1e-2)
                assert data[f"{kind}_{real}_worst"] == pytest.approx(np.nanmin(data[f"{kind}_{real}"]), abs=1e-2)


def test_curves_of_digits_stand_over_the_argument_of_lambda() -> None:
    """The root less 1, in single precision: what is left of it at each argument."""
    data = chart("digits_Lambda")
    a = data["ggx_a"].astype(np.float32)
    root = (np.sqrt(1 + 1 / (a * a)) - 1) / 2
    exact = 1 / (2 * data["ggx_a"] ** 2) / (1 + np.sqrt(1 + 1 / data["ggx_a"] ** 2))
    digits = -np.log10(np.abs(root.astype(float) / exact - 1).clip(1e-8))
    inside = (data["ggx_a"] > 3) & (digits > 0.5)
    assert abs(np.mean((data["ggx_root_float32_curve"] - digits)[inside])) < 0.25
    assert data["ggx_root_float32_from"] == data["ggx_a"][data["ggx_root_float32_curve"] < 3].min()


def test_newtons_errors_fall_with_steps_to_a_floor() -> None:
    data = chart("samplers")
    assert data["steps"].tolist() == list(range(1, 9))
    for real, floor in (("float64", 1e-12), ("float32", 1e-4)):
        errors = data[f"newton_{real}"]
        assert errors[0] > 1e-3
        assert errors[-1] < floor
    assert data["library_error"] < 1e-14
    assert np.nanmin(data["ggx_library_float64"]) > 12
    assert np.nanmin(data["beckmann_library_float64"]) > 11
    assert not np.nanmin(data["ggx_published_float32"]) > 1
    assert data["across"].max() < 1e-2
    np.testing.assert_allclose(data["u"], (np.arange(2000) + 0.5) / 2000, rtol=6e-3)
    odds = data["odds"]
    assert odds[[0, -1]].tolist() == [1e-7, 1e7]


@pytest.mark.parametrize(
    ("name", "axes"),
    [("edges", ("alpha", "cosines", "offsets")), ("integrals", ("alpha", "samples")), ("samplers", ("odds",))],
)
def test_axes_over_decades_have_a_whole_number_of_steps_a_decade(name: str, axes: tuple[str, ...]) -> None:
    """So that each power of ten is met."""
    data = chart(name)
    for key in axes:
        steps = np.diff(np.log10(data[key]))
        np.testing.assert_allclose(steps, steps.mean(), atol=5e-3)  # three digits are kept
        assert 1 / steps.mean() == pytest.approx(round(1 / steps.mean()), abs=0.01), key


def test_an_axis_of_angles_has_the_middle_of_every_degree(integrals: dict[str, Any]) -> None:
    assert integrals["theta"].tolist() == [degree + 0.5 for degree in range(90)]
