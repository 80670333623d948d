r"""Error against time for values computed in large arrays.

Each dot is one way to compute the quantity: on the vertical axis its largest relative error (of samples: the distance from
the exact normal, or of the share), on the horizontal one the median time per value in nanoseconds, with its quartiles.
Filled dots are on the front: nothing is both faster and nearer, for samples of the same distribution. Errors are computed
with this report; times are read from the record that the text names.
"""

import sys

import matplotlib.ticker as ticker
import numpy as np
from microfacet import plotting

SLIDES = ()
PANELS = (
    ("masking", r"masking $G_1$ of Beckmann"),
    ("brdf", "BRDF of GGX"),
    ("sampling", "sampling visible normals"),
    ("fresnel", "Fresnel reflectance of glass"),
)
MARKERS = "osD^vP*X"
HUES = ("view", "light", "lost", "green", "amber", "sky", "grey", "ink")


def panel(ax: plotting.Axes, data: dict, quantity: str, title: str) -> None:
    rows = zip(*(data[f"{quantity}_{part}"] for part in ("words", "errors", "times", "best")), strict=True)
    for k, (words, error, (low, middle, high), best) in enumerate(rows):
        colour = plotting.COLOURS[HUES[k]]
        if np.isfinite(middle):
            ax.plot([low, high], [error, error], color=colour, linestyle="-", linewidth=0.8)
        face = colour if best else "white"
        ax.plot(middle, error, MARKERS[k], color=colour, markerfacecolor=face, markersize=4.5, linestyle="", label=str(words))
    ax.set(xscale="log", yscale="log", ylim=(1e-17, 10), yticks=[1e-16, 1e-12, 1e-8, 1e-4, 1])
    ax.xaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    ax.xaxis.set_minor_formatter(ticker.NullFormatter())
    ax.set_title(title)
    if np.isfinite(data[f"{quantity}_times"]).any():
        low, high = np.nanmin(data[f"{quantity}_times"]), np.nanmax(data[f"{quantity}_times"])
        ax.set_xlim(low / 2.5, high * 2.5)
    else:
        plotting.label(ax, (0.5, 0.5), "no times on record", transform=ax.transAxes)
    ax.legend(
        fontsize=6.5,
        loc="center left",
        bbox_to_anchor=(0.0, 0.305),
        borderpad=0.2,
        labelspacing=0.25,
        handletextpad=0.2,
        frameon=True,
    )


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=5.2, ncols=2, nrows=2, sharey=True)
    figure.subplots_adjust(left=0.095, right=0.985, bottom=0.085, top=0.95, wspace=0.08, hspace=0.3)
    for ax, (quantity, title) in zip(axes.flat, PANELS, strict=True):
        panel(ax, data, quantity, title)
    for ax in axes[-1]:
        ax.set_xlabel("time per value (ns)")
    for ax in axes[:, 0]:
        ax.set_ylabel("largest error")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
