"""Drawings that move: parts of a figure, found by their gid, follow CSS keyframes inside an SVG.

The stills on paper and the motion on the web come from one script. Readers who have asked the system for reduced motion
see the first moment at rest. Like `report.plotting`, this module is never imported by the library itself.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from report.datafile import put
from report.plotting import Array, Axes, Figure

PERIOD = 10.0
CSS = {"delay": "animation-delay", "origin": "transform-origin"}
ENDING = ".moving.svg"


@dataclass
class Motion:
    """Keyframes by name, and for each moving part (by gid) the keyframes that it follows and its own values."""

    figure: Figure
    keyframes: dict[str, str] = field(default_factory=dict)
    parts: dict[str, tuple[str, dict[str, str]]] = field(default_factory=dict)

    def follow(self, gid: str, name: str, **values: str) -> None:
        """Let the part `gid` follow the keyframes `name`, which read `values` as --value.

        Two values are special: `delay` shifts the part in time, and `origin` is what stays in place when it is
        scaled; lines keep their width then.
        """
        self.parts[gid] = (name, values)

    def css(self) -> str:
        frames = "".join(f"@keyframes {name} {{ {body} }}\n" for name, body in self.keyframes.items())
        rules = "".join(rule(gid, name, values) for gid, (name, values) in self.parts.items())
        still = "@media (prefers-reduced-motion: reduce) { * { animation: none !important; } }"
        return f"{frames}{rules}{still}"


def rule(gid: str, name: str, values: Mapping[str, str]) -> str:
    """A part's own style: CSS properties, or variables for its keyframes."""
    own = "".join(f" {CSS.get(key, '--' + key)}: {value};" for key, value in values.items())
    lines = f"#{gid} path {{ vector-effect: non-scaling-stroke; }}\n" if "origin" in values else ""
    return f"#{gid} {{ animation: {name} {PERIOD:g}s ease-in-out infinite;{own} }}\n{lines}"


def on_paper(ax: Axes, places: ArrayLike) -> Array:
    """Places in the coordinates of `ax`, shape (..., 2), as the SVG counts them: points from its upper left corner."""
    figure = ax.figure
    figure.canvas.draw()
    pixels = ax.transData.transform(np.asarray(places, dtype=float))
    pixels[..., 1] = figure.bbox.height - pixels[..., 1]
    scaled: Array = pixels * 72 / figure.dpi
    return scaled


def split(outputs: Iterable[str]) -> tuple[list[str], list[str]]:
    """Paths of stills, and paths of moving drawings (NAME.moving.svg)."""
    outputs = list(outputs)
    moving = [path for path in outputs if path.endswith(ENDING)]
    return [path for path in outputs if path not in moving], moving


def save(motion: Motion, outputs: Iterable[str]) -> None:
    """Write the moving drawing to every path in `outputs`, the same bytes each time."""
    text = svg(motion)
    for output in outputs:
        put(output, text)
    plt.close(motion.figure)


def svg(motion: Motion) -> str:
    """The drawing with its style sheet; every part that is to move must be there once."""
    drawn = io.BytesIO()
    motion.figure.savefig(drawn, format="svg", metadata={"Date": None, "Creator": None})
    text = drawn.getvalue().decode()
    for gid in motion.parts:
        if len(re.findall(f'<g id="{re.escape(gid)}"', text)) != 1:
            raise ValueError(f"the drawing must have exactly one part called {gid!r} to move")
    head, rest = text.split("</defs>", 1)
    return f'{head}</defs>\n <style type="text/css">\n{motion.css()}\n </style>{rest}'
