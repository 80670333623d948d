"""What the README promises: its code runs as printed, its commands exist, its picture is small."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from as_printed import run_as_printed

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text("utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", TEXT, re.M | re.S)


@pytest.mark.parametrize("block", BLOCKS, ids=["use", "add a distribution"])
def test_code_runs_as_printed(block: str) -> None:
    run_as_printed(block, "README.md")


def test_commands_exist() -> None:
    makefile = (ROOT / "Makefile").read_text("utf-8")
    assert all(re.search(rf"^{target}:", makefile, re.M) for target in re.findall(r"(?:^    |`)make (\w+)", TEXT, re.M))
    scripts = re.findall(r"python (figures/\S+\.py)", TEXT)
    assert len(scripts) == 2
    assert all((ROOT / script).is_file() for script in scripts)


def test_figures_named_exist() -> None:
    targets = re.findall(r"bin/snakemake (\w+)", TEXT)
    assert targets == ["masking", "slide_39"]
    assert "39" in (ROOT / "figures/visibility/masking.py").read_text("utf-8").split("SLIDES = ")[1].splitlines()[0]


def test_pictures_are_small() -> None:
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", TEXT)
    assert len(pictures) == 1
    assert all(0 < (ROOT / picture).stat().st_size < 200_000 for picture in pictures)


@pytest.mark.slow
def test_digits_to_trust_are_those_that_are_found() -> None:
    """Rounded down; in the last place processors may differ."""
    from microfacet.validation import accuracy_table

    for found in (accuracy_table.digits_by_part(), accuracy_table.further_digits()):
        assert_printed(found)


def assert_printed(found: dict[str, list[float]]) -> None:
    rows = TEXT[TEXT.index(f"| {next(iter(found))} |") :].splitlines()
    for row, (name, digits) in zip(rows, found.items(), strict=False):
        printed = [cell.strip() for cell in row.strip("|").split("|")]
        assert printed[0] == name
        assert all(-0.1 < one - int(cell) < 1.1 for one, cell in zip(digits, printed[1:], strict=True))
    assert not rows[len(found)].startswith("|")
