"""The validation equations: right models pass, wrong ones fail by the amount that is known, and each equation can fail."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, ClassVar, NamedTuple

import microfacet as mf
import numpy as np
import pytest
from around import turned_to
from microfacet.validation import equations
from microfacet.validation.equations import THETA, TITLES, Validation, decide, default_views, residual, residuals
from microfacet.visibility.masking import Masking
from samples import views
from skewed import SKEWED

INTEGRALS = ("projected_area", "visible_area", "visible_norm", "weak_furnace")
CLASSIC = ("positivity", "reciprocity", "energy")
SEEN = views(0, 30, 60, 80, 89)
BECKMANN = mf.Beckmann(0.4)
WRONG = {
    mf.Implicit(BECKMANN): (1, 0.8660, 0.5019, 0.2189, 0.1218),
    mf.Kelemen(BECKMANN): (1.0747, 1.0747, 1.0491, 0.7808, 0.5629),
    mf.SchlickSmith(BECKMANN): (1, 0.9530, 0.7609, 0.5004, 0.3678),
}


@cache
def verdicts(model: Masking) -> Validation:
    return mf.validate(model, SEEN)


@pytest.mark.parametrize("model", [mf.Smith(mf.GGX(0.4, 0.2)), mf.VCavity(BECKMANN)], ids=repr)
def test_physical_models_hold(model: Masking) -> None:
    found = mf.validate(model)
    assert tuple(found) == INTEGRALS + CLASSIC
    assert found.holds, str(found)
    for name in INTEGRALS:
        assert abs(found[name].residual) + found[name].bound < 1e-9
        assert found[name].title == TITLES[name]


@pytest.mark.parametrize(("model", "printed"), WRONG.items(), ids=repr)
def test_wrong_models_miss_the_visible_area_by_the_table(model: Masking, printed: tuple[float, ...]) -> None:
    for name in INTEGRALS[1:]:
        values, bounds = residual(model, name, SEEN)
        np.testing.assert_allclose(values + 1, printed, atol=5.1e-5)
        assert (bounds < 1e-9).all()
        assert verdicts(model)[name].verdict == "fails"
        assert verdicts(model)[name].residual == values[np.argmax(np.abs(values))]
    assert not verdicts(model).holds


@pytest.mark.parametrize("model", WRONG, ids=repr)
def test_the_classic_equations_do_not_notice(model: Masking) -> None:
    assert {verdicts(model)[name].verdict for name in ("positivity", "reciprocity")} == {"holds"}
    if not isinstance(model, mf.Kelemen):
        assert verdicts(model)["energy"].verdict == "holds"
    assert verdicts(model)["projected_area"].verdict == "holds"


@pytest.mark.parametrize("model", [mf.Implicit(BECKMANN), mf.VCavity(BECKMANN), mf.Smith(mf.GGX(0.5, 0.2))], ids=repr)
def test_residuals_by_a_rule_on_the_sphere(model: Masking) -> None:
    values, _ = residual(model, "visible_area", SEEN)
    for wo, value in zip(SEEN, values, strict=True):
        seen = turned_to(wo, 96)
        m = seen.directions
        there = seen.sum(model.G1(wo, m) * (m @ wo) * model.ndf.D(m)) / wo[2] - 1
        assert value == pytest.approx(there, abs=5e-4 if isinstance(model, mf.VCavity) else 1e-8)


@pytest.mark.slow
def test_without_opposite_facets_cavities_fail_and_smith_holds() -> None:
    """The distribution itself is right: its facets project to the whole surface."""
    tilted = np.vstack([views(30, 60, 85, azimuth=0), views(60, azimuth=120), views(60, azimuth=180)])
    cavities, smith = residuals(mf.VCavity(SKEWED), tilted), residuals(mf.Smith(SKEWED), tilted)
    for values, bounds in [cavities["projected_area"], *smith.values()]:
        assert (np.abs(values) + bounds < 1e-9).all()
    for name in INTEGRALS[1:]:
        values, bounds = cavities[name]
        assert np.abs(values).max() > 0.01
        assert bounds.max() < 1e-9


@pytest.mark.parametrize(
    ("ndf", "printed"),
    [(mf.Ward(0.1), 0.980577), (mf.Ward(0.5), 0.698470), (mf.Ward(1.0), 0.403653), (mf.BlinnPhong(8.0), np.pi / 5)],
    ids=repr,
)
def test_distributions_without_norm(ndf: mf.Ward, printed: float) -> None:
    values, bounds = residual(mf.VCavity(ndf), "projected_area", SEEN[:1])
    assert values[0] + 1 == pytest.approx(printed, abs=6e-7)
    assert bounds[0] < 1e-9


def test_blinn_phong_passes_at_one_exponent_only() -> None:
    for n, right in ((2 * np.pi - 2, True), (4.0, False), (5.0, False)):
        values, _ = residual(mf.VCavity(mf.BlinnPhong(n)), "projected_area", SEEN[:1])
        assert bool(abs(values[0]) < 1e-9) is right


# --- each of the classic equations can fail -----------------------------------------------------------------------------


def any_G1(Lambda_o: float, om: float, wo: Any, wm: Any, p: Any) -> float:
    return 1.0


def any_G2(Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Any, wi: Any, wm: Any, p: Any) -> float:
    return p.model.constant + p.model.slope * wo[2]


class Line(NamedTuple):
    constant: float
    slope: float


class Arbitrary(Masking):
    """G2 = constant + slope cos theta_o: no model of anything."""

    G1_kernel: ClassVar[Callable[..., float]] = staticmethod(any_G1)
    G2_kernel: ClassVar[Callable[..., float]] = staticmethod(any_G2)

    def __init__(self, constant: float, slope: float) -> None:
        super().__init__(mf.GGX(0.5), Line(constant, slope))


@pytest.mark.parametrize(
    ("constant", "slope", "broken"),
    [(-0.1, 0.0, {"positivity"}), (0.1, 0.3, {"reciprocity"}), (1.0, 0.0, {"energy"}), (0.1, 1e-6, {"reciprocity"})],
)
def test_each_classic_equation_can_fail(constant: float, slope: float, broken: set[str]) -> None:
    found = mf.validate(Arbitrary(constant, slope), views(30, 80))
    assert {name for name in CLASSIC if found[name].verdict == "fails"} == broken


# --- verdicts -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "bound", "verdict"),
    [
        (2e-9, 5e-10, "fails"),
        (1.4e-9, 5e-10, "undecided"),
        (6e-10, 5e-10, "undecided"),
        (4e-10, 5e-10, "holds"),
        (0, 2e-9, "undecided"),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_a_verdict_counts_the_bound_on_either_side(value: float, bound: float, verdict: str, sign: int) -> None:
    assert decide(np.array([0.0, sign * value]), np.array([0.0, bound]), 1e-9) == verdict


def test_of_pairs_only_rounding_is_allowed_for() -> None:
    found = verdicts(mf.VCavity(BECKMANN))
    assert (found["positivity"].bound, found["reciprocity"].bound) == (1e-13, 1e-13)


def test_views_may_be_off_by_the_rounding_of_single_precision() -> None:
    exact, off = ([0.6 * (1 + e), 0, 0.8 * (1 + e)] for e in (0, 9e-6))
    there, here = (mf.validate(mf.VCavity(BECKMANN), view)["energy"].residual for view in (exact, off))
    assert here == pytest.approx(there, rel=1e-12)


def test_default_views_look_from_many_azimuths_unless_isotropy_is_declared() -> None:
    one, many = default_views(mf.GGX(0.3)), default_views(mf.GGX(0.3, 0.1))
    assert len(one) == len(THETA)
    azimuths = np.sort(np.unique(np.round(np.degrees(np.arctan2(many[:, 1], many[:, 0])) % 360, 6)))
    assert len(azimuths) > 40
    assert np.diff([*azimuths, azimuths[0] + 360]).max() < 12.5
    for found in (one, many):
        assert set(np.round(np.degrees(np.arccos(found[:, 2])))) == {0, 15, 30, 45, 60, 75, 85, 89}


def test_lobes_that_lean_are_looked_at_along_across_and_against() -> None:
    """From 60 and 85 degrees, after all other views; normals of the skewed surface lean towards two azimuths at most."""
    leaning = equations._leaning(SKEWED.panels)
    x, y = SKEWED.panels.moments[:, 1:].sum(axis=0)
    assert abs(np.angle(np.exp(1j * (leaning[0] - np.arctan2(-y, -x))))) < np.pi / 4
    assert len(leaning) == equations.LOBES == 2
    assert abs(np.angle(np.exp(1j * (leaning[0] - leaning[1])))) > np.pi / 6
    many = default_views(SKEWED)[-12:]
    wanted = {(t, round(np.degrees(a + turn) % 360, 4)) for a in leaning for t in (60, 85) for turn in (0, np.pi / 2, np.pi)}
    found = {(round(np.degrees(np.arccos(z))), round(np.degrees(np.arctan2(y, x)) % 360, 4)) for x, y, z in many}
    assert found == wanted


@pytest.mark.parametrize("alpha", [1e-8, 1e-3, 0.01])
def test_default_views_reach_down_to_where_facets_mask_each_other(alpha: float) -> None:
    model = mf.Smith(mf.GGX(alpha))
    assert 0.1 < model.G1(default_views(model.ndf), [0, 0, 1]).min() < 0.6


def test_a_bound_above_the_tolerance_decides_nothing() -> None:
    found = mf.validate(mf.Smith(mf.GGX(0.4, 0.2)), SEEN, tolerance=1e-16)
    assert found["visible_area"].verdict == "undecided"
    assert found["visible_area"].needs.startswith("a tolerance of ")
    assert mf.validate(mf.Smith(mf.GGX(0.4, 0.2)), SEEN)["visible_area"].needs == ""
    assert not found.holds


def test_single_precision_views_are_taken_in_double() -> None:
    views = np.array([[0.6, 0, 0.8], [0.1, 0.2, 0.9746794]], np.float32)
    found = mf.validate(mf.Smith(mf.GGX(0.3)), views)
    assert found.holds
    assert max(verdict.bound for name, verdict in found.items() if name != "energy") < 1e-10


def test_verdict_says_where() -> None:
    found = verdicts(next(iter(WRONG)))
    assert found["visible_area"].where == "theta_o = 89, phi_o = 35"
    assert found["projected_area"].where == ""
    assert "theta_i" in found["reciprocity"].where
    assert str(found).splitlines()[0] == "Implicit(Beckmann(0.4, 0.4))"
    lines = str(found).splitlines()
    assert len(lines) == 1 + len(found) + 4
    assert lines[8].startswith("projected_area: D at ")
    viewed = "visible_area, visible_norm, weak_furnace"
    assert lines[9] == f"{viewed}: 5 views, 5 polar angles, 2 azimuths; isotropy, declared and checked"
    assert lines[10] == "positivity, reciprocity: 20100 pairs of 201 directions"
    assert lines[11].startswith("energy: 5 views")
    assert lines[11].endswith("; albedos by quadrature")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((mf.GGX(0.3),), r"model must be a model of masking such as Smith\(GGX\(0.3\)\), got GGX\(0.3, 0.3\)"),
        ((mf.VCavity(BECKMANN), [[0, 0.6, -0.8]]), "wo must lie above the horizon, got z = -0.8"),
        ((mf.VCavity(BECKMANN), [0.6, 0.8]), r"wo must have shape \(..., 3\), got shape \(2,\)"),
        ((mf.VCavity(BECKMANN), None, 0.0), "tolerance must be a finite number above 0, got 0.0"),
        ((mf.VCavity(BECKMANN), None, np.nan), "tolerance must be a finite number above 0, got nan"),
        ((mf.VCavity(BECKMANN), None, np.inf), "tolerance must be a finite number above 0, got inf"),
        ((mf.VCavity(BECKMANN), None, "x"), "tolerance must be a number above 0, got 'x'"),
        ((mf.VCavity(BECKMANN), np.zeros((0, 3))), r"wo must hold at least one direction, got shape \(0, 3\)"),
        ((mf.VCavity(BECKMANN), [1.2, 0, 1.6]), "wo must hold unit vectors, got one of length 2: normalise it"),
    ],
)
def test_wrong_arguments(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mf.validate(*arguments)
