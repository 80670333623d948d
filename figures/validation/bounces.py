r"""Random walks in Smith's model send too little light out at once, and too much after two bounces, or from above after three.

Above, shares of the light, from Gaussian surfaces of perfect mirrors, that leave after one reflection (dots) and after at
most two, three, ... (the bands, darkest first), over the angle of the view. All of it leaves at last. Dashed lines:
random walks in Smith's model, after at most one, two and three bounces. Dotted: V-cavities, which know of one. Below, the
walks' share of each bounce less the measured one; bars are two standard errors, of surfaces and walks, to either side;
dots are moved apart a little so that all are seen.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (73, 74, 75)
MODEL = (
    "ray-traced surfaces and random walks, all bounces; Smith's model and V-cavities, one",
    "the surfaces are the most complete model, and the others are held against them",
)
SHADES = ("#1F4E79", "#3F7CAC", "#7FAFD0", "#AECBE0", "#D0E0EC", "#E8F0F6")
ORDERS = (("one", "view", "o"), ("two", "light", "s"), ("three", "green", "^"), ("more bounces", "lost", "v"))


def shares(ax: plotting.Axes, data: dict, k: int) -> None:
    """What has left after so many reflections."""
    total = np.cumsum(data["share"][k], axis=-1).T
    for bounce, shade in zip(range(1, len(total)), SHADES, strict=False):
        ax.fill_between(data["theta_o"], total[bounce - 1], total[bounce], color=shade, linewidth=0)
    walk = np.cumsum(data["walk_fine"][k], axis=-1)[:, 1:-1].T
    for line in (data["smith"][k], *walk):
        ax.plot(data["fine"], line, linestyle="--", color=plotting.COLOURS["light"], linewidth=1.0)
    ax.plot(data["fine"], data["v_cavity"][k], linestyle=":", color=plotting.COLOURS["ink"], linewidth=1.0)
    ax.plot(data["theta_o"], total[0], "o", markersize=2.6, color=plotting.COLOURS["ink"])
    ax.set(ylim=(0.4, 1.005), yticks=[0.4, 0.6, 0.8, 1])
    ax.set_title(rf"$\alpha = {data['alpha'][k]:.1f}$")


def differences(ax: plotting.Axes, data: dict, k: int) -> None:
    """By how much the walks are off, bounce by bounce."""
    ax.axhline(0, color="0.6", linestyle="-", linewidth=0.6)
    off = data["walk"][k] - data["by_order"][k]
    error = np.hypot(data["walk_error"][k], data["error"][k])
    for order, (name, colour, mark) in enumerate(ORDERS):
        theta = data["theta_o"] + 1.2 * (order - 1.5)
        look = {"marker": mark, "markersize": 2.6, "linewidth": 0.7, "elinewidth": 0.8, "linestyle": "-"}
        colours = {"color": plotting.COLOURS[colour], "label": name}
        ax.errorbar(theta, 100 * off[:, order], 200 * error[:, order], **look, **colours)
    ax.set(xlim=(-4, 84), xticks=[0, 20, 40, 60, 80], xlabel=r"$\theta_o$ (degrees)")


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.1, nrows=2, ncols=3, sharex=True, sharey="row")
    figure.subplots_adjust(left=0.085, right=0.985, bottom=0.165, top=0.94, wspace=0.1, hspace=0.14)
    for k in range(3):
        shares(axes[0, k], data, k)
        differences(axes[1, k], data, k)
    axes[0, 0].set_ylabel("share of the light")
    axes[1, 0].set_ylabel("walks less measured (%)")
    figure.legend(*axes[1, 0].get_legend_handles_labels(), loc="lower center", ncols=4, bbox_to_anchor=(0.5, -0.015))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
