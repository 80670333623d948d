"""Chapters are executed, their values put into the prose, and their faults named by line."""

from __future__ import annotations

from pathlib import Path

import cells
import chapter
import fences
import inventory
import pytest
import typeset
from checkout import Checkout

CHAPTER = """# Title {{#sec:title}}

```{{code-cell}}
:tags: [show-input]
{code}
```

The value is {{{{{inline}}}}}.
"""


def execute(folder: Path, code: str = "x = 2", inline: str = "x") -> str:
    path = folder / "chapters/3_test.md"
    path.write_text(CHAPTER.format(code=code, inline=inline))
    notebook = chapter.read_notebook(path)
    chapter.execute(path.relative_to(folder), notebook)
    return chapter.to_markdown(notebook, folder / "files")


def test_values_and_outputs(small: Checkout) -> None:
    text = execute(small.root, "x = {'a': 2 / 3}\nprint('shown')", "x['a']:>8.3f")
    assert "The value is    0.667." in text
    assert "```python\nx = {'a': 2 / 3}" in text
    assert "```\nshown\n\n```" in text or "```\nshown\n```" in text


@pytest.mark.parametrize(
    ("code", "inline", "sentence"),
    [
        ("x = nothing", "x", "chapters/3_test.md, line 5, in `x = nothing`: NameError"),
        ("x = 1", "z", "in {{z}}: NameError: name 'z' is not defined"),
        ("x = (", "x", "SyntaxError"),
    ],
)
def test_a_broken_cell_is_one_sentence(small: Checkout, code: str, inline: str, sentence: str) -> None:
    with pytest.raises(SystemExit) as stop:
        execute(small.root, code, inline)
    assert sentence in str(stop.value)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("```{note}\nx\n```\n", "the directive {note}"),
        (":::{figure} x.png\n:::\n", "the directive {figure}"),
        ("Text {eq}`x` text", "the role {eq}`x`"),
        ("Text {{1 + 1}}\nand {{f'{1 + 1}'}}", "3_test.md, line 4: an inline value with braces"),
        ("```{code-cell}\na\nb\nc\nd\ne\n```\n", "a cell of 5 lines"),
        ("~~~{code-cell}\na\n~~~\n", "3_test.md, line 3: a cell is fenced by ```, not by ~~~"),
        ("````{code-cell}\na\n````\n", "3_test.md, line 3: a cell is fenced by ```, not by ````"),
    ],
)
def test_what_the_build_would_lose_is_named(small: Checkout, text: str, fault: str) -> None:
    path = Path("chapters/3_test.md")
    path.write_text(f"# Title\n\n{text}")
    assert [fault in line for line in chapter.complaints(path)] == [True]


FENCES = {
    "```": "```python\nx = 1\n",
    "~~~": "~~~\nx = 1\n",
    "````": "````\n```\nx\n```\n",
    ":::": "::: {.note}\nText\n",
    "::::": ":::: note\n::: {.inner}\nText\n:::\n",
    "$$": "$$ x = 1\n",
}
BEFORE = {"nothing": "", "a closed one": "```\nx\n```\n\n$$ x $$\n\n", "a cell": "```{code-cell}\nx = 1\n```\n\n"}


@pytest.mark.parametrize("indent", ["", "  ", "- a\n\n    "])
@pytest.mark.parametrize("fence", [*FENCES, "```{code-cell}"])
@pytest.mark.parametrize("before", BEFORE)
def test_what_is_opened_and_never_closed_stops_with_its_line(small: Checkout, before: str, fence: str, indent: str) -> None:
    opened = FENCES.get(fence, "```{code-cell}\nx = 1\n").replace("\n", "\n" + indent.rpartition("\n")[2])
    path, sign = Path("chapters/3_test.md"), fence.removesuffix("{code-cell}")
    start = f"# Title\n\n{BEFORE[before]}{indent}"
    path.write_text(f"{start}{opened}and the rest of the chapter.\n")
    line = start.count("\n") + 1
    name = "the fence $$" if sign == "$$" else f"the fence {sign}"
    assert f"{path}, line {line}: {name} is never closed." in chapter.complaints(path)
    with pytest.raises(SystemExit, match=f"line {line}: "):
        chapter.main(path, Path("build/3_test.md"), Path("build/3_test.typ"))


@pytest.mark.parametrize(
    "text",
    [
        "```\n~~~\n```\n",
        "~~~\n```\n~~~~\n",
        "````\n```\n````\n",
        "`$$` and ``` ``x`` ``` and \\$$ 5\n",
        "$$ x $$ and $$\ny\n$$\n",
        "::: {.a}\n:::: b\n::::\n:::\n",
        "- item\n\n    ```\n    x\n    ```\n",
        "> ```\n> x\n> ```\n",
        "---\ntitle: x\n---\nText\n\n---\n",
    ],
)
def test_what_is_closed_is_no_fault(text: str) -> None:
    assert list(fences.unclosed(text)) == []


def test_pandoc_attributes_are_no_directives(small: Checkout) -> None:
    path = Path("chapters/3_test.md")
    path.write_text(
        "::: {.ledger}\n:::\n\n```{code-cell} ipython3\n:tags: [remove-cell]\na\nb\nc\n```\n\n``` {.python}\nx\n```\n"
    )
    assert chapter.complaints(path) == []


def test_what_a_chapter_names_is_found(small: Checkout) -> None:
    found = inventory.chapters()["1_visibility"]
    assert found.named("equation") == ["visibility.G1", "visibility.Lambda"]
    assert found.named("figure") == found.named("data") == ["masking"]
    assert list(inventory.chapters()) == ["1_visibility", "A_ledger"]


@pytest.mark.parametrize(
    ("inline", "parts"),
    [("x:.2f", ("x", ".2f")), ("d['a:b']:.1f", ("d['a:b']", ".1f")), ("a[1:2]", ("a[1:2]", "")), ("x", ("x", ""))],
)
def test_inline_values_split_like_an_f_string(inline: str, parts: tuple[str, str]) -> None:
    assert inventory.split_format(inline) == parts


def test_a_table_chooses_its_alignment_and_refuses_bars() -> None:
    text = cells.table([["a", 1.23456789]], ["h", "v"], caption="C.", label="tbl:t").text
    assert text == "| h | v |\n| :-- | --: |\n| a | 1.235 |\n\n: C. {#tbl:t}"
    with pytest.raises(ValueError, match="cannot hold a bar"):
        cells.table([["|x|"]], ["h"], caption="C.", label="tbl:t")
    with pytest.raises(ValueError, match="another length"):
        cells.table([["x"]], ["h", "v"], caption="C.", label="tbl:t")


def test_loose_ends_are_sentences() -> None:
    texts = {
        "1_a": '= T <sec:a>\n#refer(label("eq:missing")) @nobody',
        "2_b": '<sec:a> #refer(label("sec:a")) @heitz2014',
    }
    assert list(typeset.loose_ends(texts, ["heitz2014"])) == [
        "chapters/2_b.md labels sec:a again; it stands in chapters/1_a.md.",
        "chapters/1_a.md: There is no label called 'eq:missing'.",
        "chapters/1_a.md: There is no work in chapters/references.bib called 'nobody'.",
    ]


def test_a_computed_name_is_refused(tmp_path: Path) -> None:
    """What the build cannot see, it cannot make first."""
    chapter = tmp_path / "1_some.md"
    chapter.write_text('# Some\n\n```{code-cell}\nfigure(f"mask{ending}")\n```\n')
    with pytest.raises(SystemExit, match=r"figure\(\.\.\.\) takes a name in quotes"):
        inventory.read_chapter(chapter)
