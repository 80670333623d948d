r"""The distribution of normals forgets where a facet lies and keeps only how it is turned.

Every facet travels, without turning, to the place on the circle where its normal points, and is stacked there with
the facets of the same bin. From left to right: the surface, half way, and all facets sorted, with the share of the
surface's length that each bin of $24^\circ$ holds. The length in a bin, divided by the width of the bin, is
$D(\omega_m)$; summed over all bins it is the length of the microsurface. The profile is the curve of
the figure before, cut into 36 facets.
"""

import sys

import numpy as np
from report import motion, plotting

SLIDES = (33,)
CENTRE, RADIUS, GAP = np.array([0.5, 0.27]), 0.4, 0.019


def middles(bounds: plotting.Array) -> plotting.Array:
    return (bounds[1:] + bounds[:-1]) / 2


def circle(ax: plotting.Axes, bounds: plotting.Array) -> None:
    theta = np.linspace(bounds[0], bounds[-1], 100)
    ax.plot(
        *(CENTRE[:, None] + RADIUS * np.array([np.sin(theta), np.cos(theta)])),
        color="0.7",
        linestyle="-",
        linewidth=0.7,
    )
    for bound in bounds:
        ray = np.array([np.sin(bound), np.cos(bound)])
        ax.plot(
            *np.stack([CENTRE, CENTRE + (RADIUS + 0.02) * ray], axis=1),
            color="0.85",
            linestyle="-",
            linewidth=0.5,
            zorder=0,
        )


def goals(data: dict) -> plotting.Array:
    """Where the middle of each facet comes to lie."""
    theta = middles(data["bounds"])[data["bins"]]
    return CENTRE + ((RADIUS + GAP * (1 + data["rank"])) * np.array([np.sin(theta), np.cos(theta)])).T


def facets(ax: plotting.Axes, data: dict, way: float) -> None:
    middle = (1 - way) * data["middle"] + way * goals(data)
    ends = middle[:, None] + np.array([[-0.5], [0.5]]) * data["edges"][:, None]
    plotting.pieces(ax, ends, [plotting.TILTS[k] for k in data["bins"]], linewidth=1.8)


def board(ax: plotting.Axes, data: dict, way: float) -> None:
    plotting.scene(ax, x=(-0.06, 1.06), z=(-0.13, 1.0))
    plotting.ground(ax, data["x"], data["z"], depth=0.06, color="0.75", linewidth=0.5)
    circle(ax, data["bounds"])
    facets(ax, data, way)


def shares(ax: plotting.Axes, data: dict) -> list:
    """The share of each bin, beyond its stack, and the length of all."""
    labels = []
    for k, theta in enumerate(middles(data["bounds"])):
        reach = RADIUS + GAP * (1 + np.sum(data["bins"] == k)) + 0.05 + 0.04 * abs(np.sin(theta))
        place = CENTRE + reach * np.array([np.sin(theta), np.cos(theta)])
        labels.append(plotting.label(ax, place, rf"{data['percent'][k]}%", fontsize=8))
    return [*labels, plotting.label(ax, (CENTRE[0], CENTRE[1] + 0.22), f"length {data['share'].sum():.2f}")]


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.02, ncols=3)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1, wspace=0)
    for ax, way in zip(axes, (0.0, 0.5, 1.0), strict=True):
        board(ax, data, way)
    shares(axes[-1], data)
    return figure


def move(data: dict) -> motion.Motion:
    """Facet after facet flies to its place, the shares appear, and all goes back."""
    figure, ax = plotting.canvas(__file__, height=3.4)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    board(ax, data, 0.0)
    moves = motion.Motion(figure)
    moves.keyframes["fly"] = "0%, 8%, 98%, 100% { transform: none } 40%, 70% { transform: translate(var(--x), var(--z)) }"
    moves.keyframes["show"] = "0%, 52%, 72%, 100% { opacity: 0 } 56%, 68% { opacity: 1 }"
    ways = motion.on_paper(ax, goals(data)) - motion.on_paper(ax, data["middle"])
    lines = list(ax.lines)[-len(ways) :]
    for k, (line, (x, z)) in enumerate(zip(lines, ways, strict=True)):
        line.set_gid(f"facet-{k}")
        moves.follow(f"facet-{k}", "fly", x=f"{x:.2f}px", z=f"{z:.2f}px", delay=f"{k / len(ways):.2f}s")
    for k, label in enumerate(shares(ax, data)):
        label.set_gid(f"share-{k}")
        moves.follow(f"share-{k}", "show")
    return moves


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    stills, moving = motion.split(outputs)
    plotting.save(draw(plotting.load(data)), stills)
    motion.save(move(plotting.load(data)), moving)
