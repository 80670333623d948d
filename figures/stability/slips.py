r"""Slips that no rounding explains: what belongs to one surface beside what belongs to another, and light through the surface.

Left, the visible area over the cosine if $G_1$ is not that of $D$: for GGX with $\alpha_x = 0.6$ and $\alpha_y = 0.1$ the
masking of one mean roughness, seen along the rough axis and along the smooth one; for GGX with $\alpha = 0.3$ that of its
square, and that of Beckmann with the same $\alpha$. A right pair has 1 for every view. Middle, slopes along the rough axis, in
units of $\alpha_x$, as drawn by samplers for the first of these surfaces: the right one, one whose axes are swapped, and one
that knows a mean roughness. Right, the lobe in the plane of incidence at $80^\circ$ for GGX, $\alpha = 0.5$, times the cosine
of the light, if nobody asks on which side the light is; beyond $90^\circ$ it is below the surface.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (39, 51, 70, 71)
MODEL = (
    "Smith's model, separable, one bounce, perfect mirrors",
    "any form of it would send the same light through the surface",
)
PAIRS = {
    "mean_along": "mean, rough axis",
    "mean_across": "mean, smooth axis",
    "twice": "squared twice",
    "borrowed": "Beckmann's $G_1$",
}
SAMPLERS = {"right": "right", "swapped": "axes swapped", "one": "one roughness"}


def draw(data: dict) -> plotting.Figure:
    figure, (area, slopes, lobe) = plotting.canvas(__file__, height=2.6, ncols=3)
    figure.subplots_adjust(left=0.065, right=0.985, bottom=0.36, top=0.91, wspace=0.3)
    for name, label in PAIRS.items():
        area.plot(data["degrees"], data[name], label=label)
    area.axhline(1, color="0.6", linestyle="-", linewidth=0.6)
    area.set(xlabel=r"$\theta_o$ (degrees)", xlim=(0, 90), xticks=[0, 30, 60, 90], ylim=(0, 3))
    area.set_title("visible area")
    for name, label in SAMPLERS.items():
        slopes.plot(data["slopes"], data[f"density_{name}"], label=label)
    slopes.set(xlabel=r"$\tilde{x}/\alpha_x$", xlim=(-2, 2), xticks=[-2, -1, 0, 1, 2], ylim=(0, None))
    slopes.set_title("density of slopes")
    inside = data["lights"] >= 0
    for name, label in {"sides": "light above only", "both": "no question of sides"}.items():
        lobe.plot(data["lights"][inside], data[name][inside], label=label)
    lobe.axvline(90, color="0.6", linestyle="-", linewidth=0.6)
    lobe.set(xlabel=r"$\theta_i$ (degrees)", xlim=(0, 130), xticks=[0, 45, 90], ylim=(0, 1.05 * float(np.max(data["both"]))))
    lobe.set_title(r"$\rho \cos\theta_i$ (1/sr)")
    for ax in (area, slopes, lobe):
        ax.legend(loc="upper center", bbox_to_anchor=(0.45, -0.27), fontsize=7, labelspacing=0.2)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
