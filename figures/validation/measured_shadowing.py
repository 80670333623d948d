r"""How much of what is seen is also lit falls as light and viewer part in azimuth, and further than any form of $G_2$ says.

The lit share of the seen facets that are turned to the light, seen from $60^\circ$, for light from $60^\circ$ (above)
and $75^\circ$ (below), against the azimuth between the two directions. Dots: ray-traced Gaussian surfaces, with bars
of two standard errors over surfaces where these are larger than the dots. Where light and viewer are in the same
place, all that is seen is lit. In Smith's model the share is $G_2/G_1$, for each of the four forms of $G_2$; in
V-cavities it depends on the facet, and the mean is drawn.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (49, 50)
MODEL = (
    "ray-traced surfaces; all forms of Smith's shadowing",
    "it ends before the second bounce begins",
)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=3.9, nrows=2, ncols=3, sharex=True, sharey=True)
    figure.subplots_adjust(left=0.075, right=0.985, bottom=0.235, top=0.93, wspace=0.1, hspace=0.14)
    for (row, column), ax in np.ndenumerate(axes):
        for k, form in enumerate(data["forms"]):
            title = "separable" if form == "none" else str(form).replace("-", "- and ") + "-correlated"
            ax.plot(data["fine"], data["smith"][column, row, k], label=title)
        ax.plot(data["fine"], data["v_cavity"][column, row], label="V-cavities")
        bars = {"fmt": "o", "markersize": 2.6, "linewidth": 0.8, "color": plotting.COLOURS["ink"], "label": "measured"}
        ax.errorbar(data["azimuth"], data["lit"][column, row], 2 * data["error"][column, row], **bars)
        ax.set(xlim=(-4, 184), xticks=[0, 60, 120, 180], ylim=(0.5, 1.03), yticks=[0.6, 0.8, 1])
    for column, alpha in enumerate(data["alpha"]):
        axes[0, column].set_title(rf"$\alpha = {alpha:.1f}$")
        axes[1, column].set_xlabel("azimuth (degrees)")
    for ax, degrees in zip(axes[:, 0], data["theta_i"], strict=True):
        ax.set_ylabel(rf"lit, $\theta_i = {degrees:.0f}^\circ$")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=3, bbox_to_anchor=(0.5, -0.02))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
