r"""Some of the reflected light meets the surface again before it can leave.

Rays towards the viewer at $60^\circ$, spaced so that each stands for the same part of the view, are followed after
their mirror reflection. Most leave (solid arrows); some are shadowed and end on another facet (dashed, with a cross).
The printed shares are not counts of these rays: the seen surface is cut exactly into what escapes and what does not,
drawn as thick lines and as dotted ones. At the left the neighbouring period is drawn too. Light must be free both
towards the viewer and towards the source, so the masking function $G_1$ gives way to the masking-shadowing function
$G_2$.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (49, 50)
MODEL = (
    "the relief drawn, ray by ray",
    "it is its own most complete model",
)
LIGHT, LOST, VIEW = (plotting.COLOURS[name] for name in ("light", "lost", "view"))


def rays(ax: plotting.Axes, data: dict) -> None:
    for origin, wi, length in zip(data["origin"], data["wi"], data["length"], strict=True):
        if np.isfinite(length):
            stop = origin + length * wi
            ax.plot(*np.stack([origin, stop], axis=1), color=LOST, linestyle=(0, (3, 2)), linewidth=0.8, zorder=4)
            ax.plot(*stop, "x", color=LOST, markersize=4.5, markeredgewidth=1.2, zorder=6)
        else:
            plotting.arrow(ax, origin, origin + 0.16 * wi, color=LIGHT, linewidth=0.7, mutation_scale=5)


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=1.97)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    plotting.scene(ax, x=(-0.37, 1.1), z=(-0.13, 0.35))
    plotting.ground(ax, data["x"], data["z"], depth=0.05, linewidth=0.7)
    plotting.ground(ax, data["x"] - 1, data["z"], depth=0.05, linewidth=0.5, color="0.6")
    plotting.pieces(ax, data["free"], [VIEW] * len(data["free"]), linewidth=3)
    plotting.pieces(ax, data["blocked"], [LOST] * len(data["blocked"]), linewidth=3, linestyle=(0, (0.7, 0.5)))
    rays(ax, data)
    escape, meet = data["percent"]
    plotting.label(ax, (0.3, -0.09), f"{escape}% leaves the surface", color=LIGHT)
    plotting.label(ax, (0.74, -0.09), f"{meet}% meets the surface again", color=LOST)
    plotting.arrow(ax, (0.97, 0.24), (0.97, 0.24) + 0.1 * data["wo"], color=VIEW)
    plotting.label(ax, (1.0, 0.29), r"$\omega_o$", color=VIEW)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
