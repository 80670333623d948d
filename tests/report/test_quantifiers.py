"""What is said of the proofs of the two tables is read off the statements that prove it."""

import pytest
from microfacet.statements import notation
from microfacet.statements.statement import equations
from microfacet.validation import unnormalized, unphysical
from report.quantifiers import quantifiers
from report.tables import table_of_distributions, table_of_masking

pytest.importorskip("flint")


def test_quantifiers_are_read_off_the_closed_forms(monkeypatch):
    """Not typed: another zero is another word, and a form without one has none."""
    said = {name: q.brief for name, q in quantifiers().items()}
    assert said["Blinn-Phong"] == r"every $n$ but $2 \pi - 2$"
    assert said["Implicit"] == said["Schlick-Smith"] == r"every view but $0^\circ$"
    n, mu = notation.n, notation.mu_o
    monkeypatch.setitem(unnormalized.phong.__dict__, "equals", (5 - n) / (n + 2))
    assert quantifiers()["Blinn-Phong"].brief == "every $n$ but $5$"
    for wrong in (1 + mu, 0 * mu):
        monkeypatch.setitem(unphysical.implicit_ggx.__dict__, "equals", wrong)
        with pytest.raises(ValueError, match="does not vanish at mu_o = 1 alone"):
            quantifiers()


@pytest.mark.slow
def test_every_row_of_the_tables_has_its_quantifier():
    stated = quantifiers()
    rows = {**table_of_distributions(), **table_of_masking()}
    assert set(rows) == set(stated)
    for name, row in rows.items():
        assert row.physical == stated[name].verdict
        assert all(equations[key].enclosed for key in stated[name].keys)
