r"""Error against time for values computed in large arrays.

Each dot is one way to compute the quantity: on the vertical axis its largest relative error (of samples: the distance from
the exact normal, or of the share), on the horizontal one the median time per value in nanoseconds, with its quartiles.
The form of a mark is the method, its colour the precision. Filled marks are on the front: nothing is both faster and nearer,
for samples of the same distribution. Errors are computed with this report; times are read from the record that the text names.
"""

import sys

import matplotlib.ticker as ticker
import numpy as np
from report import plotting

SLIDES = ()
PANELS = (
    ("masking", "", r"masking $G_1$ of Beckmann"),
    ("normals", "", "normals $D$ of GGX"),
    ("brdf", "", "BRDF of GGX"),
    ("fresnel", "", "Fresnel reflectance of glass"),
    ("sampling", "GGX", "visible normals of GGX"),
    ("sampling", "Beckmann", "visible normals of Beckmann"),
)
OURS, OTHERS = "o", "sD^vP"
HUES = {"double": "view", "single": "light"}


def panel(ax: plotting.Axes, data: dict, quantity: str, kind: str, title: str) -> None:
    chosen = data[f"{quantity}_kinds"] == kind
    rows = zip(*(data[f"{quantity}_{part}"][chosen] for part in ("words", "errors", "times", "best")), strict=True)
    markers: dict[str, str] = {}
    for words, error, (low, middle, high), best in rows:
        told = str(words).removeprefix(f"{kind}, ")
        method, precision = told.rsplit(", ", 1)
        colour = plotting.COLOURS[HUES[precision]]
        free = OURS if method.endswith("this library") and OURS not in markers.values() else OTHERS[len(markers)]
        marker = markers.setdefault(method, free)
        if np.isfinite(middle):
            ax.plot([low, high], [error, error], color=colour, linestyle="-", linewidth=0.8)
        look = {"color": colour, "markerfacecolor": colour if best else "white", "markersize": 4.5, "linestyle": ""}
        ax.plot(middle, error, marker, label=told, **look)
    ax.set(xscale="log", yscale="log", ylim=(1e-17, 1e6), yticks=[1e-16, 1e-12, 1e-8, 1e-4, 1])
    ax.xaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    ax.xaxis.set_minor_formatter(ticker.NullFormatter())
    ax.set_title(f"{title}, {stale}" if (stale := str(data[f"{quantity}_stale"])) else title)
    known = data[f"{quantity}_times"][chosen]
    if np.isfinite(known).any():
        ax.set_xlim(np.nanmin(known) / 2, np.nanmax(known) * 2)
    else:
        plotting.label(ax, (0.5, 0.7), "no times on record", transform=ax.transAxes)
        ax.set_xlim(1.5, 90)
    ax.legend(fontsize=6.5, loc="upper center", ncols=2, borderpad=0.2, labelspacing=0.25, handletextpad=0.1, columnspacing=0.4)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=7.4, ncols=2, nrows=3, sharey=True)
    figure.subplots_adjust(left=0.095, right=0.985, bottom=0.06, top=0.965, wspace=0.08, hspace=0.3)
    for ax, which in zip(axes.flat, PANELS, strict=True):
        panel(ax, data, *which)
    for ax in axes[-1]:
        ax.set_xlabel("time per value (ns)")
    for ax in axes[:, 0]:
        ax.set_ylabel("largest error")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
