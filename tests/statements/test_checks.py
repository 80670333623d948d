"""A check counts only if it can fail: break a statement in one place, and a named kind of check goes red."""

import math
from contextlib import ExitStack
from dataclasses import dataclass, field, fields
from math import sqrt

import microfacet as mf
import mpmath
import numpy as np
import pytest
import sympy as sp
from microfacet.statements import checks, enclosures
from microfacet.statements.checks import CheckResult, check, numeric, symbolic, vanishes
from microfacet.statements.fingerprints import content, fingerprint
from microfacet.statements.registry import registry, stating
from microfacet.statements.statement import Equation, equations

x, theta = sp.symbols("x theta", positive=True)
SLIGHTLY = sp.Rational(1000001, 1000000)


STATED = dict(equations)


@pytest.fixture
def broken():
    """A statement with some of its parts changed takes the original's place while a test runs."""
    with ExitStack() as stack:

        def change(key, **changes):
            stack.enter_context(registry.without(key))
            parts = {f.name: getattr(STATED[key], f.name) for f in fields(Equation) if f.init}
            return Equation(**(parts | changes))

        yield change


CLOSED = [
    "geometry.ggx.P2",
    "geometry.beckmann.P2",
    "geometry.ggx.area",
    "geometry.ggx.Lambda",
    "geometry.beckmann.Lambda",
    "visibility.smith.G1",
    "visibility.smith.heights",
    "visibility.shadowing.separable",
    "visibility.shadowing.height",
    "material.fresnel.dielectric",
]


@pytest.mark.parametrize("key", CLOSED)
def test_a_broken_closed_form_is_red(broken, key):
    original = STATED[key]
    marks = check(broken(key, equals=original.equals * SLIGHTLY)).marks
    assert {"fail"} & {marks["symbolic"].status, marks["numeric"].status}, marks


@pytest.mark.parametrize("key", ["geometry.ggx.Lambda", "geometry.beckmann.Lambda", "geometry.ggx.D", "geometry.ggx.area"])
def test_a_broken_rewrite_is_red(broken, key):
    mark = numeric(broken(key, computed_as=STATED[key].computed_as * SLIGHTLY, computed_by=None))
    assert mark.status == "fail"
    assert "computed_as" in mark.detail or "ulps" in mark.detail


@pytest.mark.parametrize("key", ["geometry.ggx.Lambda", "geometry.ggx.P2", "visibility.shadowing.height"])
@pytest.mark.parametrize("factor", [-1, SLIGHTLY])
def test_a_broken_definition_is_red(broken, key, factor):
    changed = broken(key, means=STATED[key].means * factor, proof=None)
    assert symbolic(changed).status == "fail"


@pytest.mark.parametrize("key", ["geometry.ggx.Lambda", "geometry.ggx.P2", "geometry.beckmann.Lambda"])
def test_a_broken_definition_is_not_enclosed(broken, key):
    pytest.importorskip("flint")
    assert checks.enclosed(broken(key, means=STATED[key].means * SLIGHTLY)).status == "fail"


def test_a_broken_kernel_is_red(broken):
    original = STATED["material.fresnel.dielectric"]

    def dielectric(c: float, eta: float) -> float:
        contrast = (eta - 1.0) * (eta + 1.0)
        g = sqrt(contrast + c * c)
        r = (g - c) / (g + c)
        s = (c * (g + c) - 1.0) / (c * (g - c) + 1.0)
        return 0.5 * r * r * (1.0 + s * s) * 1.000001

    mark = numeric(broken(original.key, computed_by=dielectric))
    assert mark.status == "fail"
    assert "float64 kernel off by" in mark.detail


def test_a_generated_kernel_that_loses_digits_is_red(broken):
    mark = numeric(broken("geometry.ggx.Lambda", computed_as=None))
    assert mark.status == "fail"
    assert mark.measured["float64"]["ulps"] > 1e6


def test_a_proof_that_does_not_close_is_red(broken):
    mark = symbolic(broken("visibility.v_cavity.G1", proof=lambda: [x - x, sp.sin(x) - x]))
    assert mark.status == "fail"
    assert "step 2" in mark.detail


# --- the tools ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "zero",
    [
        sp.sin(theta) ** 2 + sp.cos(theta) ** 2 - 1,
        1 / sp.cos(theta) ** 2 - sp.tan(theta) ** 2 - 1,
        sp.sqrt(x**2) - x,
        sp.erf(x) + sp.erfc(x) - 1,
    ],
    ids=str,
)
def test_vanishes_proves(zero):
    assert vanishes(zero)


@pytest.mark.parametrize("other", [sp.sin(theta) ** 2 - sp.cos(theta) ** 2, sp.tan(theta) - theta, x - SLIGHTLY * x], ids=str)
def test_vanishes_refuses(other):
    assert not vanishes(other)


def test_ulps():
    assert checks.ulps(1.0, mpmath.mpf(1), np.float64) == 0
    assert checks.ulps(1 + 2**-52, mpmath.mpf(1), np.float64) == 1
    assert checks.ulps(1 + 2**-23, mpmath.mpf(1), np.float32) == 1
    assert checks.ulps(math.nan, mpmath.mpf(1), np.float64) == math.inf
    assert checks.ulps(1e-300, mpmath.mpf(0), np.float64) == math.inf


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_sampled_arguments_keep_to_the_domain_and_reach_its_ends(real):
    for key in ("geometry.ggx.Lambda", "geometry.ggx.P22"):
        points = checks.sample(STATED[key], real)
        assert points.shape == (checks.POINTS, len(STATED[key].arguments))
        for column, (low, high) in zip(points.T, STATED[key].over.values(), strict=True):
            assert low <= column.min() <= low + 1e-6 * abs(low)
            assert high - 1e-6 * abs(high) <= column.max() <= high


@pytest.mark.parametrize("kind", ["hemisphere", "sphere"])
def test_sampled_directions_crowd_at_the_pole_and_at_the_horizon(kind):
    """A kernel breaks there first. Of the whole sphere a third lies below; of a hemisphere nothing does."""
    theta = checks._angle(np.random.default_rng(1).random(3000), kind)
    below = theta > math.pi / 2
    assert np.mean(below) == pytest.approx(1 / 3 if kind == "sphere" else 0, abs=1e-3)
    tilt = np.minimum(theta, math.pi - theta)
    near, far = tilt[tilt < math.pi / 4 + 1e-12], math.pi / 2 - tilt[tilt > math.pi / 4]
    assert min(len(near), len(far)) > 1000
    assert 1e-9 * math.pi / 4 <= near.min() < 2e-9
    assert checks.GRAZING * (1 - 1e-8) <= far.min() < 1.5 * checks.GRAZING
    assert math.degrees(checks.GRAZING) == pytest.approx(1e-6)
    for distance, decades in ((near, 9), (far, -math.log10(checks.GRAZING))):  # as many in one decade as in another
        steep = np.log10(distance)
        share = [np.mean((steep > -d - 1) & (steep <= -d)) for d in range(1, 7)]
        np.testing.assert_allclose(share, 1 / decades, atol=0.04)


def test_shares_of_an_interval_are_taken_by_magnitude_if_it_spans_more_than_two_decades():
    half = np.array([0.0, 0.5, 1.0])
    np.testing.assert_allclose(checks._interval((0.01, 100), half), [0.01, 1, 100], rtol=1e-14)
    for low, high in ((-1, 3), (0, 1e6), (1, 99)):
        np.testing.assert_allclose(checks._interval((low, high), half), [low, (low + high) / 2, high], rtol=1e-14)


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_what_rounding_takes_over_an_end_steps_back(real):
    ends = (0.1, 0.3)
    values = checks._clip(np.array([0.1, 0.2, 0.3], real), ends, real)
    assert (values >= 0.1).all()
    assert (values <= 0.3).all()
    np.testing.assert_allclose(values, [0.1, 0.2, 0.3], rtol=3 * np.finfo(real).eps)


def test_forms_that_are_not_one_number_are_told_apart_from_those_that_are(broken):
    key = "geometry.ggx.Lambda"
    assert checks.forms_disagree(STATED[key]) == ""
    said = checks.forms_disagree(broken(key, equals=STATED[key].equals * (1 + sp.Rational(1, 10**28))))
    assert said.startswith("equals differs from computed_as by ")
    assert checks.forms_disagree(broken(key, equals=STATED[key].equals * (1 + sp.Rational(1, 10**32)))) == ""
    assert checks.forms_disagree(broken(key, equals=STATED[key].equals * 2, relation="<")) == ""


def test_printed_symbols_are_tried_well_inside_their_domains():
    equation = STATED["geometry.ggx.D"]
    (w,) = [argument for argument in equation.over if not isinstance(argument, sp.Symbol)]
    symbols = [w.theta, w.phi, *w.components, x]
    more = checks._printed_points(equation, symbols)
    points = np.array([list(map(float, next(more))) for _ in range(400)])
    for column, (low, high) in zip(points.T, [(0.01, 1.56), (0, 6.28), *3 * [(0.05, 0.95)], (0.05, 1.5)], strict=True):
        assert low <= column.min() < low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) < column.max() <= high


def test_what_a_precision_holds():
    assert checks.representable(mpmath.mpf(0), np.float32)
    for real, tiny, greatest in ((np.float64, -1022, 1024), (np.float32, -126, 128)):
        assert checks.representable(mpmath.mpf(2) ** tiny, real)
        assert not checks.representable(mpmath.mpf(2) ** tiny * 0.99, real)
        assert checks.representable(-(mpmath.mpf(2) ** (greatest - 1)), real)
        assert not checks.representable(mpmath.mpf(2) ** greatest, real)


def test_figures_of_enclosures_are_the_widest_and_the_ends_of_all():
    arb = pytest.importorskip("flint").arb

    def one(middle, radius, where):
        return enclosures.Enclosure(where, arb(middle, radius))

    away = [one(0.5, 0.125, "a"), one(-2.0, 0.25, "b"), one(1.5, 0.0625, "c")]
    figures = checks._enclosed_figures(away)
    assert (figures["at"], figures["count"]) == ("b", 3)
    assert figures["radius"] == pytest.approx(0.25, rel=1e-6)
    assert figures["low"] == pytest.approx(-2.25, rel=1e-6)
    assert figures["high"] == pytest.approx(1.5625, rel=1e-6)
    assert "low" not in checks._enclosed_figures([*away, one(0.0, 1e-30, "d")])


def test_record_says_what_failed_and_where():
    record = checks.StatementRecord("a.b", {"numeric": CheckResult("fail", "off by 9 ulps")}, "microfacet.a, line 3").as_json()
    assert record["verdict"] == "fail"
    assert record["message"] == "a.b (microfacet.a, line 3): numeric: off by 9 ulps"


def test_fingerprint_follows_what_the_check_depends_on(broken):
    key = "geometry.ggx.Lambda"
    whole = STATED[key]
    kept = fingerprint(broken(key))
    assert fingerprint(broken(key, title="another")) == kept
    assert fingerprint(broken(key, equals=whole.equals * 2)) != kept
    assert fingerprint(broken(key, within=(9.0, 9.0))) != kept


@dataclass
class Held:
    used: object = field(default=None)


def test_content_follows_nested_functions_modules_and_records():
    def outer():
        return lambda: [checks.GRAZING]

    assert any(str(checks.GRAZING) in line for line in content(outer, set()))
    assert any("1.25" in line for line in content(Held([1.25, Held(x)]), set()))


def slightly_off(kernel):
    def off(w, p):
        return kernel(w, p) * 1.00001

    return off


@pytest.mark.parametrize(("key", "kernel"), [("geometry.ggx.D", "kernel"), ("geometry.beckmann.Lambda", "closed_Lambda")])
def test_a_family_whose_kernel_is_not_its_statement_is_red(key, kernel, monkeypatch):
    """The kernel of a class takes other arguments than the statement's own, so it is another function."""
    equation = equations[key]
    ((kind, role),) = stating(equation)
    kept = fingerprint(equation)
    monkeypatch.setattr(kind, kernel, staticmethod(slightly_off(getattr(kind, kernel))))
    assert f"the kernel of {role} of {kind.__name__} is off by" in numeric(equation).detail
    assert numeric(equation).status == "fail"
    assert fingerprint(equation) != kept


def test_every_family_that_states_its_D_is_compared_with_it():
    families = {kind.__name__ for key in equations for kind, role in stating(equations[key]) if role == "D"}
    assert families >= {"GGX", "Beckmann", "Ward", "BlinnPhong", "NormalizedBlinnPhong"}


def test_scope_of_a_proof_is_the_definition_or_only_a_rewriting():
    definition = checks.symbolic(mf.equations["visibility.smith.heights"])
    rewriting = checks.symbolic(mf.equations["geometry.ggx.P22"])
    assert (definition.measured["scope"], rewriting.measured["scope"]) == ("definition", "rewriting")


def test_scope_of_an_enclosure_is_a_range_only_if_all_of_it_is():
    pytest.importorskip("flint")
    ranges, points = (
        checks.enclosed(mf.equations[key]) for key in ("validation.table2.implicit_beckmann", "geometry.ggx.area_at_one")
    )
    assert (ranges.measured["scope"], points.measured["scope"]) == ("range", "points")
    assert checks._common_scope(["range", "points"]) == "points"
    assert checks._common_scope(["range", "range"]) == "range"
