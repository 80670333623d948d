r"""A viewer does not meet the normals in the proportions in which the surface has them.

Above, the distribution of normals: each facet with its share of the surface's length, and at the right these shares
gathered in bins of $24^\circ$ by the angle of the normal. Below, the distribution of visible normals for $\omega_o$
at $60^\circ$: each visible part with its share of what is seen, $G_1\,(\omega_o\cdot\omega_m)\,l_m/\cos\theta_o$;
hidden parts are drawn thin. Facets turned to the viewer gain, others lose or vanish (outlines: the shares above).
Both rows of percentages add up to 100, which for the second row is the third validation equation.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (41, 42, 43)


def surface(ax: plotting.Axes, data: dict, name: str) -> None:
    plotting.scene(ax, x=(-0.04, 1.1), z=(-0.05, 0.31))
    plotting.ground(ax, data["x"], data["z"], depth=0.05, linewidth=0.7)
    plotting.pieces(ax, data[f"{name}_ends"], [plotting.TILTS[k] for k in data["bins"]], linewidth=3)
    for place, normal, percent in zip(data[f"{name}_middle"], data["normals"], data[f"{name}_percent"], strict=True):
        if percent:
            plotting.label(ax, place + 0.042 * normal, f"{percent}", fontsize=8)


def bars(ax: plotting.Axes, data: dict, name: str) -> None:
    centres = np.degrees(data["bounds"][1:] + data["bounds"][:-1]) / 2
    percent = data[f"{name}_bin_percent"]
    ax.bar(centres, percent, width=20, color=plotting.TILTS)
    if name == "seen":
        outline = {"facecolor": "none", "edgecolor": "0.25", "linewidth": 0.6, "linestyle": (0, (2, 1.5))}
        ax.bar(centres, data["all_bin_percent"], width=20, **outline)
    above = np.maximum(percent, data["all_bin_percent"]) + 1
    for centre, height, value in zip(centres, above, percent, strict=True):
        plotting.label(ax, (centre, height), f"{value}%", va="bottom", fontsize=8)
    ax.set(ylim=(0, 64), yticks=[], xticks=centres)
    ax.set_xticklabels([rf"${c:.0f}^\circ$" for c in centres])
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="x", length=0)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=3.5, nrows=2, ncols=2, width_ratios=(2, 1))
    figure.subplots_adjust(left=0, right=0.985, bottom=0.12, top=0.94, wspace=0.04, hspace=0.38)
    for (left, right), name in zip(axes, ("all", "seen"), strict=True):
        surface(left, data, name)
        bars(right, data, name)
    for ax, text in zip(axes[:, 0], ("all facets, % of length", "visible parts, % of view"), strict=True):
        ax.set_title(text, x=0.035)
    axes[0, 1].set_title(r"$D(\omega_m)$, % of length")
    axes[1, 1].set_title(r"$D_{\omega_o}(\omega_m)$, % of view")
    axes[1, 1].set_xlabel(r"angle $\theta_m$ of the normal")
    plotting.arrow(axes[1, 0], (0.94, 0.17), (0.94, 0.17) + 0.12 * data["wo"])
    plotting.label(axes[1, 0], (0.985, 0.235), r"$\omega_o$")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
