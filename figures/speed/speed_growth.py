r"""How time grows: with the number of values, with the side of a surface, and with the digits that are proved.

Dots are medians on record with their quartiles, dotted lines the expected power, drawn through the last dot: 1 for values of
the BRDF; 2 for making a surface of $n \times n$ nodes, and 0 for tracing a fixed number of rays on it; 1 for the digits to
which Arb encloses an integral. Numbers at the lines are fitted powers.
"""

import sys

import numpy as np
from report import plotting

SLIDES = ()
PANELS = (("values",), ("surfaces", "rays"), ("digits",))
LOOKS = {"values": ("view", "o"), "surfaces": ("light", "s"), "rays": ("lost", "^"), "digits": ("green", "D")}
TITLES = ("values of the BRDF", "side of a surface", "proved digits")


def line(ax: plotting.Axes, data: dict, name: str) -> None:
    hue, marker = LOOKS[name]
    sizes, (low, middle, high) = data[f"{name}_sizes"], data[f"{name}_times"].T
    known = np.isfinite(middle)
    if not known.any():
        return
    colour, last = plotting.COLOURS[hue], np.flatnonzero(known)[-1]
    ax.errorbar(
        sizes, middle, (middle - low, high - middle), color=colour, marker=marker, markersize=4, linestyle="", elinewidth=0.8
    )
    fitted = sizes >= data[f"{name}_first"]
    expected = middle[last] * (sizes[fitted] / sizes[last]) ** data[f"{name}_expected"]
    ax.plot(sizes[fitted], expected, color=colour, linestyle=":", linewidth=1)
    words = {"surfaces": "making it", "rays": "rays"}.get(name, "")
    told = f"{words} {float(data[f'{name}_power']):.2f}".strip()
    shift = (2, -14) if name == "rays" else (-5, 7)
    ax.annotate(told, (sizes[last], middle[last]), shift, textcoords="offset points", ha="right", color=colour, fontsize=8)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.5, ncols=3)
    figure.subplots_adjust(left=0.09, right=0.985, bottom=0.185, top=0.92, wspace=0.32)
    for ax, names, title in zip(axes, PANELS, TITLES, strict=True):
        ax.set(xscale="log", yscale="log", xlabel=title)
        for name in names:
            line(ax, data, name)
        if not any(np.isfinite(data[f"{name}_times"]).any() for name in names):
            plotting.label(ax, (0.5, 0.5), "not measured yet:\nmake bench\nNAME=growth", transform=ax.transAxes, fontsize=8)
            ax.set(xlim=(1, 10), ylim=(1, 10))
        low, high = ax.get_ylim()
        ax.set_ylim(low, 2 * high)
    for ax, ticks in zip(axes[1:], ((256, 1024, 8192), (4, 10, 20, 50)), strict=True):
        ax.set_xticks(ticks, [str(tick) for tick in ticks])
        ax.minorticks_off()
    axes[0].set_title(str(data["stale"]))
    axes[0].set_ylabel("time (seconds)")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
