"""The chart behind a choice: cost against error, the tolerance, and the candidates that no other beats in both."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from microfacet.enough.choice import Choice, Row

COLOURS = {"within": "#009E73", "beyond": "#8F3B76", "open": "#E69F00"}
WORDS = {"within": "enough", "beyond": "not enough", "open": "not known"}
MARKS = {"none": "o", "scaled": "s", "walk": "D"}
LEAST = 1e-6  # errors below this are drawn there


def save(choice: Choice, path: Path) -> None:
    """Write the chart; ValueError, in one sentence, if matplotlib is missing, the ending unknown, or no cost known."""
    if path.suffix not in (".svg", ".pdf", ".png"):
        raise ValueError(f"chart must end in .svg, .pdf or .png, got {path.name!r}")
    if not any(math.isfinite(row.cost) for row in choice.rows):
        raise ValueError("chart needs the candidates' costs, and none is known")
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ValueError("chart needs matplotlib, which is not installed") from None
    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    draw(figure.subplots(), choice)
    try:
        figure.savefig(path)
    except OSError as fault:
        raise ValueError(f"chart cannot be written to {path}: {fault.strerror}") from None


def draw(ax: Any, choice: Choice) -> None:
    """Every candidate as a dot, the front as a line through those that no other beats."""
    known = [(row, on) for row, on in zip(choice.rows, choice.front(), strict=True) if math.isfinite(row.cost)]
    front = sorted((row.cost, _drawn(row)) for row, on in known if on)
    ax.plot(*zip(*front, strict=True), color="0.6", linewidth=0.8, linestyle="-", zorder=1)
    ax.axhline(choice.tolerance, color="#1A1A1A", linewidth=0.8, linestyle="--", zorder=1)
    seen: set[str] = set()
    for row, _ in known:
        look: dict[str, Any] = {"color": COLOURS[row.verdict], "marker": MARKS[row.candidate.compensation], "linestyle": "none"}
        fill = {"markerfacecolor": "none"} if row.candidate.single else {}
        label = None if row.verdict in seen else WORDS[row.verdict]
        seen.add(row.verdict)
        ax.plot(row.cost, _drawn(row), markersize=4, label=label, zorder=3, **look, **fill)
    if choice.chosen and math.isfinite(choice.chosen.cost):
        place = choice.chosen.cost, _drawn(choice.chosen)
        ax.plot(*place, "o", markersize=11, markerfacecolor="none", markeredgecolor=COLOURS["within"], zorder=2)
    ax.set(xscale="log", yscale="log", xlabel="cost (ns a value)", ylabel=f"error ({choice.measure})")
    ax.legend(loc="best")


def _drawn(row: Row) -> float:
    return max(row.measured.error.value, LEAST)
