r"""Projected onto the plane, the facets add up to the plane.

Each microfacet, of length $l_m$, covers $l_m\,(\omega_m\cdot\omega_g)$ of the plane below it. The microsurface is
longer than the plane, but its projection is not: the printed widths, in thousandths of the segment and taken from
this polyline, add up to 1000. This is the first validation equation.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (35, 36)
PLANE = -0.12


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=2.1)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    plotting.scene(ax, x=(-0.06, 1.06), z=(-0.245, 0.147))
    plotting.ground(ax, data["x"], data["z"], depth=0.045, nodes=True)
    shades = [plotting.COLOURS["view"], plotting.COLOURS["sky"]] * 6
    plotting.pieces(ax, data["ends"], shades, linewidth=2.2)
    shadow = data["ends"] * [1, 0] + [0, PLANE]
    plotting.pieces(ax, shadow, shades, linewidth=4)
    for x, z in zip(data["x"], data["z"], strict=True):
        ax.plot([x, x], [z, PLANE], color="0.6", linewidth=0.5, linestyle=(0, (2, 2)), zorder=1)
    for (x, _), width in zip(np.mean(shadow, axis=1), data["thousandths"], strict=True):
        plotting.label(ax, (x, PLANE - 0.032), f"{width}", fontsize=8)
    plotting.label(
        ax, (0.5, PLANE - 0.085), rf"sum {data['thousandths'].sum()}: projected length {data['projected'].sum():.3f}"
    )
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
