"""The chart behind a choice: cost against error, the tolerance, and the candidates that no other beats in both."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microfacet.files import writable, write

Dots = Mapping[str, NDArray[Any]]  # as `Choice.data` has them
COLOURS = {"within": "#009E73", "beyond": "#8F3B76", "open": "#E69F00"}
VERDICT_LABELS = {"within": "enough", "beyond": "not enough", "open": "not known"}
MARKS = {
    "none": ("o", "single scattering"),
    "scaled": ("s", "scaled"),
    "lobe": ("^", "lobe added"),
    "walk": ("D", "random walk"),
}


def refuse(path: Path) -> None:
    """ValueError, in one sentence, if no chart can be written there: an unknown ending, not a plain file, no matplotlib."""
    if path.suffix not in (".svg", ".pdf", ".png"):
        raise ValueError(f"chart must end in .svg, .pdf or .png, got {path.name!r}")
    writable(path)
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise ValueError("chart needs matplotlib, which is not installed") from None


def save(dots: Dots, path: Path) -> None:
    """Write the chart; ValueError, in one sentence, where `refuse` raises one, or if no cost is known."""
    refuse(path)
    if not np.isfinite(dots["cost"]).any():
        raise ValueError("chart needs the candidates' costs, and none is known")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    draw(figure.subplots(), dots)
    drawn = io.BytesIO()
    figure.savefig(drawn, format=path.suffix[1:])
    write(path, drawn.getvalue())


def front(cost: NDArray[Any], error: NDArray[Any]) -> NDArray[np.bool_]:
    """The Pareto front: the candidates of known cost that no other beats in both cost and error."""
    points = list(zip(cost.tolist(), error.tolist(), strict=True))
    on = [math.isfinite(a) and not any(c <= a and e <= b and (c, e) != (a, b) for c, e in points) for a, b in points]
    return np.array(on, bool)


def draw(ax: Any, dots: Dots) -> None:
    """Every candidate as a dot at its error or the bound of that, whichever is larger; open in single precision.

    A line joins the Pareto front, the tolerance is dashed, the choice ringed.
    """
    cost, error = dots["cost"], np.maximum(dots["error"], dots["bound"])
    order = np.argsort(cost)[front(cost, error)[np.argsort(cost)]]
    ax.plot(cost[order], error[order], color="0.6", linewidth=0.8, linestyle="-", zorder=1)
    ax.axhline(float(dots["tolerance"]), color="#1A1A1A", linewidth=0.8, linestyle="--", zorder=1)
    for kind, (mark, label) in MARKS.items():
        if (dots["compensation"] == kind).any():
            ax.plot([], [], mark, color="0.4", markersize=4, linestyle="none", label=label)
        for verdict, colour in COLOURS.items():
            for single in (False, True):
                chosen = (dots["compensation"] == kind) & (dots["verdict"] == verdict) & (dots["single"] == single)
                style = {"color": colour, "markerfacecolor": "none" if single else colour, "markersize": 4, "linestyle": "none"}
                ax.plot(cost[chosen], error[chosen], mark, zorder=3, **style)
    for verdict in dict.fromkeys(dots["verdict"].tolist()):
        ax.plot(
            [],
            [],
            "_",
            color=COLOURS[verdict],
            markersize=8,
            markeredgewidth=3,
            linestyle="none",
            label=VERDICT_LABELS[verdict],
        )
    ring = {"markersize": 11, "markerfacecolor": "none", "markeredgecolor": COLOURS["within"], "linestyle": "none"}
    ax.plot(cost[dots["chosen"]], error[dots["chosen"]], "o", zorder=2, **ring)
    ax.set(xscale="log", yscale="log", xlabel="cost (ns a value)", ylabel=f"error ({dots['measure']})")
    ax.legend(loc="best")
