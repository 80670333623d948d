r"""On Gaussian surfaces, how much of a facet is seen depends on its slope, which Smith's model leaves out.

The seen share of the facets turned to the viewer against their slope along the view, in units of $\alpha$; slopes fall
towards the viewer on the left. Dots: ray-traced Gaussian surfaces, with bars of two standard errors over surfaces
where these are larger than the dots. Smith's $G_1$ is one number for all facets; in V-cavities, all facets that fall
towards the viewer beyond some slope are seen less and less, and all others wholly. Both give the same mean, which
conserves the area that is seen; so do the surfaces.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (37, 38, 40)
MODEL = (
    "ray-traced surfaces; Smith's model",
    "masking comes before any bounce",
)
CURVES = {"smith": ("Smith", "view", "--"), "v_cavity": ("V-cavities", "lost", ":")}


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=3.6, nrows=2, ncols=3, sharex=True, sharey=True)
    figure.subplots_adjust(left=0.075, right=0.985, bottom=0.19, top=0.93, wspace=0.1, hspace=0.14)
    for (row, column), ax in np.ndenumerate(axes):
        for name, (title, colour, line) in CURVES.items():
            ax.plot(
                data["fine"][row, column], data[name][row, column], label=title, linestyle=line, color=plotting.COLOURS[colour]
            )
        bars = {"fmt": "o", "markersize": 2.6, "linewidth": 0.8, "color": plotting.COLOURS["ink"], "label": "measured"}
        ax.errorbar(data["slope"][row, column], data["G1"][row, column], 2 * data["error"][row, column], **bars)
        ax.set(xlim=(-3.1, 1.6), xticks=[-3, -2, -1, 0, 1], ylim=(0, 1.04), yticks=[0, 0.5, 1])
    for column, alpha in enumerate(data["alpha"]):
        axes[0, column].set_title(rf"$\alpha = {alpha:.1f}$")
        axes[1, column].set_xlabel(r"slope along the view, $q/\alpha$")
    for ax, degrees in zip(axes[:, 0], data["degrees"], strict=True):
        ax.set_ylabel(rf"$G_1$ at $\theta_o = {degrees:.0f}^\circ$")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=3, bbox_to_anchor=(0.5, -0.025))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
