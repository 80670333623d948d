r"""Taken from the cosine alone, the distribution of normals of a smooth surface has no digits left.

Decimal digits of $D$ that agree with a reference of 50 digits, over roughness and the angle of the normal; the latter is
spaced by its tangent, from $10^{-8}$ above the pole to as near the horizon. Left, the textbook forms, right, the library's, in
both precisions; above GGX, below Beckmann. The line encloses where fewer than three digits are right: next to the pole the
cosine rounds to 1, and what it has lost is divided by $\alpha^2$. Hatched, numbers too small for the precision.
"""

import sys

from maps import ANGLES, digit_map
from report import plotting

SLIDES = (55, 67)
COLUMNS = ("textbook_float64", "textbook_float32", "library_float64", "library_float32")
TITLES = ("textbook, double", "textbook, single", "library, double", "library, single")
PLACE = {"ggx": (-5.4, -5.2), "beckmann": (-0.2, -5.4)}  # of the name of the cause


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=3.5, nrows=2, ncols=4, sharex=True, sharey=True)
    figure.subplots_adjust(left=0.14, right=0.9, bottom=0.13, top=0.92, wspace=0.1, hspace=0.12)
    for row, name in zip(axes, ("ggx", "beckmann"), strict=True):
        for ax, column, title in zip(row, COLUMNS, TITLES, strict=True):
            filled = digit_map(ax, data, f"{name}_{column}")
            if name == "ggx":
                ax.set_title(title)
            if column == "textbook_float32":
                plotting.label(ax, PLACE[name], "$\\cos\\theta_m$\nrounds to 1", color="w", fontsize=6.5)
        row[0].set_ylabel({"ggx": "GGX", "beckmann": "Beckmann"}[name] + r": $\theta_m$")
        row[0].set_yticks([-8, -4, 0, 4, 8], labels=ANGLES)
    for ax in axes[1]:
        ax.set_xticks([-8, -4, 0], labels=["$10^{-8}$", "$10^{-4}$", "1"])
        ax.set_xlabel(r"$\alpha$")
    bar = figure.colorbar(filled, cax=figure.add_axes((0.92, 0.13, 0.018, 0.79)))
    bar.set_ticks([0, 3, 7, 15])
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
