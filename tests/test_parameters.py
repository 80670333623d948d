"""Parameters that are arrays: at each place what the model of this place's numbers gives, in either precision."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import microfacet as mf
import mpmath
import numpy as np
import pytest
from microfacet.directions import spherical
from microfacet.geometry.blinn_phong import gamma_ratio
from samples import hemisphere, uniform

COUNT = 40
REALS = (np.float64, np.float32)
ULPS = 24  # a formula with other operations, and as many as others may be off by


def even(low: float, high: float, seed: int) -> np.ndarray:
    """Numbers even in their logarithm."""
    return np.exp(np.random.default_rng(seed).uniform(np.log(low), np.log(high), COUNT))


WO, WI, U = hemisphere(COUNT, 1), hemisphere(COUNT, 2), uniform(COUNT, 3)
ALPHA_X, ALPHA_Y = even(1e-3, 30, 4), even(1e-3, 30, 5)
MODELS: dict[str, Callable[[], mf.Microfacet]] = {
    "joined": lambda: mf.Microfacet(mf.Smith(mf.GGX(ALPHA_X, ALPHA_Y)), mf.Dielectric(even(0.25, 4, 6))),
    "isotropic": lambda: mf.Microfacet(mf.Smith(mf.GGX(ALPHA_X))),
    "one array": lambda: mf.Microfacet(mf.Smith(mf.GGX(ALPHA_X, 0.3), "direction"), mf.Schlick(0.04, even(0.1, 1, 7))),
    "beckmann": lambda: mf.Microfacet(mf.Smith(mf.Beckmann(ALPHA_X, ALPHA_Y)), mf.Conductor(even(0.2, 3, 8), even(0.1, 8, 9))),
    "cavity": lambda: mf.Microfacet(mf.VCavity(mf.Ward(0.2, ALPHA_Y)), mf.F82Tint(even(0.5, 1, 10), 0.8)),
    "ward": lambda: mf.Microfacet(mf.Smith(mf.Ward(even(0.05, 2, 11)))),
    "power": lambda: mf.Microfacet(mf.Smith(mf.NormalizedBlinnPhong(even(1, 1e4, 12)))),
    "schlick": lambda: mf.Microfacet(mf.SchlickSmith(mf.Beckmann(ALPHA_X))),
    "own k": lambda: mf.Microfacet(mf.SchlickSmith(mf.GGX(0.4), even(0.1, 1, 13))),
    "fresnel alone": lambda: mf.Microfacet(mf.Smith(mf.GGX(0.4)), mf.Dielectric(even(0.25, 4, 6))),
}


def assert_alike(found: np.ndarray, expected: np.ndarray, real: type) -> None:
    assert found.dtype == expected.dtype == real
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, rtol=ULPS * np.finfo(real).eps, atol=ULPS * np.finfo(real).tiny)


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("name", MODELS)
def test_each_place_has_what_its_numbers_give(name: str, real: type) -> None:
    brdf, wo, wi = MODELS[name](), WO.astype(real), WI.astype(real)
    assert brdf.batch_shape == (COUNT,)
    each = [brdf.at(k) for k in range(COUNT)]
    for function in ("evaluate", "pdf", "weight"):
        found = getattr(brdf, function)(wo, wi)
        assert_alike(found, np.array([getattr(one, function)(wo[k], wi[k]) for k, one in enumerate(each)]), real)
    normals = brdf.sample(wo, U.astype(real))
    expected = np.array([one.sample(wo[k], U[k].astype(real)) for k, one in enumerate(each)])
    np.testing.assert_allclose(normals, expected, rtol=0, atol=ULPS * np.finfo(real).eps)
    for parts in (brdf.model.G1(wo, [0, 0, 1]), brdf.model.ndf.D(wo), brdf.fresnel.F(np.full(COUNT, 0.3))):
        assert parts.shape == (COUNT,)


def test_parts_of_each_place() -> None:
    ndf = mf.GGX(ALPHA_X, ALPHA_Y)
    model, eta = mf.Smith(ndf), even(0.25, 4, 6)
    for k in range(COUNT):
        assert ndf.D(WO)[k] == mf.GGX(ALPHA_X[k], ALPHA_Y[k]).D(WO[k])
        assert ndf.P22(0.1, 0.2)[k] == mf.GGX(ALPHA_X[k], ALPHA_Y[k]).P22(0.1, 0.2)
        assert model.D_visible(WO, WI)[k] == model.at(k).D_visible(WO[k], WI[k])
        assert model.G2(WO, WI, [0, 0, 1])[k] == model.at(k).G2(WO[k], WI[k], [0, 0, 1])
        assert mf.Dielectric(eta).F(0.3)[k] == mf.Dielectric(eta[k]).F(0.3)
    np.testing.assert_array_equal(ndf.sample(U)[7], mf.GGX(ALPHA_X[7], ALPHA_Y[7]).sample(U[7]))
    np.testing.assert_array_equal(model.sample_visible(WO, U)[7], model.at(7).sample_visible(WO[7], U[7]))


def test_channels_of_a_metal() -> None:
    copper = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor([0.2, 0.9, 1.4], [3.9, 2.4, 1.6]))
    values = copper.evaluate(WO[:, None], WI[:, None])
    assert values.shape == (COUNT, 3)
    for channel, (eta, k) in enumerate([(0.2, 3.9), (0.9, 2.4), (1.4, 1.6)]):
        one = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(eta, k))
        np.testing.assert_array_equal(values[:, channel], one.evaluate(WO, WI))
        np.testing.assert_array_equal(copper.albedo(WO[:4, None])[:, channel], one.albedo(WO[:4]))
        np.testing.assert_array_equal(copper.weight(WO[:, None], WI[:, None])[:, channel], one.weight(WO, WI))
    assert copper.sample(WO, U).shape == (COUNT, 3)  # one direction for all channels
    assert copper.pdf(WO, WI).shape == (COUNT,)


def test_albedo_of_a_texture() -> None:
    texture = np.array([[0.1, 0.5, 0.1], [0.5, 0.5, 1.0]])
    wo = spherical(np.radians([[10], [70]]), 0.4)
    value, error = mf.Microfacet(mf.Smith(mf.Beckmann(texture))).albedo_with_error(wo)
    for place in np.ndindex(2, 3):
        one = mf.Microfacet(mf.Smith(mf.Beckmann(texture[place]))).albedo_with_error(wo[place[0], 0])
        assert (value[place], error[place]) == one
    assert mf.Microfacet(mf.Smith(mf.Beckmann(texture))).albedo(wo.astype(np.float32)).dtype == np.float32


def test_many_places_are_taken_in_pieces() -> None:
    alpha, wo, wi = np.geomspace(0.01, 10, 300_000), hemisphere(300_000, 6), hemisphere(300_000, 7)
    values = mf.Microfacet(mf.VCavity(mf.GGX(alpha))).evaluate(wo, wi)
    for k in (0, 1, 77_777, 299_999):
        assert values[k] == mf.Microfacet(mf.VCavity(mf.GGX(alpha[k]))).evaluate(wo[k], wi[k])
    out = np.empty(300_000)
    assert mf.Microfacet(mf.VCavity(mf.GGX(alpha))).evaluate(wo, wi, out) is out
    np.testing.assert_array_equal(out, values)


def test_a_texture_in_single_precision_stays() -> None:
    texture = np.linspace(0.1, 0.9, COUNT, dtype=np.float32)
    brdf = mf.Microfacet(mf.Smith(mf.GGX(texture)))
    assert brdf.model.ndf.alpha_x.dtype == np.float32
    assert brdf.evaluate(WO, WI).dtype == np.float64
    assert_alike(brdf.evaluate(WO, WI), mf.Microfacet(mf.Smith(mf.GGX(texture.astype(float)))).evaluate(WO, WI), np.float64)
    K = mf.BlinnPhong(texture).parameters[1]
    np.testing.assert_array_equal(K, mf.BlinnPhong(texture.astype(float)).parameters[1])


def test_models_keep_arrays_of_their_own() -> None:
    texture = np.array([0.1, 0.2])
    ndf = mf.GGX(texture)
    texture[0] = 5
    np.testing.assert_array_equal(ndf.alpha_x, [0.1, 0.2])
    with pytest.raises(ValueError, match="read-only"):
        ndf.alpha_x[0] = 5
    assert ndf == mf.GGX([0.1, 0.2]) == pickle.loads(pickle.dumps(ndf))
    assert ndf != mf.GGX([0.1, 0.3])
    assert hash(ndf) == hash(mf.GGX([0.1, 0.2]))
    assert repr(ndf) == "GGX(<0.1 to 0.2, (2,)>, <0.1 to 0.2, (2,)>)"
    assert ndf.isotropic
    assert not mf.GGX([0.1, 0.2], 0.1).isotropic


def test_places() -> None:
    brdf = mf.Microfacet(mf.Smith(mf.GGX([[0.1], [0.2]])), mf.Schlick([0.3, 0.4, 0.5]))
    assert brdf.batch_shape == (2, 3)
    assert brdf.at(1, 2) == mf.Microfacet(mf.Smith(mf.GGX(0.2)), mf.Schlick(0.5))
    assert mf.GGX(0.3).at() == mf.GGX(0.3)
    with pytest.raises(IndexError):
        brdf.at(2, 0)
    with pytest.raises(IndexError, match=r"an index for each axis of \(2, 3\) is needed, got \(1,\)"):
        brdf.at(1)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: mf.GGX([0.1, -1]), "alpha_x must be a finite number above 0, got -1"),
        (lambda: mf.GGX(0.1, [0.1, np.nan]), "alpha_y must be a finite number above 0, got nan"),
        (lambda: mf.Beckmann([0.1, 1e12]), r"alpha_x must lie between 1e-11 and 1e\+11, got 1e\+12"),
        (lambda: mf.Ward(["a"]), r"alpha_x must be an array of numbers, got \['a'\]"),
        (lambda: mf.GGX([True]), "alpha_x must be a number above 0, got True"),
        (lambda: mf.GGX([0.1, 0.2], [0.1, 0.2, 0.3]), r"parameters must broadcast, got alpha_x \(2,\), alpha_y \(3,\)"),
        (lambda: mf.Conductor([1, 2], [-1, 2]), "k must be 0 or lie between"),
        (lambda: mf.Conductor([1, 2], [0, 1e-30]), "k must be 0 or lie between"),
        (lambda: mf.Schlick([0.1, 1.1]), r"F0 must lie in \[0, 1\], got 1.1"),
        (lambda: mf.F82Tint([0.9, 0.1], [0.9, 0.1]), "tint must be lighter for F0 = 0.1 and F90 = 1"),
        (lambda: mf.SchlickSmith(mf.GGX([0.1, 0.2]), [1, 2, 3]), r"parameters must broadcast, got ndf \(2,\), k \(3,\)"),
        (lambda: mf.Microfacet(mf.Smith(mf.GGX([0.1, 0.2])), mf.Dielectric([1.0, 2, 3])), "parameters must broadcast"),
        (lambda: mf.GGX([0.1, 0.2]).D(WO), r"\(2,\) do not broadcast with directions of shape \(40,\)"),
    ],
)
def test_arrays_that_are_no_parameters_are_refused(make: Callable[[], Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        make()


@pytest.mark.parametrize(
    "call",
    [
        lambda brdf: mf.validate(brdf.model),
        lambda brdf: mf.Compensated(brdf),
        lambda brdf: mf.RandomWalk(brdf.model),
        lambda brdf: mf.Diffuse(brdf.model),
        lambda brdf: mf.seen_area(brdf.model.ndf),
        lambda brdf: brdf.reflected,
        lambda brdf: brdf.model.ndf.panels,
    ],
)
def test_what_needs_numbers_says_so(call: Callable[[mf.Microfacet], Any]) -> None:
    with pytest.raises(ValueError, match=r"takes numbers for parameters, got .* of shape \(2,\), of which `at` gives one"):
        call(mf.Microfacet(mf.Smith(mf.GGX([0.1, 0.2]))))


def test_ratios_of_gamma_functions() -> None:
    a = np.concatenate([np.geomspace(1e-22, 1e22, 500), np.linspace(0, 60, 500), [999.0, 1000.0, 1001.0]])
    with mpmath.workdps(40):
        exact = [mpmath.gammaprod([mpmath.mpf(x) + 1.5], [mpmath.mpf(x) + 2]) for x in map(float, a)]
    np.testing.assert_allclose(gamma_ratio(a), np.array(exact, float), rtol=1.5e-15)
    assert gamma_ratio(0.7) == pytest.approx(gamma_ratio(np.array([0.7]))[0], rel=1e-15)
