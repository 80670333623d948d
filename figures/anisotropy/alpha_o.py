r"""Seen along one direction, an anisotropic surface masks like an isotropic one.

Left: the ellipse with half-axes $\alpha_x$ and $\alpha_y$ is a contour of the distribution of slopes. Its half-width
along the azimuth $\phi_o$ of the view, the distance of the tangent, is $\alpha_o$; the thin line is $\alpha_o$ for
all azimuths. Right: Smith's masking at $\theta_o = 75^\circ$ over the azimuth. Lines: isotropic masking of roughness
$\alpha_o$; dots: the integral over the hidden slopes of the stretched distribution itself. Dotted lines: what a mean
roughness $\sqrt{\alpha_x \alpha_y}$ would give at every azimuth.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (70, 71)


def ellipse(ax: plotting.Axes, data: dict) -> None:
    """The contour, its tangent across the view, and alpha_o as the tangent's distance."""
    plotting.scene(ax, x=(-0.66, 0.9), z=(-0.7, 0.72))
    turn, shown, alphas = np.radians(data["phi"]), np.radians(data["shown"]), data["alphas"]
    ax.fill(alphas[0] * np.cos(turn), alphas[1] * np.sin(turn), color=plotting.COLOURS["sky"], alpha=0.35, linewidth=0)
    ax.plot(alphas[0] * np.cos(turn), alphas[1] * np.sin(turn), color=plotting.COLOURS["view"], linestyle="-")
    ax.plot(data["alpha_o"] * np.cos(turn), data["alpha_o"] * np.sin(turn), color="0.45", linestyle="-", linewidth=0.6)
    along, across = np.array([np.cos(shown), np.sin(shown)]), np.array([-np.sin(shown), np.cos(shown)])
    foot, touch = data["at"] * along, alphas**2 * along / data["at"]
    ax.plot(*np.stack([foot - 0.2 * across, touch + 0.15 * across], axis=1), color="0.3", linestyle="--", linewidth=0.7)
    ax.plot(*touch, "o", color=plotting.COLOURS["view"], markersize=3)
    ax.plot(*np.stack([0 * foot, foot], axis=1), color=plotting.COLOURS["light"], linestyle="-", linewidth=1.6)
    plotting.arrow(ax, foot, foot + 0.3 * along)
    plotting.label(ax, foot + 0.36 * along + (0.05, 0), r"$\phi_o$")
    plotting.label(ax, 0.5 * foot + 0.07 * across, r"$\alpha_o$", color=plotting.COLOURS["light"])
    for end, name, shift in (((alphas[0], 0), r"$\alpha_x$", (0.0, -0.07)), ((0, alphas[1]), r"$\alpha_y$", (-0.06, -0.2))):
        ax.plot([0, end[0]], [0, end[1]], color="0.3", linestyle="-", linewidth=0.7)
        plotting.label(ax, 0.5 * np.array(end) + shift, name)


def draw(data: dict) -> plotting.Figure:
    figure, (left, right) = plotting.canvas(__file__, height=2.4, ncols=2, width_ratios=(1, 1.35))
    figure.subplots_adjust(left=0, right=0.985, bottom=0.18, top=0.9, wspace=0.13)
    ellipse(left, data)
    for k, (name, title) in enumerate((("beckmann", "Beckmann"), ("ggx", "GGX"))):
        (line,) = right.plot(data["phi"], data[name], label=title)
        right.plot(
            data["quadrature_phi"], data[f"{name}_quadrature"], "os"[k], color=line.get_color(), markersize=3.2, clip_on=False
        )
        right.axhline(data[f"{name}_mean"], color=line.get_color(), linestyle=":", linewidth=0.9)
    right.set(
        xlim=(0, 180), xticks=[0, 45, 90, 135, 180], xlabel=r"$\phi_o$ (degrees)", ylim=(0.4, 1.02), yticks=[0.4, 0.6, 0.8, 1]
    )
    right.set_title(r"$G_1$ at $\theta_o = 75^\circ$")
    right.legend(loc="lower left")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
