"""A check counts only if it can fail: break a statement in one place, and a named kind of check goes red."""

import math
from dataclasses import dataclass, field, fields
from math import sqrt

import mpmath
import numpy as np
import pytest
import sympy as sp
from microfacet import checks, statement
from microfacet.checks import Mark, check, numeric, symbolic, vanishes
from microfacet.statement import Equation, equations

x, theta = sp.symbols("x theta", positive=True)
SLIGHTLY = sp.Rational(1000001, 1000000)


STATED = dict(equations)


@pytest.fixture
def broken(monkeypatch):
    """A statement with some of its parts changed takes the original's place while a test runs."""

    def change(key, **changes):
        monkeypatch.setattr(statement, "_registry", {k: e for k, e in STATED.items() if k != key})
        monkeypatch.setattr(statement, "_abbreviations", dict(statement._abbreviations))
        parts = {f.name: getattr(STATED[key], f.name) for f in fields(Equation) if f.init}
        return Equation(**(parts | changes))

    return change


CLOSED = [
    "geometry.ggx.P2",
    "geometry.beckmann.P2",
    "geometry.ggx.area",
    "visibility.ggx.Lambda",
    "visibility.beckmann.Lambda",
    "visibility.smith.G1",
    "visibility.smith.heights",
    "brdf.shadowing.separable",
    "brdf.shadowing.height",
    "material.fresnel.dielectric",
]


@pytest.mark.parametrize("key", CLOSED)
def test_a_broken_closed_form_is_red(broken, key):
    original = STATED[key]
    marks = check(broken(key, equals=original.equals * SLIGHTLY)).marks
    assert {"fail"} & {marks["symbolic"].status, marks["numeric"].status}, marks


@pytest.mark.parametrize("key", ["visibility.ggx.Lambda", "visibility.beckmann.Lambda", "geometry.ggx.D", "geometry.ggx.area"])
def test_a_broken_rewrite_is_red(broken, key):
    mark = numeric(broken(key, computed_as=STATED[key].computed_as * SLIGHTLY, computed_by=None))
    assert mark.status == "fail"
    assert "computed_as" in mark.detail or "ulps" in mark.detail


@pytest.mark.parametrize("key", ["visibility.ggx.Lambda", "geometry.ggx.P2", "brdf.shadowing.height"])
@pytest.mark.parametrize("factor", [-1, SLIGHTLY])
def test_a_broken_definition_is_red(broken, key, factor):
    changed = broken(key, means=STATED[key].means * factor, proof=None)
    assert symbolic(changed).status == "fail"


@pytest.mark.parametrize("key", ["visibility.ggx.Lambda", "geometry.ggx.P2", "visibility.beckmann.Lambda"])
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
    mark = numeric(broken("visibility.ggx.Lambda", computed_as=None))
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
    for key in ("visibility.ggx.Lambda", "geometry.ggx.P22"):
        points = checks.sample(STATED[key], real)
        assert points.shape == (checks.POINTS, len(STATED[key].arguments))
        for column, (low, high) in zip(points.T, STATED[key].over.values(), strict=True):
            assert low <= column.min() <= low + 1e-6 * abs(low)
            assert high - 1e-6 * abs(high) <= column.max() <= high


def test_record_says_what_failed_and_where():
    record = checks.Record("a.b", {"numeric": Mark("fail", "off by 9 ulps")}, "microfacet.a, line 3").as_json()
    assert record["verdict"] == "fail"
    assert record["message"] == "a.b (microfacet.a, line 3): numeric: off by 9 ulps"


def test_fingerprint_follows_what_the_check_depends_on(broken):
    key = "visibility.ggx.Lambda"
    whole = STATED[key]
    kept = broken(key).fingerprint
    assert broken(key, title="another").fingerprint == kept
    assert broken(key, equals=whole.equals * 2).fingerprint != kept
    assert broken(key, within=(9.0, 9.0)).fingerprint != kept


@dataclass
class Held:
    used: object = field(default=None)


def test_content_follows_nested_functions_modules_and_records():
    def outer():
        return lambda: [checks.GRAZING]

    assert any(str(checks.GRAZING) in line for line in statement._content(outer, set()))
    assert any("1.25" in line for line in statement._content(Held([1.25, Held(x)]), set()))
