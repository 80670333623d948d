"""What a chapter's cells may call. Each helper but `data` and `sci` returns Markdown: it shows in a notebook too.

from cells import computed, data, equation, figure, ledger_table, listing, models_of_light, sci, table, verdicts
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from math import ceil, log10
from pathlib import Path
from typing import Any

import inventory
import seal


class Markdown:
    """Text that a notebook shows as Markdown and that the report's build hands to pandoc."""

    def __init__(self, text: str) -> None:
        self.text = text

    def _repr_markdown_(self) -> str:
        return self.text


def equation(key: str) -> Markdown:
    """A statement of the library, numbered, with its check marks."""
    return Markdown(f"$$ {_facts(key)['latex']} $$ {{#eq:{key}}}")


def computed(key: str) -> Markdown:
    """A statement in the form that the library evaluates, which keeps its digits; it has no number of its own."""
    return Markdown(f"$$ {_facts(key)['computed_latex']} $$")


def _facts(key: str) -> dict[str, Any]:
    statements = inventory.statements()
    if key not in statements:
        raise LookupError(inventory.unknown("equation", key, statements))
    return statements[key]


def figure(name: str, width: float = 100, place: str = "auto") -> Markdown:
    """A figure by its name, `width` per cent of the text wide; its script holds the caption.

    It floats to the `top` or `bottom` of a page, whichever is nearer (`auto`), or stands `here`.
    """
    figures = inventory.figures()
    if name not in figures:
        raise LookupError(inventory.unknown("figure", name, figures))
    drawn = figures[name]
    caption = f"**{drawn.title}** {drawn.caption}".strip()
    slides = ",".join(map(str, drawn.slides))
    image = f"build/figures/{name}.svg"
    more = f" moving={drawn.moving}" if drawn.moves else ""
    return Markdown(f'![{caption}]({image}){{#fig:{name} width={width:g}% slides="{slides}" place={place}{more}}}')


def data(name: str) -> Any:
    """The arrays behind a figure (build/data/NAME.npz), for numbers quoted in the prose."""
    import numpy as np

    if name not in inventory.figures() or not inventory.figures()[name].data:
        with_data = [n for n, f in inventory.figures().items() if f.data]
        raise LookupError(inventory.unknown("figure with data", name, with_data))
    path = Path(f"build/data/{name}.npz")
    seal.refuse_broken([path])
    return np.load(path)


def table(
    rows: Sequence[Sequence[object]],
    headers: Sequence[str],
    *,
    caption: str,
    label: str,
    align: str = "",
) -> Markdown:
    """A table; `align` has one letter a column (l, c, r), else numbers go right and text left."""
    body = [[cell_text(cell) for cell in row] for row in rows]
    if any(len(row) != len(headers) for row in body):
        raise ValueError(f"the table {label} has rows of another length than its {len(headers)} headers")
    letters = align or "".join(guess(list(column)) for column in zip(*rows, strict=True))
    rule = {"l": ":--", "c": ":-:", "r": "--:"}
    lines = [headers, [rule[letter] for letter in letters], *body]
    text = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    return Markdown(f"{text}\n\n: {caption} {{#{label}}}")


def listing(function: Callable[..., Any]) -> Markdown:
    """The text of a function, to be copied."""
    return Markdown(f"```python\n{inspect.getsource(function).strip()}\n```")


def cell_text(cell: object) -> str:
    text = f"{cell:.4g}" if isinstance(cell, float) else str(cell)
    if "|" in text or "\n" in text:
        raise ValueError(f"a table's cell cannot hold a bar or a line break: {text!r}")
    return text


def sci(number: float) -> str:
    """A number by its order of magnitude, with one digit, as mathematics."""
    factor, power = f"{float(number):.0e}".split("e")
    if int(power) == 0:
        return factor
    return f"$10^{{{int(power)}}}$" if factor == "1" else rf"${factor} \cdot 10^{{{int(power)}}}$"


def guess(column: list[object]) -> str:
    return "r" if column and all(isinstance(cell, int | float) for cell in column) else "l"


def models_of_light(*, caption: str, label: str) -> Markdown:
    """Every figure with light in it that a chapter shows: the model that its script names, and why that was enough."""
    in_chapters = dict.fromkeys(name for chapter in inventory.chapters().values() for name in chapter.named("figure"))
    rows = [(name, *one.model) for name in in_chapters if (one := inventory.figures()[name]).model]
    lines = [f"| [@fig:{name}] | {cell_text(which)} | {cell_text(why)} |" for name, which, why in rows]
    head = [
        "| Figure | Model | Enough, because |",
        "|:-----------|:------------------------------|:------------------------------|",
    ]
    return Markdown("\n".join([*head, *lines]) + f"\n\n: {caption} {{#{label}}}")


EQUATIONS = {
    "projected_area": "projected area",
    "visible_area": "visible area",
    "visible_norm": "visible normals",
    "weak_furnace": "weak white furnace",
    "positivity": "positivity",
    "reciprocity": "reciprocity",
    "energy": "largest albedo",
}


def verdicts(validations: Mapping[str, Any], equations: Sequence[str], *, caption: str, label: str) -> Markdown:
    """One row per model, by name; for each of the validation equations its verdict and residual."""
    rows = [[name, *(verdict_text(verdicts[e]) for e in equations)] for name, verdicts in validations.items()]
    headers = ["Model", *(EQUATIONS[e] for e in equations)]
    return table(rows, headers, caption=caption, label=label, align="l" + "r" * len(equations))


def verdict_text(verdict: Any) -> str:
    """A sign, and the residual: few digits where it stands clear of its error, else a power of ten above both."""
    sign = {"holds": "✓", "fails": "✗", "undecided": "?"}[verdict.verdict]
    if verdict.equation == "energy":
        return f"{1 + verdict.residual:.3f} {sign}"
    size = abs(verdict.residual) + verdict.bound
    if verdict.verdict == "holds":
        return f"$< 10^{{{ceil(log10(size))}}}$ {sign}" if size else f"0 {sign}"
    return f"${verdict.residual:+.3f}$ {sign}"


def ledger_table() -> Markdown:
    """Every statement, how it was checked and how well: the template sets it from the ledger."""
    return Markdown("::: {.ledger}\n:::")
