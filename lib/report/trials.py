"""Statements put to the test by chance: ray-traced random surfaces and random samples, each test with known odds.

What is tested here would hold exactly if nothing were random, so a result that odds of one in a million separate from the
statement refutes it. Models that are only near to such surfaces are compared with them in figures, not here.

python -m report.trials build/measured.json
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from microfacet.brdf.specular import Microfacet
from microfacet.checks import CheckResult
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.blinn_phong import NormalizedBlinnPhong
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution
from microfacet.statement import equations
from microfacet.surface.compare import normals_of
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.measure import Estimate, estimate
from microfacet.validation.chi_square import agreement
from microfacet.visibility.smith import Smith
from scipy.special import ndtr, stdtr

from report.campaign import CAMPAIGN, read
from report.datafile import put, refuse

ENTRIES = ("lobes_04", "lobes_07", "lobes_10", "stretched", "gabor_07")  # of the campaign
REFUTED = 1e-6  # odds
SAMPLES = 400_000
COMMON = 0.01  # what is rarer is not normally distributed over surfaces
ABOVE = np.array([0.0, 0.0, 1.0])
VIEWS = {degrees: spherical(np.radians(degrees), 0.6) for degrees in (30.0, 75.0, 89.0)}


class Look(NamedTuple):
    """One test: its odds if the statement holds, what was looked at, and how fine: a standard error, or a number of samples."""

    odds: float
    where: str
    error: float = 0.0


def verdict(what: str, looks: list[Look]) -> CheckResult:
    """Passed if no look, nor the worst of so many, refutes the statement."""
    worst = min(looks, key=lambda look: look.odds if look.odds > 0 else 0.0)  # what is no number is the worst
    odds = min(1.0, worst.odds * len(looks)) if worst.odds > 0 else 0.0
    error = max(look.error for look in looks)
    count = f"{len(looks)} comparisons" if len(looks) > 1 else "one comparison"
    detail = f"{what}: {count}" + (f", standard error at most {error:.1g}" if error else "")
    figures = {"count": len(looks), "odds": float(f"{odds:.3g}"), "error": float(f"{error:.3g}")}
    if not odds > REFUTED:
        return CheckResult(
            "fail", f"{detail}; refuted: chance brings one so far off with odds of {odds:.1e}, at {worst.where}", figures
        )
    return CheckResult("pass", f"{detail}; odds of one so far off by chance {odds:.2g}", figures)


# --- random surfaces ----------------------------------------------------------------------------------------------------


def off(found: Estimate, expected: float, surfaces: int) -> float:
    """The odds, by Student's distribution, that a mean over surfaces lies so far from what is expected."""
    value, error = float(found.value), float(found.error)
    if error < 1e-12:  # all surfaces show the same
        return 1.0 if abs(value - expected) < 1e-9 else 0.0
    return float(2 * stdtr(surfaces - 1, -abs(value - expected) / error))


def over_views(quantity: str, expected: Callable[[GaussianField, np.ndarray], float]) -> list[Look]:
    """A sum over the facets, per area of the plane, against what is expected of it, for all surfaces and views."""
    looks = []
    for entry in ENTRIES:
        family, views, found = CAMPAIGN[entry].family, np.asarray(CAMPAIGN[entry].plan.views), read(entry)
        for k, wo in enumerate(views):
            mean = estimate(found[quantity][:, k].sum(axis=-1))
            degrees = np.degrees(np.arccos(wo[2]))
            odds = off(mean, expected(family, wo), len(found[quantity]))
            looks.append(Look(odds, f"{entry}, theta_o = {degrees:.0f}", float(mean.error)))
    return looks


def cosine(family: GaussianField, wo: np.ndarray) -> float:
    return float(wo[2])


def turned_to(family: GaussianField, wo: np.ndarray) -> float:
    """Projected area of the facets turned to the viewer: cos theta_o (1 + Lambda), Gaussian slopes along the view."""
    ax, ay = family.facet_alpha
    x, y = wo[0] * ax, wo[1] * ay
    slope = np.sqrt(x * x + y * y + 2 * family.facet_correlation * x * y)
    if not slope > 0:
        return float(wo[2])
    along = Smith(Beckmann(float(slope / np.hypot(*wo[:2]))))
    return float(wo[2] / along.G1(spherical(np.arccos(wo[2])), ABOVE))


def slopes_seen_from_above() -> list[Look]:
    """Shares of slopes, of all surfaces together: from straight above every facet is seen for what it covers.

    Few and large parts are looked at: a small bin says little of a surface, and every look has to be paid for.
    """
    found, wanted = [], []
    for entry in ENTRIES:
        family, plan = CAMPAIGN[entry].family, CAMPAIGN[entry].plan
        for k in np.flatnonzero(np.asarray(plan.views)[:, 2] > 1 - 1e-12):
            found.append(pooled(read(entry)["normals"][:, k]))
            wanted.append(pooled(normals_of(Smith(Beckmann(*family.facet_alpha)), ABOVE, plan)[None])[0])
    means, expected = estimate(np.concatenate(found)), np.mean(wanted, axis=0)
    count = sum(map(len, found))
    return [
        Look(off(Estimate(value, error), share, count), f"share {k} of slopes", float(error))
        for k, (value, error, share) in enumerate(zip(*means, expected, strict=True))
        if share > COMMON
    ]


def pooled(shares: np.ndarray) -> np.ndarray:
    """Shares (surfaces, s, s) of slopes between -reach and reach: around 0 along either axis, and in 4 x 4 squares."""
    inside = shares[:, 1:-1, 1:-1]  # the outermost bins hold all that is beyond
    side = inside.shape[-1]
    strips = [inside.sum(axis=axis)[:, k : side - k].sum(axis=1) for axis in (1, 2) for k in range(side // 2)]
    edges = np.linspace(0, side, 5).astype(int)[:-1]
    squares = np.add.reduceat(np.add.reduceat(inside, edges, axis=1), edges, axis=2).reshape(len(shares), -1)
    return np.column_stack([*strips, squares])


# --- random samples -----------------------------------------------------------------------------------------------------


@cache
def uniform(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random((SAMPLES, 2))


def drawn(*distributions: Distribution) -> list[Look]:
    """Normals drawn regardless of the viewer, against the density of projected facets."""
    return [
        Look(agreement(ndf.sample(uniform(k)), ndf.pdf, ABOVE, ndf.slope_scale), repr(ndf))
        for k, ndf in enumerate(distributions)
    ]


def drawn_as_seen(*distributions: Distribution) -> list[Look]:
    looks = []
    for ndf in distributions:
        model = Smith(ndf)
        for k, (degrees, wo) in enumerate(VIEWS.items()):
            normals = model.sample_visible(wo, uniform(k))
            odds = agreement(normals, partial(model.D_visible, wo), wo, ndf.slope_scale)
            looks.append(Look(odds, f"{ndf!r}, theta_o = {degrees:.0f}"))
    return looks


def weighed(*distributions: Distribution, albedo: Callable[[Microfacet, np.ndarray], Any]) -> list[Look]:
    """The mean weight of light directions drawn by visible normals, against the albedo."""
    looks = []
    for ndf in distributions:
        brdf = Microfacet(Smith(ndf))
        for k, (degrees, wo) in enumerate(VIEWS.items()):
            wi = brdf.sample(wo, uniform(k))
            pdf = brdf.pdf(wo, wi)
            weight = np.where(pdf > 0, brdf.evaluate(wo, wi) * wi[:, 2] / np.where(pdf > 0, pdf, 1.0), 0.0)
            error = weight.std(ddof=1) / np.sqrt(SAMPLES)
            odds = 2 * ndtr(-abs(weight.mean() - albedo(brdf, wo)) / error)
            looks.append(Look(float(odds), f"{ndf!r}, theta_o = {degrees:.0f}", float(error)))
    return looks


def exact_albedo(brdf: Microfacet, wo: np.ndarray) -> float:
    """In closed form, for GGX of alpha = 1."""
    return float(equations["brdf.specular.anchor"].exact(float(wo[2])))


# --- by statement -------------------------------------------------------------------------------------------------------


def _weights() -> list[Look]:
    return weighed(Beckmann(0.4), GGX(0.4), GGX(0.5, 0.2), albedo=Microfacet.albedo)


SURFACES = "ray-traced surfaces"
SAMPLED = f"{SAMPLES} samples each, chi-square"
TRIALS: Mapping[str, tuple[str, Callable[[], list[Look]]]] = {
    "visibility.masking.projected_area": (SURFACES, lambda: over_views("seen", cosine)),
    "visibility.smith.seen": (SURFACES, lambda: over_views("faced", turned_to)),
    "visibility.beckmann.Lambda": (SURFACES, lambda: over_views("faced", turned_to)),
    "geometry.beckmann.P22": (SURFACES, slopes_seen_from_above),
    "geometry.beckmann.D": (SAMPLED, lambda: drawn(Beckmann(0.4), Beckmann(0.2, 0.5))),
    "geometry.ggx.D": (SAMPLED, lambda: drawn(GGX(0.4), GGX(0.5, 0.2))),
    "geometry.normalized_blinn_phong.D": (SAMPLED, lambda: drawn(NormalizedBlinnPhong(8.0))),
    "visibility.masking.D_visible": (SAMPLED, lambda: drawn_as_seen(Beckmann(0.4), GGX(0.4))),
    "anisotropy.visible_normals": (SAMPLED, lambda: drawn_as_seen(Beckmann(0.2, 0.5), GGX(0.5, 0.2))),
    "brdf.specular.weight": (f"{SAMPLES} samples each", _weights),
    "brdf.specular.anchor": (f"{SAMPLES} samples each", lambda: weighed(GGX(1.0), albedo=exact_albedo)),
}


def marks() -> Iterator[tuple[str, CheckResult]]:
    """The mark "measured" of every statement that has a trial, by its key. Reads the campaign's results."""
    for key, (what, looks) in TRIALS.items():
        yield key, verdict(what, looks())


def main(out: str) -> None:
    refuse(out)
    found: dict[str, Any] = {key: asdict(mark) for key, mark in marks()}
    put(out, json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
