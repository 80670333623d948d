r"""A Gaussian surface, rays that are traced on it, and the lobe of many of them beside that of a model.

Left, heights of a surface of Gabor noise, $\alpha = 0.7$. Middle, the same piece in cuts from front to back, with six
rays that come from the viewer at $60^\circ$ on the left; those in orange leave after one reflection, those in purple
after more. Right, where the light of millions of rays leaves after one reflection (above) and where Smith's model
sends it (below), over the hemisphere of directions seen from above.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (59,)
MODEL = (
    "a ray-traced surface, one bounce; Smith's model",
    "a lobe of one bounce is compared with a model of one",
)
TILT = np.array([0.42, 0.5])  # how far one cell to the back moves on the page
EVERY, DEPTH = 3, 22


def page(points: plotting.Array) -> plotting.Array:
    """Points (..., 3) as they stand on the page (..., 2)."""
    return points[..., [0, 2]] + points[..., 1:2] * TILT


def block(ax: plotting.Axes, heights: plotting.Array) -> None:
    """The surface in vertical cuts, each hiding what is behind it, and the right side of the block."""
    last = len(heights) - 1
    x, shades = np.arange(last + 1), {"linewidth": 0, "edgecolor": "none"}
    for y in range(last, -1, -EVERY):
        line, foot = page(np.stack([x, np.full_like(x, y), heights[:, y]], axis=-1)).T, y * TILT[1] - DEPTH
        ax.fill_between(*line, foot, facecolor="#F7F6F4" if y else plotting.COLOURS["ground"], zorder=-y, **shades)
        ax.plot(*line, color=plotting.COLOURS["grey"], linestyle="-", linewidth=0.5, zorder=-y)
    edge = page(np.stack([np.full_like(x, last), x, heights[last]], axis=-1))
    feet = page(np.stack([np.full_like(x, last), x, np.full_like(x, -DEPTH)], axis=-1))
    ax.fill(*np.concatenate([edge, feet[::-1]]).T, facecolor="#DAD8D3", zorder=1, **shades)


def rays(ax: plotting.Axes, paths: plotting.Array) -> None:
    for path in paths:
        places = page(path[~np.isnan(path[:, 0])])
        colour = plotting.COLOURS["light" if len(places) == 3 else "lost"]
        ax.plot(*places[:2].T, color=plotting.COLOURS["view"], linestyle="-", linewidth=1, zorder=4)
        ax.plot(*places[1:-1].T, color=colour, linestyle="-", linewidth=1, zorder=4)
        plotting.arrow(ax, places[-2], places[-1], color=colour, linewidth=1)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.2)
    axes.remove()
    places = ((0.01, 0.12, 0.23, 0.76), (0.23, 0, 0.56, 1), (0.82, 0.5, 0.17, 0.43), (0.82, 0, 0.17, 0.43))
    above, middle, one, other = (figure.add_axes(place) for place in places)
    heights = data["heights"]
    above.contourf(heights.T, 14)
    plotting.scene(above, x=(0, len(heights) - 1), z=(0, len(heights) - 1))
    block(middle, heights)
    rays(middle, data["paths"])
    plotting.scene(middle, x=(-20, 140), z=(-DEPTH - 1, 78))
    top = max(data["measured"].max(), data["smith"].max())
    for ax, name, title in ((one, "measured", "measured"), (other, "smith", "Smith")):
        plotting.hemisphere(ax, data["theta"], data["phi"], data[name], top)
        plotting.label(ax, (-1.25, 0), title, rotation=90)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
