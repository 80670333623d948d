r"""A mirror moves what is seen to other directions and loses nothing of it.

Each visible facet reflects its part of the view $\omega_o$ into one direction $\omega_i$: the bands are the reflected
beams, at their true width. Below the surface, in black, the share of the view that each facet takes; at the arrows'
tips, in orange, the share of the reflected light that leaves along them, computed from the widths of the beams. The
two agree facet by facet, and both add up to 100: the distribution of reflected directions is as normalised as that of
visible normals, which is the weak white furnace test. Light that runs into the surface again, such as the level beam
in the valley at the right, still counts here.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (44, 45, 46)
MODEL = (
    "the relief drawn, ray by ray",
    "it is its own most complete model",
)
LIGHT, VIEW = plotting.COLOURS["light"], plotting.COLOURS["view"]


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=2.5)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    plotting.scene(ax, x=(-0.16, 1.1), z=(-0.155, 0.37))
    plotting.ground(ax, data["x"], data["z"], depth=0.05, linewidth=0.7)
    plotting.pieces(ax, data["ends"], [VIEW] * len(data["ends"]), linewidth=3)
    for k in np.flatnonzero(data["seen_percent"]):
        ends, start, wi = data["ends"][k], data["middle"][k], data["wi"][k]
        ax.fill(*np.concatenate([ends, ends[::-1] + 0.11 * wi]).T, color=LIGHT, alpha=0.15, linewidth=0, zorder=1)
        plotting.arrow(ax, start, start + 0.15 * wi, color=LIGHT)
        plotting.label(ax, start + 0.172 * wi, f"{data['reflected_percent'][k]}", color=LIGHT, fontsize=8)
        plotting.label(ax, (start[0], -0.08), f"{data['seen_percent'][k]}", fontsize=8)
    plotting.label(ax, (0.5, -0.125), f"share of the view: {data['seen_percent'].sum()}%")
    plotting.label(ax, (0.5, 0.335), f"share of the reflected light: {data['reflected_percent'].sum()}%", color=LIGHT)
    plotting.arrow(ax, (0.97, 0.24), (0.97, 0.24) + 0.1 * data["wo"], color=VIEW)
    plotting.label(ax, (1.0, 0.29), r"$\omega_o$", color=VIEW)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
