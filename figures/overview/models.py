r"""Some of what is called a microfacet model lies outside microfacet theory.

What is inside of what, without regard to size. Above left, what one would like to have: a description of all that
surfaces do to light. Below, what there is: a theory of a part of it, and models in use, some of them (with a tick) in
the theory and some (with a cross) not, as our four equations find at $\alpha = 0.4$; the numbers say how many of the
four a model fails. The second to the fourth are one condition at three places of the derivation and fail together.
Above right, where one should go: further, from what is known to be sound.
"""

import sys

import numpy as np
from matplotlib.patches import Ellipse
from report import plotting

SLIDES = tuple(range(6, 13))
GREY, VIEW = plotting.COLOURS["grey"], plotting.COLOURS["view"]


def area(ax: plotting.Axes, centre: tuple[float, float], size: tuple[float, float], colour: str) -> None:
    ax.add_patch(Ellipse(centre, *size, facecolor=colour, alpha=0.13, edgecolor="none"))
    ax.add_patch(Ellipse(centre, *size, facecolor="none", edgecolor=colour, linewidth=0.9))


def wished(ax: plotting.Axes) -> None:
    area(ax, (1.45, 3.62), (2.5, 1.05), GREY)
    area(ax, (1.45, 3.62), (2.4, 0.97), VIEW)
    plotting.label(ax, (1.45, 3.85), "what surfaces do to light", fontsize=8)
    plotting.label(ax, (1.45, 3.55), "described completely", color=VIEW)
    plotting.label(ax, (0.1, 4.3), "what one would like", ha="left")


def goal(ax: plotting.Axes) -> None:
    area(ax, (4.45, 3.62), (2.5, 1.05), GREY)
    area(ax, (4.45, 3.55), (1.1, 0.44), VIEW)
    plotting.label(ax, (4.45, 3.55), "the theory", color=VIEW)
    for way in ((-1, 0), (1, 0), (0, 1), (0, -1)):
        start = np.array([4.45, 3.55]) + np.array(way) * (0.58, 0.25)
        plotting.arrow(ax, start, start + np.array(way) * (0.38, 0.13), color=VIEW)
    plotting.label(ax, (3.1, 4.3), "where to go", ha="left")


def listed(ax: plotting.Axes, names: list, failed: list, corner: tuple[float, float], step: float) -> None:
    for k, (name, wrong) in enumerate(zip(names, failed, strict=True)):
        place = corner[0], corner[1] - step * k
        plotting.verdict(ax, place, not wrong, size=0.05)
        plotting.label(ax, (place[0] + 0.13, place[1]), f"{name}: {wrong}" if wrong else name, ha="left", fontsize=8)


def present(ax: plotting.Axes, data: dict) -> None:
    wrong = data["failed"].sum(axis=1)
    inside = wrong == 0
    area(ax, (1.93, 1.42), (3.76, 2.74), GREY)
    area(ax, (2.0, 1.2), (3.1, 2.05), VIEW)
    ax.add_patch(plotting.box((0.92, 0.53), 4.93, 1.36))
    plotting.label(ax, (1.93, 2.55), "what surfaces do to light", fontsize=8)
    plotting.label(ax, (2.0, 2.04), "microfacet theory", color=VIEW)
    plotting.label(ax, (5.8, 2.02), "models in use", ha="right")
    listed(ax, data["name"][inside], wrong[inside], (1.1, 1.74), 0.215)
    listed(ax, data["name"][~inside], wrong[~inside], (4.02, 1.66), 0.23)
    plotting.label(ax, (0.1, 2.9), "what there is", ha="left")


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=4.45)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    plotting.scene(ax, x=(0, 6), z=(0, 4.45))
    wished(ax)
    goal(ax)
    present(ax, data)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
