r"""In a furnace, a sphere whose masking conserves the visible area vanishes.

Spheres of perfect mirrors, GGX of $\alpha = 0.5$, in surroundings that are equally bright everywhere. Above, masking
alone, the weak white furnace: what is seen must be as bright as what is behind. Brighter spheres show more surface
than there is, darker ones less; the numbers are the lowest and the highest brightness seen from $0$ to $89.9^\circ$.
Below, with shadowing: what one bounce lacks, a real surface sends out after more of them.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (46, 53)
MODEL = (
    "five masking functions without and with shadowing, one bounce",
    "the furnace is the test, and all of them are put to it",
)
SIDE = 301
ROWS = ("masking alone", "one bounce")


def sphere(theta: plotting.Array, light: plotting.Array) -> plotting.Array:
    """Brightness of a sphere seen from afar, and of the surroundings, which is 1."""
    x, y = np.meshgrid(*[np.linspace(-1.25, 1.25, SIDE)] * 2)
    radius = np.hypot(x, y)
    cover = np.clip((1 - radius) * SIDE / 2.5 + 0.5, 0, 1)
    return 1 + cover * (np.interp(np.arcsin(np.minimum(radius, 1)), theta, light) - 1)


def shown(light: plotting.Array) -> plotting.Array:
    """A shade of grey for any brightness; 1 is half way."""
    return light / (1 + light)


def span(light: plotting.Array) -> str:
    low, high = (f"{value:.2f}" for value in (light.min(), light.max()))
    return low if low == high else f"{low} to {high}"


def draw(data: dict) -> plotting.Figure:
    columns = len(data["name"])
    figure, axes = plotting.canvas(__file__, height=2.75, nrows=len(ROWS), ncols=columns)
    figure.subplots_adjust(left=0.035, right=1, bottom=0.06, top=0.92, wspace=0.06, hspace=0.2)
    for row, column in np.ndindex(axes.shape):
        ax, light = axes[row, column], data["light"][row, column]
        ax.imshow(shown(sphere(data["theta"], light)), cmap="gray", vmin=0, vmax=0.8, interpolation="bilinear")
        ax.set(xticks=[], yticks=[], xlabel=span(light))
        ax.spines[:].set_visible(False)
    for ax, name in zip(axes[0], data["name"], strict=True):
        ax.set_title(str(name), loc="center")
    for ax, name in zip(axes[:, 0], ROWS, strict=True):
        ax.set_ylabel(name)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
