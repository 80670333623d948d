"""The talk's two tables, computed: which distributions (slide 55) and which masking functions (slide 58) are physically based.

Every tick and every cross is a verdict of `validate`, taken for each model over the parameters named in `Table.tried`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, log10

import numpy as np
import sympy as sp
from microfacet.geometry import beckmann, blinn_phong, ggx, ward
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.blinn_phong import BlinnPhong, NormalizedBlinnPhong
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution, alpha_of
from microfacet.geometry.ward import Ward
from microfacet.notation import alpha, n
from microfacet.statement import Equation, reference
from microfacet.validation.equations import (
    AZIMUTHS,
    PAIRS,
    THETA,
    TOLERANCE,
    Verdict,
    decide,
    default_views,
    residual,
    validate,
)
from microfacet.visibility import unphysical
from microfacet.visibility.masking import Masking
from microfacet.visibility.smith import Smith
from microfacet.visibility.unphysical import Implicit, Kelemen, SchlickSmith
from microfacet.visibility.v_cavity import VCavity

INTEGRALS = ("projected_area", "visible_area", "visible_norm", "weak_furnace")
CLASSIC = ("positivity", "reciprocity", "energy")
SIGNS = {"holds": "✓", "fails": "✗", "undecided": "?"}

ROUGHNESS = (0.1, 0.25, 0.5, 1.0)
STRETCHED = ((0.1, 0.5), (0.05, 1.0))
EXPONENTS = (1, 2, 5, 10, 50, 1000)
MASKED_ROUGHNESS = (0.1, 0.4, 1.0)
MASKED_STRETCHED = ((0.1, 0.6),)

# --- what was tried, and what came of it ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Trial:
    """One model with one set of parameters, and its verdicts. label: the parameters, as LaTeX.

    found: by equation. by_angle: the verdict on the visible area for each view angle that all surfaces have, degrees.
    farthest: the view where it is worst.
    """

    label: str
    model: Masking
    found: Mapping[str, Verdict]
    by_angle: Mapping[int, str]
    farthest: np.ndarray
    exact: float | None = None  # the row's leading integral where it is worst, if there is a closed form

    def verdict(self, equations: Sequence[str]) -> str:
        return together([self.found[name].verdict for name in equations])

    @property
    def angle(self) -> float:
        return float(degrees_of(self.farthest))


def attempt(label: str, model: Masking) -> Trial:
    """Put a model to all equations, from all default views."""
    views = default_views(model.ndf)
    values, bounds = residual(model, "visible_area", views)
    angles = degrees_of(views)
    by_angle = {round(t): decide(values[angles == t], bounds[angles == t], TOLERANCE) for t in np.degrees(THETA).round(2)}
    farthest = views[np.argmax(np.abs(values))]
    return Trial(label, model, validate(model, views), by_angle, farthest)


def degrees_of(views: np.ndarray) -> np.ndarray:
    """Polar angles, to a hundredth of a degree."""
    return np.asarray(np.degrees(np.arccos(np.minimum(views[..., 2], 1.0))).round(2))


@dataclass(frozen=True)
class Row:
    """One line of a table: a model over all its trials. leading: the equation whose residual is quoted."""

    name: str
    cite: str
    trials: tuple[Trial, ...]
    leading: str
    family: str  # what varies from trial to trial, in words

    def verdict(self, *equations: str) -> str:
        """holds: in every trial; fails: in at least one."""
        return together([trial.verdict(equations) for trial in self.trials])

    @property
    def physical(self) -> str:
        """The talk's question: do the validation equations hold?"""
        return self.verdict(self.leading)

    @property
    def worst(self) -> Trial:
        """The trial that is farthest from the leading equation."""
        return max(self.trials, key=lambda trial: abs(trial.found[self.leading].residual))

    @property
    def value(self) -> float:
        """The leading integral there; 1 if the equation held."""
        return 1 + self.worst.found[self.leading].residual

    @property
    def words(self) -> str:
        """For which of the parameters tried."""
        return quantified([(trial.label, trial.verdict([self.leading])) for trial in self.trials], self.family)

    def at_angle(self, angle: int) -> str:
        """The leading verdict if one looked at one view angle only, degrees."""
        return together([trial.by_angle[angle] for trial in self.trials])

    @property
    def words_by_angle(self) -> str:
        """For which of the view angles tried."""
        angles = self.trials[0].by_angle
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
    kinds = {verdict: [label for label, found in outcomes if found == verdict] for verdict in SIGNS}
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


# --- table 1: distributions of normals ----------------------------------------------------------------------------------


def passing_exponent() -> sp.Expr:
    """The one exponent at which Blinn-Phong's closed form is 1."""
    (root,) = sp.solve(sp.Eq(blinn_phong.projected_area.equals, 1), n)
    return root


def table_of_distributions() -> Table:
    """Slide 55. The first equation decides; V-cavities, right for all these, carry it on to the others."""
    rows = (
        Row("Blinn-Phong", "blinn1977", _powers(BlinnPhong, blinn_phong.projected_area), INTEGRALS[0], "$n$"),
        Row(
            "Blinn-Phong, normalised",
            "heitz2014",
            _powers(NormalizedBlinnPhong, blinn_phong.normalized_projected_area),
            INTEGRALS[0],
            "$n$",
        ),
        Row("Ward", "ward1992", _rough(Ward, ward.projected_area), INTEGRALS[0], r"$\alpha$"),
        Row("Beckmann", "heitz2014", _rough(Beckmann, beckmann.projected_area), INTEGRALS[0], r"$\alpha$"),
        Row("GGX", "walter2007", _rough(GGX, ggx.projected_area), INTEGRALS[0], r"$\alpha$"),
    )
    headers = ("distribution", "physical", "the projected area is 1:", "computed", "exact", "deviation", "at", "classic")
    return Table(rows, headers, tuple(map(_distribution_cells, rows)), _distributions_tried())


def _powers(make: Callable[[float], Distribution], statement: Equation) -> tuple[Trial, ...]:
    special = passing_exponent()
    labels = {float(e): f"$n = {e}$" for e in EXPONENTS} | {float(special): f"$n = {sp.latex(special, order='rev-lex')}$"}
    return tuple(_shape(label, make(e), exactly(statement, n=e)) for e, label in sorted(labels.items()))


def _rough(make: Callable[[float, float], Distribution], statement: Equation) -> tuple[Trial, ...]:
    trials = []
    for scales in roughnesses(ROUGHNESS, STRETCHED):
        known = scales[0] == scales[1] or alpha not in sp.sympify(statement.equals).free_symbols
        exact = exactly(statement, alpha=scales[0]) if known else None
        trials.append(_shape(roughness_label(scales), make(*scales), exact))
    return tuple(trials)


def _shape(label: str, ndf: Distribution, exact: float | None) -> Trial:
    return replace(attempt(label, VCavity(ndf)), exact=exact)


def roughnesses(isotropic: Sequence[float], stretched: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    return [*((a, a) for a in isotropic), *stretched]


def roughness_label(scales: tuple[float, float]) -> str:
    if scales[0] == scales[1]:
        return rf"$\alpha = {scales[0]:g}$"
    return rf"$(\alpha_x, \alpha_y) = ({scales[0]:g}, {scales[1]:g})$"


def _distribution_cells(row: Row) -> tuple[str, ...]:
    worst = row.worst
    found = worst.found[row.leading]
    exact = "–" if worst.exact is None else f"{worst.exact:.6f}"
    where = worst.label if row.physical == "fails" else "all"
    return (
        row.name,
        sign(row.physical),
        row.words,
        f"{row.value:.6f}",
        exact,
        deviation(found.residual, found.bound),
        where,
        sign(row.verdict(*CLASSIC)),
    )


def _distributions_tried() -> str:
    powers = ", ".join(map(str, EXPONENTS))
    special = sp.latex(passing_exponent(), order="rev-lex")
    return rf"Tried were $n = {powers}$ and ${special}$; {_roughness_tried(ROUGHNESS, STRETCHED)}; {_views_tried()}."


def _roughness_tried(isotropic: Sequence[float], stretched: Sequence[tuple[float, float]]) -> str:
    pairs = ", ".join(f"({x:g}, {y:g})" for x, y in stretched)
    return rf"$\alpha = {', '.join(f'{a:g}' for a in isotropic)}$ and $(\alpha_x, \alpha_y) = {pairs}$"


def _views_tried() -> str:
    angles = np.degrees(THETA)
    albedo = f"10^{{{round(log10(TOLERANCE))}}}"
    return (
        f"{len(angles)} view angles from {angles[0]:.0f} to {angles[-1]:.0f} degrees"
        f" (all but the first at {AZIMUTHS} azimuths where the distribution is stretched, more along its longer slopes);"
        f" {PAIRS} pairs of random directions for positivity and reciprocity, an albedo of at most $1 + {albedo}$ for energy"
    )


# --- table 2: masking functions -----------------------------------------------------------------------------------------

MASKINGS: dict[str, tuple[Callable[[Distribution], Masking], str]] = {
    "Smith": (Smith, "smith1967"),
    "V-cavities": (VCavity, "cook1982"),
    "Implicit": (Implicit, "hoffman2010"),
    "Kelemen": (Kelemen, "kelemen2001"),
    "Schlick-Smith": (SchlickSmith, "schlick1994"),
    "Schlick-Smith, halved": (lambda ndf: SchlickSmith(ndf, max(alpha_of(ndf)) / 2), "schlick1994"),
}
"""The talk's five, and the variant k = alpha/2 of games."""


def table_of_masking() -> Table:
    """Slide 58. The second, third and fourth equation, over Beckmann and GGX, which both pass the first."""
    rows = tuple(
        Row(name, cite, tuple(_masked(make(ndf), label) for ndf, label in masked_shapes()), INTEGRALS[1], "distribution")
        for name, (make, cite) in MASKINGS.items()
    )
    headers = ("masking", *"234", "the visible area is right:", "computed", "exact", "at", r"only $0^\circ$", "classic")
    return Table(rows, headers, tuple(map(_masking_cells, rows)), _masking_tried())


def masked_shapes() -> list[tuple[Distribution, str]]:
    """The distributions under each masking function, and what to call them."""
    return [
        (make(*scales), f"{make.__name__} {roughness_label(scales)}")
        for make in (Beckmann, GGX)
        for scales in roughnesses(MASKED_ROUGHNESS, MASKED_STRETCHED)
    ]


def _masked(model: Masking, label: str) -> Trial:
    trial = attempt(label, model)
    return replace(trial, exact=exact_share(model, trial.farthest))


def exact_share(model: Masking, view: np.ndarray) -> float | None:
    """What a viewer below the zenith sees by this model, over what there is to see, from statements; None if there is none.

    A masking function of the view direction alone shows G1 (1 + Lambda) of it. Kelemen's shows, from above, the whole area
    of the facets and not what they project to.
    """
    if isinstance(model, Smith | VCavity):
        return 1.0
    across, cosine = float(np.linalg.norm(np.array(alpha_of(model.ndf)) * view[:2])), float(view[2])
    statement = beckmann.Lambda if isinstance(model.ndf, Beckmann) else ggx.Lambda
    hidden = statement.exact(cosine / across) if across else 0
    if isinstance(model, Implicit):
        return float(unphysical.implicit_G1.exact(1.0, cosine) * (1 + hidden))
    if isinstance(model, SchlickSmith):
        return float(unphysical.schlick_G1.exact(1.0, cosine, model.k) * (1 + hidden))
    if isinstance(model, Kelemen) and not across and model.ndf.isotropic:
        area = beckmann.area if isinstance(model.ndf, Beckmann) else ggx.area
        return float(sp.limit(area.equals, alpha, sp.nsimplify(alpha_of(model.ndf)[0])))
    return None


def _masking_cells(row: Row) -> tuple[str, ...]:
    worst = row.worst
    wrong = row.physical == "fails"
    at = f"{worst.label}, ${worst.angle:g}^\\circ$" if wrong else "all"
    return (
        row.name,
        *(sign(row.verdict(name)) for name in INTEGRALS[1:]),
        f"{row.words}; {row.words_by_angle}" if wrong else row.words,
        f"{row.value:.6f}",
        "–" if worst.exact is None else f"{worst.exact:.6f}",
        at,
        sign(row.at_angle(0)),
        sign(row.verdict(*CLASSIC)),
    )


def _masking_tried() -> str:
    return rf"Tried were Beckmann and GGX with {_roughness_tried(MASKED_ROUGHNESS, MASKED_STRETCHED)}; {_views_tried()}."
