"""Numbers in the chapters' prose are computed, or are those of the code beside them; and so are the captions'."""

from __future__ import annotations

import ast
import re
import runpy
from collections.abc import Iterator
from pathlib import Path

import inventory
import numpy as np
import pytest
from scipy.special import erf

ROOT = Path(__file__).resolve().parents[1]
CHAPTERS = sorted(path.stem for path in (ROOT / "chapters").glob("[0-9]_*.md"))
LISTING = re.compile(r"^```.*?^```", re.M | re.S)
REFERENCES = re.compile(r"`[^`]*`|\[[^\]]*@[^\]]*\]|@[\w:-]+|\{#[^}]*\}|\(https?[^)]*\)|\[[^\]]*\]\([^)]*\)")
FORMULA = re.compile(r"\$\$.*?\$\$|\$[^$]*\$", re.S)
RESULT = re.compile(r"(?<![\w.])\d+\.\d+|(?<![\w.])\d+(?= ?%)")  # what is not a whole number, or a share
CHOICE = re.compile(r"(?<![\w.])\d+\.\d+|(?<![\w.])\d+(?=°| ?%)")  # for what roughness, at what angle
TYPED = {  # what is said by hand, because no computation of ours says it
    "3_material": {"1.5"},  # the index of glass
    "8_stability": {"1"},  # the level of a test; a per cent of error
}


@pytest.fixture(autouse=True)
def at_root(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(ROOT)
    inventory.figures.cache_clear()
    yield
    inventory.figures.cache_clear()


def prose(text: str) -> str:
    """A chapter without its cells and listings, and with # in place of each computed value."""
    return REFERENCES.sub("", inventory.INLINE.sub("#", LISTING.sub("", inventory.CELL.sub("", inventory.FRONT.sub("", text)))))


def results(text: str) -> set[str]:
    """Numbers outside of formulae that look like the outcome of a computation."""
    return set(RESULT.findall(FORMULA.sub("", prose(text))))


def choices(text: str) -> set[float]:
    """Numbers typed in paragraphs that hold a computed value: for what they hold."""
    return {float(number) for line in prose(text).splitlines() if "#" in line for number in CHOICE.findall(line)}


def literals(source: str) -> set[float]:
    found = [node.value for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Constant)]
    return {float(value) for value in found if isinstance(value, int | float)}


def sources(chapter: inventory.Chapter) -> Iterator[str]:
    """The code beside the prose: the chapter's cells, and the scripts of the figures that it shows or reads."""
    yield chapter.code
    for name in {*chapter.named("figure"), *chapter.named("data")} & set(inventory.figures()):
        figure = inventory.figures()[name]
        yield from (script.read_text("utf-8") for script in (figure.script, figure.data_script) if script)


@pytest.mark.parametrize("stem", CHAPTERS)
def test_no_result_is_typed_by_hand(stem: str) -> None:
    assert results((ROOT / f"chapters/{stem}.md").read_text("utf-8")) <= TYPED.get(stem, set())


@pytest.mark.parametrize("stem", CHAPTERS)
def test_what_a_computed_value_is_said_to_hold_for_is_what_it_was_computed_for(stem: str) -> None:
    chapter = inventory.read_chapter(Path(f"chapters/{stem}.md"))
    known = set().union(*map(literals, sources(chapter)))
    assert choices(chapter.path.read_text("utf-8")) - known == set()


def test_a_number_typed_by_hand_is_found() -> None:
    cell = "# A\n\n```{code-cell}\nx = f(0.25)\n```\n\n"
    text = cell + "At $\\alpha = 0.3$ and 40° it is {{x:.2f}}, not 0.71 or 3 %, see `1.5` and [@a, 2.5].\n"
    assert results(text) == {"0.71", "3"}
    assert choices(text) == {0.3, 40.0, 0.71, 3.0}
    assert literals("x = f(0.25)") == {0.25}


# --- captions -------------------------------------------------------------------------------------------------------------


def spoken(script: str) -> set[str]:
    """Numbers in what a drawing script says: its caption, which is its docstring."""
    return set(CHOICE.findall(FORMULA.sub(lambda found: found[0].strip("$"), ast.get_docstring(ast.parse(script)) or "")))


def derived() -> dict[str, dict[str, float]]:
    """Results that captions type by hand: computed here from the constants of their data scripts."""
    view, slopes, stages, equal, samplers = (
        runpy.run_path(f"figures/{name}_data.py")
        for name in (
            "anisotropy/stretched_view", "anisotropy/stretching", "overview/pipeline",
            "speed/equal_time", "speed/speed_samplers",
        )
    )  # fmt: skip
    return {
        "stretched_view": {"70.7": np.degrees(np.arctan(max(view["STRETCHES"]) * np.tan(view["THETA_O"])))},
        "stretching": {"0.25": slopes["ALPHA"] / slopes["STRETCH"]},
        "pipeline": {"0.643": np.cos(stages["THETA_O"])},
        "equal_time": {"95": 100 * erf(equal["SIGMA"] / np.sqrt(2))},
        "speed_samplers": {"95": 100 * erf(samplers["SIGMA"] / np.sqrt(2))},
    }


def beside(figure: inventory.Figure) -> Iterator[str]:
    """The scripts of a figure, what they import of their folder, and the campaign if they read it."""
    scripts = [figure.script, *([figure.data_script] if figure.data_script else [])]
    texts = [script.read_text("utf-8") for script in scripts]
    yield from texts
    for folder, name in re.findall(r"^from (benchmarks\.)?(\w+) import", "\n".join(texts), re.M):
        path = Path("benchmarks", f"{name}.py") if folder else figure.script.with_name(f"{name}.py")
        yield from [path.read_text("utf-8")] if path.exists() else []
    if "report.campaign" in "".join(texts):
        yield Path("lib/report/campaign.py").read_text("utf-8")


def test_numbers_in_captions_are_those_of_the_data() -> None:
    """What a caption says of roughness and angles stands in a script beside it, or follows from what does."""
    results, loose = derived(), []
    for name, figure in inventory.figures().items():
        known = set().union(*map(literals, beside(figure)))
        for number in spoken(figure.script.read_text("utf-8")):
            value = results.get(name, {}).get(number)
            right = float(number) in known if value is None else f"{value:.{len(number.partition('.')[2])}f}" == number
            loose += [] if right else [f"{name}: {number}"]
    assert loose == []


def test_a_number_in_a_caption_is_found() -> None:
    assert spoken('"""Rough surfaces.\n\nAt $\\\\alpha = 0.4$, seen at 60°, 3 % are lost."""') == {"0.4", "60", "3"}
