"""What a chapter opens and never closes, so that pandoc would swallow the rest, or print it as it stands, without a word."""

from __future__ import annotations

import re
from collections.abc import Iterator

CODE = re.compile(r"[ \t>]*(`{3,}(?=[^`]*$)|~{3,})(.*)")
DIV = re.compile(r"[ \t>]*(:{3,})(.*)")
INLINE_CODE = re.compile(r"(?<!`)(`+)(?!`).+?(?<!`)\1(?!`)")
FORMULA = re.compile(r"(?<!\\)\$\$")
FRONT = re.compile(r"---\n.*?^---$", re.M | re.S)


def unclosed(text: str) -> Iterator[tuple[int, str]]:
    """Place and name of each fence, box and displayed formula that is not closed."""
    if text.startswith("---\n") and not FRONT.match(text):
        yield 0, "the front matter"
    code, boxes, formula = (0, ""), list[tuple[int, str]](), (0, "")
    for at, line in lines(text):
        if code[1]:
            code = code if not closes(line, code[1]) else (0, "")
        elif match := CODE.match(line):
            code = at, match[1]
        elif match := DIV.match(line):
            boxes = [*boxes, (at, match[1])] if match[2].strip(" :") else boxes[:-1]
        else:
            for sign in FORMULA.finditer(INLINE_CODE.sub(lambda m: " " * len(m[0]), line)):
                formula = (0, "") if formula[1] else (at + sign.start(), "$$")
    yield from ((at, f"the fence {fence}") for at, fence in sorted([code, formula, *boxes]) if fence)


def lines(text: str) -> Iterator[tuple[int, str]]:
    """Each line and where it begins."""
    at = 0
    for line in text.split("\n"):
        yield at, line
        at += len(line) + 1


def closes(line: str, fence: str) -> bool:
    """A fence is closed by one as long at least, of the same sign, alone on its line."""
    bare = line.strip(" \t>")
    return len(bare) >= len(fence) and set(bare) == {fence[0]}
