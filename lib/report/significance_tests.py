"""Significance tests of statements, on ray-traced random surfaces and on random samples.

What is tested here would hold exactly if nothing were random, so a p-value below one in a million refutes the statement.
Models that are only near to such surfaces are compared with them in figures, not here.

python -m report.significance_tests build/measured.json
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from microfacet.brdf.microfacet import Microfacet
from microfacet.confidence import Estimate
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.blinn_phong import NormalizedBlinnPhong
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution
from microfacet.statements.checks import CheckResult
from microfacet.statements.statement import equations
from microfacet.surface.compare import normals_of
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.measure import estimate
from microfacet.validation.chi_square import p_value
from microfacet.visibility.smith import Smith
from scipy.special import ndtr, stdtr

from report.campaign import CAMPAIGN, read
from report.datafile import put, refuse

ENTRIES = ("lobes_04", "lobes_07", "lobes_10", "stretched", "gabor_07")  # of the campaign
REFUTED = 1e-6  # the p-value, after Bonferroni's correction, below which a statement is refuted
SAMPLES = 400_000
LEAST_FRACTION = 0.01  # a rarer bin is not normally distributed over surfaces
ABOVE = np.array([0.0, 0.0, 1.0])
VIEWS = {degrees: spherical(np.radians(degrees), 0.6) for degrees in (30.0, 75.0, 89.0)}


class SignificanceTest(NamedTuple):
    """One test: its p-value, what was compared, and the standard error, if there is one."""

    odds: float
    where: str
    error: float = 0.0


def verdict(what: str, tests: list[SignificanceTest]) -> CheckResult:
    """Passed if the smallest p-value, times the number of tests, does not refute the statement."""
    worst = min(tests, key=lambda test: test.odds if test.odds > 0 else 0.0)  # NaN counts as the worst
    odds = min(1.0, worst.odds * len(tests)) if worst.odds > 0 else 0.0
    error = max(test.error for test in tests)
    count = f"{len(tests)} comparisons" if len(tests) > 1 else "one comparison"
    detail = f"{what}: {count}" + (f", standard error at most {error:.1g}" if error else "")
    figures = {"count": len(tests), "odds": float(f"{odds:.3g}"), "error": float(f"{error:.3g}")}
    if not odds > REFUTED:
        return CheckResult(
            "fail", f"{detail}; refuted: chance brings one so far off with odds of {odds:.1e}, at {worst.where}", figures
        )
    return CheckResult("pass", f"{detail}; odds of one so far off by chance {odds:.2g}", figures)


# --- random surfaces ----------------------------------------------------------------------------------------------------


def p_value_of_mean(estimated: Estimate, expected: float, surfaces: int) -> float:
    """The p-value, by Student's t-test, of a mean over surfaces against the expected value."""
    value, error = float(estimated.value), float(estimated.error)
    if error < 1e-12:  # all surfaces have the same value
        return 1.0 if abs(value - expected) < 1e-9 else 0.0
    return float(2 * stdtr(surfaces - 1, -abs(value - expected) / error))


def over_views(quantity: str, expected: Callable[[GaussianField, np.ndarray], float]) -> list[SignificanceTest]:
    """A sum over the facets, per area of the plane, against its expected value, for all surfaces and views."""
    tests = []
    for entry in ENTRIES:
        family, views, measured = CAMPAIGN[entry].family, np.asarray(CAMPAIGN[entry].plan.views), read(entry)
        for k, wo in enumerate(views):
            mean = estimate(measured[quantity][:, k].sum(axis=-1))
            degrees = np.degrees(np.arccos(wo[2]))
            odds = p_value_of_mean(mean, expected(family, wo), len(measured[quantity]))
            tests.append(SignificanceTest(odds, f"{entry}, theta_o = {degrees:.0f}", float(mean.error)))
    return tests


def cosine(family: GaussianField, wo: np.ndarray) -> float:
    return float(wo[2])


def front_facing_area(family: GaussianField, wo: np.ndarray) -> float:
    """Projected area of the facets that face the viewer: cos theta_o (1 + Lambda), Gaussian slopes along the view."""
    ax, ay = family.facet_alpha
    x, y = wo[0] * ax, wo[1] * ay
    slope = np.sqrt(x * x + y * y + 2 * family.facet_correlation * x * y)
    if not slope > 0:
        return float(wo[2])
    along = Smith(Beckmann(float(slope / np.hypot(*wo[:2]))))
    return float(wo[2] / along.G1(spherical(np.arccos(wo[2])), ABOVE))


def slopes_visible_from_above() -> list[SignificanceTest]:
    """Fractions of slopes, of all surfaces together: from straight above every facet is visible with its projected area.

    The bins are few and large: a small one says little of a surface, and every further test weakens all others.
    """
    measured, expected_fractions = [], []
    for entry in ENTRIES:
        family, plan = CAMPAIGN[entry].family, CAMPAIGN[entry].plan
        for k in np.flatnonzero(np.asarray(plan.views)[:, 2] > 1 - 1e-12):
            measured.append(pooled(read(entry)["normals"][:, k]))
            expected_fractions.append(pooled(normals_of(Smith(Beckmann(*family.facet_alpha)), ABOVE, plan)[None])[0])
    means, expected = estimate(np.concatenate(measured)), np.mean(expected_fractions, axis=0)
    count = sum(map(len, measured))
    return [
        SignificanceTest(p_value_of_mean(Estimate(value, error), fraction, count), f"share {k} of slopes", float(error))
        for k, (value, error, fraction) in enumerate(zip(*means, expected, strict=True))
        if fraction > LEAST_FRACTION
    ]


def pooled(fractions: np.ndarray) -> np.ndarray:
    """Fractions (surfaces, s, s) of slopes between -reach and reach: around 0 along either axis, and in 4 x 4 squares."""
    inside = fractions[:, 1:-1, 1:-1]  # the outermost bins also hold everything beyond them
    side = inside.shape[-1]
    strips = [inside.sum(axis=axis)[:, k : side - k].sum(axis=1) for axis in (1, 2) for k in range(side // 2)]
    edges = np.linspace(0, side, 5).astype(int)[:-1]
    squares = np.add.reduceat(np.add.reduceat(inside, edges, axis=1), edges, axis=2).reshape(len(fractions), -1)
    return np.column_stack([*strips, squares])


# --- random samples -----------------------------------------------------------------------------------------------------


@cache
def uniform(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random((SAMPLES, 2))


def sampled_by_area(*distributions: Distribution) -> list[SignificanceTest]:
    """Normals sampled regardless of the viewer, against the density of projected facets."""
    return [
        SignificanceTest(p_value(ndf.sample(uniform(k)), ndf.pdf, ABOVE, ndf.slope_scale), repr(ndf))
        for k, ndf in enumerate(distributions)
    ]


def sampled_by_view(*distributions: Distribution) -> list[SignificanceTest]:
    tests = []
    for ndf in distributions:
        model = Smith(ndf)
        for k, (degrees, wo) in enumerate(VIEWS.items()):
            normals = model.sample_visible(wo, uniform(k))
            odds = p_value(normals, partial(model.D_visible, wo), wo, ndf.slope_scale)
            tests.append(SignificanceTest(odds, f"{ndf!r}, theta_o = {degrees:.0f}"))
    return tests


def mean_weights(*distributions: Distribution, albedo: Callable[[Microfacet, np.ndarray], Any]) -> list[SignificanceTest]:
    """The mean weight of light directions sampled by visible normals, against the albedo."""
    tests = []
    for ndf in distributions:
        brdf = Microfacet(Smith(ndf))
        for k, (degrees, wo) in enumerate(VIEWS.items()):
            wi = brdf.sample(wo, uniform(k))
            pdf = brdf.pdf(wo, wi)
            weight = np.where(pdf > 0, brdf.evaluate(wo, wi) * wi[:, 2] / np.where(pdf > 0, pdf, 1.0), 0.0)
            error = weight.std(ddof=1) / np.sqrt(SAMPLES)
            odds = 2 * ndtr(-abs(weight.mean() - albedo(brdf, wo)) / error)
            tests.append(SignificanceTest(float(odds), f"{ndf!r}, theta_o = {degrees:.0f}", float(error)))
    return tests


def exact_albedo(brdf: Microfacet, wo: np.ndarray) -> float:
    """In closed form, for GGX of alpha = 1."""
    return float(equations["brdf.microfacet.anchor"].exact(float(wo[2])))


# --- by statement -------------------------------------------------------------------------------------------------------


def _weights() -> list[SignificanceTest]:
    return mean_weights(Beckmann(0.4), GGX(0.4), GGX(0.5, 0.2), albedo=Microfacet.albedo)


SURFACES = "ray-traced surfaces"
SAMPLED = f"{SAMPLES} samples each, chi-square"
TESTS: Mapping[str, tuple[str, Callable[[], list[SignificanceTest]]]] = {
    "visibility.masking.projected_area": (SURFACES, lambda: over_views("seen", cosine)),
    "visibility.smith.seen": (SURFACES, lambda: over_views("faced", front_facing_area)),
    "geometry.beckmann.Lambda": (SURFACES, lambda: over_views("faced", front_facing_area)),
    "geometry.beckmann.P22": (SURFACES, slopes_visible_from_above),
    "geometry.beckmann.D": (SAMPLED, lambda: sampled_by_area(Beckmann(0.4), Beckmann(0.2, 0.5))),
    "geometry.ggx.D": (SAMPLED, lambda: sampled_by_area(GGX(0.4), GGX(0.5, 0.2))),
    "geometry.normalized_blinn_phong.D": (SAMPLED, lambda: sampled_by_area(NormalizedBlinnPhong(8.0))),
    "visibility.masking.D_visible": (SAMPLED, lambda: sampled_by_view(Beckmann(0.4), GGX(0.4))),
    "visibility.stretching.visible_normals": (SAMPLED, lambda: sampled_by_view(Beckmann(0.2, 0.5), GGX(0.5, 0.2))),
    "brdf.microfacet.weight": (f"{SAMPLES} samples each", _weights),
    "brdf.microfacet.anchor": (f"{SAMPLES} samples each", lambda: mean_weights(GGX(1.0), albedo=exact_albedo)),
}


def marks() -> Iterator[tuple[str, CheckResult]]:
    """The mark "measured" of every statement that has a significance test, by its key. Reads the campaign's results."""
    for key, (what, tests) in TESTS.items():
        yield key, verdict(what, tests())


def main(out: str) -> None:
    refuse(out)
    results: dict[str, Any] = {key: asdict(mark) for key, mark in marks()}
    put(out, json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
