"""The rules in slopes: twelve digits for sharp and for broad lobes, up to grazing, whatever lies across the view."""

from __future__ import annotations

from math import pi

import microfacet as mf
import numpy as np
import pytest
from microfacet.geometry.roughness import SlopeScale
from microfacet.validation.equations import residual, residuals
from microfacet.visibility import quadrature
from microfacet.visibility.masking import Masking, ModelParameters, dot
from microfacet.visibility.smith import quadrature_Lambda, radial_Lambda
from samples import views
from skewed import SKEWED

ROUGH = (1e-3, 0.03, 0.4, 1.0, 2.0)
ANGLES = (0, 0.01, 1, 5, 30, 60, 85, 89, 89.9)
TWELVE, TEN = 1e-12, 1e-10
MODELS = [
    *(kind(make(alpha)) for kind in (mf.Smith, mf.VCavity) for make in (mf.GGX, mf.Beckmann) for alpha in ROUGH),
    *(kind(make(0.01, 1.5)) for kind in (mf.Smith, mf.VCavity) for make in (mf.GGX, mf.Beckmann)),
]


@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_twelve_digits(model: Masking) -> None:
    """Beyond the edge of the tails, at it, and within; both the value and the bound."""
    for name, (values, bounds) in residuals(model, views(*ANGLES)).items():
        assert np.abs(values).max() < TWELVE, name
        assert bounds.max() < TEN, name
        assert (np.abs(values) <= bounds).all(), name


@pytest.mark.parametrize("model", [mf.Smith(mf.Ward(0.05, 0.6)), mf.Smith(mf.Ward(0.4)), mf.Smith(SKEWED)], ids=repr)
def test_other_densities_go_on_to_more_nodes(model: Masking) -> None:
    """What is seen, over the cosine, less what there is: 0 by Lambda's own integral, which takes no closed form either."""
    area = residual(model, "visible_area", views(*ANGLES))
    whole = residual(model, "projected_area", views(0))[0][0]
    away = 1 / model.G1(views(*ANGLES), views(*ANGLES)) - 1  # Ward's facets fall short of the surface; Lambda is what they hide
    np.testing.assert_allclose(area[0], whole / (1 + away), atol=3e-12)
    assert area[1].max() < TEN


@pytest.mark.parametrize("make", [mf.GGX, mf.Beckmann])
def test_the_first_two_rules_suffice_for_the_two(make: type[mf.GGX]) -> None:
    """If a third one were needed, all would still be right, but slow."""
    exponential, ndf = make is mf.Beckmann, make(0.4, 0.1)
    first = quadrature.FIRST_EXPONENTIAL if exponential else quadrature.FIRST_POWER
    for wo in views(30, 60, 89):
        asked: list[float] = []

        def area(Lambda_o, wo, wm, p, asked=asked):
            asked.append(wm[2])
            return dot(wo, wm) * make.kernel(wm, p)

        integrate = quadrature.integrate_adaptively(area)
        integrate(0, exponential, 0.0, quadrature.AGREED, 0.0, tuple(wo), SlopeScale(*ndf.slope_scale), ndf.parameters)
        assert len(asked) in {panels * sum(along * across for along, across in first[:2]) for panels in (1, 2)}


@pytest.mark.parametrize(("make", "exponential"), [(mf.GGX, False), (mf.Beckmann, True), (mf.Ward, True)])
@pytest.mark.parametrize("scale", [(1e-3, 1e-3), (0.05, 2.0)])
def test_tails_are_told_apart(make: type[mf.GGX], exponential: bool, scale: tuple[float, float]) -> None:
    ndf = make(*scale)
    assert quadrature.has_exponential_tails(make.kernel)(SlopeScale(*ndf.slope_scale), ndf.parameters) is exponential


def test_rules_are_exact_for_what_they_are_made_for() -> None:
    x, w = quadrature.periodic(3)
    assert np.sum(w / (1 + x * x) ** 2) == pytest.approx(pi / 2, rel=1e-15)
    x, w = quadrature.hermite(3)
    assert np.sum(w * x**4 * np.exp(-x * x)) == pytest.approx(0.75 * pi**0.5, rel=1e-14)
    for count in quadrature.LEVELS[2:]:
        x, w = quadrature.equal_steps(count)
        assert np.sum(w * np.exp(-x * x)) == pytest.approx(pi**0.5, rel=1e-12)
    reach = [quadrature.equal_steps(count)[0].max() for count in quadrature.LEVELS]
    assert (np.diff(reach) > 0).all()


def test_each_rule_has_one_turn_in_either_order() -> None:
    count = quadrature.RULE_COUNT
    for order in (quadrature.SCHEDULE[:count], quadrature.SCHEDULE[count:]):
        assert sorted(order) == list(range(count))


def test_lambda_of_a_sharp_lobe_by_rings() -> None:
    """From near the pole the rings that are hidden are far out, a thousand times its roughness."""
    ndf = mf.GGX(1e-3)
    for wo in views(0.5, 5, 60, 89.9):
        exact = mf.equations["geometry.ggx.Lambda"].exact(wo[2] / np.hypot(*wo[:2]) / 1e-3)
        for rule in (radial_Lambda, quadrature_Lambda):
            found = rule(mf.GGX.kernel)(tuple(wo), ModelParameters(ndf.parameters, SlopeScale(*ndf.slope_scale)))
            assert found == pytest.approx(float(exact), rel=1e-12)
