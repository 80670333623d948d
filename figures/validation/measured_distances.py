r"""By the lobe's shape Smith's model is nearer to a Gaussian surface; by the albedo, on rough ones at a slant, V-cavities are.

Above, total variation between the shapes of the measured lobe after one reflection and of each model's, over the angle
of the view; what noise alone would give is grey. Below, the model's albedo less the measured one. Bars are two standard
errors over surfaces, to either side; dots are moved apart a little so that all are seen.
"""

import sys

from report import plotting

SLIDES = (60,)
MODEL = (
    "ray-traced surfaces, one bounce, perfect mirrors; Smith's models and V-cavities",
    "one bounce is held against one; a reflectance would hide part of the differences",
)


def title(name: str) -> str:
    return name.replace("none", "separable").replace("Smith, height-direction", "Smith, height and direction")


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=3.9, nrows=2, ncols=3, sharex=True, sharey="row")
    figure.subplots_adjust(left=0.105, right=0.985, bottom=0.235, top=0.93, wspace=0.1, hspace=0.14)
    for k, alpha in enumerate(data["alpha"]):
        shape, albedo = axes[:, k]
        shape.fill_between(data["theta_o"], data["noise"][k], color="0.9", linewidth=0)
        albedo.axhline(0, color="0.6", linestyle="-", linewidth=0.6)
        for m, name in enumerate(data["names"][k]):
            theta, (value, error) = data["theta_o"] + 0.8 * (m - 2), data["distance"][k, :, m].T
            bars = {"marker": "o", "markersize": 2.2, "linewidth": 0.7, "elinewidth": 0.9, "label": title(str(name))}
            shape.errorbar(theta, value, 2 * error, **bars)
            value, error = data["albedo"][k].T
            albedo.errorbar(theta, data["model_albedo"][k, :, m] - value, 2 * error, **bars)
        shape.set_title(rf"$\alpha = {alpha:.1f}$")
        shape.set(yscale="log", ylim=(0.003, 0.6), yticks=[0.01, 0.1])
        albedo.set(xlim=(-3, 84), xticks=[0, 20, 40, 60, 80], xlabel=r"$\theta_o$ (degrees)")
    axes[0, 0].set_ylabel("total variation")
    axes[1, 0].set_ylabel("error of the albedo")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=3, bbox_to_anchor=(0.5, -0.02))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
