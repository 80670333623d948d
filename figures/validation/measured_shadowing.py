r"""No form of $G_2$ follows how much of what is seen is also lit as light and viewer part in azimuth.

The lit share of the seen facets that are turned to the light, by area in the view, seen from $60^\circ$, for light from
$60^\circ$ (above) and $75^\circ$ (below), against the azimuth between the two directions: by how much Smith's four forms
of $G_2$, as $G_2/G_1$, are off from ray-traced Gaussian surfaces, whose autocorrelation is a Gaussian. Bars: two
standard errors over surfaces. Numbers: the measured share in the same and in opposite directions. V-cavities, which
are off by up to several tenths, are left out.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (49, 50)
MODEL = (
    "ray-traced surfaces; all forms of Smith's shadowing",
    "it ends before the second bounce begins",
)
MARKS = ("o", "s", "^", "D")


def title(form: str) -> str:
    return "separable" if form == "none" else form.replace("-", "- and ") + "-correlated"


def differences(ax: plotting.Axes, data: dict, column: int, row: int) -> None:
    """Each form less the measured share, with the error of the latter; marks are moved apart a little."""
    ax.axhline(0, color=plotting.COLOURS["grey"], linestyle="-", linewidth=0.6)
    lit, error = data["lit"][column, row], data["error"][column, row]
    for k, (form, mark) in enumerate(zip(data["forms"], MARKS, strict=True)):
        off, azimuth = data["smith"][column, row, k] - lit, data["azimuth"] + 1.5 * (k - 1.5)
        look = {"marker": mark, "markersize": 2.6, "linewidth": 0.9, "elinewidth": 0.8}
        ax.errorbar(azimuth, off, 2 * error, label=title(str(form)), **look)
    plotting.label(ax, (20, 0.088), f"{lit[0]:.2f}", fontsize=8)
    plotting.label(ax, (160, -0.115), f"{lit[-1]:.2f}", fontsize=8)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.2, nrows=2, ncols=3, sharex=True, sharey=True)
    figure.subplots_adjust(left=0.1, right=0.985, bottom=0.195, top=0.94, wspace=0.1, hspace=0.14)
    for (row, column), ax in np.ndenumerate(axes):
        differences(ax, data, column, row)
        ax.set(xlim=(-8, 188), xticks=[0, 60, 120, 180], ylim=(-0.14, 0.11), yticks=[-0.1, -0.05, 0, 0.05, 0.1])
    for column, alpha in enumerate(data["alpha"]):
        axes[0, column].set_title(rf"$\alpha = {alpha:.1f}$")
        axes[1, column].set_xlabel("azimuth (degrees)")
    for ax, degrees in zip(axes[:, 0], data["theta_i"], strict=True):
        ax.set_ylabel(rf"form less measured, $\theta_i = {degrees:.0f}^\circ$")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=4, bbox_to_anchor=(0.5, -0.015))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
