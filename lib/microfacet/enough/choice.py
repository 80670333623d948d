"""The choice of the cheapest model within a tolerance of the most complete one.

Sources: heitz2016 (the random walk), turquin2019 and kulla2017 (energy put back), heitz2014 (all else).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microfacet.confidence import ODDS
from microfacet.directions import one_of, positive
from microfacet.enough import cost
from microfacet.enough.candidates import Candidate, candidates_for
from microfacet.enough.comparison import SURFACES, WALKS, Comparison, Measured
from microfacet.enough.lobes import Array, lobe_of, nodes
from microfacet.enough.measures import Error
from microfacet.enough.scene import PRECISIONS, Scene

MEASURES = {
    "albedo": "the share of light that is reflected",
    "lobe": "the share of the reflected light that goes elsewhere",
    "picture": "the mean relative error of spheres under a sky with a sun",
}


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
