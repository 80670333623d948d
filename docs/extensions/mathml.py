"""Formulas as MathML, which browsers draw by themselves: neither scripts nor fonts have to be fetched."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert_to_element

FUNCTIONS = {"cos", "sin", "tan", "cot", "exp", "ln", "log", "min", "max"}


def mathml(latex: str, display: str) -> str:
    whole = convert_to_element(latex, display=display)
    for row in [*whole.iter("mrow")]:
        space(row)
    return ET.tostring(whole, "unicode").replace("&amp;#", "&#")  # the converter writes characters as entities


def space(row: ET.Element) -> None:
    """Set functions apart from what is before and behind, as TeX does: browsers do not."""
    children = list(row)
    for k in reversed(range(len(children))):
        if not ({children[k].text, *(part.text for part in children[k][:1])} & FUNCTIONS):
            continue
        if k + 1 < len(children) and children[k + 1].tag not in ("mo", "mrow"):
            row.insert(k + 1, ET.Element("mspace", width="0.17em"))
        if k and children[k - 1].tag != "mo":
            row.insert(k, ET.Element("mspace", width="0.17em"))


def inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="formula">{mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
