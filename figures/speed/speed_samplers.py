r"""Samplers differ in how far they are from their density, in time, and in noise.

Above, how far the normals drawn are from the density they should have, as the total variation, over the noise that is left
after a given time; filled dots are on the front among samplers for the same distribution. At $10^{-8}$ and below difference
quotients tell no more. Below, that noise over the angle of the view: the variance of the light reflected under a white
sky at $\alpha = 0.5$, times the time of one light direction with its weight; lower is better. Lines above are the quartiles
of the time, bands below 95 % confidence intervals of the variance. The mean over angles is the geometric one.
"""

import sys

import matplotlib.ticker as ticker
import numpy as np
from report import plotting

SLIDES = ()
LOOKS = {
    "normals": ("grey", "o", ":"),
    "heitz_d_eon": ("amber", "s", "--"),
    "disk": ("green", "^", "-."),
    "caps": ("light", "D", "-"),
    "bounded": ("lost", "v", (0, (5, 1, 1, 1, 1, 1))),
    "jakob": ("view", "P", "--"),
    "library": ("light", "D", "-"),
}
KINDS = ("GGX", "Beckmann")


def look(name: str) -> tuple:
    return LOOKS[str(name).removeprefix("beckmann_")]


def dots(ax: plotting.Axes, data: dict, chosen: plotting.Array) -> None:
    for k in np.flatnonzero(chosen):
        hue, marker, _ = look(data["names"][k])
        colour, (low, middle, high) = plotting.COLOURS[hue], data["efforts"][k]
        if np.isfinite(middle):
            ax.plot([low, high], 2 * [data["errors"][k]], color=colour, linestyle="-", linewidth=0.8)
        face = colour if data["best"][k] else "white"
        ax.plot(middle, data["errors"][k], marker, color=colour, markerfacecolor=face, markersize=5, linestyle="")
    known = data["efforts"][chosen][np.isfinite(data["efforts"][chosen])]
    ax.set(xscale="log", yscale="log", ylim=(3e-9, 0.05), xlim=(known.min() / 2, known.max() * 2) if len(known) else (2, 600))
    if not len(known):
        plotting.label(ax, (0.5, 0.5), "not measured yet:\nmake bench NAME=estimate", transform=ax.transAxes)
    ax.xaxis.set_major_locator(ticker.LogLocator(subs=(1, 3)))
    ax.xaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    ax.xaxis.set_minor_formatter(ticker.NullFormatter())
    ax.set_xlabel(r"variance $\times$ time (ns), mean over angles")


def curves(ax: plotting.Axes, data: dict, chosen: plotting.Array) -> None:
    for k in np.flatnonzero(chosen):
        hue, marker, dash = look(data["names"][k])
        colour, time = plotting.COLOURS[hue], data["times"][k, 1]
        low, high = ((data["variance"][k] + sign * data["spread"][k]) * time for sign in (-1, 1))
        ax.fill_between(data["degrees"], low, high, color=colour, alpha=0.2, linewidth=0)
        look_of_line = {"color": colour, "linestyle": dash, "marker": marker, "markersize": 3.5, "markerfacecolor": "white"}
        ax.plot(data["degrees"], data["product"][k], label=str(data["words"][k]), **look_of_line)
    ax.set(yscale="log", xlabel=r"$\theta_o$ (degrees)", xlim=(0, 90), xticks=range(0, 91, 15))
    ax.legend(fontsize=7, loc="upper left", labelspacing=0.2, borderpad=0.2, handlelength=2.4)
    if np.isfinite(data["product"][chosen]).any():
        ax.set_ylim(None, 30 * np.nanmax(data["product"][chosen]))
    else:
        plotting.label(ax, (0.5, 0.3), "not measured yet", transform=ax.transAxes)
        ax.set_ylim(1, 100)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=5.2, nrows=2, ncols=2, height_ratios=(1, 1.35))
    figure.subplots_adjust(left=0.105, right=0.985, bottom=0.085, top=0.95, wspace=0.2, hspace=0.36)
    for column, kind in zip(axes.T, KINDS, strict=True):
        chosen = data["kinds"] == kind
        dots(column[0], data, chosen)
        curves(column[1], data, chosen)
        column[0].set_title(f"{kind}, {stale}" if (stale := str(data["stale"])) else kind)
    axes[0, 0].set_ylabel("total variation")
    axes[1, 0].set_ylabel(r"variance $\times$ time (ns)")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
