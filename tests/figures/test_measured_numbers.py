"""Every number of the measured figures once more: from the campaign's arrays with numpy alone, models from their formulas."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from report.campaign import CAMPAIGN, THETA_O, read
from scipy.special import erf

Array = NDArray[np.float64]
Compute = Callable[[str], dict[str, Any]]
ALPHAS = (0.4, 0.7, 1.0)
LOBES = [f"lobes_{name}" for name in ("04", "07", "10")]


def same(found: Any, expected: Any, **options: Any) -> None:
    """To the five digits that a data file keeps."""
    np.testing.assert_allclose(found, expected, **{"rtol": 2e-4, "atol": 1e-7, **options})


def mean(values: Array) -> tuple[Array, Array]:
    """Of the surfaces, and its standard error."""
    return values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(len(values))


def jackknife(function: Callable[[Array], Any], values: Array) -> tuple[Any, Any]:
    """A function of the mean, and how it scatters when one surface after the other is left out."""
    n = len(values)
    without = np.array([function(np.delete(values, k, axis=0).mean(axis=0)) for k in range(n)])
    return function(values.mean(axis=0)), np.sqrt((n - 1) / n * ((without - without.mean(axis=0)) ** 2).sum(axis=0))


def quotient(above: Array, below: Array) -> tuple[Any, Any]:
    with np.errstate(invalid="ignore", divide="ignore"):
        return jackknife(lambda both: both[0] / both[1], np.stack([above, below], axis=1))


# --- models, isotropic and Beckmann ---------------------------------------------------------------------------------------


def direction(theta: Array | float, phi: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), axis=-1)


def Lambda(theta: Array | float, alpha: float) -> Array:
    with np.errstate(divide="ignore"):
        a = 1 / (alpha * np.tan(np.maximum(theta, 1e-9)))
    return (erf(a) - 1) / 2 + np.exp(-(a**2)) / (2 * a * np.sqrt(np.pi))


def smith_G1(theta: float, alpha: float, cosine: Array, z: Array) -> Array:
    return np.full_like(z, 1 / (1 + Lambda(theta, alpha)))


def cavity_G1(theta: float, alpha: float, cosine: Array, z: Array) -> Array:
    return np.minimum(1, 2 * z * np.cos(theta) / cosine)


def light(model: str, alpha: float, theta: float, wi: Array) -> Array:
    """BRDF times the cosine, of mirrors, lit from wi and seen from the azimuth 0."""
    wo = direction(theta, 0.0)
    m = wo + wi
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    cosine, z = m @ wo, m[..., 2]
    D = np.exp((1 - 1 / z**2) / alpha**2) / (np.pi * alpha**2 * z**4)
    if model == "smith":
        G2 = 1 / (1 + Lambda(theta, alpha) + Lambda(np.arccos(wi[..., 2]), alpha))
    else:
        G2 = np.minimum(cavity_G1(theta, alpha, cosine, z), 2 * z * wi[..., 2] / cosine)
    return D * G2 / (4 * wo[2])


def middles(edges: Array, parts: int = 10) -> Array:
    return np.concatenate([low + (high - low) * (np.arange(parts) + 0.5) / parts for low, high in pairwise(edges)])


def lobe(model: str, alpha: float, theta: float, edges: tuple[Array, Array]) -> Array:
    """The share of light in each bin, by sums over points."""
    t, p = (middles(one) for one in edges)
    values = light(model, alpha, theta, direction(t[:, None], p)) * np.sin(t)[:, None]
    shape = (len(edges[0]) - 1, 10, len(edges[1]) - 1, 10)
    return values.reshape(shape).mean(axis=(1, 3)) * np.outer(np.diff(edges[0]), np.diff(edges[1]))


EDGES = np.radians(np.arange(0, 91, 6)), np.radians(np.arange(-180, 181, 15))
ANGLES = np.outer(-np.diff(np.cos(EDGES[0])), np.diff(EDGES[1]))


def merged(lobes: Array) -> Array:
    """Three bins by two as one, and both sides of the plane of incidence alike."""
    *others, t, p = lobes.shape
    whole = lobes.reshape(*others, t // 3, 3, p // 2, 2).sum(axis=(-3, -1))
    return (whole + whole[..., ::-1]) / 2


def variation(a: Array, b: Array) -> float:
    return float(abs(a / a.sum() - b / b.sum()).sum() / 2)


def scatter(lobes: Array) -> float:
    """Half the sum of the mean distances of normally distributed shares from their means."""
    shapes = lobes / lobes.sum(axis=tuple(range(1, lobes.ndim)), keepdims=True)
    return float(0.5 * np.sqrt(2 / np.pi) * mean(shapes)[1].sum())


# --- figures ----------------------------------------------------------------------------------------------------------------


def test_lobes(compute: Compute) -> None:
    data = compute("validation/measured_lobes")
    same(data["alpha"], ALPHAS)
    same(data["theta"], EDGES[0])
    same(data["phi"], EDGES[1])
    view = THETA_O.index(float(data["degrees"]))
    for k, (entry, alpha) in enumerate(zip(LOBES, ALPHAS, strict=True)):
        found = read(entry)
        lobes = merged(found["lobe"][:, view, 0])
        models = [lobe(name, alpha, np.radians(60), EDGES) for name in ("v_cavity", "smith")]
        for row, expected in enumerate(models):
            same(data["lobe"][k, row], expected / ANGLES, rtol=0.02, atol=0.01 * (expected / ANGLES).max())
        same(data["lobe"][k, 2], lobes.mean(axis=0) / ANGLES)
        value, error = mean(found["escaped"][:, view, 0])
        same(data["albedo"][k], [*(one.sum() for one in models), value], rtol=3e-3)
        same(data["albedo_error"][k], error)
        for row, model in enumerate(models):
            value, error = jackknife(lambda one, model=model: variation(one, model), lobes)
            assert data["distance"][k, row] == pytest.approx(value, abs=3e-3)
            assert data["distance_error"][k, row] == pytest.approx(error, abs=1e-3)
        assert data["noise"][k] == pytest.approx(scatter(lobes), rel=1e-4)
        assert data["surfaces"][k] == 4


def test_planes(compute: Compute) -> None:
    """Seven and a half degrees to either side of the plane of incidence, as the mean of BRDF times cosine."""
    data = compute("validation/measured_plane")
    same(data["theta"], np.arange(-87, 90, 6))
    same(data["wedge"], 7.5)
    assert data["degrees"].tolist() == [40, 60, 80]
    same(data["alpha"], ALPHAS)
    assert data["surfaces"] == 4
    wedge = np.radians([-7.5, 7.5])
    angles = -np.diff(np.cos(EDGES[0])) * np.radians(15)
    for row, degrees in enumerate(data["degrees"]):
        for column, (entry, alpha) in enumerate(zip(LOBES, ALPHAS, strict=True)):
            for name in ("smith", "v_cavity"):
                sides = [lobe(name, alpha, np.radians(degrees), (EDGES[0], turn + wedge))[:, 0] for turn in (0, np.pi)]
                expected = np.concatenate([sides[0][::-1], sides[1]]) / np.concatenate([angles[::-1], angles])
                same(data[name][row, column], expected, rtol=0.02, atol=0.01 * expected.max())
            lobes = read(entry)["lobe"][:, THETA_O.index(degrees), 0].reshape(4, 15, 3, 48).sum(axis=2)
            towards, away = (lobes[:, :, list(turns)].sum(axis=2) / angles for turns in ((23, 24), (0, 47)))
            value, error = mean(np.concatenate([towards[:, ::-1], away], axis=1))
            same(data["measured"][row, column], value)
            same(data["error"][row, column], error)


def test_maskings(compute: Compute) -> None:
    data = compute("validation/measured_masking")
    assert data["degrees"].tolist() == [60, 80]
    same(data["alpha"], ALPHAS)
    assert tuple(data["theta_o"]) == THETA_O
    for row, degrees in enumerate(data["degrees"]):
        for column, (entry, alpha) in enumerate(zip(LOBES, ALPHAS, strict=True)):
            found, theta = read(entry), np.radians(degrees)
            seen, faced = (found[name][:, THETA_O.index(degrees)] for name in ("seen", "faced"))
            value, error = quotient(seen, faced)
            few = faced.mean(axis=0) <= 2e-3 * faced.mean(axis=0).sum()
            assert 0 < few.sum() < len(few)
            same(data["G1"][row, column], np.where(few, np.nan, value))
            same(data["error"][row, column], np.where(few, np.nan, error))
            same(data["slope"][row, column], np.linspace(-3, 3, 49)[1::2])
            same(data["mean"][row, column], quotient(seen.sum(axis=1), faced.sum(axis=1)))
            fine = data["fine"][row, column]
            same(fine, np.linspace(-3, min(3, 1 / (alpha * np.tan(theta))), 201)[:-1], atol=1e-4)
            z = 1 / np.sqrt(1 + (alpha * fine) ** 2)
            cosine = z * (np.cos(theta) - alpha * fine * np.sin(theta))
            same(data["smith"][row, column], smith_G1(theta, alpha, cosine, z))
            same(data["v_cavity"][row, column], cavity_G1(theta, alpha, cosine, z), rtol=2e-3)
    for k, entry in enumerate(LOBES):
        value, error = mean(read(entry)["seen"].sum(axis=2) / np.cos(np.radians(THETA_O)))
        same(data["area"][k, 0], value - 1, atol=1e-6)
        same(data["area"][k, 1], error, atol=1e-6)


def test_normals(compute: Compute) -> None:
    data = compute("validation/measured_normals")
    assert data["degrees"] == 80
    same(data["alpha"], ALPHAS)
    theta = np.radians(80)
    for k, (entry, alpha) in enumerate(zip(LOBES, ALPHAS, strict=True)):
        found = read(entry)
        seen = found["seen"][:, THETA_O.index(80)]
        value, error = quotient(seen, seen.sum(axis=1, keepdims=True) * np.ones_like(seen))
        same(data["edges"][k], np.linspace(-3, 3, 25))
        same(data["seen"][k], value / 0.25)
        same(data["error"][k], error / 0.25)
        fine = data["fine"][k]
        same(fine, np.linspace(-3, 3, 301), atol=1e-4)
        density = np.exp(-(fine**2)) / np.sqrt(np.pi)
        same(data["all"][k], density, rtol=1e-3)
        z = 1 / np.sqrt(1 + (alpha * fine) ** 2)
        cosine = np.maximum(z * (np.cos(theta) - alpha * fine * np.sin(theta)), 1e-12)
        for name, G1 in (("smith", smith_G1), ("v_cavity", cavity_G1)):
            expected = G1(theta, alpha, cosine, z) * cosine / (z * np.cos(theta)) * density
            same(data[name][k], expected, rtol=3e-3, atol=1e-4)
        shares = found["normals"][:, THETA_O.index(80)]
        assert data["noise"][k] == pytest.approx(scatter(shares), rel=1e-4)
        x, y, z = np.asarray(CAMPAIGN[entry].plan.views)[THETA_O.index(80)]
        q = middles(np.linspace(-3, 3, 25))
        area = np.maximum(z - alpha * (q[:, None] * x + q * y), 0)
        upright = 1 / np.sqrt(1 + alpha**2 * (q[:, None] ** 2 + q**2))
        for row, G1 in enumerate((cavity_G1, smith_G1)):
            masked = G1(theta, alpha, np.maximum(area * upright, 1e-12), upright)
            model = (masked * area * np.exp(-(q[:, None] ** 2) - q**2)).reshape(24, 10, 24, 10).sum(axis=(1, 3))
            value, error = jackknife(lambda one, model=model: variation(one, model), shares)
            np.testing.assert_allclose(data["distance"][k, row], [value, error], atol=2e-3)


@pytest.mark.slow
def test_shadowings(compute: Compute) -> None:
    data = compute("validation/measured_shadowing")
    assert (data["degrees"], data["theta_i"].tolist()) == (60, [60, 75])
    same(data["azimuth"], [0, 5, 10, 20, 40, 60, 90, 135, 180])
    theta, forms = np.radians(60), list(data["forms"])
    for k, alpha in enumerate(ALPHAS):
        found = read(f"azimuths_{10 * alpha:02.0f}")
        value, error = quotient(found["lit"][:, 0], found["facing"][:, 0])
        same(data["lit"][k], value)
        same(data["error"][k], error)
        for j, theta_i in enumerate(np.radians([60, 75])):
            o, i = Lambda(theta, alpha), Lambda(theta_i, alpha)
            expected = {"none": 1 / (1 + i), "height": (1 + o) / (1 + o + i)}
            for form, share in expected.items():
                same(data["smith"][k, j, forms.index(form)], np.full(9, share))
            q = 4 * ((np.arange(300) + 0.5) * 2 / 300 - 1)
            m = np.stack(np.broadcast_arrays(-alpha * q[:, None], -alpha * q, 1.0), axis=-1)
            m /= np.linalg.norm(m, axis=-1, keepdims=True)
            weight = np.exp(-(q[:, None] ** 2) - q**2) / m[..., 2]
            wo = direction(theta, 0.0)
            for at in (0, 3, 6, 8):
                om, im = (np.maximum(m @ w, 0) for w in (wo, direction(theta_i, np.radians(data["azimuth"][at]))))
                both = (om > 0) & (im > 0)
                om, im, w, z = om[both], im[both], weight[both], m[both][:, 2]
                G1 = cavity_G1(theta, alpha, om, z)
                lit = (w * om * np.minimum(G1, 2 * z * np.cos(theta_i) / im)).sum() / (w * om * G1).sum()
                assert data["v_cavity"][k, j, at] == pytest.approx(lit, abs=4e-3)


@pytest.mark.slow
def test_distances(compute: Compute) -> None:
    """Isotropic families from two views, with two models; what was measured of all."""
    data = compute("validation/measured_distances")
    same(data["alpha"], ALPHAS)
    assert data["entries"].tolist() == LOBES
    for prefix, entries in (("", LOBES), ("stretched_", ["stretched"]), ("gabor_", ["gabor_07"])):
        for k, entry in enumerate(entries):
            found, views = read(entry), np.asarray(CAMPAIGN[entry].plan.views)
            part = {name: data[f"{prefix}{name}"] for name in ("albedo", "bounces", "area", "noise", "surfaces", "names")}
            part = {name: value[k] if not prefix else value for name, value in part.items()}
            value, error = mean(found["escaped"][:, :, 0])
            same(part["albedo"], np.transpose([value, error]))
            same(part["bounces"], np.moveaxis(mean(found["escaped"]), 0, -1))
            same(part["area"], np.transpose(mean(found["seen"].sum(axis=2) / views[:, 2])), atol=1e-6)
            assert part["surfaces"] == 4
            whole = found["lobe"][:, :, 0].reshape(4, len(views), 15, 3, 24, 2).sum(axis=(3, 5))
            lobes = whole if entry == "stretched" else merged(found["lobe"][:, :, 0])
            same(part["noise"], [scatter(lobes[:, v]) for v in range(len(views))])
    lobes = merged(read("lobes_07")["lobe"][:, :, 0])
    names = list(data["names"][1])
    for name, kind in (("V-cavities", "v_cavity"), ("Smith, height", "smith")):
        for v in (2, 4):
            model = lobe(kind, 0.7, np.radians(THETA_O[v]), EDGES)
            value, error = jackknife(lambda one, model=model: variation(one, model), lobes[:, v])
            np.testing.assert_allclose(data["distance"][1, v, names.index(name)], [value, error], atol=3e-3)
            assert data["model_albedo"][1, v, names.index(name)] == pytest.approx(model.sum(), rel=3e-3)


@pytest.mark.slow
def test_bounces(compute: Compute) -> None:
    data = compute("validation/bounces")
    same(data["alpha"], ALPHAS)
    assert tuple(data["theta_o"]) == THETA_O
    same(data["fine"], np.linspace(0, 80, 33))
    for k, (entry, alpha) in enumerate(zip(LOBES, ALPHAS, strict=True)):
        escaped = read(entry)["escaped"]
        orders = np.concatenate([escaped[..., :3], escaped[..., 3:].sum(axis=-1, keepdims=True)], axis=-1)
        value, error = mean(orders)
        same(data["by_order"][k], value)
        same(data["error"][k], error, atol=1e-6)
        for at in (8, 24, 32):
            for name in ("smith", "v_cavity"):
                whole = lobe(name, alpha, np.radians(data["fine"][at]), EDGES).sum()
                assert data[name][k, at] == pytest.approx(whole, rel=3e-3)
        assert abs(data["walk_fine"][k, ::8, 0] - data["smith"][k, ::8]).max() < 5e-3
        np.testing.assert_allclose(data["walk_fine"][k].sum(axis=-1), 1, atol=1e-4)
