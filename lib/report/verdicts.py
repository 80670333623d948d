"""Verdicts of the validation equations on models, one by one and over many parameters, and their wording.

Every tick and every cross is a verdict of `validate`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, log10

import numpy as np
import sympy as sp
from microfacet.statements.reference import reference
from microfacet.statements.statement import Equation
from microfacet.validation.equations import THETA, TOLERANCE, Verdict, decide, default_views, residual, validate
from microfacet.visibility.masking import Masking

CLASSIC = ("positivity", "reciprocity", "energy")
SIGNS = {"holds": "✓", "fails": "✗", "undecided": "?"}


@dataclass(frozen=True)
class Case:
    """One model with one set of parameters, and its verdicts. label: the parameters, as LaTeX.

    verdicts: by equation. by_angle: the verdict on the visible area for each view angle that all surfaces have, degrees.
    worst_view: where the visible area is farthest from its value.
    """

    label: str
    model: Masking
    verdicts: Mapping[str, Verdict]
    by_angle: Mapping[int, str]
    worst_view: np.ndarray
    exact: float | None = None  # the row's leading integral at the worst view, if it has a closed form

    def verdict(self, equations: Sequence[str]) -> str:
        return together([self.verdicts[name].verdict for name in equations])

    @property
    def angle(self) -> float:
        return float(degrees_of(self.worst_view))


def case_of(label: str, model: Masking) -> Case:
    """Validate a model by all equations, from all default views."""
    views = default_views(model.ndf)
    values, bounds = residual(model, "visible_area", views)
    angles = degrees_of(views)
    by_angle = {round(t): decide(values[angles == t], bounds[angles == t], TOLERANCE) for t in np.degrees(THETA).round(2)}
    worst_view = views[np.argmax(np.abs(values))]
    return Case(label, model, validate(model, views), by_angle, worst_view)


def degrees_of(views: np.ndarray) -> np.ndarray:
    """Polar angles, to a hundredth of a degree."""
    return np.asarray(np.degrees(np.arccos(np.minimum(views[..., 2], 1.0))).round(2))


@dataclass(frozen=True)
class Row:
    """One line of a table: a model over all its parameters. leading: the equation whose residual is quoted."""

    name: str
    cite: str
    cases: tuple[Case, ...]
    leading: str
    family: str  # the parameters that vary between the cases, for the wording

    def verdict(self, *equations: str) -> str:
        """holds: in every case; fails: in at least one."""
        return together([case.verdict(equations) for case in self.cases])

    @property
    def physical(self) -> str:
        """The talk's question: does the leading validation equation hold?"""
        return self.verdict(self.leading)

    @property
    def worst(self) -> Case:
        """The case that is farthest from the leading equation."""
        return max(self.cases, key=lambda case: abs(case.verdicts[self.leading].residual))

    @property
    def value(self) -> float:
        """The leading integral there; 1 if the equation held."""
        return 1 + self.worst.verdicts[self.leading].residual

    @property
    def summary(self) -> str:
        """For which of the parameters tried."""
        return quantified([(case.label, case.verdict([self.leading])) for case in self.cases], self.family)

    def at_angle(self, angle: int) -> str:
        """The leading verdict from one view angle only, degrees."""
        return together([case.by_angle[angle] for case in self.cases])

    @property
    def summary_by_angle(self) -> str:
        """For which of the view angles tried."""
        angles = self.cases[0].by_angle
        return quantified([(rf"${angle}^\circ$", self.at_angle(angle)) for angle in angles], "angle")


@dataclass(frozen=True)
class Table(Mapping[str, Row]):
    """Rows by name, and what a chapter prints of them. tried: a sentence about the parameters, for the caption."""

    rows: tuple[Row, ...]
    headers: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    tried: str

    def __getitem__(self, name: str) -> Row:
        return {row.name: row for row in self.rows}[name]

    def __iter__(self) -> Iterator[str]:
        return iter(row.name for row in self.rows)

    def __len__(self) -> int:
        return len(self.rows)


def together(verdicts: Sequence[str]) -> str:
    """One failure fails all; all must hold for all to hold."""
    return "fails" if "fails" in verdicts else "undecided" if "undecided" in verdicts else "holds"


# --- in words ---------------------------------------------------------------------------------------------------------


def quantified(outcomes: Sequence[tuple[str, str]], family: str) -> str:
    """`holds for every n tried`, `fails for every n tried except n = 2 pi - 2`, from labelled verdicts."""
    kinds = {kind: [label for label, verdict in outcomes if verdict == kind] for kind in SIGNS}
    main = "fails" if kinds["fails"] else "holds" if kinds["holds"] else "undecided"
    others = [label for verdict, labels in kinds.items() if verdict != main for label in labels]
    if len(others) > len(kinds[main]):
        return f"{main} at {listed(kinds[main])}"
    return f"{main} for every {family} tried" + (f" except {listed(others)}" if others else "")


def listed(labels: Sequence[str]) -> str:
    return " and ".join([", ".join(labels[:-1]), labels[-1]] if len(labels) > 1 else labels)


def deviation(residual: float, bound: float) -> str:
    """A residual with its error: few digits where it stands clear of the error, otherwise a power of ten above both."""
    if abs(residual) > 10 * bound:
        return f"${residual:+.4f}$"
    return f"$< 10^{{{ceil(log10(abs(residual) + bound))}}}$"


def sign(verdict: str) -> str:
    return SIGNS[verdict]


def exactly(statement: Equation, **values: float) -> float:
    """The closed form of a statement, to 50 digits and then rounded."""
    closed = sp.sympify(statement.equals)
    symbols = sorted(closed.free_symbols, key=str)
    return float(reference(closed, symbols)(*(values[str(symbol)] for symbol in symbols)))
