r"""To halve the roughness along one axis is to stretch the surface along it by two.

Above, a Gaussian height field, isotropic with $\alpha = 0.5$, and the same surface stretched along $x$; lengths in
units of the correlation length, heights by colour. Below, slope space: contours of Beckmann's distribution of slopes
with $\alpha_x = \alpha_y = 0.5$ and with $\alpha_x = 0.25$, and slopes of facets of this very surface. Stretching
moves no facet up or down, so it divides every slope along $x$ by two and leaves those along $y$; every dot at the
right is a dot of the left at half its distance from the axis, as the diamonds show. The roughness measured on all
facets is printed; a period of twelve correlation lengths is a small sample, so it is not quite the 0.5 of the family
it was drawn from.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (64, 65, 66)
LEVELS = (0.05, 0.2, 0.5, 0.8)


def field(ax: plotting.Axes, data: dict, wide: float) -> object:
    cells, limit = data["cells"], np.max(np.abs(data["heights"]))
    filled = ax.contourf(wide * cells, cells, data["heights"].T, np.linspace(-limit, limit, 11), cmap="cividis")
    last = cells[-1]
    ax.set(aspect="equal", xlabel=r"$x$", xticks=np.arange(0, wide * last + 1, 4), yticks=np.arange(0, last + 1, 4))
    return filled


def slopes(ax: plotting.Axes, data: dict, name: str) -> None:
    grid, density, dots = data["grid"], data[f"{name}_P22"].T, data[f"{name}_slopes"]
    limit = grid[-1]
    ax.plot(*dots, ".", color="0.6", markersize=1.6, zorder=1)
    ax.plot(*dots[:, data["marked"]], "D", color=plotting.COLOURS["light"], markersize=3, zorder=4)
    ax.contour(grid, grid, density / density.max(), LEVELS, colors=plotting.COLOURS["view"], linewidths=1, linestyles="-")
    ax.set(aspect="equal", xlim=(-limit, limit), ylim=(-limit, limit), xticks=[-1, 0, 1], yticks=[-1, 0, 1])
    ax.set_xlabel(r"slope $\tilde{x}$")
    found = data[f"{name}_measured"]
    ax.set_title(rf"measured: $\alpha_x = {found[0]:.2f}$, $\alpha_y = {found[1]:.2f}$", loc="center")


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.4)
    axes.remove()
    above = [figure.add_axes(place) for place in ((0.07, 0.62, 0.27, 0.36), (0.38, 0.62, 0.53, 0.36))]
    below = [figure.add_axes(place) for place in ((0.04, 0.09, 0.33, 0.385), (0.48, 0.09, 0.33, 0.385))]
    for ax, wide in zip(above, (1.0, float(data["stretch"])), strict=True):
        filled = field(ax, data, wide)
    for ax, name in zip(below, ("before", "after"), strict=True):
        slopes(ax, data, name)
    above[1].set_yticklabels([])
    above[0].set_ylabel(r"$y$", rotation=0)
    below[0].set_ylabel(r"$\tilde{y}$", rotation=0)
    bar = figure.colorbar(filled, cax=figure.add_axes((0.93, 0.65, 0.015, 0.3)))
    bar.set_ticks([-0.5, 0, 0.5])
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
