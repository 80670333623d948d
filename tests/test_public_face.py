"""What the library promises to whoever calls it: precision, shapes, errors, horizons, imports."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet import directions
from microfacet.validation import accuracy
from samples import POWERS, STRETCHED, hemisphere, uniform

LIBRARY = Path(__file__).parent.parent / "lib"
NDF = mf.GGX(0.5, 0.2)
SMITH = mf.Smith(NDF)
BRDF = mf.Microfacet(SMITH)

# name -> (operation, width of each argument, width of the result; 1 is none)
OPERATIONS: dict[str, tuple[Callable[..., Any], tuple[int, ...], int]] = {
    "D": (NDF.D, (3,), 1),
    "pdf of normals": (NDF.pdf, (3,), 1),
    "sample": (NDF.sample, (2,), 3),
    "G1": (SMITH.G1, (3, 3), 1),
    "G2": (SMITH.G2, (3, 3, 3), 1),
    "D_visible": (SMITH.D_visible, (3, 3), 1),
    "sample_visible": (SMITH.sample_visible, (3, 2), 3),
    "evaluate": (BRDF.evaluate, (3, 3), 1),
    "pdf": (BRDF.pdf, (3, 3), 1),
    "sample of the BRDF": (BRDF.sample, (3, 2), 3),
    "albedo": (BRDF.albedo, (3,), 1),
}
NAMES = {
    "D": ("wm",),
    "pdf of normals": ("wm",),
    "sample": ("u",),
    "G1": ("wo", "wm"),
    "G2": ("wo", "wi", "wm"),
    "D_visible": ("wo", "wm"),
    "sample_visible": ("wo", "u"),
    "evaluate": ("wo", "wi"),
    "pdf": ("wo", "wi"),
    "sample of the BRDF": ("wo", "u"),
    "albedo": ("wo",),
}


def values(widths: tuple[int, ...], shape: tuple[int, ...] = (4,), real: type = np.float64) -> list[np.ndarray]:
    count = int(np.prod(shape))
    made = [hemisphere(count, k) if width == 3 else uniform(count, k) for k, width in enumerate(widths)]
    return [a.reshape(*shape, width).astype(real) for a, width in zip(made, widths, strict=True)]


def full(shape: tuple[int, ...], width: int) -> tuple[int, ...]:
    return shape if width == 1 else (*shape, width)


@pytest.mark.parametrize("name", OPERATIONS)
def test_precision_follows_the_arguments(name: str) -> None:
    """float32 in gives float32 out, float64 otherwise, also for integers, half precision and any mixture."""
    operation, widths, _ = OPERATIONS[name]
    for reals in itertools.product((np.float32, np.float64), repeat=len(widths)):
        given = [a.astype(real) for a, real in zip(values(widths), reals, strict=True)]
        assert operation(*given).dtype == (np.float32 if set(reals) == {np.float32} else np.float64)
    halves = [np.array([0.25, 0.5] if w == 2 else [0, 0, 1], np.float16) for w in widths]
    assert operation(*halves).dtype == np.float64
    assert operation(*[np.array([0, 0, 1][-w:]) * (w == 3) for w in widths]).dtype == np.float64


@pytest.mark.parametrize("name", OPERATIONS)
def test_precisions_agree(name: str) -> None:
    operation, widths, _ = OPERATIONS[name]
    single = values(widths, real=np.float32)
    np.testing.assert_allclose(operation(*single), operation(*[a.astype(float) for a in single]), rtol=3e-4, atol=1e-5)


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3), (2, 0, 3)])
def test_shapes(name: str, shape: tuple[int, ...]) -> None:
    operation, widths, width = OPERATIONS[name]
    given = values(widths, shape)
    result = operation(*given)
    assert np.shape(result) == full(shape, width)
    one_by_one = [operation(*[a[k] for a in given]) for k in np.ndindex(shape)]
    np.testing.assert_array_equal(np.asarray(result).reshape(np.shape(one_by_one)), one_by_one)


@pytest.mark.parametrize("name", [name for name, (_, widths, _) in OPERATIONS.items() if len(widths) > 1])
def test_arguments_broadcast(name: str) -> None:
    operation, widths, width = OPERATIONS[name]
    columns = [a.reshape(*(4 if j == k else 1 for j in range(len(widths))), -1) for k, a in enumerate(values(widths))]
    result = operation(*columns)
    shape = (4,) * len(widths)
    assert result.shape == full(shape, width)
    spread = [np.broadcast_to(a, (*shape, a.shape[-1])) for a in columns]
    np.testing.assert_array_equal(result, operation(*spread))


@pytest.mark.parametrize("name", OPERATIONS)
def test_arguments_are_not_touched_and_lists_will_do(name: str) -> None:
    operation, widths, _ = OPERATIONS[name]
    given = values(widths)
    kept = [a.copy() for a in given]
    result = operation(*given)
    for a, b in zip(given, kept, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(operation(*[a.tolist() for a in given]), result)


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_numbers_that_are_not_finite_are_named(name: str, wrong: float, real: type) -> None:
    operation, widths, _ = OPERATIONS[name]
    for k, argument in enumerate(NAMES[name]):
        given = values(widths, real=real)
        given[k][2, 1] = wrong
        with pytest.raises(ValueError, match=rf"{argument} must be finite, got {wrong} at index \(2, 1\)"):
            operation(*given)


@pytest.mark.parametrize("name", OPERATIONS)
def test_wrong_shapes_and_kinds_are_named(name: str) -> None:
    operation, widths, _ = OPERATIONS[name]
    for k, argument in enumerate(NAMES[name]):
        wrong: Any
        for wrong in (np.zeros((5, 4)), np.zeros(widths[k] + 1), np.zeros((3, 0)), 0.5):
            given: list[Any] = values(widths)
            given[k] = wrong
            found = r"\(" + ", ".join(map(str, np.shape(wrong)))
            with pytest.raises(ValueError, match=rf"{argument} must have shape \(..., {widths[k]}\), got shape {found}"):
                operation(*given)
        for wrong in (["a"] * widths[k], [[1, 2], [3]], {"x": 1}, np.ones(widths[k]) * 1j):
            given = values(widths)
            given[k] = wrong
            with pytest.raises(ValueError, match=rf"{argument} must be an array of numbers of shape"):
                operation(*given)


@pytest.mark.parametrize("name", [name for name, (_, widths, _) in OPERATIONS.items() if len(widths) > 1])
def test_shapes_that_do_not_broadcast(name: str) -> None:
    operation, widths, _ = OPERATIONS[name]
    given = values(widths)
    given[0] = np.concatenate([given[0], given[0][:1]])
    with pytest.raises(ValueError, match=r"broadcast.*5.*4"):
        operation(*given)


@pytest.mark.parametrize("wrong", [-1e-9, 1.0, 1.5])
def test_uniform_numbers_lie_below_one(wrong: float) -> None:
    for operation, arguments in ((NDF.sample, ()), (SMITH.sample_visible, ([0, 0, 1],)), (BRDF.sample, ([0, 0, 1],))):
        with pytest.raises(ValueError, match=rf"u must lie in \[0, 1\), got .*{wrong}"):
            operation(*arguments, [0.5, wrong])


@pytest.mark.parametrize("kind", STRETCHED)
@pytest.mark.parametrize("wrong", [0, -0.1, np.nan, np.inf, "rough", "0.3", True, np.True_, 1j, None, {}])
def test_roughness_that_is_none(kind: type, wrong: Any) -> None:
    """An alpha of 0 would divide by 0 later, in a kernel."""
    with pytest.raises(ValueError, match=r"alpha_x must be .*got") as raised:
        kind(wrong)
    assert str(wrong) in str(raised.value)
    if wrong is not None:
        with pytest.raises(ValueError, match=r"alpha_y must be .*got"):
            kind(0.3, wrong)


@pytest.mark.parametrize("kind", STRETCHED)
def test_roughness_out_of_its_limits(kind: type) -> None:
    for wrong in (1e-320, 1e-12, 1e12, 1e160):
        with pytest.raises(ValueError, match=r"alpha_x must lie between 1e-11 and 1e\+11, got"):
            kind(wrong)
        with pytest.raises(ValueError, match=r"alpha_y must lie between 1e-11 and 1e\+11, got"):
            kind(0.3, wrong)
    with pytest.raises(ValueError, match="alpha_x must be a finite number above 0, got inf"):
        kind(10**400)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("kind", STRETCHED)
def test_at_the_limits_of_roughness_all_are_numbers(kind: type, real: type) -> None:
    """From 1e-12 beside the pole to 1e-12 above the horizon; what single precision cannot hold may be infinite."""
    grid = accuracy.directions(real, np.logspace(-12, 12, 25))
    last = np.nextafter(real(1), real(0))
    u = np.array([(a, b) for a in (0, 0.3, last) for b in (0, 0.3, last)], real)
    for pair in itertools.product((*directions.ALPHA_LIMITS, 1.0), repeat=2):
        ndf = kind(*pair)
        assert np.isfinite(ndf.D(grid)).all()
        assert np.isfinite(ndf.sample(u)).all()
        assert not np.isnan(ndf.pdf(ndf.sample(u))).any()
        brdfs = [mf.Microfacet(mf.Smith(ndf)), mf.Microfacet(mf.VCavity(ndf))] if kind is not mf.Ward else []
        for brdf in brdfs:
            wi = brdf.sample(grid[:, None], u)
            assert np.isfinite(wi).all()
            for there in (wi, grid[None], (grid * np.array([-1, -1, 1], real))[None]):
                assert not np.isnan(brdf.evaluate(grid[:, None], there)).any()
                assert not np.isnan(brdf.pdf(grid[:, None], there)).any()


@pytest.mark.parametrize("kind", POWERS)
@pytest.mark.parametrize("wrong", [0, -1, np.nan, "x"])
def test_exponents_that_are_none(kind: type, wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"n must be .*got"):
        kind(wrong)


@pytest.mark.parametrize("kind", [mf.Smith, mf.VCavity, mf.Implicit, mf.Kelemen, mf.SchlickSmith])
@pytest.mark.parametrize("wrong", [0.3, None, mf.GGX])
def test_a_distribution_is_wanted(kind: type, wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"ndf must be a distribution of normals such as GGX\(0.3\), got"):
        kind(wrong)


def test_other_wrong_parameters() -> None:
    with pytest.raises(ValueError, match="correlation must be one of height, none, direction, height-direction, got 'full'"):
        mf.Smith(NDF, "full")
    with pytest.raises(ValueError, match=r"correlation must be one of height, .*, got \['height'\]"):
        mf.Smith(NDF, ["height"])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="k must be a finite number above 0, got 0"):
        mf.SchlickSmith(NDF, k=0)
    with pytest.raises(AttributeError, match="microfacet has no 'GXX'; it has BRDF, Beckmann, "):
        mf.GXX  # noqa: B018
    with pytest.raises(KeyError, match=r"no equation 'geometry.ggx.Lamda'; near: geometry.ggx.Lambda"):
        mf.equations["geometry.ggx.Lamda"]


@pytest.mark.parametrize("wrong", [np.nan, np.inf, "steep", [0.1, np.nan]])
def test_slopes_that_are_none(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"slope_x must be .*got"):
        NDF.P22(wrong, 0.0)
    with pytest.raises(ValueError, match=r"slope_y must be .*got"):
        NDF.P22(0.0, wrong)


# --- out ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_out_takes_the_result(real: type) -> None:
    wo, wi = values((3, 3), (2, 3), real)
    out = np.full((2, 3), np.nan, real)
    assert BRDF.evaluate(wo, wi, out=out) is out
    np.testing.assert_array_equal(out, BRDF.evaluate(wo, wi))
    u, normals = np.full((2, 3, 2), 0.3, real), np.full((2, 3, 3), np.nan, real)
    for sample in (SMITH.sample_visible, BRDF.sample):
        assert sample(wo, u, out=normals) is normals
        np.testing.assert_array_equal(normals, sample(wo, u))


def test_out_that_does_not_fit() -> None:
    wo, wi = values((3, 3))
    for out in (np.zeros(5), np.zeros(4, np.float32), np.zeros((4, 2))[:, 0], [0.0] * 4):
        with pytest.raises(ValueError, match=r"out must be a C-contiguous float64 array of shape \(4,\), got"):
            BRDF.evaluate(wo, wi, out=out)


# --- directions ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_directions_are_unit_vectors_to_one_tolerance(name: str, real: type) -> None:
    """What is off by rounding is taken as it is, what is farther off is refused by its name, length and place."""
    operation, widths, _ = OPERATIONS[name]
    for k, argument in enumerate(NAMES[name]):
        if argument == "u":
            continue
        for factor in (1 - 9e-6, 1 + 9e-6):
            given = values(widths, real=real)
            given[k][2] *= real(factor)
            operation(*given)
        for factor in (1 - 1.1e-5, 1 + 1.1e-5, 2.0, 1e-3):
            given = values(widths, real=real)
            given[k][2] *= real(factor)
            with pytest.raises(ValueError, match=rf"^{argument} must hold unit vectors, .* at index \(2,\): normalise it$"):
                operation(*given)


def test_cosines_have_the_tolerance_of_directions() -> None:
    np.testing.assert_array_equal(directions.cosines("cosine", [-1e-5, 0.5, 1.00001]), [0, 0.5, 1])
    for wrong in (-1.1e-5, 1.000011, np.nan):
        with pytest.raises(ValueError, match="cosine must"):
            directions.cosines("cosine", [0.5, wrong])


# --- horizon ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_below_the_horizon_the_result_is_zero(name: str, real: type) -> None:
    """Whichever of the directions it is; but normals are masked in D, not in G1, and samples may be reflected down."""
    operation, widths, _ = OPERATIONS[name]
    for k, argument in enumerate(NAMES[name]):
        if argument == "u" or (name, argument) in (("G1", "wm"), ("G2", "wm"), ("pdf", "wi")):
            continue
        for flip in ([1, 1, -1], [1, 1, 0]):
            given = values(widths, (20,), real)
            given[k] = given[k] * np.array(flip, real)
            given[k] /= np.linalg.norm(given[k], axis=-1, keepdims=True)
            np.testing.assert_array_equal(operation(*given), 0)


# --- modules ------------------------------------------------------------------------------------------------------------


def fresh(code: str) -> Any:
    """What a new interpreter prints, as JSON."""
    code = f"import sys, json, time; sys.path.insert(0, {str(LIBRARY)!r})\n{code}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_import_is_light() -> None:
    """Under a second of processor time, and none of the heavy or unrelated modules."""
    seconds, modules = fresh(
        "start = time.process_time(); import microfacet; spent = time.process_time() - start\n"
        "print(json.dumps([spent, sorted(sys.modules)]))"
    )
    assert seconds < 1
    heavy = {"matplotlib", "sympy", "numba", "scipy", "numpy", "mpmath", "cells", "jupytext", "flint"}
    assert not heavy & set(modules)
    assert [m for m in modules if m.startswith("microfacet")] == ["microfacet"]


def test_use_loads_no_drawing() -> None:
    modules = fresh(
        "import microfacet as mf; brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3)), mf.Dielectric(1.5)); mf.validate\n"
        "len(mf.equations); print(json.dumps(sorted(sys.modules)))"
    )
    assert not {"matplotlib", "report", "cells", "jupytext", "IPython"} & set(modules)


def test_every_public_name_is_there() -> None:
    promised = {
        *("Beckmann", "GGX", "Ward", "BlinnPhong", "NormalizedBlinnPhong"),
        *("Smith", "VCavity", "Implicit", "Kelemen", "SchlickSmith"),
        *("Microfacet", "Diffuse", "Dielectric", "Conductor", "Schlick", "validate", "equations"),
    }
    assert promised <= set(dir(mf))
    for name in promised:
        assert getattr(mf, name) is not None


def test_public_functions_say_what_they_do() -> None:
    for thing in (
        mf.GGX,
        mf.Smith,
        mf.Microfacet,
        mf.GGX.D,
        mf.Smith.G1,
        mf.Microfacet.evaluate,
        directions.reflect,
        mf.validate,
    ):
        assert len(thing.__doc__ or "") > 20
