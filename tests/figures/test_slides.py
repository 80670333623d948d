"""Every slide with something to draw has its figure, by number and by name, and every figure is shown and spoken of."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import build
import inventory
import pytest
from slides import AWAITED, MOVING, SLIDES

ROOT = Path(__file__).resolve().parents[2]
DRAWN = {n for entry in SLIDES if entry.drawn for n in range(entry.first, entry.last + 1)}
CAPTIONED = re.compile(r"@fig:(\w+)")


@pytest.fixture(autouse=True)
def at_root(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The inventory looks at the current folder, once."""
    monkeypatch.chdir(ROOT)
    inventory.chapters.cache_clear()
    inventory.figures.cache_clear()
    yield
    inventory.chapters.cache_clear()
    inventory.figures.cache_clear()


def test_the_list_has_every_slide_once() -> None:
    told = [n for entry in SLIDES for n in range(entry.first, entry.last + 1)]
    assert told == list(range(1, 76))
    assert len({entry.about for entry in SLIDES}) == len(SLIDES)


def test_every_slide_with_something_to_draw_is_drawn() -> None:
    drawn = set(inventory.drawn_slides())
    assert DRAWN - drawn == set(AWAITED), "slides without a figure, or no longer awaited"


def test_a_figure_rebuilds_slides_of_the_talk() -> None:
    """None at all, if it goes beyond the talk."""
    for name, figure in inventory.figures().items():
        assert set(figure.slides) <= set(range(1, 76)), name
        assert list(figure.slides) == sorted(set(figure.slides)), name


def test_every_drawn_slide_is_a_target_and_so_is_every_figure() -> None:
    targets = build.targets()
    for slide in DRAWN - set(AWAITED):
        assert targets[f"slide_{slide}"], slide
        assert all(slide in inventory.figures()[name].slides for name in targets[f"slide_{slide}"])
    assert set(inventory.figures()) <= set(targets)


def test_no_figure_is_an_orphan_or_unmentioned() -> None:
    """Each is shown in one chapter, and that chapter's prose refers to it."""
    shown: Counter[str] = Counter()
    for stem, chapter in inventory.chapters().items():
        prose = set(CAPTIONED.findall(inventory.CELL.sub("", chapter.path.read_text("utf-8"))))
        for name in chapter.named("figure"):
            shown[name] += 1
            assert name in prose, f"{stem} shows {name} and does not speak of it"
    assert shown == Counter(list(inventory.figures()))


@pytest.mark.parametrize("slide", MOVING)
def test_what_moves_in_the_talk_moves_here(slide: int) -> None:
    assert any(inventory.figures()[name].moves for name in inventory.figures_of_slide(slide))


def test_a_caption_ends_its_first_sentence_and_goes_on() -> None:
    for name, figure in inventory.figures().items():
        assert figure.title.endswith("."), name
        assert len(figure.caption) > len(figure.title), name
