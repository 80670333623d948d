"""The proofs of the two tables hold, agree with quadrature, and go red when anything in them is broken."""

import math

import microfacet as mf
import numpy as np
import pytest
import sympy as sp
from microfacet.directions import spherical
from microfacet.statements import ball_functions, balls, checks, enclosures
from microfacet.statements.notation import alpha, mu_o, n
from microfacet.statements.statement import equations
from microfacet.validation import kelemen, physical, slopes_along_view, unnormalized, unphysical
from microfacet.validation.equations import residual

pytest.importorskip("flint")
KEYS = [key for key in equations if equations[key].enclosed]
SLIGHTLY = sp.Rational(1000001, 1000000)


@pytest.fixture(autouse=True)
def forgotten():
    """No compiled closed form outlives a test that changes it."""
    yield
    for cached in (slopes_along_view.ball_function, slopes_along_view._integral, slopes_along_view.compiled_form):
        cached.cache_clear()


@pytest.mark.parametrize("key", [key for key in KEYS if callable(equations[key].enclosed)])
def test_enclosed(key):
    mark = checks.enclosed(equations[key])
    assert mark.status == "pass", mark.detail
    assert equations[key].relation != "=" or mark.measured["radius"] < 1e-25


def breaking(monkeypatch, key, part="equals", factor=SLIGHTLY):
    """Change one part of a statement in place."""
    statement = equations[key]
    changed = getattr(statement, part) * factor
    monkeypatch.setitem(statement.__dict__, part, changed)
    for cached in (slopes_along_view.ball_function, slopes_along_view._integral, slopes_along_view.compiled_form):
        cached.cache_clear()


SMITH = "validation.table2.smith_"


@pytest.mark.parametrize(
    ("changed", "red"),
    [
        ("geometry.ggx.Lambda", SMITH + "ggx"),
        ("geometry.beckmann.Lambda", SMITH + "beckmann"),
        ("geometry.blinn_phong.Lambda", SMITH + "normalized_blinn_phong"),
        ("geometry.blinn_phong.H", SMITH + "normalized_blinn_phong"),
        ("geometry.ggx.Lambda", "visibility.masking.projected_area"),
        ("geometry.ggx.P22", "geometry.ggx.projected_area"),
        ("geometry.beckmann.P22", "geometry.beckmann.projected_area"),
        ("geometry.ward.projected_area", "geometry.ward.projected_area"),
        ("geometry.blinn_phong.projected_area", "geometry.blinn_phong.projected_area"),
        ("validation.table1.blinn_phong", "validation.table1.blinn_phong"),
        ("validation.table2.implicit_ggx", "validation.table2.implicit_ggx"),
        ("validation.table2.schlick_smith_ggx", "validation.table2.schlick_smith_ggx"),
        ("validation.table2.schlick_smith_halved_ggx", "validation.table2.schlick_smith_halved_ggx"),
    ],
)
def test_a_closed_form_off_by_a_millionth_is_red(monkeypatch, changed, red):
    breaking(monkeypatch, changed)
    assert checks.enclosed(equations[red]).status == "fail"


@pytest.mark.parametrize("family", ["BECKMANN", "GGX", "STUDENT"])
@pytest.mark.parametrize("part", ["level", "tilted"])
def test_a_broken_substitution_is_red(monkeypatch, family, part):
    from dataclasses import replace

    slopes = getattr(slopes_along_view, family)
    wrong = replace(slopes, **{part: -getattr(slopes, part)})
    assert not all(map(checks.vanishes, wrong.steps()))
    with balls.precision(160):
        shape, angle = balls.ball(slopes.shapes[-2]), balls.ball(40)
        assert not physical.smith_residual(wrong, shape, angle).contains(0)


@pytest.mark.parametrize("key", [k for k in KEYS if equations[k].relation in "<>"])
def test_the_opposite_inequality_is_red(monkeypatch, key):
    statement = equations[key]
    monkeypatch.setitem(statement.__dict__, "relation", "<" if statement.relation == ">" else ">")
    assert checks.enclosed(statement).status == "fail"


def test_a_box_that_holds_a_solution_is_red():
    def right_at_a_third(x):
        return x - balls.ball(1) / 3

    assert not enclosures.over(right_at_a_third, x=(0, 1)).supports("<")
    assert enclosures.over(right_at_a_third, x=(0.34, 1)).supports(">")
    assert enclosures.over(right_at_a_third, x=(0.34, 1)).supports(r"\ne")


def test_a_wide_ball_around_0_proves_nothing():
    with balls.precision(64):
        assert not enclosures.Enclosure("", balls.between(-1e-20, 1e-20)).supports("=")
        assert enclosures.Enclosure("", balls.between(-1e-30, 1e-30)).supports("=")
        assert not enclosures.Enclosure("", balls.ball(1) / 0).supports("=")
        assert not enclosures.Enclosure("", balls.ball(1e-30)).supports("=")


@pytest.mark.slow
def test_crosses_agree_with_quadrature():
    """What the tables prove is what the kernels compute: Implicit and Schlick-Smith over GGX, Kelemen over both."""
    wo = spherical(np.radians([20.0, 70.0]))
    for rough in (0.3, 0.8):
        ndf = mf.GGX(rough)
        named = {"implicit_ggx": mf.Implicit(ndf), "schlick_smith_halved_ggx": mf.SchlickSmith(ndf, rough / 2)}
        for name, model in named.items():
            computed = residual(model, "visible_area", wo)[0]
            stated = equations[f"validation.table2.{name}"].equals
            values = [ball_functions.exact(stated, (alpha, mu_o))(rough, mu) for mu in wo[:, 2]]
            np.testing.assert_allclose(computed, [float(v) for v in values], atol=1e-11)
    for seen, ndf in ((kelemen.beckmann_visible_area, mf.Beckmann(0.4)), (kelemen.ggx_visible_area, mf.GGX(0.4))):
        computed = residual(mf.Kelemen(ndf), "visible_area", wo)[0] + 1
        with balls.precision(80):
            exact = [float(seen(balls.ball(0.4), balls.ball(z / math.sqrt(1 - z * z) / 0.4))) for z in wo[:, 2]]
        np.testing.assert_allclose(computed, exact, rtol=1e-7)


def test_exact_cases():
    """Blinn-Phong passes at one exponent; Schlick-Smith with k = alpha/2 is Smith over GGX at alpha = 1, and only there."""
    assert sp.solve(unnormalized.phong.equals.doit(), n) == [2 * sp.pi - 2]
    halved = unphysical.halved_ggx.equals.doit()
    assert halved.subs(alpha, 1) == 0
    assert sp.simplify(halved.subs({alpha: sp.Rational(1, 2), mu_o: sp.Rational(1, 2)})) != 0
    for key in ("implicit_ggx", "schlick_smith_ggx", "schlick_smith_halved_ggx"):
        assert equations[f"validation.table2.{key}"].equals.doit().subs(mu_o, 1) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Implicit", "Schlick-Smith"])
def test_beyond_what_is_proved_there_is_an_exception(name):
    """Above the largest alpha, the closed form has a second zero: the bound is not a matter of caution."""
    statement, largest = {
        "Implicit": (unphysical.implicit_ggx, unphysical.IMPLICIT_UP_TO),
        "Schlick-Smith": (unphysical.schlick_ggx, unphysical.SCHLICK_UP_TO),
    }[name]
    closed = statement.equals.doit().subs(unphysical.k, alpha * unphysical.SCHLICK_K)
    shapes = [closed.subs(alpha, share * largest) for share in (0.999, 1.001)]
    signs = [{bool(shape.subs(mu_o, sp.Rational(k, 1000)).evalf() < 0) for k in range(1, 1000)} for shape in shapes]
    assert signs == [{True}, {True, False}]
