"""The talk's tables come out of the verdicts, and the numbers in them are those of the closed forms."""

from __future__ import annotations

import microfacet as mf
import numpy as np
import pytest
from microfacet.directions import spherical
from microfacet.geometry import beckmann
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.blinn_phong import BlinnPhong
from microfacet.validation.equations import INTEGRALS
from microfacet.visibility.smith import Smith
from microfacet.visibility.unphysical import Kelemen
from microfacet.visibility.v_cavity import VCavity
from report import tables, verdicts

pytestmark = pytest.mark.slow  # both tables are computed here


@pytest.fixture(scope="module")
def distributions() -> verdicts.Table:
    return tables.table_of_distributions()


@pytest.fixture(scope="module")
def masking() -> verdicts.Table:
    return tables.table_of_masking()


def test_distributions_are_those_of_slide_55(distributions: verdicts.Table) -> None:
    physical = {name: row.physical for name, row in distributions.items()}
    right = ("Blinn-Phong, normalised", "Beckmann", "GGX")
    assert physical == {name: "holds" if name in right else "fails" for name in ("Blinn-Phong", "Ward", *right)}


def test_masking_functions_are_those_of_slide_58(masking: verdicts.Table) -> None:
    for name, row in masking.items():
        found = {row.verdict(equation) for equation in INTEGRALS[1:]}
        assert found == {"holds" if name in ("Smith", "V-cavities") else "fails"}, name
        assert row.verdict("projected_area") == "holds"


def test_blinn_phong_passes_at_one_exponent(distributions: verdicts.Table) -> None:
    assert float(tables.passing_exponent()) == pytest.approx(2 * np.pi - 2, abs=1e-15)
    cases = distributions["Blinn-Phong"].cases
    (only,) = [case for case in cases if case.verdicts["projected_area"].verdict == "holds"]
    assert isinstance(only.model.ndf, BlinnPhong)
    assert only.model.ndf.n == float(tables.passing_exponent())
    assert distributions["Blinn-Phong"].summary == r"fails for every $n$ tried except $n = 2 \pi - 2$"


def test_quadrature_meets_every_closed_form(distributions: verdicts.Table, masking: verdicts.Table) -> None:
    rows = [*distributions.rows, *masking.rows]
    compared = [(1 + t.verdicts[row.leading].residual, t.exact) for row in rows for t in row.cases if t.exact is not None]
    assert len(compared) > 60
    np.testing.assert_allclose(*np.array(compared).T, rtol=1e-10)


def test_wrong_models_pass_the_classic_three(masking: verdicts.Table) -> None:
    assert {row.verdict(*verdicts.CLASSIC) for row in masking.rows} == {"holds"}


def test_normal_incidence_alone_lets_wrong_functions_through(masking: verdicts.Table) -> None:
    let_through = {row.name for row in masking.rows if row.physical == "fails" and row.at_angle(0) == "holds"}
    assert let_through == {"Implicit", "Schlick-Smith", "Schlick-Smith, halved"}
    assert masking["Kelemen"].at_angle(0) == "fails"


def test_halved_schlick_smith_is_smith_at_one_roughness(masking: verdicts.Table) -> None:
    assert masking["Schlick-Smith, halved"].summary.endswith(r"except GGX $\alpha = 1$")


def test_kelemen_shows_the_area_from_above() -> None:
    case = verdicts.case_of("", Kelemen(Beckmann(0.4)))
    assert tables.exact_visible_fraction(case.model, np.array([0.0, 0.0, 1.0])) == pytest.approx(
        float(beckmann.area.exact(0.4))
    )
    assert tables.exact_visible_fraction(case.model, np.array([0.6, 0.0, 0.8])) is None


def test_a_wrong_norm_turns_every_tick() -> None:
    """What breaks the distribution's norm breaks every model over it: ticks can turn."""
    wrong = verdicts.case_of("", VCavity(BlinnPhong(3.0)))
    assert {wrong.verdicts[name].verdict for name in INTEGRALS} == {"fails"}
    assert verdicts.case_of("", Smith(Beckmann(0.3, 0.5))).verdict(INTEGRALS) == "holds"


def test_every_row_has_a_cell_under_every_header(distributions: verdicts.Table, masking: verdicts.Table) -> None:
    for table in (distributions, masking):
        assert {len(cells) for cells in table.cells} == {len(table.headers)}
        assert not any("|" in cell for cells in table.cells for cell in cells)


def steepest(model: mf.Masking) -> float:
    """The slope of x (1/G1 - 1) next to x = cot theta_o = 0, which is at least -1/2 for a surface."""
    x = np.array([1e-6, 2e-6])
    wo = spherical(np.arctan2(1.0, x))
    f = x * (1 / model.G1(wo, [0.0, 0.0, 1.0]) - 1)
    return float(np.diff(f)[0] / 1e-6)


def test_a_function_has_the_surface_that_the_table_names() -> None:
    """By values of G1, where the table has it from statements."""
    named, ndf = tables.surfaces(), mf.GGX(0.5)
    assert steepest(mf.Smith(ndf)) == pytest.approx(-0.5, abs=1e-4)
    assert steepest(mf.Implicit(ndf)) == pytest.approx(-1, abs=1e-4)
    assert (named["Smith"], named["Implicit"]) == ("its own", "none")
    for k in (0.4, 0.5):
        assert steepest(mf.SchlickSmith(ndf, k)) > -0.5001
    assert steepest(mf.SchlickSmith(ndf, 0.51)) < -0.5
    assert named["Schlick-Smith"] == named["Schlick-Smith, halved"] == r"$k \leq 1/2$"


def test_every_masking_function_of_the_table_has_a_surface_or_none(masking: verdicts.Table) -> None:
    assert {row.name for row in masking.rows} == tables.surfaces().keys()
