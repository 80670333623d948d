r"""Stretched distributions of normals still project to the surface they cover.

Left and middle: $D(\omega_m)$ of Beckmann and GGX with $\alpha_x = 0.6$ and $\alpha_y = 0.2$ over the hemisphere of
normals seen from above, one colour and contour for each power of $\sqrt{10}$; the rim is the horizon, the circles are
$\theta_m = 30^\circ$ and $60^\circ$. Right: the projected area over a grid of roughnesses along $x$ and $y$. A dot
marks each pair at which Beckmann and GGX both keep the first validation equation, to the precision of the quadrature;
contours give the projected area of Ward, which loses more the larger either roughness is.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (67,)
LEVELS = 10.0 ** np.arange(-3, 0.6, 0.5)


def hemisphere(ax: plotting.Axes, data: dict, name: str) -> object:
    plotting.scene(ax, x=(-1.05, 1.05), z=(-1.05, 1.05))
    filled = ax.contourf(data["x"], data["y"], np.log10(data[name]), np.log10(LEVELS), extend="both", cmap="cividis", zorder=1)
    ax.contour(data["x"], data["y"], np.log10(data[name]), np.log10(LEVELS), colors="k", linewidths=0.3, linestyles="-")
    turn = np.linspace(0, 2 * np.pi, 120)
    for radius, style in ((1.0, "-"), (np.sin(np.pi / 3), ":"), (0.5, ":")):
        colour = "k" if radius == 1 else "w"
        ax.plot(radius * np.cos(turn), radius * np.sin(turn), color=colour, linestyle=style, linewidth=0.7)
    return filled


def areas(ax: plotting.Axes, data: dict) -> None:
    x, y = np.meshgrid(data["tried"], data["tried"])
    good = data["beckmann_keeps"] & data["ggx_keeps"]
    ax.plot(x[good], y[good], ".", color=plotting.COLOURS["green"], markersize=2.2)
    lines = ax.contour(x, y, data["ward_area"], [0.5, 0.6, 0.7, 0.8, 0.9], colors=plotting.COLOURS["lost"], linewidths=0.9)
    ax.clabel(lines, fontsize=8, fmt="%.1f")
    ax.set(xlim=(0, 1.02), ylim=(0, 1.02), aspect="equal", xticks=[0, 0.5, 1], yticks=[0, 0.5, 1])
    ax.set_xlabel(r"$\alpha_x$")
    ax.set_ylabel(r"$\alpha_y$", rotation=0, labelpad=8)
    ax.set_title("projected area", loc="center")


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.45)
    axes.remove()
    left, middle, right = (figure.add_axes((x, 0.2, 0.285, 0.7)) for x in (0.0, 0.31, 0.7))
    for ax, name, title in ((left, "beckmann", "Beckmann"), (middle, "ggx", "GGX")):
        filled = hemisphere(ax, data, name)
        ax.set_title(title, loc="center")
    bar = figure.colorbar(filled, cax=figure.add_axes((0.115, 0.15, 0.37, 0.035)), orientation="horizontal")
    bar.set_ticks([-3, -2, -1, 0], labels=["0.001", "0.01", "0.1", "1"])
    figure.text(0.09, 0.165, r"$D$", ha="right", va="center")
    figure.text(0.51, 0.165, "1/sr", ha="left", va="center")
    areas(right, data)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
