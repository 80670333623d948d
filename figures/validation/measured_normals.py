r"""The normals that are seen at a grazing angle are nearly those of Smith's model, and not those of V-cavities.

Which slopes along the view fill it, at $80^\circ$ from the normal: the density of slopes in units of $\alpha$, where
slopes on the left fall towards the viewer. Steps: ray-traced Gaussian surfaces, with bands of two standard errors over
surfaces to either side; grey: all facets, seen or not. The numbers are total variations between the measured
distribution of visible normals, over both slopes, and each model's. Where a mirror sends its light follows from its
normal alone, so that these are also the distances between distributions of reflected directions.
"""

import sys

from report import plotting

SLIDES = (41, 42, 44, 45)
MODEL = (
    "ray-traced surfaces; Smith's model and V-cavities",
    "what is seen comes before any bounce",
)
CURVES = {"v_cavity": ("V-cavities", "lost", ":"), "smith": ("Smith", "view", "--")}


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.5, ncols=3, sharey=True)
    figure.subplots_adjust(left=0.055, right=0.985, bottom=0.29, top=0.9, wspace=0.08)
    for k, (ax, alpha) in enumerate(zip(axes, data["alpha"], strict=True)):
        ax.fill_between(data["fine"][k], data["all"][k], color="0.9", linewidth=0, label="all facets")
        low, high = (data["seen"][k] + sign * 2 * data["error"][k] for sign in (-1, 1))
        ax.fill_between(
            data["edges"][k], [*low, low[-1]], [*high, high[-1]], step="post", color=plotting.COLOURS["amber"], linewidth=0
        )
        ax.stairs(data["seen"][k], data["edges"][k], color=plotting.COLOURS["ink"], linewidth=0.8, label="measured")
        for place, (name, (title, colour, line)) in zip((0.86, 0.74), CURVES.items(), strict=True):
            ax.plot(data["fine"][k], data[name][k], label=title, linestyle=line, color=plotting.COLOURS[colour])
            value = data["distance"][k, list(CURVES).index(name), 0]
            ax.text(0.97, place, f"{title}: {value:.3f}", transform=ax.transAxes, ha="right", fontsize=8)
        ax.set(xlim=(-3, 3), xticks=[-2, 0, 2], ylim=(0, 1.3), yticks=[0, 0.5, 1], xlabel=r"slope along the view, $q/\alpha$")
        ax.set_title(rf"$\alpha = {alpha:.1f}$")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="lower center", ncols=4, bbox_to_anchor=(0.5, -0.03))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
