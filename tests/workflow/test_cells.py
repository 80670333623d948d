"""What a chapter's cells print: orders of magnitude, verdicts with their residuals, tables, figures by name."""

from __future__ import annotations

from dataclasses import dataclass
from math import log10

import cells
import inventory
import pytest
from checkout import Checkout


@dataclass
class Verdict:
    equation: str
    verdict: str
    residual: float
    bound: float


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (1e-12, "$10^{-12}$"), (3.2e-5, r"$3 \cdot 10^{-5}$"), (7.0, "7"), (1.0, "1"), (9.6, r"$10^{1}$"),
        (-2e3, r"$-2 \cdot 10^{3}$"),
    ],
)  # fmt: skip
def test_a_number_by_its_order(number: float, text: str) -> None:
    assert cells.sci(number) == text


@pytest.mark.parametrize(("residual", "bound"), [(3e-13, 5e-13), (-8e-11, 1e-11), (0.0, 1e-9), (9.9e-10, 2e-12), (-1e-12, 0.0)])
def test_what_holds_is_told_by_a_power_of_ten_above_residual_and_error(residual: float, bound: float) -> None:
    text = cells.verdict_text(Verdict("visible_area", "holds", residual, bound))
    power = int(text.split("^{")[1].split("}")[0])
    assert text == f"$< 10^{{{power}}}$ ✓"
    assert 10.0**power >= (abs(residual) + bound) * (1 - 1e-12)
    assert power - 1 < log10(abs(residual) + bound)


def test_what_fails_is_told_with_its_sign() -> None:
    assert cells.verdict_text(Verdict("visible_area", "fails", -0.12345, 1e-12)) == "$-0.123$ ✗"
    assert cells.verdict_text(Verdict("visible_area", "undecided", 0.5, 0.4)) == "$+0.500$ ?"
    assert cells.verdict_text(Verdict("reciprocity", "holds", 0.0, 0.0)) == "0 ✓"
    assert cells.verdict_text(Verdict("energy", "fails", 0.25, 0.0)) == "1.250 ✗"


def test_verdicts_are_rows_of_models() -> None:
    found = {"a": {"visible_area": Verdict("visible_area", "fails", 0.5, 0), "energy": Verdict("energy", "holds", -0.25, 0)}}
    text = cells.verdicts(found, ["energy", "visible_area"], caption="C.", label="tbl:t").text
    assert text.splitlines()[:3] == [
        "| Model | largest albedo | visible area |", "| :-- | --: | --: |", "| a | 0.750 ✓ | $+0.500$ ✗ |",
    ]  # fmt: skip


def test_columns_of_numbers_stand_on_the_right() -> None:
    assert [cells.guess(column) for column in ([1, 2.5], [1, "a"], ["a"], [])] == ["r", "l", "l", "l"]
    assert cells.cell_text(1234.5678) == "1235"
    assert cells.cell_text(12) == "12"


def test_a_figure_is_shown_with_its_caption_slides_and_width(small: Checkout) -> None:
    drawn = inventory.figures()["masking"]
    text = cells.figure("masking", width=62.5, place="top").text
    assert text.startswith(f"![**{drawn.title}**")
    assert "](build/figures/masking.svg){#fig:masking width=62.5% " in text
    assert f'slides="{",".join(map(str, drawn.slides))}" place=top' in text
    assert "width=100% " in cells.figure("masking").text
    with pytest.raises(LookupError, match="Did you mean masking"):
        cells.figure("maskin")


def test_a_statement_is_numbered_once(small: Checkout) -> None:
    key, facts = next(iter(inventory.statements().items()))
    assert cells.equation(key).text == f"$$ {facts['latex']} $$ {{#eq:{key}}}"
    assert cells.computed(key).text == f"$$ {facts['computed_latex']} $$"
    for helper in (cells.equation, cells.computed):
        with pytest.raises(LookupError, match="There is no equation called"):
            helper("none")


def test_data_is_that_of_a_figure_with_data(small: Checkout) -> None:
    with pytest.raises(LookupError, match="no figure with data called 'plain'"):
        cells.data("plain")
