r"""Making up for later bounces returns the light, but not to where it goes, nor with the colour it has.

Above, light in the wrong place, over the angle of the view: half the sum of the differences between the light that Gaussian
surfaces of perfect mirrors send into each direction after all bounces and what a model sends there, as a share of what
arrives. What noise alone would give is grey. Below, for GGX with Schlick's reflectance, what is reflected of light from
everywhere, less what random walks in Smith's model reflect; one bounce soon leaves the picture. Bars above are two standard
errors to either side; below, what walks may be off at most.
"""

import sys

from report import plotting

SLIDES = (73, 74, 75)
MODEL = (
    "ray-traced surfaces and random walks, all bounces; one, made up for or not",
    "the surfaces are the most complete model that there is",
)
LOOKS = (("view", "o", "-"), ("light", "s", "--"), ("green", "^", ":"), ("ink", "v", "-."))


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.3, nrows=2, ncols=3, sharey="row")
    figure.subplots_adjust(left=0.085, right=0.985, bottom=0.155, top=0.945, wspace=0.1, hspace=0.45)
    for k, (above, below) in enumerate(axes.T):
        above.fill_between(data["theta_o"], 100 * data["noise"][k], color="0.88", linewidth=0)
        below.axhline(0, color="0.6", linestyle="-", linewidth=0.6)
        for m, (name, (colour, mark, line)) in enumerate(zip(data["names"], LOOKS, strict=True)):
            look = {"marker": mark, "markersize": 2.6, "linewidth": 0.9, "elinewidth": 0.8, "linestyle": line}
            paint = {"color": plotting.COLOURS[colour], "label": str(name)}
            value, error = 100 * data["distance"][k, :, m].T
            above.errorbar(data["theta_o"], value, 2 * error, **look, **paint)
            if m < 3:
                off = 100 * (data["metal"][k, :, m] - data["metal"][k, :, 3])
                below.errorbar(data["F0"], off, 100 * data["metal"][k, :, 4], **look, **paint)
        above.set_title(rf"$\alpha = {data['alpha'][k]:.1f}$")
        above.set(xlim=(-3, 83), xticks=[0, 20, 40, 60, 80], xlabel=r"$\theta_o$ (degrees)")
        below.set_title(rf"GGX, $\alpha = {data['metal_alpha'][k]:g}$")
        above.set(yscale="log", ylim=(0.5, 40), yticks=[1, 10], yticklabels=["1", "10"])
        below.set(xlim=(0, 1.03), xticks=[0.2, 0.4, 0.6, 0.8, 1], xlabel=r"$F_0$", ylim=(-5.5, 5.5), yticks=[-4, -2, 0, 2, 4])
    axes[0, 0].set_ylabel("light misplaced (%)")
    axes[1, 0].set_ylabel("albedo less walks' (%)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=4, bbox_to_anchor=(0.5, -0.015))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
