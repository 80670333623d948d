r"""A sampler is right if the normals that it draws give back the numbers that it drew them from.

Right digits of these numbers, computed from the normals at 50 digits; left as published, right by the library. Above, GGX by
spherical caps at $\alpha = 1$, over the angle of the view and the uniform number that sets the height on the cap, from
$10^{-7}$ to $1 - 10^{-7}$: as published the numbers next to 0 and 1 are lost. Middle, Beckmann over roughness and angle: as
published 0 is divided by 0 where the stretched cosine rounds to 1. Below, the largest error of Beckmann's slope along the
view after so many of Newton's steps, as a share of what is seen; and that of a rational fit to GGX's slope across the view.
"""

import sys

from maps import ANGLES, digit_map
from report import plotting

SLIDES = (41, 42, 43)
COLUMNS = ("published_float64", "published_float32", "library_float64", "library_float32")
TITLES = ("published, double", "published, single", "library, double", "library, single")
ROWS = {"ggx": ("odds", [-7, 0, 7], ["0", "1/2", "1"], "$u_2$")}
ROWS["beckmann"] = ("alpha", [-8, -4, 0], ["$10^{-8}$", "$10^{-4}$", "1"], r"$\alpha$")


def maps(rows: plotting.Array, data: dict) -> object:
    for row, (name, (along, ticks, labels, of)) in zip(rows, ROWS.items(), strict=True):
        for ax, column, title in zip(row, COLUMNS, TITLES, strict=True):
            filled = digit_map(ax, data, f"{name}_{column}", along)
            ax.set(xticks=ticks, xticklabels=labels, yticks=[-8, -4, 0, 4, 8], yticklabels=ANGLES if ax is row[0] else [])
            ax.set_xlabel(of, labelpad=1)
            if name == "ggx":
                ax.set_title(title)
        row[0].set_ylabel({"ggx": "GGX", "beckmann": "Beckmann"}[name] + r": $\theta_o$")
    plotting.label(rows[1][1], (-4.6, -4.5), "0/0", color="w", fontsize=7)
    return filled


def curves(newton: plotting.Axes, across: plotting.Axes, data: dict) -> None:
    newton.semilogy(data["steps"], data["newton_float64"], marker="o", markersize=3, label="double")
    newton.semilogy(data["steps"], data["newton_float32"], marker="o", markersize=3, label="single")
    newton.axhline(data["library_error"], color="0.4", linestyle=":", linewidth=0.9, label="library")
    newton.set(xlabel="Newton's steps", ylabel="error of the share", yticks=[1e-3, 1e-8, 1e-15], ylim=(1e-16, 1e1))
    newton.legend(loc="upper right", fontsize=6.5, labelspacing=0.15)
    across.plot(data["u"], 1e4 * data["across"])
    across.set(xlabel="$u$", ylabel=r"error $\times 10^4$", xlim=(0, 1), ylim=(0, None))


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=5.0, nrows=3, ncols=4)
    figure.subplots_adjust(left=0.14, right=0.9, bottom=0.09, top=0.95, wspace=0.12, hspace=0.28)
    filled = maps(axes[:2], data)
    for ax in axes[2]:
        ax.remove()
    curves(figure.add_axes((0.14, 0.085, 0.34, 0.19)), figure.add_axes((0.6, 0.085, 0.3, 0.19)), data)
    bar = figure.colorbar(filled, cax=figure.add_axes((0.92, 0.4, 0.018, 0.55)))
    bar.set_ticks([0, 3, 7, 15])
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
