r"""What a model of one reflection leaves out is what leaves the surface after two, three and more.

Shares of the light, from Gaussian surfaces of perfect mirrors, that leave after one reflection (dots, with bars of two
standard errors where these are larger) and after at most two, three, ... (the bands, darkest first), over the angle of
the view. All of it leaves at last. The lines are the albedos of two models of one reflection.
"""

import sys

import numpy as np
from microfacet import plotting

SLIDES = (73, 74, 75)
CURVES = {"smith": ("Smith", "view", "--"), "v_cavity": ("V-cavities", "lost", ":")}
SHADES = ("#1F4E79", "#3F7CAC", "#7FAFD0", "#AECBE0", "#D0E0EC", "#E8F0F6")


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.5, ncols=3, sharey=True)
    figure.subplots_adjust(left=0.075, right=0.985, bottom=0.29, top=0.9, wspace=0.1)
    for k, (ax, alpha) in enumerate(zip(axes, data["alpha"], strict=True)):
        total = np.cumsum(data["share"][k], axis=-1).T
        for bounce, shade in zip(range(1, len(total)), SHADES, strict=False):
            ax.fill_between(data["theta_o"], total[bounce - 1], total[bounce], color=shade, linewidth=0, label=str(bounce + 1))
        for name, (title, colour, line) in CURVES.items():
            ax.plot(data["fine"], data[name][k], label=title, linestyle=line, color=plotting.COLOURS[colour])
        bars = {"fmt": "o", "markersize": 2.6, "linewidth": 0.8, "color": plotting.COLOURS["ink"], "label": "measured: 1"}
        ax.errorbar(data["theta_o"], data["share"][k, :, 0], 2 * data["error"][k, :, 0], **bars)
        ax.set(
            xlim=(-2, 82),
            xticks=[0, 20, 40, 60, 80],
            ylim=(0.4, 1.005),
            yticks=[0.4, 0.6, 0.8, 1],
            xlabel=r"$\theta_o$ (degrees)",
        )
        ax.set_title(rf"$\alpha = {alpha:.1f}$")
    axes[0].set_ylabel("share of the light")
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="lower center", ncols=8, bbox_to_anchor=(0.5, -0.03), handlelength=1.6
    )
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
