r"""A ray that remembers its facet needs no offset.

Left, the median time of a ray on a Gaussian surface of $1024^2$ nodes, $\alpha = 0.7$ seen at $60^\circ$, here in double
precision and in Embree in single, on the same triangles, with the same rays in the same order. Right, the share of rays from
facets whose verdict, blocked or not, is wrong in Embree if they start some way along their direction. Open marks are offsets
without a wrong verdict among these rays. The library's rays start where they are.
"""

import sys

import matplotlib.ticker as ticker
import numpy as np
from report import plotting

SLIDES = ()
OURS, THEIRS = ("light", "D", "this library"), ("lost", "s", "Embree")
SHARES = {
    "reflected": ("view", "o", "-", "Embree,\nreflected", (0.04, 5e-5)),
    "shadow": ("green", "^", "--", "Embree, back\nto the viewer", (8e-3, 3e-3)),
}


def times(ax: plotting.Axes, data: dict) -> None:
    """A line for each kind of ray, from the library's time to Embree's."""
    rows = np.arange(len(data["words"]))[::-1]
    ours, theirs = data["times"][:, 1], data["embree_times"][:, 1]
    ax.hlines(rows, ours, theirs, color=plotting.COLOURS["grey"], linewidth=0.8, zorder=0)
    for (hue, marker, label), values in ((OURS, ours), (THEIRS, theirs)):
        ax.plot(values, rows, marker, color=plotting.COLOURS[hue], markersize=5, linestyle="", label=label)
    for row, low, high, ratio in zip(rows, ours, theirs, data["ratio"], strict=True):
        if np.isfinite(ratio):
            plotting.label(ax, (np.sqrt(low * high), row + 0.22), rf"$\times\,{ratio:.1f}$", fontsize=7)
    words = [words.replace(", ", ",\n") for words in data["words"]]
    ax.set(xscale="log", xlabel="time of a ray (ns)", yticks=rows, yticklabels=words, ylim=(-0.6, len(rows) - 0.4))
    ax.xaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    ax.xaxis.set_minor_locator(ticker.NullLocator())
    known = [value for value in [*ours, *theirs] if np.isfinite(value)]
    if known:
        ax.set_xlim(min(known) / 1.5, max(known) * 1.5)
    else:
        plotting.label(ax, (0.5, 0.5), "not measured yet:\nmake bench NAME=rays", transform=ax.transAxes)
        ax.set_xlim(10, 1000)
    ax.legend(loc="lower center", ncols=2, bbox_to_anchor=(0.5, 0.98), columnspacing=1, handletextpad=0.2)


def shares(ax: plotting.Axes, data: dict) -> None:
    """Wrong verdicts over the offset; none at all, and no offset at all, have a place of their own at the end of an axis."""
    offsets, floor = data["offsets"].copy(), 0.3 / data["rays"]
    offsets[0] = offsets[1] / 10
    for kind, (hue, marker, dash, words, place) in SHARES.items():
        colour, values = plotting.COLOURS[hue], data[f"embree_{kind}"]
        ax.plot(offsets, np.maximum(values, floor), dash, marker=marker, color=colour, markersize=4.5)
        ax.plot(
            offsets[values == 0], floor + values[values == 0], marker, color=colour, markersize=4.5, markerfacecolor="white"
        )
        plotting.label(ax, place, words if np.isfinite(values).any() else "", color=colour)
    colour = plotting.COLOURS[OURS[0]]
    ax.plot(offsets[0], max(data["false"], floor), OURS[1], color=colour, markersize=6)
    plotting.label(ax, (1e-6, 3 * floor), "this\nlibrary", color=colour)
    ax.set(xscale="log", yscale="log", xlabel="offset (cells)", ylabel="share of wrong verdicts", ylim=(floor / 2, 1.5))
    ax.set_xticks([offsets[0], 1e-5, 1e-3, 1e-1], ["0", "$10^{-5}$", "$10^{-3}$", "$10^{-1}$"])
    ax.set_yticks([floor, 1e-5, 1e-3, 1e-1], ["none", "$10^{-5}$", "$10^{-3}$", "$10^{-1}$"])
    ax.minorticks_off()


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=3.2, ncols=2)
    figure.subplots_adjust(left=0.18, right=0.985, bottom=0.14, top=0.91, wspace=0.32)
    times(axes[0], data)
    shares(axes[1], data)
    axes[1].set_title(str(data["stale"]))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
