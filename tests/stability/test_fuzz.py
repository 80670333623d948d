"""Arguments crowded at every edge: nothing is NaN, negative, or infinite, and no two functions contradict each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import microfacet as mf
import mpmath
import numpy as np
import pytest
from microfacet.geometry.visible_normals import HORIZON

REALS = (np.float64, np.float32)
FLAT = {np.float64: 6.123233995736766e-17, np.float32: 6.123234e-17}  # cos(pi/2) as trigonometry gives it
ALPHAS = [(0.3, 0.3), (1e-8, 1e-8), (1e3, 1e3), (1e-4, 1.0), (1e3, 0.1)]
DRAWN = {
    "GGX": lambda a: mf.Smith(mf.GGX(*a)),
    "Beckmann": lambda a: mf.Smith(mf.Beckmann(*a)),
    "VCavity(GGX)": lambda a: mf.VCavity(mf.GGX(*a)),
    "Kelemen(Beckmann)": lambda a: mf.Kelemen(mf.Beckmann(*a)),
    "Implicit(Ward)": lambda a: mf.Implicit(mf.Ward(*a)),
    "VCavity(BlinnPhong)": lambda a: mf.VCavity(mf.BlinnPhong(min(2 / a[0] ** 2, 1e16))),
    "SchlickSmith(NormalizedBlinnPhong)": lambda a: mf.SchlickSmith(mf.NormalizedBlinnPhong(min(2 / a[0] ** 2, 1e16))),
}  # fmt: skip


def least(real: type) -> float:
    return float(HORIZON if real is np.float64 else HORIZON.single)


def heights(count: int, real: type, rng: np.random.Generator, deepest: float = -8) -> np.ndarray:
    """Cosines from the pole to the horizon: even, by powers of ten from either end, and at the ends themselves."""
    kind, size = rng.integers(0, 4, count), 10.0 ** rng.uniform(deepest, 0, count)
    z = np.where(kind == 0, rng.random(count), np.where(kind == 1, size, 1 - 0.5 * size * size))
    return np.where(kind == 3, rng.choice([1.0, 1e-8, 1e-4, FLAT[real] if deepest < -8 else 1e-7, 0.5], count), z)


def directions(count: int, real: type, rng: np.random.Generator, deepest: float = -8) -> np.ndarray:
    z = heights(count, real, rng, deepest)
    turn = np.where(rng.random(count) < 0.3, rng.integers(0, 5, count) * np.pi / 2, rng.uniform(0, 7, count))
    sine = np.sqrt((1 - z) * (1 + z))
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=-1).astype(real)


def pairs(count: int, real: type, rng: np.random.Generator, deepest: float = -8) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of any directions, of equal ones, of mirrored ones, and of almost opposite ones that both graze."""
    wo, wi = directions(count, real, rng, deepest), directions(count, real, rng, deepest)
    mirrored, kind = wo * np.array([-1, -1, 1], real), rng.integers(0, 4, count)
    near = np.finfo(real).eps * rng.integers(-3, 4, (count, 2))
    grazing = mirrored + np.concatenate([near, 0 * near[:, :1]], axis=-1).astype(real)
    grazing[:, 2] = mirrored[:, 2] * 10.0 ** rng.uniform(-0.5, 0.5, count).astype(real)
    fits = np.abs(np.sum(grazing.astype(float) ** 2, axis=-1) - 1) < 1e-5
    wi = np.where((kind == 1)[:, None], mirrored, wi)
    wi = np.where(((kind == 2) & fits)[:, None], grazing, wi)
    return wo, np.where(((kind == 3) & (rng.random(count) < 0.3))[:, None], wo, wi).astype(real)


def numbers(count: int, real: type, rng: np.random.Generator) -> np.ndarray:
    """In [0, 1), often at an end."""
    last = np.nextafter(real(1), real(0))
    ends = np.array([0, np.finfo(real).tiny, 1e-30, 1e-12, 0.25, 0.5, 0.75, last, 1 - 1e-6], real)
    u = np.minimum(rng.random((count, 2)).astype(real), last)
    return np.where(rng.random((count, 2)) < 0.5, rng.choice(ends, (count, 2)), u).astype(real)


def contradictions(brdf: mf.Microfacet, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """Where one of BRDF and density is 0 and the other is not, unless what is 0 is too small for the precision."""
    tiny = float(np.finfo(wo.dtype).tiny)
    value, density, weight = (f(wo, wi).astype(float) for f in (brdf.evaluate, brdf.pdf, brdf.weight))
    assert (weight > 0).all()
    assert np.isfinite(weight).all()
    ratio = weight / wi[:, 2].astype(float)  # of value to density
    return ((value == 0) & (density * ratio > 4 * tiny)) | ((density == 0) & (value / ratio > 4 * tiny))


def lost(brdf: mf.Microfacet, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """Where a sample above the horizon has no density."""
    return (wi[:, 2] > least(wo.dtype.type)) & (brdf.pdf(wo, wi) == 0)


def run_consistency(name: str, real: type, count: int, alphas: list[tuple[float, float]]) -> int:
    rng, done = np.random.default_rng(abs(np.dtype(real).itemsize) % 1000), 0
    for alpha in alphas:
        brdf = mf.Microfacet(DRAWN[name](alpha))
        for _ in range(-(-count // 250_000)):
            n = min(count, 250_000)
            wo, wi = pairs(n, real, rng)
            bad = contradictions(brdf, wo, wi)
            assert not bad.any(), (name, alpha, bad.sum(), wo[bad][0].tolist(), wi[bad][0].tolist())
            done += n
    return done


@pytest.mark.parametrize("name", ["GGX", "Beckmann", "VCavity(GGX)"])
@pytest.mark.parametrize("real", REALS)
def test_value_and_density_vanish_together(name: str, real: type) -> None:
    run_consistency(name, real, 4000, ALPHAS)


@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("real", REALS)
def test_a_sample_of_ggx_has_a_density(alpha: tuple[float, float], real: type) -> None:
    rng, brdf = np.random.default_rng(3), mf.Microfacet(DRAWN["GGX"](alpha))
    wo = directions(20_000, real, rng)
    wi = brdf.sample(wo, numbers(20_000, real, rng))
    assert (brdf.pdf(wo, wi) > 0).all()


@pytest.mark.parametrize("alpha", [0.03, 0.3, 3.0])
@pytest.mark.parametrize("real", REALS)
def test_a_sample_of_beckmann_has_a_density_where_its_lobe_is_wider_than_rounding(alpha: float, real: type) -> None:
    rng, brdf = np.random.default_rng(3), mf.Microfacet(mf.Smith(mf.Beckmann(alpha)))
    wo = directions(20_000, real, rng)
    wo = wo[wo[:, 2] > 100 * np.finfo(real).eps / alpha]
    wi = brdf.sample(wo, numbers(len(wo), real, rng))
    assert not lost(brdf, wo, wi).any()


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("real", REALS)
def test_visible_normals_face_the_viewer(kind: type, alpha: tuple[float, float], real: type) -> None:
    rng, model = np.random.default_rng(4), mf.Smith(kind(*alpha))
    wo = directions(20_000, real, rng)
    m = model.sample_visible(wo, numbers(20_000, real, rng))
    assert (np.sum(wo * m, axis=-1) > 0).all()
    assert (model.D_visible(wo, m) > 0).all()


def calls(name: str, alpha: tuple[float, float]) -> dict[str, Callable[[Any, Any, Any, Any], Any]]:
    """Every public function of one model, of two directions, a normal and two numbers."""
    model = DRAWN[name](alpha)
    brdf, ndf = mf.Microfacet(model), model.ndf
    found: dict[str, Callable[[Any, Any, Any, Any], Any]] = {
        "evaluate": lambda o, i, m, u: brdf.evaluate(o, i),
        "pdf": lambda o, i, m, u: brdf.pdf(o, i),
        "weight": lambda o, i, m, u: brdf.weight(o, i),
        "sample": lambda o, i, m, u: np.abs(brdf.sample(o, u)),
        "G1": lambda o, i, m, u: model.G1(o, m),
        "G2": lambda o, i, m, u: model.G2(o, i, m),
        "D_visible": lambda o, i, m, u: model.D_visible(o, m),
        "D": lambda o, i, m, u: ndf.D(m),
        "pdf of normals": lambda o, i, m, u: ndf.pdf(m),
        "sample of normals": lambda o, i, m, u: np.abs(ndf.sample(u)),
    }
    if model.sampler is not None:
        found["sample_visible"] = lambda o, i, m, u: np.abs(model.sample_visible(o, u))
    return found


UNBOUNDED = {"G1", "G2", "evaluate", "weight", "pdf", "D_visible"}  # which may exceed the largest number next to the horizon


def run_numbers(name: str, real: type, count: int, alphas: list[tuple[float, float]]) -> int:
    """How many values were looked at; down to the horizon as trigonometry gives it, and below."""
    rng, done = np.random.default_rng(5), 0
    for alpha in alphas:
        functions = calls(name, alpha)
        for deepest in (-8.0, -20.0):
            wo, wi = pairs(count, real, rng, deepest)
            normals, u = directions(count, real, rng, deepest), numbers(count, real, rng)
            sides = np.where(rng.random((count, 2, 1)) < 0.1, -1, 1).astype(real)
            wo, wi = wo * sides[:, 0], wi * sides[:, 1]
            for function, call in functions.items():
                values = call(wo, wi, normals, u)
                assert not np.isnan(values).any(), (name, alpha, function, deepest)
                assert (values >= 0).all(), (name, alpha, function)
                if deepest == -8.0 or function not in UNBOUNDED:
                    assert np.isfinite(values).all(), (name, alpha, function)
                if function in ("evaluate", "weight", "G2"):
                    assert (values[(wo[:, 2] <= 0) | (wi[:, 2] <= 0)] == 0).all()
                done += values.size
    return done


@pytest.mark.parametrize("name", ["GGX", "Beckmann", "VCavity(GGX)"])
@pytest.mark.parametrize("real", REALS)
def test_all_values_are_numbers(name: str, real: type) -> None:
    assert run_numbers(name, real, 2000, ALPHAS) > 10_000


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("real", REALS)
def test_of_ten_million_pairs_none_contradicts(name: str, real: type) -> None:
    done = run_consistency(name, real, 2_000_000, ALPHAS)
    assert done == 10_000_000
    print(f"{name} {real.__name__}: {done} pairs, none inconsistent")


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("real", REALS)
def test_of_millions_of_values_all_are_numbers(name: str, real: type) -> None:
    done = run_numbers(name, real, 50_000, ALPHAS)
    print(f"{name} {real.__name__}: {done} values, all numbers")
    assert done > 5_000_000


# --- right values, at 50 digits, of the numbers given ---------------------------------------------------------------------

GRAZING = [
    (np.float32, 0.43674469, (0.70151567, 0.71265399, 1.117435e-4), (-0.70151573, -0.71265399, 7.94616e-5)),
    (
        np.float64,
        0.3,
        (0.5917929859542123, 0.8060899836714244, 1e-8),
        (-0.5917929940962393, -0.806089977693935, 6.31167676204533e-9),
    ),
]


@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
@pytest.mark.parametrize(("real", "alpha", "wo", "wi"), GRAZING)
def test_forward_grazing_pairs_have_all_digits(kind: type, real: type, alpha: float, wo: Any, wi: Any) -> None:
    from microfacet.validation import accuracy

    wo, wi, ndf = np.array(wo, real), np.array(wi, real), kind(accuracy.rounded(alpha, real))
    brdf = mf.Microfacet(mf.Smith(kind(alpha)))
    with mpmath.workdps(50):
        exact = [accuracy.exact_rho(ndf, wo, wi), accuracy.exact_pdf(ndf, wo, wi)]
    assert accuracy.digits(np.array([brdf.evaluate(wo, wi), brdf.pdf(wo, wi)]), exact, real).min() > accuracy.MOST[real] - 2.5


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("n", [0.5, 1e3, 1e6, 1e8, 1e12])
def test_a_power_of_the_cosine_next_to_one_keeps_its_digits(real: type, n: float) -> None:
    """The slopes have what the rounded cosine has lost; samples of such lobes are not all upright."""
    ndf, rng = mf.NormalizedBlinnPhong(n), np.random.default_rng(6)
    theta = np.arctan(np.sqrt(np.expm1(np.minimum(2 / n * rng.uniform(0, 60, 50), 30))))
    normals = np.stack([np.sin(theta) * 0.6, np.sin(theta) * 0.8, np.cos(theta)], axis=-1).astype(real)
    for m, found in zip(normals, ndf.D(normals), strict=True):
        with mpmath.workdps(50):
            x, y, z = (mpmath.mpf(float(c)) for c in m)
            power = mpmath.mpf(float(real(n)))
            exact = (power + 2) / (2 * mpmath.pi) * (z / mpmath.sqrt(x * x + y * y + z * z)) ** power
            assert abs(found / exact - 1) < 6 * np.finfo(real).eps
    u = np.stack([np.full(1000, 0.5), (np.arange(1000) + 0.5) / 1000], axis=-1).astype(real)
    with mpmath.workdps(50):
        slope = float(mpmath.sqrt(mpmath.mpf(2) ** (mpmath.mpf(2) / (mpmath.mpf(float(real(n))) + 2)) - 1))
    m = ndf.sample(u)
    np.testing.assert_allclose(np.hypot(m[:, 0], m[:, 1]) / m[:, 2], slope, rtol=10 * np.finfo(real).eps)


# --- what is made of these models -------------------------------------------------------------------------------------------

FRESNEL = [
    *(mf.Dielectric(eta) for eta in (1e-10, 1e-3, 0.25, 1.0, 1 + 1e-7, 1.5, 1e3, 1e8)),
    *(mf.Conductor(eta, k) for eta in (1e-10, 1.0, 1.5, 1e8) for k in (0, 1e-20, 1e-8, 1.0, 1e8)),
    *(mf.Schlick(F0, F90) for F0 in (0, 1e-8, 1) for F90 in (0, 1e-8, 1)),
    *(mf.F82Tint(F0, tint) for F0, tint in ((0, 1), (0.5, 0.7), (1, 0.5), (1, 1))),
]


@pytest.mark.slow
@pytest.mark.parametrize("real", REALS)
def test_every_reflectance_is_a_number_from_0_to_1(real: type) -> None:
    cosine: np.ndarray = heights(20_000, real, np.random.default_rng(7), -20.0).astype(real)
    for term in [mf.Microfacet(DRAWN["GGX"]((0.3, 0.3))).fresnel, *FRESNEL]:
        values = term.F(cosine)
        assert values.dtype == real
        assert ((values >= 0) & (values <= 1)).all(), (term, values.min(), values.max())


class ByPanels(mf.GGX):
    """A user's distribution: one that offers no closed form of Lambda."""

    closed_Lambda = None


def correlated(correlation: str) -> Callable[[tuple[float, float]], Any]:
    return lambda a: mf.Microfacet(mf.Smith(mf.GGX(*a), correlation))


BUILT: dict[str, Callable[[tuple[float, float]], Any]] = {
    **{f"Smith, {name}": correlated(name) for name in ("none", "direction", "height-direction")},
    "by panels": lambda a: mf.Microfacet(mf.Smith(ByPanels(*a))),
    "Diffuse": lambda a: mf.Diffuse(mf.Smith(mf.GGX(*a))),
}


def run_built(name: str, real: type, count: int, alphas: list[tuple[float, float]]) -> int:
    """Values of the BRDF, with and without light from below: numbers, not negative, and 0 at the horizon and below."""
    rng, done = np.random.default_rng(8), 0
    for alpha in alphas:
        brdf = BUILT[name](alpha)
        wo, wi = pairs(count, real, rng)
        sides: np.ndarray = np.where(rng.random((count, 2)) < 0.1, rng.choice([-1.0, 0.0], (count, 2)), 1).astype(real)
        wo, wi = ended(wo, sides[:, 0]), ended(wi, sides[:, 1])
        values = brdf.evaluate(wo, wi)
        bad = ~(np.isfinite(values) & (values >= 0))
        assert not bad.any(), (name, alpha, bad.sum(), wo[bad][0].tolist(), wi[bad][0].tolist())
        assert (values[(wo[:, 2] <= 0) | (wi[:, 2] <= 0)] == 0).all()
        done += values.size
    return done


def ended(w: np.ndarray, side: np.ndarray) -> np.ndarray:
    """Directions as they are, below the horizon, or (side 0) on it."""
    level: np.ndarray = np.array([0.6, 0.8, 0.0], w.dtype)
    return np.where(side[:, None] == 0, level, w * np.stack([0 * side + 1, 0 * side + 1, side], axis=-1)).astype(w.dtype)


@pytest.mark.parametrize("name", ["Smith, height-direction", "Diffuse"])
def test_what_is_built_of_models_gives_numbers(name: str) -> None:
    run_built(name, np.float64, 300, ALPHAS)


@pytest.mark.slow
@pytest.mark.parametrize("name", BUILT)
@pytest.mark.parametrize("real", REALS)
def test_of_many_values_of_what_is_built_all_are_numbers(name: str, real: type) -> None:
    count = 200_000 if name.startswith("Smith") else 20_000
    done = run_built(name, real, count, ALPHAS)
    print(f"{name} {real.__name__}: {done} values, all numbers")
    assert done == count * len(ALPHAS)


ENERGY: dict[str, Callable[[mf.Microfacet], Any]] = {
    "albedo": lambda brdf: brdf,
    "lobe": lambda brdf: mf.Compensated(brdf, "lobe"),
    "scaled": lambda brdf: mf.Compensated(brdf, "scaled"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ENERGY)
@pytest.mark.parametrize("real", REALS)
def test_energy_is_a_number_with_an_error_that_is_one(name: str, real: type) -> None:
    rng = np.random.default_rng(9)
    for alpha in ALPHAS[:3]:
        brdf = ENERGY[name](mf.Microfacet(mf.Smith(mf.GGX(*alpha))))
        wo, wi = pairs(3400, real, rng)
        values, (share, error) = brdf.evaluate(wo, wi), brdf.albedo_with_error(wo)
        for found in (values, share, error):
            assert np.isfinite(found).all(), (name, alpha)
            assert (found >= 0).all(), (name, alpha)
        assert (share <= 1 + error).all(), (name, alpha)
        np.testing.assert_array_equal(brdf.evaluate(wo, wi * np.array([1, 1, -1], real)), 0)


@pytest.mark.slow
@pytest.mark.parametrize("alpha", ALPHAS[:3])
def test_random_walks_give_numbers(alpha: tuple[float, float]) -> None:
    wo, wi = pairs(20, np.float64, np.random.default_rng(10))
    walk = mf.RandomWalk(mf.Smith(mf.GGX(*alpha)))
    value, error = walk.evaluate_with_error(wo, wi, walks=16)
    for found in (value, error):
        assert np.isfinite(found).all()
        assert (found >= 0).all()
    assert (walk.evaluate(wo, -wi, walks=16) == 0).all()
