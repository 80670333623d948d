"""The report's chapters show every statement once and discuss every figure they show."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import inventory
import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def at_root(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The inventory looks at the current folder, once."""
    monkeypatch.chdir(ROOT)
    forget()
    yield
    forget()


def forget() -> None:
    for function in (inventory.chapters, inventory.figures, inventory.statements):
        function.cache_clear()


def shown(helper: str) -> Counter[str]:
    """How often each name is the argument of `helper` over all chapters."""
    return Counter(name for chapter in inventory.chapters().values() for name in chapter.calls.get(helper, []))


def prose() -> str:
    return "\n".join(inventory.CELL.sub("", chapter.path.read_text("utf-8")) for chapter in inventory.chapters().values())


def test_every_statement_is_shown_once() -> None:
    import microfacet as mf

    assert shown("equation") == Counter(list(mf.equations))


def test_every_figure_is_shown_once() -> None:
    assert shown("figure") == Counter(list(inventory.figures()))


def test_every_figure_is_discussed() -> None:
    referred = set(re.findall(r"@fig:(\w+)", prose()))
    assert referred == set(inventory.figures())


def test_every_table_is_discussed() -> None:
    chapters = "\n".join(chapter.path.read_text("utf-8") for chapter in inventory.chapters().values())
    labels = re.findall(r'label="tbl:([\w-]+)"|\{#tbl:([\w-]+)\}', chapters)
    assert {first or second for first, second in labels} == set(re.findall(r"@tbl:([\w-]*\w)", prose()))


def test_every_work_is_cited() -> None:
    """By a chapter, or by the source that a statement names in the ledger."""
    works = set(re.findall(r"^@\w+\{([^,\s]+),", (ROOT / "chapters/references.bib").read_text("utf-8"), re.M))
    sources = {one.split(",")[0] for facts in inventory.statements().values() for one in facts["cite"].split("; ")}
    text = prose() + (ROOT / "chapters/abstract.md").read_text("utf-8")
    cited = set(re.findall(r"@([a-z]+\d{4}\w*)", text)) | sources
    assert cited - works == set()


def test_every_chapter_but_the_ledger_says_what_its_checks_say() -> None:
    closing = {"1_geometry", "2_visibility", "3_material", "4_brdf", "6_anisotropy"}
    assert {stem for stem, chapter in inventory.chapters().items() if "verdicts" in chapter.calls} >= closing
