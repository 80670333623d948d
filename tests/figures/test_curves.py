"""Curves and maps of the models' figures against formulas of the literature, written out here once more with numpy alone.

Not one of them is the library's: what a figure shows is computed twice, and each number in a data script that says where, of
what roughness and how much would be seen to be another one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import erf

Array = NDArray[np.float64]
Compute = Callable[[str], dict[str, Any]]


# --- formulas -------------------------------------------------------------------------------------------------------------


def tangents(w: Array, alpha_x: float, alpha_y: float) -> Array:
    """|slope| over alpha of the normal, or of the plane seen edge-on by a view."""
    return np.hypot(w[..., 0] / alpha_x, w[..., 1] / alpha_y) / w[..., 2]


def beckmann_D(m: Array, alpha_x: float, alpha_y: float) -> Array:
    """Cook and Torrance 1982, stretched."""
    return np.exp(-(tangents(m, alpha_x, alpha_y) ** 2)) / (np.pi * alpha_x * alpha_y * m[..., 2] ** 4)


def ggx_D(m: Array, alpha_x: float, alpha_y: float) -> Array:
    """Trowbridge and Reitz 1975, stretched."""
    return 1 / (np.pi * alpha_x * alpha_y * m[..., 2] ** 4 * (1 + tangents(m, alpha_x, alpha_y) ** 2) ** 2)


def ward_D(m: Array, alpha_x: float, alpha_y: float) -> Array:
    """Ward 1992: Beckmann's exponential without the cosines below it."""
    return np.exp(-(tangents(m, alpha_x, alpha_y) ** 2)) / (np.pi * alpha_x * alpha_y)


def ggx_G1(theta: Array | float, alpha: Array | float) -> Array:
    """Smith 1967 for GGX, after Walter et al. 2007, eq. 34."""
    return 2 / (1 + np.sqrt(1 + (np.asarray(alpha) * np.tan(theta)) ** 2))


def beckmann_G1(theta: Array | float, alpha: Array | float) -> Array:
    """Smith 1967 for Beckmann, after Walter et al. 2007, eq. 25 and 26 before they are fitted."""
    a = 1 / (np.asarray(alpha) * np.tan(theta))
    return 2 / (1 + erf(a) + np.exp(-(a**2)) / (a * np.sqrt(np.pi)))


def polar(theta: Array, phi: Array | float = 0.0) -> Array:
    return np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), axis=-1)


def projected_area(D: Callable[..., Array], *alphas: float) -> float:
    """The sum of D cos over the hemisphere, by midpoints over the slopes' logarithm and the azimuth."""
    t = np.exp(np.linspace(-14, 9, 4001))[:, None] * np.sqrt(np.prod(alphas))
    phi = (np.arange(256) + 0.5) * np.pi / 128
    m = polar(np.arctan(t), phi)
    values = D(m, *alphas) * m[..., 2] * np.sin(np.arctan(t)) / (1 + t**2) * t
    return float(values.mean(axis=1).sum() * 2 * np.pi * 23 / 4000)


def same(found: Any, expected: Any, digits: int = 5) -> None:
    """To the digits that a data file keeps."""
    np.testing.assert_allclose(found, expected, rtol=2 * 10.0**-digits, atol=1e-9)


# --- anisotropy -------------------------------------------------------------------------------------------------------------


def test_roughness_along_a_view_and_the_masking_of_it(compute: Compute) -> None:
    data = compute("anisotropy/alpha_o")
    theta, (ax, ay) = np.radians(data["degrees"]), data["alphas"]
    assert data["phi"][0] == 0
    assert data["phi"][-1] == 360
    for name in ("phi", "quadrature_phi"):
        np.testing.assert_allclose(np.diff(data[name], 2), 0, atol=1e-9)
    same(data["alpha_o"], np.hypot(ax * np.cos(np.radians(data["phi"])), ay * np.sin(np.radians(data["phi"]))))
    turn = np.radians(data["shown"])
    same(data["at"], np.hypot(ax * np.cos(turn), ay * np.sin(turn)))
    for name, G1 in (("ggx", ggx_G1), ("beckmann", beckmann_G1)):
        same(data[name], G1(theta, data["alpha_o"]), 4)
        same(data[f"{name}_mean"], G1(theta, np.sqrt(ax * ay)))
        few = np.radians(data["quadrature_phi"])
        same(data[f"{name}_quadrature"], G1(theta, np.hypot(ax * np.cos(few), ay * np.sin(few))))
        assert 1e-15 < data[f"{name}_apart"] < 1e-10
        assert np.log10(data[f"{name}_apart"]) == pytest.approx(round(np.log10(data[f"{name}_apart"])), abs=1e-9)
    assert data["quadrature_phi"][[0, -1]].tolist() == [0, 180]


@pytest.mark.parametrize(("name", "D"), [("beckmann", beckmann_D), ("ggx", ggx_D), ("ward", ward_D)])
def test_maps_of_stretched_normals(compute: Compute, name: str, D: Callable[..., Array]) -> None:
    data = compute("anisotropy/anisotropic_normals")
    x, y = data["x"], data["y"]
    radius = np.hypot(x, y)
    np.testing.assert_allclose(radius[:, [0, -1]], [[0, 0.9999]] * len(radius), atol=1e-5)
    assert (np.diff(radius, axis=1) > 0).all()
    inside = radius < 0.99  # where coordinates of six digits tell the cosine
    m = np.stack([x, y, np.sqrt(1 - np.minimum(radius, 0.999) ** 2)], axis=-1)
    np.testing.assert_allclose(data[name][inside], np.maximum(D(m, *data["alphas"]), 1e-12)[inside], rtol=3e-3, atol=2e-12)
    assert data[name].min() >= 1e-12 * (1 - 1e-9)
    for k, j in ((0, 0), (3, 9), (15, 7), (15, 15)):  # rows are alpha_y
        assert data[f"{name}_area"][k, j] == pytest.approx(projected_area(D, data["tried"][j], data["tried"][k]), abs=2e-5)
    same(data["tried"], np.linspace(1, 16, 16) / 16)
    assert data[f"{name}_verdict"] == ("fails" if name == "ward" else "holds")
    off = abs(data[f"{name}_area"] - 1)
    assert ((off < 1e-7) == data[f"{name}_keeps"]).all()
    assert off.max() <= data[f"{name}_worst"] * (1 + 1e-6)
    assert data[f"{name}_worst"] < (1 + 1e-6 if name == "ward" else 1e-8)


def test_a_mean_roughness_is_off_by_the_quotient_of_both_maskings(compute: Compute) -> None:
    """Smith's G1 is the same for all facets, so what is seen is off by G1(mean)/G1(alpha_o), whatever sees it."""
    data = compute("anisotropy/residual_map")
    theta, phi = np.meshgrid(np.radians(data["theta"]), np.radians(data["phi"]), indexing="ij")
    ax, ay = data["alphas"]
    along = np.hypot(ax * np.cos(phi), ay * np.sin(phi))
    off = abs(ggx_G1(theta, np.sqrt(ax * ay)) / ggx_G1(theta, along) - 1)
    assert (data["mean"] >= off * (1 - 1e-4) - 1e-11).all()
    np.testing.assert_allclose(data["mean"], off, rtol=1e-4, atol=2e-9)
    assert [data[f"{name}_verdict"] for name in ("smith", "v_cavity", "mean")] == ["holds", "holds", "fails"]
    assert data["floor"] == 1e-10
    assert data["smith"].max() == data["v_cavity"].max() == data["floor"] < 1e-9  # what holds is drawn at the floor
    assert data["tried"] == 5 * 5 * 2 * 2
    assert data["views"] == 4 * 4
    assert data["theta"][[0, -1]].tolist() == [0, 88]
    assert data["phi"][[0, -1]].tolist() == [0, 90]


def test_a_stretched_surface_has_stretched_slopes(compute: Compute) -> None:
    data = compute("anisotropy/stretching")
    before, after, s = data["before_alphas"], data["after_alphas"], data["stretch"]
    same(after, [before[0] / s, before[1]])
    x, y = np.meshgrid(data["grid"], data["grid"], indexing="ij")
    for name, (ax, ay) in (("before", before), ("after", after)):
        P22 = np.exp(-((x / ax) ** 2) - (y / ay) ** 2) / (np.pi * ax * ay)
        np.testing.assert_allclose(data[f"{name}_P22"], P22, rtol=3e-4, atol=1e-9)
        slopes = data[f"{name}_slopes"]
        np.testing.assert_allclose(np.sqrt(2 * (slopes**2).mean(axis=1)), data[f"{name}_measured"], rtol=0.15)
    rough = 2 * np.std(data["heights"][:-1, :-1])  # alpha = 2 sigma/l, in correlation lengths
    assert rough == pytest.approx(before[0], rel=0.2)
    np.testing.assert_allclose(data["heights"][0], data["heights"][-1])  # it is periodic
    np.testing.assert_allclose(data["heights"][:, 0], data["heights"][:, -1])
    steps = np.diff(data["heights"], axis=0) / np.diff(data["cells"])[:, None]
    assert np.sqrt(2 * (steps**2).mean()) == pytest.approx(before[0], rel=0.15)
    assert data["cells"][0] == 0
    order = np.argsort(data["before_slopes"][0])
    ranks = [int(np.flatnonzero(order == k)[0]) for k in data["marked"]]
    assert ranks == sorted(ranks)  # the marked facets: two steep ones on either side
    assert data["before_slopes"][0][data["marked"][1]] < 0 < data["before_slopes"][0][data["marked"][2]]


# --- geometry ---------------------------------------------------------------------------------------------------------------


def test_areas_of_both_surfaces(compute: Compute) -> None:
    """Beckmann's as an integral over slopes, GGX's in closed form."""
    data = compute("geometry/area")
    t = np.linspace(0, 9, 200001)
    beckmann = [np.trapezoid(np.sqrt(1 + (a * t) ** 2) * np.exp(-(t**2)) * 2 * t, t) for a in data["alpha"]]
    same(data["beckmann"], beckmann)
    root = np.sqrt(1 - data["alpha"] ** 2)
    same(data["ggx"], 1 + data["alpha"] ** 2 * np.arctanh(root) / root)
    assert data["checked"][[0, -1]].tolist() == [0.1, 1.0]
    assert data["made"][[0, -1]].tolist() == [0.2, 1.0]
    assert data["theta"][[0, -1]].tolist() == [0, 90]
    theta, alpha = np.radians(data["theta"])[1:-1], data["shown"]
    for name, D in (("beckmann", beckmann_D), ("ggx", ggx_D)):
        density = D(polar(theta), alpha, alpha) * 2 * np.pi * np.sin(theta)  # of area, per radian
        np.testing.assert_allclose(data[f"{name}_density"][1:-1], density * np.pi / 180, rtol=2e-4, atol=1e-9)


def test_distributions_and_what_they_project_to(compute: Compute) -> None:
    data = compute("geometry/distributions")
    theta, alpha = np.radians(data["theta"]), data["shown"]
    m, n = polar(theta[:-1]), 2 / alpha**2 - 2
    first = m[..., 2] ** n
    shown = [first, (n + 2) / (2 * np.pi) * first, *(D(m, alpha, alpha) for D in (ward_D, beckmann_D, ggx_D))]
    np.testing.assert_allclose(data["density"][:, :-1], shown, rtol=1e-4, atol=1e-8)
    np.testing.assert_allclose(data["integral"][0], np.pi * data["alpha"] ** 2, rtol=1e-5)
    np.testing.assert_allclose(data["integral"][[1, 3, 4]], 1, atol=1e-7)
    for k in (5, 30, 79):
        assert data["integral"][2][k] == pytest.approx(projected_area(ward_D, *2 * [data["alpha"][k]]), abs=2e-5)
    np.testing.assert_allclose(data["apart"], np.maximum(abs(data["integral"] - 1), data["floor"]), rtol=1e-2, atol=1e-8)
    assert data["apart"].min() >= data["floor"] * (1 - 1e-9)
    assert np.sqrt(1 / np.pi) in [pytest.approx(a, abs=1e-6) for a in data["alpha"]]


# --- material and masking -------------------------------------------------------------------------------------------------


def reflectance(cosine: Array, eta: complex) -> Array:
    """Fresnel 1823: the mean of both polarisations."""
    c = cosine.astype(complex)
    t = np.sqrt(1 - (1 - c**2) / eta**2)
    s, p = (c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t)
    return (abs(s) ** 2 + abs(p) ** 2) / 2


def test_reflectances_and_their_landmarks(compute: Compute) -> None:
    data = compute("material/fresnel")
    theta, eta = np.radians(data["theta"]), float(data["eta"])
    assert data["theta"][[0, -1]].tolist() == [0, 90]
    indices = {"outside": eta, "inside": 1 / eta, "metal_0": 1 + 6.7j, "metal_1": 2.9 + 3j}
    for name, index in indices.items():
        exact = reflectance(np.maximum(np.cos(theta), 0), index)
        np.testing.assert_allclose(data[name], exact, atol=2e-6)
        zero = exact[0]
        np.testing.assert_allclose(data[f"{name}_schlick"], zero + (1 - zero) * (1 - np.cos(theta)) ** 5, atol=2e-6)
    ray = np.radians(data["degrees"])
    assert data["split"] == pytest.approx(reflectance(np.cos(np.array(ray)), eta), rel=1e-5)
    assert eta * np.sin(np.radians(data["refracted"])) == pytest.approx(np.sin(ray), rel=1e-5)
    assert eta * np.sin(np.radians(data["critical"])) == pytest.approx(1, rel=1e-5)
    c, s = np.cos(np.radians(data["brewster"])), np.sin(np.radians(data["brewster"]))
    assert eta * c == pytest.approx(np.sqrt(1 - (s / eta) ** 2), rel=1e-5)  # nothing of the one polarisation is reflected
    assert [text.replace("\\,", "") for text in data["metals"]] == ["$1 + 6.7i$", "$2.9 + 3i$"]


def test_masking_functions_fill_the_view(compute: Compute) -> None:
    """Smith's exactly; those of others by sums over facets."""
    data = compute("visibility/masking_functions")
    theta = np.radians(data["theta"])
    assert data["theta"][[0, -1]].tolist() == [0, 89.5]
    assert (np.diff(data["theta"])[:-1] == 1).all()
    np.testing.assert_allclose(data["share"][:, :2], 1, atol=1e-8)
    off = np.maximum(abs(data["share"] - 1), data["floor"])
    np.testing.assert_allclose(data["apart"], off, rtol=0.01, atol=2e-6)
    assert data["apart"].min() >= data["floor"] * (1 - 1e-9)
    implicit = list(data["names"]).index("Implicit")
    for row, G1 in enumerate((beckmann_G1(theta[1:], 0.4), ggx_G1(theta[1:], 1.0))):
        np.testing.assert_allclose(data["share"][row, implicit, 1:], np.cos(theta[1:]) / G1, atol=2e-5)


# --- lobes --------------------------------------------------------------------------------------------------------------------


def lobe(name: str, wo: Array, wi: Array, alpha: float) -> Array:
    """BRDF times the cosine of wo, after the papers that each masking function is from."""
    h = wo + wi
    h = h / np.linalg.norm(h, axis=-1, keepdims=True)
    co, ci, ch, oh = wo[..., 2], wi[..., 2], h[..., 2], (wo * h).sum(axis=-1)
    masking, distribution = name.split(", ")
    D = (ggx_D if distribution == "GGX" else beckmann_D)(h, alpha, alpha)
    G1 = ggx_G1 if distribution == "GGX" else beckmann_G1
    if masking == "Smith":
        G = 1 / (1 / G1(np.arccos(co), alpha) + 1 / G1(np.arccos(ci), alpha) - 1)
    else:
        V = {
            "V-cavities": np.minimum(1, 2 * ch * np.minimum(co, ci) / oh),  # Cook and Torrance 1982
            "Kelemen": co * ci / oh**2,  # Kelemen and Szirmay-Kalos 2001
            "Implicit": co * ci,  # Hoffman 2010
        }
        G = V[masking]
    return D * G / (4 * ci)


@pytest.mark.slow
def test_lobes_and_albedos_of_right_and_wrong_models(compute: Compute) -> None:
    data = compute("brdf/lobes")
    theta = np.radians(data["theta_o"])
    assert data["theta_o"][[0, -1]].tolist() == [-90, 90]
    assert data["degrees"] == 60
    wi = polar(np.radians(np.array(60.0)), np.pi)
    inside = (abs(data["theta_o"]) < 89.9) & (abs(data["theta_o"]) > 1e-9)
    for k, name in enumerate(data["names"]):
        expected = lobe(str(name), polar(theta[inside]), wi, 0.4)
        np.testing.assert_allclose(data["lobe"][k][inside], expected, rtol=1e-4, atol=1e-7, err_msg=str(name))
        assert data["peak"][k] == data["theta_o"][data["lobe"][k].argmax()]
        u = np.linspace(0, 1, 1201)[1:] - 0.5 / 1200  # cosines
        phi = (np.arange(360) + 0.5) * np.pi / 180
        for at in (1, 45, 80):
            wo = polar(np.radians(np.array(float(data["theta_i"][at]))))
            w = polar(np.arccos(u)[:, None], phi)
            albedo = (lobe(str(name), w, wo, 0.4)).mean() * 2 * np.pi
            assert data["albedo"][k][at] == pytest.approx(albedo, rel=2e-3), name
    assert data["theta_i"][[0, -1]].tolist() == [0, 88]
