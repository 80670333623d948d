r"""However rough it is, a surface shows a viewer exactly the projected area of the plane it covers.

Seen from $\omega_o$, here $60^\circ$ from the normal, a flat unit segment fills a screen of width $\cos\theta_o$ (top
left), and so does a microsurface too fine to be made out (top right). Magnified (below, one of its twelve periods),
it turns out that facets hide one another: the masking function $G_1$ is the visible fraction of each facet, drawn
thick. The visible parts, cut exactly where the horizon crosses a facet, leave no gap on the screen; their widths
there, in thousandths, add up to $\cos\theta_o$ again. This is the second validation equation.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (37, 38, 39)
BLUES = (plotting.COLOURS["view"], plotting.COLOURS["sky"])


def view(ax: plotting.Axes, data: dict, name: str, gap: float) -> plotting.Array:
    """Surface, the beams of its visible parts and the screen; returns the beams' ends on the screen."""
    wo, ends = data["wo"], data[f"{name}_ends"]
    far = np.max(ends @ wo) + gap
    screen = ends + (far - ends @ wo)[..., None] * wo
    shown = data[f"{name}_G1"] > 0
    for k, (surface, image) in enumerate(zip(ends[shown], screen[shown], strict=True)):
        ax.fill(*np.concatenate([surface, image[::-1]]).T, color=BLUES[k % 2], alpha=0.16, linewidth=0, zorder=1)
    shades = [BLUES[k % 2] for k in range(shown.sum())]
    plotting.ground(ax, data[f"{name}_x"], data[f"{name}_z"], depth=0.05, linewidth=0.8)
    plotting.pieces(ax, ends[shown], shades, linewidth=3 if name == "zoom" else 1.6)
    plotting.pieces(ax, screen[shown], shades, linewidth=3)
    return screen[shown]


def angles(ax: plotting.Axes, data: dict) -> None:
    """Normal, view direction and the angle between them, at the middle of the flat surface."""
    foot, theta = np.array([0.5, 0.0]), np.linspace(0, np.radians(data["degrees"]), 40)
    plotting.arrow(ax, foot, (0.5, 0.2))
    plotting.arrow(ax, foot, foot + 0.24 * data["wo"])
    ax.plot(0.5 + 0.09 * np.sin(theta), 0.09 * np.cos(theta), color="0.3", linestyle="-", linewidth=0.6)
    plotting.label(ax, (0.45, 0.18), r"$\omega_g$")
    plotting.label(ax, foot + 0.24 * data["wo"] + (0.05, 0.01), r"$\omega_o$")
    plotting.label(ax, (0.575, 0.115), r"$\theta_o$")


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.5)
    axes.remove()
    flat, fine = (figure.add_axes((left, 0.635, 0.5, 0.365)) for left in (0, 0.5))
    zoom = figure.add_axes((0, 0, 1, 0.635))
    for ax, name, gap in ((flat, "flat", 0.1), (fine, "fine", 0.1), (zoom, "zoom", 0.06)):
        plotting.scene(ax, x=(-0.05, 1.28), z=(-0.17, 0.58) if ax is not zoom else (-0.06, 0.58))
        screen = view(ax, data, name, gap)
        total = data[f"{name}_projected"].sum()
        text = rf"width {total:.3f}" if ax is not zoom else rf"$\sum G_1\,(\omega_o\cdot\omega_m)\,l_m = {total:.3f}$"
        plotting.label(ax, screen[0, 0] + (0.02, 0.05), text)
    angles(flat, data)
    for ax, text in ((flat, "geometric surface"), (fine, "microsurface")):
        plotting.label(ax, (0.5, -0.12), text)
    for k, width in enumerate(data["thousandths"][data["zoom_G1"] > 0]):
        away = 0.065 if width < 25 and k % 2 else 0.035
        plotting.label(zoom, screen[k].mean(axis=0) + away * data["wo"], f"{width}", fontsize=8)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
