"""Validation of distributions that lean, have lobes, folds or notches: right ones get seven ticks, wrong ones a cross."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import pi
from typing import Any, ClassVar

import microfacet as mf
import mpmath as mp
import numpy as np
import pytest
from hostile import Hostile, Shape, balanced, lean, leaning
from microfacet.directions import spherical
from microfacet.geometry.ggx import ggx_Lambda
from microfacet.visibility.masking import Masking

VIEWED = ("visible_area", "visible_norm", "weak_furnace")


def borrowed(w: tuple[float, float, float], p: Any) -> float:
    x, y, z = w
    return ggx_Lambda(abs(z) / (p.width1 * max((x * x + y * y) ** 0.5, 1e-300)))


class Borrowed(Hostile):
    """With the Lambda of GGX, alpha = width1, whatever its own is."""

    closed_Lambda: ClassVar[Callable[..., float] | None] = staticmethod(borrowed)


def verdicts(model: Masking) -> dict[str, str]:
    return {name: verdict.verdict for name, verdict in mf.validate(model).items()}


def assert_right(model: Masking) -> None:
    found = mf.validate(model)
    assert found.holds, str(found)


def assert_wrong(model: Masking, broken: tuple[str, ...], kept: tuple[str, ...]) -> None:
    """Which equations must fail, and which must hold; of the others nothing is said."""
    found = mf.validate(model)
    assert [name for name in broken if found[name].verdict != "fails"] == [], str(found)
    assert [name for name in kept if found[name].verdict != "holds"] == [], str(found)


RIGHT = [
    balanced(0.25, 0.9, 0.0, (0.02 * 2**0.5,) * 2),
    balanced(0.5, 0.3, 1.234, (0.001, 0.5)),
    balanced(0.001, 0.7, -2.0, (0.001, 0.5)),
    balanced(0.5, 0.01, 0.5, (0.3, 0.3), heavy=1.0),
    Shape(share=0.5, width1=0.001, width2=0.5),
    Shape(depth=0.9, fold=3.0, turn=0.3),
    Shape(depth=0.9, fold=4.0, heavy=1.0),
    Shape(depth=0.5, fold=12.0),
    Shape(notch=0.8, narrow=0.15, towards=1.0),
]


@pytest.mark.parametrize("shape", RIGHT, ids=lambda shape: repr(Hostile(shape)))
def test_right_ones_hold_under_smith(shape: Shape) -> None:
    assert_right(mf.Smith(Hostile(shape)))


@pytest.mark.parametrize(
    ("shape", "right"),
    [
        (balanced(0.5, 0.3, 1.234, (0.2, 0.2)), True),
        (balanced(0.5, 0.3, 1.234, (0.2, 0.1)), False),
        (Shape(depth=0.9, fold=4.0, turn=0.3), True),
        (Shape(depth=0.9, fold=3.0, turn=0.3), False),
        (Shape(depth=1e-4, fold=5.0), False),
        (Shape(notch=0.8, narrow=0.15, towards=1.0), True),
    ],
    ids=str,
)
def test_cavities_need_opposite_facets(shape: Shape, right: bool) -> None:
    if right:
        assert_right(mf.VCavity(Hostile(shape)))
    else:
        assert_wrong(mf.VCavity(Hostile(shape)), VIEWED, ("projected_area", "positivity", "reciprocity"))


@pytest.mark.parametrize("azimuth", [0.0, pi / 2, 0.7, -2.5])
@pytest.mark.parametrize(("distance", "heavy"), [(0.01, 0.0), (0.3, 1.0), (1.0, 0.0)])
def test_a_surface_that_leans_fails(azimuth: float, distance: float, heavy: float) -> None:
    """Its facets project to the whole surface, but not to what a viewer sees of a level one."""
    ndf = Hostile(leaning(distance, azimuth, 0.3, heavy))
    for model in (mf.Smith(ndf), mf.VCavity(ndf)):
        assert_wrong(model, VIEWED, ("projected_area", "positivity", "reciprocity"))


@pytest.mark.parametrize(
    ("factor", "verdict"), [(1 + 7e-10, "holds"), (1 - 7e-10, "holds"), (1 + 1.5e-9, "fails"), (1 - 1.5e-9, "fails")]
)
def test_the_tolerance_is_a_part_in_a_billion(factor: float, verdict: str) -> None:
    found = mf.validate(mf.VCavity(Hostile(Shape(factor=factor))))
    for name in ("projected_area", *VIEWED):
        assert found[name].verdict == verdict
        assert found[name].residual == pytest.approx(factor - 1, abs=1e-12)
        assert 1e-13 <= found[name].bound < 1e-11


@pytest.mark.parametrize("factor", [1.01, 1 - 1e-6, 1 + 1e-6])
def test_another_norm_fails(factor: float) -> None:
    for shape in (Shape(factor=factor), replace(RIGHT[0], factor=factor)):
        assert_wrong(mf.Smith(Hostile(shape)), ("projected_area", *VIEWED), ("positivity", "reciprocity"))


def test_masking_of_another_distribution_fails() -> None:
    for shape in (RIGHT[1], Shape(depth=0.3, fold=4.0, heavy=1.0), Shape(depth=1e-4, fold=5.0, heavy=1.0)):
        assert_wrong(mf.Smith(Borrowed(shape)), VIEWED, ("projected_area", "positivity", "reciprocity"))
    assert_right(mf.Smith(Borrowed(Shape(width1=0.3, heavy=1.0))))


@pytest.mark.parametrize("width", [0.1, 8e-3, 1e-4, 1e-6])
def test_masking_is_looked_at_where_a_smooth_surface_masks(width: float) -> None:
    """At 89 degrees its facets hide hardly anything, and many folds differ from none by a part in 10^11."""
    shape = Shape(width1=width, depth=0.9653, fold=14.0, turn=1.689, heavy=1.0)
    assert_wrong(mf.Smith(Borrowed(shape)), VIEWED, ("projected_area", "positivity", "reciprocity"))
    assert_right(mf.Smith(Hostile(shape)))


@pytest.mark.parametrize("narrow", [0.5, 0.1, 0.03])
def test_a_density_below_zero_fails(narrow: float) -> None:
    assert_wrong(mf.Smith(Hostile(Shape(notch=1.01, narrow=narrow, towards=0.4))), ("positivity",), ("projected_area", *VIEWED))


# --- isotropy -----------------------------------------------------------------------------------------------------------


class Declared(Hostile):
    isotropic = True


@pytest.mark.parametrize(
    "shape",
    [Shape(y1=0.01), Shape(y1=1e-6), Shape(depth=2e-7, fold=4.0), Shape(notch=0.5, narrow=0.02), Shape(depth=0.1, fold=60.0)],
    ids=repr,
)
def test_isotropy_that_is_declared_is_checked(shape: Shape) -> None:
    with pytest.raises(ValueError, match="says that it is isotropic, but its D differs by"):
        mf.validate(mf.Smith(Declared(shape)))


def test_rounding_is_no_preferred_azimuth() -> None:
    assert_right(mf.VCavity(Declared(Shape(depth=2e-8, fold=4.0))))


def test_what_is_isotropic_needs_one_azimuth_of_each_polar_angle() -> None:
    ndf = Declared(Shape(width1=0.3, heavy=1.0))
    found = mf.validate(mf.Smith(ndf))
    assert found.holds
    assert found["visible_area"].rests_on == "8 views, 8 polar angles, 8 azimuths; isotropy, declared and checked"
    other = mf.validate(mf.Smith(Hostile(ndf.shape)))["visible_area"].rests_on
    assert "no symmetry, azimuths at most 12 degrees apart" in other
    assert int(other.split()[0]) > 40


# --- Lambda of narrow lobes -------------------------------------------------------------------------------------------------


def exact_G1(shape: Shape, wo: np.ndarray) -> mp.mpf:
    """Of Gaussian lobes, at 50 digits: along the view each is a Gaussian, which hides what lies beyond cot theta_o."""
    with mp.workdps(50):
        x, y, z = map(mp.mpf, map(float, wo))
        across = mp.hypot(x, y)
        cot, hidden = z / across, mp.mpf(0)
        for share, cx, cy, width in (
            (shape.share, shape.x1, shape.y1, shape.width1),
            (1 - shape.share, shape.x2, shape.y2, shape.width2),
        ):
            mean, sigma = (x * mp.mpf(cx) + y * mp.mpf(cy)) / across - cot, mp.mpf(width) / mp.sqrt(2)
            hidden += share * (mean * mp.ncdf(mean / sigma) + sigma * mp.npdf(mean / sigma))
        return 1 / (1 + hidden / cot)


@pytest.mark.parametrize("shape", RIGHT[:3], ids=lambda shape: repr(Hostile(shape)))
def test_lambda_of_lobes_off_the_centre(shape: Shape) -> None:
    model = mf.Smith(Hostile(shape))
    for azimuth in (0.0, 0.4, 1.234, 2.0, -2.0):
        wo = spherical(np.array([1e-6, 0.1, 0.7, 0.8, 0.84, 1.2, 1.45, 1.57, pi / 2 - 1e-8]), azimuth)
        exact = [float(exact_G1(shape, view)) for view in wo]
        np.testing.assert_allclose(model.G1(wo, [0, 0, 1]), exact, rtol=1e-10)


def test_the_lobe_that_two_rules_did_not_see() -> None:
    wo = spherical(1.45, 0.0)
    model = mf.Smith(Hostile(RIGHT[0]))
    assert model.G1(wo, [0, 0, 1]) == pytest.approx(0.384088, abs=5e-7)
    assert model.G1(wo.astype(np.float32), np.array([0, 0, 1], np.float32)) == pytest.approx(0.384088, abs=2e-5)


# --- many at random -----------------------------------------------------------------------------------------------------------


def members(count: int) -> Iterator[tuple[str, Shape]]:
    """Shapes of each kind in turn."""
    draw = np.random.default_rng(1)
    for k in range(count):
        azimuth, heavy = draw.uniform(-pi, pi), float(draw.integers(2))
        wide = float(10 ** draw.uniform(-2.5, 0.3))
        kind = ("lobes", "lean", "fold", "notch", "spike")[k % 5]
        if kind == "lobes":
            other = float(wide * 10 ** draw.uniform(-1, 1))
            yield kind, balanced(draw.uniform(0.1, 0.9), wide * draw.uniform(0, 5), azimuth, (wide, other), heavy)
        elif kind == "lean":
            yield kind, leaning(float(10 ** draw.uniform(-2, 0)), azimuth, wide, heavy)
        elif kind == "fold":
            fold = float(draw.integers(2, 25))
            yield kind, Shape(width1=wide, depth=draw.uniform(0.01, 1), fold=fold, turn=azimuth, heavy=heavy)
        elif kind == "notch":
            narrow = float(10 ** draw.uniform(-1.5, 0))
            yield kind, Shape(width1=wide, notch=draw.uniform(0.1, 1), narrow=narrow, towards=azimuth, heavy=heavy)
        else:
            spike = wide * float(10 ** draw.uniform(-2.5, -1))
            yield kind, balanced(draw.uniform(0.001, 0.1), wide * draw.uniform(0.5, 2), azimuth, (spike, wide), heavy)


def judged(k: int, kind: str, shape: Shape) -> list[str]:
    """What is judged wrongly of the shape under both models, and of what is wrong about it made on purpose."""
    faults = []
    opposite = kind == "notch" or (kind == "fold" and shape.fold % 2 == 0)
    tilted = lean(shape) > 1e-12
    for model, right in ((mf.Smith(Hostile(shape)), not tilted), (mf.VCavity(Hostile(shape)), opposite)):
        found = verdicts(model)
        expected = {"projected_area": "holds", "positivity": "holds", "reciprocity": "holds"}
        expected |= dict.fromkeys(VIEWED, "holds" if right else "fails") | ({"energy": "holds"} if right else {})
        faults += [f"{model!r}: {name} {found[name]}" for name, verdict in expected.items() if found[name] != verdict]
    broken, name = made_wrong(k, shape)
    found = verdicts(broken)
    return faults if found[name] == "fails" else [*faults, f"{broken!r}: {name} {found[name]}"]


def made_wrong(k: int, shape: Shape) -> tuple[Masking, str]:
    """A wrong model of the shape, of three kinds in turn, and the equation that it breaks."""
    if k % 3 < 2:
        return mf.Smith(Hostile(replace(shape, factor=(1.01, 1 + 1e-6)[k % 3]))), "projected_area"
    return mf.Smith(Borrowed(replace(shape, heavy=1.0))), "visible_area"


@pytest.mark.slow
@pytest.mark.parametrize("part", range(6))
def test_no_false_tick_and_no_false_cross(part: int) -> None:
    faults = [fault for k, member in list(enumerate(members(150)))[part::6] for fault in judged(k, *member)]
    assert faults == []
