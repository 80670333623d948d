"""The talk's two tables, computed: which distributions (slide 55) and which masking functions (slide 58) are physically based.

Every tick and every cross is a verdict of `validate`, taken for each model over the parameters named in `Table.tried`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import log10
from typing import Any

import numpy as np
import sympy as sp
from microfacet.families import alphas_of, families, of_alpha
from microfacet.geometry import beckmann, blinn_phong, ggx
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution, alpha_of
from microfacet.model import signature
from microfacet.statements.notation import alpha, n
from microfacet.statements.statement import Equation
from microfacet.validation.equations import AZIMUTH_COUNT, INTEGRALS, PAIRS, THETA, TOLERANCE
from microfacet.visibility import criterion, unphysical
from microfacet.visibility.masking import Masking
from microfacet.visibility.smith import Smith
from microfacet.visibility.unphysical import Implicit, Kelemen, SchlickSmith
from microfacet.visibility.v_cavity import VCavity

from report.verdicts import CLASSIC, Case, Row, Table, case_of, deviation, exactly, sign

TALK_DISTRIBUTIONS = ("BlinnPhong", "NormalizedBlinnPhong", "Ward", "Beckmann", "GGX")  # slide 55, in its order
TALK_MASKINGS = ("Smith", "VCavity", "Implicit", "Kelemen", "SchlickSmith")  # slide 58

ALPHAS = (0.1, 0.25, 0.5, 1.0)
ANISOTROPIC_ALPHAS = ((0.1, 0.5), (0.05, 1.0))
EXPONENTS = (1, 2, 5, 10, 50, 1000)
MASKED_ALPHAS = (0.1, 0.4, 1.0)
MASKED_ANISOTROPIC_ALPHAS = ((0.1, 0.6),)

# --- table 1: distributions of normals ----------------------------------------------------------------------------------


def passing_exponent() -> sp.Expr:
    """The one exponent at which Blinn-Phong's closed form is 1."""
    (root,) = sp.solve(sp.Eq(blinn_phong.projected_area.equals, 1), n)
    return root


def table_of_distributions() -> Table:
    """Slide 55. The first equation decides; the others are tested under V-cavities, which hold for all these distributions."""
    rows = tuple(
        Row(kind.label, kind.cite, shapes(kind), INTEGRALS[0], r"$\alpha$" if alphas_of(kind) else "$n$")
        for kind in distributions()
    )
    headers = ("distribution", "physical", "the projected area is 1:", "computed", "exact", "deviation", "at", "classic")
    return Table(rows, headers, tuple(map(_distribution_cells, rows)), _distributions_tried())


def distributions() -> list[type[Distribution]]:
    """The families of distributions: the talk's in its order, then all others."""
    return families(Distribution, TALK_DISTRIBUTIONS)


def shapes(kind: type[Distribution]) -> tuple[Case, ...]:
    """One family over all its parameters: one or two roughnesses, or an exponent."""
    statement = kind.statements.get("projected_area")
    made_of: Any = kind
    if "n" in signature(made_of).parameters:
        return _powers(kind, statement)
    if not alphas_of(kind):
        raise ValueError(f"{kind.__name__} must be made of alpha, of alpha_x and alpha_y, or of n, to be tried in a table")
    return _rough(kind, statement, alpha_pairs(ALPHAS, ANISOTROPIC_ALPHAS if alphas_of(kind) > 1 else ()))


def _powers(make: Callable[..., Distribution], statement: Equation | None) -> tuple[Case, ...]:
    special = passing_exponent()
    labels = {float(e): f"$n = {e}$" for e in EXPONENTS} | {float(special): f"$n = {sp.latex(special, order='rev-lex')}$"}
    stated_area = [exactly(statement, n=e) if statement else None for e in sorted(labels)]
    return tuple(_shape(labels[e], make(e), exact) for e, exact in zip(sorted(labels), stated_area, strict=True))


def _rough(kind: type[Distribution], statement: Equation | None, pairs: list[tuple[float, float]]) -> tuple[Case, ...]:
    cases = []
    for alphas in pairs:
        known = statement and (alphas[0] == alphas[1] or alpha not in sp.sympify(statement.equals).free_symbols)
        exact = exactly(statement, alpha=alphas[0]) if statement and known else None
        cases.append(_shape(alpha_label(alphas), of_alpha(kind, *alphas), exact))
    return tuple(cases)


def _shape(label: str, ndf: Distribution, exact: float | None) -> Case:
    return replace(case_of(label, VCavity(ndf)), exact=exact)


def alpha_pairs(isotropic: Sequence[float], anisotropic: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    return [*((a, a) for a in isotropic), *anisotropic]


def alpha_label(alphas: tuple[float, float]) -> str:
    if alphas[0] == alphas[1]:
        return rf"$\alpha = {alphas[0]:g}$"
    return rf"$(\alpha_x, \alpha_y) = ({alphas[0]:g}, {alphas[1]:g})$"


def _distribution_cells(row: Row) -> tuple[str, ...]:
    worst = row.worst
    verdict = worst.verdicts[row.leading]
    exact = "–" if worst.exact is None else f"{worst.exact:.6f}"
    where = worst.label if row.physical == "fails" else "all"
    return (
        row.name,
        sign(row.physical),
        row.summary,
        f"{row.value:.6f}",
        exact,
        deviation(verdict.residual, verdict.bound),
        where,
        sign(row.verdict(*CLASSIC)),
    )


def _distributions_tried() -> str:
    powers = ", ".join(map(str, EXPONENTS))
    special = sp.latex(passing_exponent(), order="rev-lex")
    return rf"Tried were $n = {powers}$ and ${special}$; {_alphas_tried(ALPHAS, ANISOTROPIC_ALPHAS)}; {_views_tried()}."


def _alphas_tried(isotropic: Sequence[float], anisotropic: Sequence[tuple[float, float]]) -> str:
    pairs = ", ".join(f"({x:g}, {y:g})" for x, y in anisotropic)
    return rf"$\alpha = {', '.join(f'{a:g}' for a in isotropic)}$ and $(\alpha_x, \alpha_y) = {pairs}$"


def _views_tried() -> str:
    angles = np.degrees(THETA)
    albedo = f"10^{{{round(log10(TOLERANCE))}}}"
    return (
        f"{len(angles)} view angles from {angles[0]:.0f} to {angles[-1]:.0f} degrees"
        f" (all but the first at {AZIMUTH_COUNT} azimuths where the distribution is stretched, more along its longer slopes);"
        f" {PAIRS} pairs of random directions for positivity and reciprocity, an albedo of at most $1 + {albedo}$ for energy"
    )


# --- table 2: masking functions -----------------------------------------------------------------------------------------


def halved(ndf: Distribution) -> SchlickSmith:
    """The variant k = alpha/2 of games."""
    return SchlickSmith(ndf, max(alpha_of(ndf)) / 2)


def maskings() -> dict[str, tuple[Callable[[Distribution], Masking], str]]:
    """Masking functions by name, and their sources: the talk's five and a variant of the last, then all others."""
    talk = {kind.label: (kind, kind.cite) for kind in families(Masking, TALK_MASKINGS)}
    variant = {f"{SchlickSmith.label}, halved": (halved, SchlickSmith.cite)}
    rows = [*talk.items()]
    return dict([*rows[: len(TALK_MASKINGS)], *variant.items(), *rows[len(TALK_MASKINGS) :]])


def surfaces() -> dict[str, str]:
    """To which surface each of the talk's masking functions belongs, if its distribution may be another than the one beside it.

    A surface has f'(0+) of at least -1/2 (`visibility.criterion`): Schlick's has -k, implicit masking -1.
    """
    steepest = -sp.Rational(1, 2)
    schlick = rf"$k \leq {-steepest}$"
    return {
        Smith.label: "its own",
        VCavity.label: "its own",
        Implicit.label: "none" if criterion.implicit.equals < steepest else "some",
        Kelemen.label: "the plane",
        SchlickSmith.label: schlick,
        f"{SchlickSmith.label}, halved": schlick,
    }


def table_of_masking() -> Table:
    """Slide 58. The second, third and fourth equation, over Beckmann and GGX, which both pass the first."""
    rows = tuple(
        Row(name, cite, tuple(_masked(make(ndf), label) for ndf, label in masked_shapes()), INTEGRALS[1], "distribution")
        for name, (make, cite) in maskings().items()
    )
    headers = ("masking", *"234", "the visible area is right:", "computed", "exact", "at", r"only $0^\circ$", "classic")
    return Table(rows, headers, tuple(map(_masking_cells, rows)), _masking_tried())


def masked_shapes() -> list[tuple[Distribution, str]]:
    """The distributions under each masking function, and their labels."""
    return [
        (make(*alphas), f"{make.__name__} {alpha_label(alphas)}")
        for make in (Beckmann, GGX)
        for alphas in alpha_pairs(MASKED_ALPHAS, MASKED_ANISOTROPIC_ALPHAS)
    ]


def _masked(model: Masking, label: str) -> Case:
    case = case_of(label, model)
    return replace(case, exact=exact_visible_fraction(model, case.worst_view))


def exact_visible_fraction(model: Masking, view: np.ndarray) -> float | None:
    """The visible area by this model over its true value, below the zenith, from statements; None if no statement gives it.

    A masking function of the view direction alone makes it G1 (1 + Lambda). Kelemen's takes, from above, the whole area of
    the facets in place of their projected area.
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
        f"{row.summary}; {row.summary_by_angle}" if wrong else row.summary,
        f"{row.value:.6f}",
        "–" if worst.exact is None else f"{worst.exact:.6f}",
        at,
        sign(row.at_angle(0)),
        sign(row.verdict(*CLASSIC)),
    )


def _masking_tried() -> str:
    return rf"Tried were Beckmann and GGX with {_alphas_tried(MASKED_ALPHAS, MASKED_ANISOTROPIC_ALPHAS)}; {_views_tried()}."
