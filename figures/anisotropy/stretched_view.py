r"""A stretched surface hides what it has hidden before.

The report's polyline, and the same stretched along the plane to one and a half and to two times its width, which
divides its roughness $\alpha$ by as much; the viewer's direction is stretched with it, from $55^\circ$ to
$70.7^\circ$. Each surface is traced anew. Every ray towards the viewer that was free (arrows) stays free, and every
ray that was stopped (dashed, ending in a dot) is stopped by the same facet. The visible parts, drawn thick, are the
same parts. Below the facets stand their shares of the view, in per cent: the distribution of visible normals is
stretched with the surface and otherwise unchanged.
"""

import sys

import numpy as np
from report import motion, plotting

SLIDES = (68, 69)
BLUES = (plotting.COLOURS["view"], plotting.COLOURS["sky"])
LOST = plotting.COLOURS["lost"]
DEPTH = 0.13


def surface(ax: plotting.Axes, data: dict, k: int) -> None:
    plotting.ground(ax, data["x"][k], data["z"][k], depth=DEPTH, linewidth=0.7)
    shown = np.flatnonzero(data["percent"][k])
    plotting.pieces(ax, data["ends"][k][shown], [BLUES[n % 2] for n in range(len(shown))], linewidth=2.6)


def rays(ax: plotting.Axes, data: dict, k: int, arrows: bool = True) -> None:
    for start, stop, free in zip(data["start"][k], data["stop"][k], data["free"][k], strict=True):
        if free and arrows:
            plotting.arrow(ax, start, stop, color=BLUES[0], linewidth=0.8, mutation_scale=5)
        else:
            look = {"color": BLUES[0] if free else LOST, "linestyle": "-" if free else (0, (3, 2)), "linewidth": 0.8}
            ax.plot(*np.stack([start, stop], axis=1), zorder=4, **look)


def hits(ax: plotting.Axes, data: dict, k: int) -> list:
    stopped = data["stop"][k][~data["free"][k]]
    return [line for place in stopped for line in ax.plot(*place, ".", color=LOST, markersize=5, zorder=5)]


def shares(ax: plotting.Axes, data: dict, k: int) -> list:
    places = zip(data["middle"][k], data["percent"][k], strict=True)
    return [plotting.label(ax, (x, -DEPTH / 2), f"{percent}", fontsize=8) for (x, _), percent in places if percent]


def told(data: dict, k: int) -> str:
    stretch = data["stretch"][k]
    rough = r"\alpha" if stretch == 1 else rf"\alpha/{stretch:g}"
    free = np.sum(data["free"][k])
    return rf"roughness ${rough}$, view at ${data['degrees'][k]:.1f}^\circ$: {free} of {data['free'][k].size} rays free"


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.47, nrows=3)
    figure.subplots_adjust(left=0, right=1, bottom=0.0, top=1, hspace=0.0)
    for k, ax in enumerate(axes):
        plotting.scene(ax, x=(-0.04, 2.46), z=(-DEPTH - 0.03, 0.46))
        surface(ax, data, k)
        rays(ax, data, k)
        hits(ax, data, k)
        shares(ax, data, k)
        plotting.label(ax, (0, 0.41), told(data, k), ha="left")
        plotting.verdict(ax, (1.43, 0.41), bool(data["kept"][k] and data["same"][k]), size=0.018)
    return figure


def move(data: dict) -> motion.Motion:
    """The first surface becomes the last and goes back, its rays with it."""
    figure, ax = plotting.canvas(__file__, height=1.49)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    plotting.scene(ax, x=(-0.04, 2.46), z=(-DEPTH - 0.03, 0.46))
    surface(ax, data, 0)
    rays(ax, data, 0, arrows=False)
    moves = motion.Motion(figure)
    moves.keyframes["stretch"] = "0%, 12%, 96%, 100% { transform: none } 44%, 64% { transform: scaleX(var(--wide)) }"
    moves.keyframes["shift"] = "0%, 12%, 96%, 100% { transform: none } 44%, 64% { transform: translateX(var(--x)) }"
    moves.keyframes["first"] = "0%, 10%, 98%, 100% { opacity: 1 } 16%, 92% { opacity: 0 }"
    moves.keyframes["last"] = "0%, 40%, 68%, 100% { opacity: 0 } 46%, 62% { opacity: 1 }"
    left = motion.on_paper(ax, (0, 0))[0]
    for k, part in enumerate([*ax.patches, *ax.lines]):
        part.set_gid(f"part-{k}")
        moves.follow(f"part-{k}", "stretch", wide=f"{data['stretch'][-1]:g}", origin=f"{left:.2f}px 0")
    first, last = (np.r_[data["middle"][k][data["percent"][k] > 0], data["stop"][k][~data["free"][k]]] for k in (0, -1))
    ways = motion.on_paper(ax, last) - motion.on_paper(ax, first)
    for k, (part, (way, _)) in enumerate(zip([*shares(ax, data, 0), *hits(ax, data, 0)], ways, strict=True)):
        part.set_gid(f"kept-{k}")
        moves.follow(f"kept-{k}", "shift", x=f"{way:.2f}px")
    for k, name in ((0, "first"), (-1, "last")):
        plotting.label(ax, (0, 0.41), told(data, k), ha="left", gid=name)
        moves.follow(name, name)
    return moves


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    stills, moving = motion.split(outputs)
    plotting.save(draw(plotting.load(data)), stills)
    motion.save(move(plotting.load(data)), moving)
