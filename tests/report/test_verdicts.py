"""Verdicts of many trials in one, and in words."""

from __future__ import annotations

import pytest
from report import verdicts


@pytest.mark.parametrize(
    ("found", "words"),
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
def test_quantifier_in_words(found: str, words: str) -> None:
    full = {"h": "holds", "f": "fails", "u": "undecided"}
    assert verdicts.quantified([(label, full[v]) for label, v in zip("abcd", found, strict=False)], "x") == words


def test_together_needs_all() -> None:
    assert verdicts.together(["holds", "holds"]) == "holds"
    assert verdicts.together(["holds", "undecided"]) == "undecided"
    assert verdicts.together(["undecided", "fails"]) == "fails"


def test_deviation_prints_what_is_known() -> None:
    assert verdicts.deviation(-0.59634, 1e-13) == "$-0.5963$"
    assert verdicts.deviation(3e-13, 5e-13) == "$< 10^{-12}$"
