"""The choice of the cheapest model within a tolerance of the most complete one.

Sources: heitz2016 (the random walk), turquin2019 and kulla2017 (energy put back), heitz2014 (all else).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microfacet.brdf.specular import Microfacet
from microfacet.confidence import ODDS
from microfacet.directions import one_of, positive, whole
from microfacet.enough import cost
from microfacet.enough.candidates import Candidate, candidates_for
from microfacet.enough.lobes import Array, Reference, Ruled, binned, lobe_of, nodes, surface, walked
from microfacet.enough.scene import PRECISIONS, Point, Scene
from microfacet.visibility.smith import Smith

MEASURES = {
    "albedo": "the share of light that is reflected",
    "lobe": "the share of the reflected light that goes elsewhere",
    "picture": "the mean relative error of spheres under a sky with a sun",
}
SUN, SKY = (0.6, 0.64, 0.48), (0.3, 0.7, 5.0, 20.0)  # direction of the sun; ground, sky, sun, its concentration
RING_AZIMUTHS = 12  # points along each ring of the sphere
SURFACES, WALKS = 8, 1 << 16


class Error(NamedTuple):
    """A candidate's error, and a bound on the uncertainty of that."""

    value: float
    bound: float


# --- measures -------------------------------------------------------------------------------------------------------------


def albedo_error(lobe: Ruled, truth: Reference) -> Error:
    """Absolute difference of the two albedos."""
    return Error(abs(float(lobe.lobe.sum() - truth.lobe.sum())), float(lobe.error(truth.once).sum()) + _light_error(truth))


def lobe_error(lobe: Ruled, truth: Reference) -> Error:
    """Half the sum of all differences, over the total light, which is itself uncertain."""
    light = float(truth.lobe.sum())
    light_bound = _light_error(truth) + float(truth.once.error().sum())
    off = 0.5 * float(abs(lobe.lobe - truth.lobe).sum())
    bound = truth.misplaced() + 0.5 * float(lobe.error(truth.once).sum())
    return quotient(off, bound, light, light_bound)


def quotient(above: float, above_bound: float, below: float, below_bound: float) -> Error:
    """A quotient of two numbers that are known within bounds; its bound is infinite where the denominator may be 0."""
    if not below > below_bound:
        return Error(0.0, math.inf)
    value = above / below
    return Error(value, (above + above_bound) / (below - below_bound) - value)


def _light_error(truth: Reference) -> float:
    return float(truth.bound(lambda lobes: lobes.sum(axis=(1, 2))))


def sky(w: Array) -> Array:
    """Radiance from the directions w (..., 3), y up: a sky brighter than the ground, and one broad sun."""
    ground, above, sun, narrow = SKY
    light: Array = ground + above * (1 + w[..., 1]) / 2 + sun * np.exp(narrow * (w @ np.array(SUN) / np.linalg.norm(SUN) - 1))
    return light


def _light(point: Point, scene: Scene) -> Array:
    """Mean radiance in each bin for each point of a ring of the sphere, (RING_AZIMUTHS, ROWS, COLUMNS)."""
    rule = nodes(point)
    weight = rule.weight * Microfacet(Smith(point.ndf(scene.normals))).evaluate(point.wo, rule.wi)
    total = np.maximum(binned(weight), 1e-300)
    theta, phi = math.radians(point.theta), math.radians(point.phi)
    global_wi = rule.wi @ np.array([[math.cos(phi), -math.sin(phi), 0], [math.sin(phi), math.cos(phi), 0], [0, 0, 1]])
    return np.array(
        [
            binned(weight * sky(global_wi @ _axes(theta, azimuth))) / total
            for azimuth in 2 * math.pi * np.arange(RING_AZIMUTHS) / RING_AZIMUTHS
        ]
    )


def _radiance_under(light: Array) -> Callable[[Array], Array]:
    """Radiance that lobes (n, ...) send to the viewer from each point of a ring, (n, RING_AZIMUTHS)."""

    def radiance(lobes: Array) -> Array:
        total: Array = np.einsum("tij,nij->nt", light, lobes)
        return total

    return radiance


def _axes(theta: float, azimuth: float) -> Array:
    """Local axes, one a row, at a point of a sphere viewed from +z: towards the view, across it, the normal."""
    c, s = math.cos(azimuth), math.sin(azimuth)
    towards = [-math.cos(theta) * c, -math.cos(theta) * s, math.sin(theta)]
    return np.array([towards, [s, -c, 0], [math.sin(theta) * c, math.sin(theta) * s, math.cos(theta)]])


class Measured(NamedTuple):
    """A candidate's error at the worst of all points, and the lower and upper bound of the largest error."""

    error: Error
    least: float
    most: float


# --- comparison -----------------------------------------------------------------------------------------------------------


class Comparison:
    """All candidates for a scene compared with the most complete model, at every point of the scene.

    surfaces: number of ray-traced surfaces, for Gaussian slopes; walks: number of walks through Smith's model, for GGX.
    points: by default the scene's.
    """

    def __init__(
        self, scene: Scene, surfaces: int = SURFACES, walks: int = WALKS, points: tuple[Point, ...] | None = None
    ) -> None:
        self.scene, self.surfaces, self.walks = scene, whole("surfaces", surfaces, 2), whole("walks", walks, 2)
        self.points = scene.points if points is None else points
        self._lobes: dict[Candidate, list[Ruled]] = {}

    @cached_property
    def candidates(self) -> list[Candidate]:
        return candidates_for(self.scene)

    @cached_property
    def truth(self) -> list[Reference]:
        """The most complete model there is, one lobe for each point."""
        if self.scene.normals == "beckmann":
            return [surface(self.scene, point, self.surfaces) for point in self.points]
        return [walked(self.scene, point, self.walks) for point in self.points]

    def lobes(self, one: Candidate) -> list[Ruled]:
        if one not in self._lobes:
            self._lobes[one] = [one.lobe(self.scene, point, self.walks) for point in self.points]
        return self._lobes[one]

    def measured(self, one: Candidate, measure: str) -> Measured:
        """The error of a candidate over all points."""
        if measure == "picture":
            return self._worst([self._picture(one, group) for group in self._rings()])
        of = {"albedo": albedo_error, "lobe": lobe_error}[measure]
        return self._worst([of(lobe, truth) for lobe, truth in zip(self.lobes(one), self.truth, strict=True)])

    def _worst(self, errors: list[Error]) -> Measured:
        worst = max(errors, key=lambda error: error.value + error.bound)
        least = max(max(error.value - error.bound, 0.0) for error in errors)
        return Measured(worst, least, worst.value + worst.bound)

    def _rings(self) -> list[list[int]]:
        """The points that make up one sphere: of one roughness and one azimuth."""
        groups: dict[tuple[float, ...], list[int]] = {}
        for at, point in enumerate(self.points):
            groups.setdefault((point.alpha_x, point.alpha_y, point.phi), []).append(at)
        return list(groups.values())

    @cached_property
    def _skies(self) -> list[Array]:
        return [_light(point, self.scene) for point in self.points]

    def _picture(self, one: Candidate, ring: list[int]) -> Error:
        """Mean over a sphere of the relative error of radiance, every ring weighted by its area in the picture."""
        theta = np.radians([self.points[at].theta for at in ring])
        area = np.sin(2 * theta) if len(ring) > 1 else np.ones(1)
        off, noise = np.zeros(len(ring)), np.zeros(len(ring))
        for k, at in enumerate(ring):
            light, truth, lobe = self._skies[at], self.truth[at], self.lobes(one)[at]
            expected, sent = (np.einsum("tij,ij->t", light, sums) for sums in (truth.lobe, lobe.lobe))
            scatter, rule, once = (
                truth.bound(_radiance_under(light)),
                *(np.einsum("tij,ij->t", light, sums) for sums in (lobe.error(truth.once), truth.once.error())),
            )
            errors = [
                quotient(*numbers)
                for numbers in zip(abs(sent - expected), scatter + rule, expected, scatter + once, strict=True)
            ]
            off[k], noise[k] = np.mean(errors, axis=0)
        return Error(float(area @ off / area.sum()), float(area @ noise / area.sum()))


# --- the choice -----------------------------------------------------------------------------------------------------------


class Row(NamedTuple):
    """A candidate, its error, its nanoseconds a value (NaN if unknown), and whether it is `within`, `beyond` or `open`."""

    candidate: Candidate
    measured: Measured
    cost: float
    verdict: str


@dataclass(frozen=True)
class Choice:
    """Choice of a model, and the candidates it was made from.

    Attributes
    ----------
    scene : Scene
        The scene.
    tolerance : float
        The largest error.
    measure : str
        What the error is of.
    rows : tuple of Row
        All candidates, the cheapest first.
    reference : str
        The model that errors are relative to.
    sampler : str
        How to draw directions for the chosen model, and what that costs.
    beyond : Error or None
        Error of the reference itself relative to ray-traced surfaces of Gaussian slopes, by the same measure, if known.
    samplers : dict
        Nanoseconds and mean square weight of each sampler.
    """

    scene: Scene
    tolerance: float
    measure: str
    rows: tuple[Row, ...]
    reference: str
    sampler: str = ""
    beyond: Error | None = None
    samplers: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def chosen(self) -> Row | None:
        """The cheapest candidate that is within the tolerance, or None."""
        return next((row for row in self.rows if row.verdict == "within"), None)

    @property
    def failed(self) -> Row | None:
        """The best of the candidates that are cheaper than the chosen one; None if the cheapest is chosen.

        It is beyond the tolerance, or not known to be within it.
        """
        at = next((k for k, row in enumerate(self.rows) if row.verdict == "within"), len(self.rows))
        return min(self.rows[:at], key=lambda row: row.measured.most, default=None)

    def summary(self) -> str:
        """The choice in sentences."""
        lines = [f"{self.scene}; tolerance {self.tolerance:g} on {self.measure} ({MEASURES[self.measure]})."]
        if self.chosen:
            lines.append(f"Enough: {self.chosen.candidate.label}: {_numbers(self.chosen)}.")
            lines += [f"Sampler: {self.sampler}."] if self.sampler else []
            lines.append(
                f"Next cheaper, {_VERDICT_LABELS[self.failed.verdict]}: {self.failed.candidate.label}: {_numbers(self.failed)}."
                if self.failed
                else "No candidate is cheaper."
            )
        else:
            best = min(self.rows, key=lambda row: row.measured.most)
            lines.append(
                f"None of the candidates is known to be enough. The nearest: {best.candidate.label}: {_numbers(best)}."
            )
        if undecided := self._undecided():
            of = f"{undecided}{' cheaper' * bool(self.chosen)} candidate{'s' * (undecided > 1)}"
            more = "surfaces" if self.scene.normals == "beckmann" else "walks"
            lines.append(f"Undecided of {of}: more {more} would tell.")
        lines.append(f"Errors are relative to {self.reference}; each is within its bound but for odds of {ODDS:g}.")
        if self.beyond:
            far = f"{self.beyond.value:.2g} ± {self.beyond.bound:.1g}"
            lines.append(f"For Gaussian slopes of the largest roughness that model itself is {far} from ray-traced surfaces.")
        return "\n".join(lines)

    def _undecided(self) -> int:
        """The number of undecided candidates among those cheaper than the chosen one, or among all if none is chosen."""
        before = takewhile(lambda row: row.verdict != "within", self.rows)
        return sum(row.verdict == "open" for row in before)

    def table(self) -> str:
        """All candidates, the cheapest first, in Markdown."""
        head = ["", "model", "error", "±", "ns", "verdict"]
        lines = [head, [":--", ":--", "--:", "--:", "--:", ":--"]]
        for row in self.rows:
            sign = {"within": "✓", "beyond": "✗", "open": "?"}[row.verdict]
            error = row.measured.error
            mark = "→" if row is self.chosen else ""
            lines.append(
                [
                    mark,
                    row.candidate.label,
                    f"{error.value:.2e}",
                    f"{error.bound:.0e}",
                    _cost(row.cost),
                    f"{sign} {row.verdict}",
                ]
            )
        return "\n".join("| " + " | ".join(line) + " |" for line in lines)

    def data(self) -> dict[str, NDArray[Any]]:
        """The data of the chart, one entry per candidate, the cheapest first."""
        return {
            "words": np.array([row.candidate.label for row in self.rows]),
            "cost": np.array([row.cost for row in self.rows]),
            "error": np.array([row.measured.error.value for row in self.rows]),
            "bound": np.array([row.measured.error.bound for row in self.rows]),
            "verdict": np.array([row.verdict for row in self.rows]),
            "compensation": np.array([row.candidate.compensation for row in self.rows]),
            "single": np.array([row.candidate.single for row in self.rows]),
            "chosen": np.array([row is self.chosen for row in self.rows]),
            "tolerance": np.array(self.tolerance),
            "measure": np.array(self.measure),
        }

    def chart(self, path: str | Path) -> None:
        """Draw cost against error, with the tolerance and the front, as .svg, .pdf or .png; ValueError without matplotlib."""
        from microfacet.enough.chart import save

        save(self.data(), Path(path))


_VERDICT_LABELS = {"beyond": "and not enough", "open": "and not known to be enough"}


def _cost(nanoseconds: float) -> str:
    return f"{nanoseconds:.1f}" if math.isfinite(nanoseconds) else "not measured"


def _time(nanoseconds: float) -> str:
    return f"{nanoseconds:.1f} ns" if math.isfinite(nanoseconds) else "not timed"


def _numbers(row: Row) -> str:
    error = row.measured.error
    cost_ = f"{_cost(row.cost)} ns a value" if math.isfinite(row.cost) else "cost not measured"
    return f"error {error.value:.2g} ± {error.bound:.1g}, {cost_}"


def choose(
    alpha: Any,
    theta: Any = (0.0, 80.0),
    tolerance: float = 1e-3,
    *,
    measure: str = "albedo",
    costs: cost.Costs | None = None,
    surfaces: int = SURFACES,
    walks: int = WALKS,
    **more: Any,
) -> Choice:
    """Choose the cheapest model that stays within a tolerance of the most complete one, for all of a scene.

    The most complete model has the exact reflectance at each bounce, and all bounces unless the scene asks for one: for
    Gaussian slopes it is ray-traced surfaces; for GGX, which no surface is known to have, Smith's random walk.

    Parameters
    ----------
    alpha : float or pair of float
        Roughness of the scene, dimensionless, or its range.
    theta : float or pair of float, optional
        Range of the polar angle of the view, degrees.
    tolerance : float, optional
        Largest error, above 0, of what ``measure`` names.
    measure : {"albedo", "lobe", "picture"}, optional
        The fraction of light that is reflected; the fraction of the reflected light that goes elsewhere; or the mean
        relative error of spheres under a sky.
    costs : mapping of str to float, optional
        Nanoseconds by name; by default times taken now.
    surfaces : int, optional
        Number of ray-traced surfaces, at least 2.
    walks : int, optional
        Number of random walks for each point, at least 2.
    **more : object
        ``ratio``, ``light``, ``normals``, ``fresnel``, ``bounces`` and ``precision`` of a `Scene`.

    Returns
    -------
    Choice
        All candidates with error, cost and verdict, and the one that is chosen. A candidate is undecided where the bound on
        its error is too large for a verdict; a bound fails with probability 1e-5.

    Raises
    ------
    ValueError
        For a scene, tolerance, measure, costs or numbers that are outside their ranges.

    References
    ----------
    heitz2014; heitz2016.

    Examples
    --------
    It takes some seconds; the costs given here make it repeatable.

    >>> import microfacet as mf
    >>> choice = mf.choose(0.1, (0, 60), 0.05, costs={}, walks=256)
    >>> choice.chosen.verdict
    'within'
    """
    tolerance = positive("tolerance", tolerance)
    one_of("measure", measure, MEASURES)
    if not (costs is None or isinstance(costs, Mapping)):
        raise ValueError(f"costs must be None or nanoseconds by name, got {costs!r}")
    comparison = Comparison(Scene(alpha, theta, **more), surfaces, walks)
    return choice(comparison, measure, tolerance, costs_now(comparison) if costs is None else costs, beyond=True)


def costs_now(comparison: Comparison) -> cost.Costs:
    """Times of all candidates and samplers, taken now."""
    material = comparison.scene.material
    wanted = {cost.name_of(one, material): one for one in comparison.candidates}
    calls = [(name, cost.evaluation(one, material, cost.COUNT)) for name, one in wanted.items()]
    samplers = [(name, cost.sampling(*form, cost.COUNT)) for name, form in _samplers(comparison.scene).items()]
    return cost.timed([*calls, *samplers])


def _samplers(scene: Scene) -> dict[str, tuple[str, str, type]]:
    """The samplers for a scene, by name."""
    kinds = dict.fromkeys(one.normals for one in candidates_for(scene))
    reals = PRECISIONS[scene.precision]
    ways = [(s, kind) for s in cost.SAMPLERS for kind in kinds if s in cost.samplers_of(kind)]
    return {cost.sampler_name(s, kind, real): (s, kind, real) for s, kind in ways for real in reals}


def cheapest_first(scene: Scene, costs: cost.Costs) -> list[tuple[Candidate, float]]:
    """All candidates and their costs; those of unknown cost (NaN) come last, in their own order, the crudest first."""
    priced = [(one, costs.get(cost.name_of(one, scene.material), math.nan)) for one in candidates_for(scene)]
    return sorted(priced, key=lambda pair: pair[1] if math.isfinite(pair[1]) else math.inf)


def choice(comparison: Comparison, measure: str, tolerance: float, costs: cost.Costs, beyond: bool = False) -> Choice:
    """The choice from measured candidates."""
    rows = []
    for one, time in cheapest_first(comparison.scene, costs):
        measured = comparison.measured(one, measure)
        verdict = "within" if measured.most <= tolerance else "beyond" if measured.least > tolerance else "open"
        rows.append(Row(one, measured, time, verdict))
    made = Choice(comparison.scene, tolerance, measure, tuple(rows), comparison.truth[0].label)
    if made.chosen:
        one = made.chosen.candidate
        samplers = {name: sampler(comparison, one, name, costs) for name in cost.samplers_of(one.normals)}
        made = replace(made, sampler=sampler_label(samplers), samplers=samplers)
    return replace(made, beyond=walk_error(comparison, measure)) if beyond else made


def sampler(comparison: Comparison, one: Candidate, name: str, costs: cost.Costs) -> tuple[float, float]:
    """Nanoseconds for a sample and its density, and the largest mean square of its weight over all points, for the candidate.

    A weight's mean square, relative to the square of its mean, is 1 for samples without noise.
    """
    squares = []
    once = replace(one, compensation="none") if one.compensation == "walk" else one  # a walk draws its later bounces itself
    for point in comparison.points:
        evaluate, pdf = once.evaluate(comparison.scene.material, point), cost.guide(name, one.normals, point).pdf
        cosine = nodes(point).wi[:, 2]

        def square(wo: Array, wi: Array, evaluate: Any = evaluate, pdf: Any = pdf, cosine: Any = cosine) -> Array:
            values = np.asarray(evaluate(wo, wi), float)
            density: NDArray[Any] = np.asarray(pdf(wo, wi), float)
            return np.where(density > 0, values * values * cosine / np.where(density > 0, density, 1), 0.0)

        mean = float(lobe_of(evaluate, comparison.scene, point).sum())
        light = float(lobe_of(square, comparison.scene, point).sum())
        squares.append(light / mean**2 if mean**2 > 0 else math.inf)
    return costs.get(cost.sampler_name(name, one.normals, one.real), math.nan), max(squares)


def sampler_label(samplers: dict[str, tuple[float, float]]) -> str:
    """The samplers in order of time for a given noise, with both numbers of each."""
    known = all(math.isfinite(time) for time, _ in samplers.values())
    ranked = sorted(samplers, key=lambda name: samplers[name][0] * samplers[name][1] if known else samplers[name][1])
    labels = [
        f"{cost.SAMPLERS[name]} ({_time(samplers[name][0])}, mean square weight {samplers[name][1]:.3g})" for name in ranked
    ]
    return " before ".join(labels)


def walk_error(comparison: Comparison, measure: str) -> Error | None:
    """How far the random walk is from ray-traced surfaces: Gaussian slopes of the scene's largest roughness, same views."""
    scene = comparison.scene
    if scene.normals == "beckmann":
        return None
    last = max(comparison.points, key=lambda point: (point.alpha_x, point.alpha_y))[:2]
    points = tuple(point for point in comparison.points if point[:2] == last)
    gaussian = Comparison(replace(scene, normals="beckmann"), comparison.surfaces, comparison.walks, points)
    fresnel = "mirror" if scene.fresnel is None else "exact"
    compensation = "walk" if scene.bounces == "all" else "none"
    whole = Candidate("beckmann", "height", fresnel, scene.ratio[1] > 1, compensation, False)
    return gaussian.measured(whole, measure).error
