"""Drawing helpers that the report's figures share. The library itself never imports this module."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Polygon
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike, NDArray

from report.datafile import load, put

__all__ = [
    "COLOURS",
    "TILTS",
    "WIDTH",
    "Array",
    "Axes",
    "Figure",
    "arrow",
    "box",
    "canvas",
    "ground",
    "hemisphere",
    "label",
    "load",
    "overlaps",
    "pieces",
    "save",
    "scene",
    "verdict",
]

Array = NDArray[np.float64]
Style = dict[str, Any]

WIDTH = 6.0
"""Width of the report's text in inches: a figure of this width is set at its drawn size."""

COLOURS = {
    "ink": "#1A1A1A",
    "grey": "#6E6E6E",
    "ground": "#ECEBE8",
    "view": "#0072B2",
    "light": "#C75000",
    "lost": "#8F3B76",
    "sky": "#56B4E9",
    "amber": "#E69F00",
    "green": "#009E73",
}
"""Meanings, not hues: ``view`` is what the viewer sees, ``light`` is reflected, ``lost`` is blocked or hidden."""

TILTS = ("#0B4F82", "#5AA2D0", "#A9A29A", "#E9A23B", "#B4460F")
"""One colour for each of five bins of normals, from those that lean left to those that lean right."""

_METADATA: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
}


def canvas(script: str, height: float, **options: Any) -> tuple[Figure, Any]:
    """Figure of full text width and its axes (``plt.subplots`` options), in the style beside the ``script``'s stage."""
    for folder in Path(script).resolve().parents:
        style = folder / "report.mplstyle"
        if style.exists():
            plt.style.use(["default", style])
            return plt.subplots(figsize=(WIDTH, height), **options)
    raise FileNotFoundError(f"no report.mplstyle in any folder above {script}")


def save(figure: Figure, outputs: Iterable[str]) -> None:
    """Write ``figure`` to every path in ``outputs`` (.svg, .pdf, .png), the same bytes each time."""
    for output in outputs:
        path = Path(output)
        if path.suffix[1:] not in _METADATA:
            raise SystemExit(f"A figure is written as .svg, .pdf or .png, not as {path.name}.")
        drawn, form = io.BytesIO(), path.suffix[1:]
        figure.savefig(drawn, format=form, metadata=_METADATA[form])
        put(path, drawn.getvalue())
    plt.close(figure)


def scene(ax: Axes, x: tuple[float, float], z: tuple[float, float]) -> Axes:
    """Turn ``ax`` into a drawing board: no frame, one scale, the given limits."""
    ax.set(xlim=x, ylim=z, aspect="equal", xticks=[], yticks=[])
    ax.axis("off")
    return ax


def ground(ax: Axes, x: ArrayLike, z: ArrayLike, depth: float, nodes: bool = False, **style: Any) -> None:
    """Surface with heights ``z`` over ``x``, filled down to ``-depth``."""
    x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
    outline = np.stack([np.r_[x, x[-1], x[0]], np.r_[z, -depth, -depth]], axis=-1)
    ax.add_patch(Polygon(outline, facecolor=COLOURS["ground"], edgecolor="none", zorder=0))
    defaults: Style = {"color": COLOURS["ink"], "linestyle": "-", "linewidth": 1.0, "zorder": 2}
    ax.plot(x, z, **(defaults | style))
    if nodes:
        ax.plot(x, z, ".", color=COLOURS["ink"], markersize=3, zorder=4)


def arrow(ax: Axes, start: ArrayLike, stop: ArrayLike, **style: Any) -> None:
    """Arrow from ``start`` to ``stop``, in the coordinates of ``ax``."""
    defaults: Style = {"color": COLOURS["ink"], "linewidth": 0.9, "arrowstyle": "-|>", "mutation_scale": 7, "zorder": 5}
    ends = (tuple(np.asarray(end, dtype=float)) for end in (start, stop))
    ax.add_patch(FancyArrowPatch(*ends, shrinkA=0, shrinkB=0, **(defaults | style)))


def label(ax: Axes, place: ArrayLike, text: str, **style: Any) -> Text:
    """Text centred at ``place`` in the coordinates of ``ax``."""
    x, z = np.asarray(place, dtype=float)
    defaults: Style = {"ha": "center", "va": "center", "color": COLOURS["ink"], "zorder": 6}
    return ax.text(x, z, text, **(defaults | style))


def box(corner: tuple[float, float], width: float, height: float) -> FancyBboxPatch:
    """Frame with its lower left ``corner``, for diagrams."""
    defaults: Style = {"boxstyle": "round,pad=0,rounding_size=0.04", "facecolor": "none", "edgecolor": COLOURS["grey"]}
    return FancyBboxPatch(corner, width, height, linewidth=0.7, zorder=6, **defaults)


def verdict(ax: Axes, place: ArrayLike, holds: bool, size: float = 0.055) -> None:
    """Green tick or purple cross around ``place``, ``size`` in the coordinates of ``ax``."""
    tick, strokes = [[(-1, 0), (-0.3, -0.8), (1, 1)]], [[(-1, -1), (1, 1)], [(-1, 1), (1, -1)]]
    for line in tick if holds else strokes:
        x, z = (np.asarray(place) + size * np.array(line, dtype=float)).T
        ax.plot(x, z, color=COLOURS["green" if holds else "lost"], linestyle="-", linewidth=1.5, zorder=6)


def pieces(ax: Axes, ends: Array, colours: Sequence[str], **style: Any) -> None:
    """Segments with ``ends`` of shape (n, 2, 2), each in its colour; those of no length are left out."""
    defaults: Style = {"linestyle": "-", "linewidth": 2.6, "solid_capstyle": "butt", "zorder": 3}
    for (start, stop), colour in zip(ends, colours, strict=True):
        if np.any(start != stop):
            ax.plot([start[0], stop[0]], [start[1], stop[1]], **(defaults | {"color": colour} | style))


LEVELS = 15  # bands of a hemisphere; an odd number has one around 0


def hemisphere(ax: Axes, theta: Array, phi: Array, values: Array, top: float, *, signed: bool = False) -> ContourSet:
    """Filled contours of values (t, p) in bins with the edges ``theta`` and ``phi``, radians.

    They go from 0 to ``top`` or, if the values are ``signed``, from -top to top in colours that part at 0. The rim is the
    horizon and the view, at azimuth 0, is on the left; equal areas are equal solid angles.
    """
    rows, azimuth = ((edges[1:] + edges[:-1]) / 2 for edges in (theta, phi))
    radius = np.sqrt(2) * np.sin(np.r_[0, rows, np.pi / 2] / 2)[:, None]
    filled = np.vstack([np.full(len(azimuth), values[0].mean()), values, values[-1]])
    azimuth, filled = np.r_[azimuth, azimuth[0] + 2 * np.pi], np.hstack([filled, filled[:, :1]])
    least = -top if signed else 0.0
    levels, colours = np.linspace(least, top, LEVELS + 1), "PuOr_r" if signed else None
    x, y = -radius * np.cos(azimuth), radius * np.sin(azimuth)
    contours = ax.contourf(x, y, np.clip(filled, least, top), levels, cmap=colours)
    around = np.linspace(0, 2 * np.pi, 181)
    ax.plot(np.cos(around), np.sin(around), color=COLOURS["grey"], linestyle="-", linewidth=0.6)
    scene(ax, x=(-1.05, 1.05), z=(-1.05, 1.05))
    return contours


def overlaps(figure: Figure) -> list[str]:
    """Faults of the layout: texts that touch one another or leave the figure, one sentence each."""
    figure.canvas.draw()
    hidden = set(_labels_not_drawn(figure))
    texts = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip() and t not in hidden]
    boxes = {f"{k}: {t.get_text()!r}": t.get_window_extent() for k, t in enumerate(texts)}
    boxes = {name: box for name, box in boxes.items() if box.width > 0}
    page = figure.bbox.padded(1)
    outside = [f"{name} leaves the figure" for name, b in boxes.items() if not _holds(page, b)]
    return outside + [f"{one} touches {two}" for one, two in combinations(boxes, 2) if boxes[one].overlaps(boxes[two])]


def _labels_not_drawn(figure: Figure) -> Iterator[Text]:
    """Labels of ticks that lie beyond the ends of their axis, or whose axes are switched off."""
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            low, high = sorted(axis.get_view_interval())
            slack = 1e-9 * (high - low)
            for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
                if not (ax.axison and low - slack <= tick.get_loc() <= high + slack):
                    yield from (tick.label1, tick.label2)


def _holds(page: Bbox, box: Bbox) -> bool:
    return bool(np.all(box.min >= page.min) and np.all(box.max <= page.max))
