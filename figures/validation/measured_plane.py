r"""In the plane of incidence, Gaussian surfaces reflect much as Smith's model says.

$\rho \cos\theta_i$ after one reflection in the plane of incidence, as the distance from the origin, for three
roughnesses and three views (the arrows), each at its own scale: the circles are labelled, in 1/sr. Bands reach over
two standard errors of the measured lobe to either side; they are widest near the normal, where the bins are smallest.
Models and measurement are means over the same bins, of $6^\circ$ by $15^\circ$.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (60,)
MODEL = (
    "ray-traced surfaces, one bounce, perfect mirrors; Smith's model and V-cavities",
    "a lobe of one bounce is compared with a model of one",
)
RINGS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
CURVES = {"v_cavity": "V-cavities", "smith": "Smith"}


def polar(theta: plotting.Array, radius: plotting.Array) -> plotting.Array:
    return np.array([radius * np.sin(theta), radius * np.cos(theta)])


def panel(ax: plotting.Axes, data: dict, row: int, column: int) -> None:
    theta, half = np.radians(data["theta"]), np.linspace(-np.pi / 2, np.pi / 2, 60)
    middle, error = data["measured"][row, column], data["error"][row, column]
    top = 1.03 * max(curve.max() for curve in (middle + 2 * error, data["smith"][row, column], data["v_cavity"][row, column]))
    plotting.scene(ax, x=(-0.8 * top, top), z=(-0.14 * top, top))
    ring = max(radius for radius in RINGS if radius < 0.78 * top)
    ax.plot(*polar(half, np.full(60, ring)), color="0.8", linestyle="-", linewidth=0.5, zorder=0)
    plotting.label(ax, (-ring, -0.09 * top), f"{ring:g}", fontsize=8, color="0.4")
    ax.plot([-top, top], [0, 0], color="0.3", linestyle="-", linewidth=0.6)
    band = np.hstack([polar(theta, middle + 2 * error), polar(theta, np.maximum(middle - 2 * error, 0))[:, ::-1]])
    ax.fill(*band, color=plotting.COLOURS["amber"], alpha=0.5, linewidth=0, zorder=1)
    ax.plot(*polar(theta, middle), color=plotting.COLOURS["ink"], linestyle="-", linewidth=0.9, label="measured")
    for (name, title), colour, line in zip(CURVES.items(), ("lost", "view"), (":", "--"), strict=True):
        ax.plot(*polar(theta, data[name][row, column]), color=plotting.COLOURS[colour], linestyle=line, label=title)
    way = polar(-np.radians(data["degrees"][row]), np.array(1.0))
    plotting.arrow(ax, (0, 0), 0.6 * top * way, color=plotting.COLOURS["grey"])


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.6, nrows=3, ncols=3)
    figure.subplots_adjust(left=0.06, right=1, bottom=0.06, top=0.95, wspace=0.02, hspace=0.08)
    for (row, column), ax in np.ndenumerate(axes):
        panel(ax, data, row, column)
    for column, alpha in enumerate(data["alpha"]):
        axes[0, column].set_title(rf"$\alpha = {alpha:.1f}$", loc="center")
    for row, degrees in enumerate(data["degrees"]):
        figure.text(0.025, 0.81 - 0.305 * row, rf"$\theta_o = {degrees:.0f}^\circ$", rotation=90, ha="center", va="center")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=3, bbox_to_anchor=(0.5, -0.02))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
