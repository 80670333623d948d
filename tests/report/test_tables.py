"""The talk's tables come out of the verdicts, and the numbers in them are those of the closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from microfacet.geometry import beckmann
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.blinn_phong import BlinnPhong
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity
from report import tables

pytestmark = pytest.mark.slow  # both tables are computed here


@pytest.fixture(scope="module")
def distributions() -> tables.Table:
    return tables.table_of_distributions()


@pytest.fixture(scope="module")
def masking() -> tables.Table:
    return tables.table_of_masking()


def test_distributions_are_those_of_slide_55(distributions: tables.Table) -> None:
    physical = {name: row.physical for name, row in distributions.items()}
    right = ("Blinn-Phong, normalised", "Beckmann", "GGX")
    assert physical == {name: "holds" if name in right else "fails" for name in ("Blinn-Phong", "Ward", *right)}


def test_masking_functions_are_those_of_slide_58(masking: tables.Table) -> None:
    for name, row in masking.items():
        verdicts = {row.verdict(equation) for equation in tables.INTEGRALS[1:]}
        assert verdicts == {"holds" if name in ("Smith", "V-cavities") else "fails"}, name
        assert row.verdict("projected_area") == "holds"


def test_blinn_phong_passes_at_one_exponent(distributions: tables.Table) -> None:
    assert float(tables.passing_exponent()) == pytest.approx(2 * np.pi - 2, abs=1e-15)
    trials = distributions["Blinn-Phong"].trials
    (only,) = [trial for trial in trials if trial.found["projected_area"].verdict == "holds"]
    assert isinstance(only.model.ndf, BlinnPhong)
    assert only.model.ndf.n == float(tables.passing_exponent())
    assert distributions["Blinn-Phong"].words == r"fails for every $n$ tried except $n = 2 \pi - 2$"


def test_quadrature_meets_every_closed_form(distributions: tables.Table, masking: tables.Table) -> None:
    rows = [*distributions.rows, *masking.rows]
    compared = [(1 + t.found[row.leading].residual, t.exact) for row in rows for t in row.trials if t.exact is not None]
    assert len(compared) > 60
    np.testing.assert_allclose(*np.array(compared).T, rtol=1e-10)


def test_wrong_models_pass_the_classic_three(masking: tables.Table) -> None:
    assert {row.verdict(*tables.CLASSIC) for row in masking.rows} == {"holds"}


def test_normal_incidence_alone_lets_wrong_functions_through(masking: tables.Table) -> None:
    let_through = {row.name for row in masking.rows if row.physical == "fails" and row.at_angle(0) == "holds"}
    assert let_through == {"Implicit", "Schlick-Smith", "Schlick-Smith, halved"}
    assert masking["Kelemen"].at_angle(0) == "fails"


def test_halved_schlick_smith_is_smith_at_one_roughness(masking: tables.Table) -> None:
    assert masking["Schlick-Smith, halved"].words.endswith(r"except GGX $\alpha = 1$")


def test_kelemen_shows_the_area_from_above() -> None:
    trial = tables.attempt("", tables.Kelemen(Beckmann(0.4)))
    assert tables.exact_share(trial.model, np.array([0.0, 0.0, 1.0])) == pytest.approx(float(beckmann.area.exact(0.4)))
    assert tables.exact_share(trial.model, np.array([0.6, 0.0, 0.8])) is None


def test_a_wrong_norm_turns_every_tick() -> None:
    """What breaks the distribution's norm breaks every model over it: ticks can turn."""
    wrong = tables.attempt("", VCavity(BlinnPhong(3.0)))
    assert {wrong.found[name].verdict for name in tables.INTEGRALS} == {"fails"}
    assert tables.attempt("", Smith(Beckmann(0.3, 0.5))).verdict(tables.INTEGRALS) == "holds"


@pytest.mark.parametrize(
    ("verdicts", "words"),
    [
        ("hhh", "holds for every x tried"),
        ("fff", "fails for every x tried"),
        ("fhf", "fails for every x tried except b"),
        ("hfhh", "fails at b"),
        ("hu", "holds for every x tried except b"),
        ("uu", "undecided for every x tried"),
        ("ffhh", "fails for every x tried except c and d"),
    ],
)
def test_quantifier_in_words(verdicts: str, words: str) -> None:
    full = {"h": "holds", "f": "fails", "u": "undecided"}
    assert tables.quantified([(label, full[v]) for label, v in zip("abcd", verdicts, strict=False)], "x") == words


def test_together_needs_all() -> None:
    assert tables.together(["holds", "holds"]) == "holds"
    assert tables.together(["holds", "undecided"]) == "undecided"
    assert tables.together(["undecided", "fails"]) == "fails"


def test_deviation_prints_what_is_known() -> None:
    assert tables.deviation(-0.59634, 1e-13) == "$-0.5963$"
    assert tables.deviation(3e-13, 5e-13) == "$< 10^{-12}$"


def test_every_row_has_a_cell_under_every_header(distributions: tables.Table, masking: tables.Table) -> None:
    for table in (distributions, masking):
        assert {len(cells) for cells in table.cells} == {len(table.headers)}
        assert not any("|" in cell for cells in table.cells for cell in cells)
