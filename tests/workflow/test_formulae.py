"""Formulae come out as they were written, or the build stops and shows them."""

from __future__ import annotations

import re
from pathlib import Path

import chapter
import pytest
import typst

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BATTERY = HERE / "battery.md"


@pytest.fixture(autouse=True)
def in_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def typst_of(markdown: str) -> str:
    """What the filter makes of it, without the line that imports the template."""
    return chapter.to_typst(markdown, Path("test")).split("\n", 1)[1].strip()


def pages(text: str) -> bytes:
    return bytes(typst.compile(text.encode(), ignore_system_fonts=True))


def test_the_battery_is_set(tmp_path: Path) -> None:
    body = typst_of(BATTERY.read_text("utf-8"))
    assert pages(f"#set math.equation(numbering: none)\n{body}").startswith(b"%PDF")


def test_the_battery_holds_every_command_that_is_allowed() -> None:
    listed = re.search(r"local commands = set \[\[(.*?)\]\]", (ROOT / "workflow/filter.lua").read_text("utf-8"), re.S)
    assert listed
    used = set(re.findall(r"\\([A-Za-z]+)", BATTERY.read_text("utf-8")))
    assert set(listed[1].split()) <= used


REFUSED = [
    r"\bigl\langle x \bigr\rangle", r"\Big( x \Big)", r"a\!b", r"a\;b", r"a\:b", r"\left. x \right|_0",
    r"\left( x \right]", r"\left( x", r"x \right)", r"\begin{array}{c} a \end{array}", r"a \tag{1}",
    r"\color{red} x", r"\begin{aligned} a &= b & c &= d \end{aligned}",
    r"\left\{ \begin{aligned} a \end{aligned} \right\}",
    r"\dfrac{a}{b}", r"\tfrac{a}{b}", r"\|x\|", r"|x|", r"\begin{vmatrix} a \end{vmatrix}", r"a \cap b", r"a \otimes b",
    r"a \odot b", r"\displaystyle x", r"\int\limits_0^1 x", r"\sum\nolimits_i x",
    r"\begin{matrix} a & b \end{matrix}", r"\hspace{1em}", r"\unknown",
]  # fmt: skip


@pytest.mark.parametrize("tex", REFUSED)
@pytest.mark.parametrize("form", ["${}$", "$$ {} $$", "$$ {} $$ {{#eq:x}}"])
def test_what_pandoc_gets_wrong_is_refused(tex: str, form: str) -> None:
    with pytest.raises(SystemExit) as stop:
        typst_of("Text.\n\n" + form.format(tex))
    assert tex in str(stop.value)
    assert "formula uses" in str(stop.value)


@pytest.mark.parametrize(
    ("tex", "typst_text"),
    [
        (r"\mathrm{erfc}(x)", r'op("erfc") \( x \)'),
        (r"\operatorname{erf}(x)", r'op("erf") \( x \)'),
        (r"x \text{ if } y", r'x upright(" if ") y'),
        (r"\mathrm{d}x", "upright(d) x"),
    ],
)
def test_words_in_formulae(tex: str, typst_text: str) -> None:
    assert typst_of(f"${tex}$") == f"${typst_text}$"


def test_labels_and_references() -> None:
    text = typst_of("See [@eq:a.b], [-@fig:c] and [@heitz2014, eq. 7].\n\n$$ x $$ {#eq:a.b}\n\n$$ y $$\n")
    assert '#refer(label("eq:a.b"))' in text
    assert '#refer-bare(label("fig:c"))' in text
    assert "@heitz2014[eq. 7]" in text
    assert "$ x $ <eq:a.b>" in text
    assert "#math.equation(block: true, numbering: none, $ y $)" in text


@pytest.mark.parametrize(
    "text",
    ["Words $$ x $$ {#eq:a}", "[@eq:a; @heitz2014]", "A <b>bold</b> word.", "<hr>", r"\newpage"],
)
def test_prose_that_would_be_lost_is_refused(text: str) -> None:
    with pytest.raises(SystemExit):
        typst_of(text)
