"""The report obeys its own rule: a figure with light in it says which model it used, and why that was enough."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import inventory
import pytest

ROOT = Path(__file__).parents[2]
LIGHT = re.compile(r"\b(Microfacet|RandomWalk|Compensated|CAMPAIGN|rivals_render|Comparison)\b")


@pytest.fixture(autouse=True)
def at_root(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The inventory looks at the current folder, once."""
    monkeypatch.chdir(ROOT)
    inventory.figures.cache_clear()
    yield
    inventory.figures.cache_clear()


def test_figures_that_make_light_name_their_model() -> None:
    making = {
        name
        for name, one in inventory.figures().items()
        if one.data_script and one.stage != "speed" and LIGHT.search(one.data_script.read_text("utf-8"))
    }
    assert len(making) > 8
    assert {name for name in making if not inventory.figures()[name].model} == set()


def test_a_model_is_two_strings(tmp_path: Path) -> None:
    script = tmp_path / "plain.py"
    script.write_text('"""Words."""\nSLIDES = (1,)\nMODEL = ("Smith", "why not")\n')
    found = inventory.read_figure(script)
    assert found
    assert found.model == ("Smith", "why not")
    for wrong in ('"Smith"', '("Smith",)', "3", "name"):
        script.write_text(f'"""Words."""\nSLIDES = (1,)\nMODEL = {wrong}\n')
        with pytest.raises(SystemExit, match="MODEL is two strings"):
            inventory.read_figure(script)


def test_the_table_has_every_model_that_a_chapter_shows() -> None:
    import cells

    told = cells.models_of_light(caption="Models.", label="tbl:models").text
    shown = {name for chapter in inventory.chapters().values() for name in chapter.named("figure")}
    named = {name for name, one in inventory.figures().items() if one.model and name in shown}
    assert set(re.findall(r"@fig:(\w+)", told)) == named
    assert len(named) > 8
