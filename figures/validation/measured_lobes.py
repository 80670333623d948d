r"""The lobe of Gaussian surfaces has the shape that Smith's model gives it, and not that of V-cavities.

Light that leaves after one reflection, seen from $60^\circ$ (dots; crosses: where a flat mirror would send it), over the
hemisphere, whose rim is the horizon, in a projection that keeps solid angles. Above, $\rho \cos\theta_i$ as rays find it
on Gaussian surfaces. Below, by how much the models differ from that: V-cavities and Smith's height-correlated $G_2$ over
Beckmann's distribution of the same roughness, orange where a model sends too much light, purple where too little. Scales
hold within a column. Under the measured lobe stands its albedo with the standard error over surfaces, and the total
variation that noise alone would show; under each model its albedo, and the total variation between its lobe's shape and
the measured one.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (60,)
MODEL = (
    "ray-traced surfaces, one bounce, perfect mirrors; Smith's model and V-cavities",
    "a lobe of one bounce is compared with models of one",
)
MODELS = ("V-cavities", "Smith")
MEASURED = 2  # the last of the lobes


def directions(ax: plotting.Axes, data: dict, colour: str) -> None:
    """The view, and where a mirror would send its light."""
    at = np.sqrt(2) * np.sin(np.radians(data["degrees"]) / 2)
    ax.plot([at], [0], "+", color=colour, markersize=5, markeredgewidth=0.8)
    ax.plot([-at], [0], "o", color=colour, markersize=2.5)


def words(data: dict, column: int, row: int) -> str:
    albedo = data["albedo"][column, row]
    if row == MEASURED:
        return rf"{albedo:.3f} $\pm$ {data['albedo_error'][column]:.3f};  {data['noise'][column]:.3f}"
    return rf"{albedo:.3f};  {data['distance'][column, row]:.3f}"


def scale(figure: plotting.Figure, ax: plotting.Axes, filled: object, top: float, signed: bool) -> None:
    """A bar of colours beside the disc, with its ends."""
    bar = figure.colorbar(filled, ax=ax, fraction=0.035, pad=0.02, ticks=[-top, 0, top] if signed else [0, top])
    ends = [rf"$-{top:.2f}$", "0", f"{top:.2f}"] if signed else ["0", f"{top:.2f}"]
    bar.ax.set_yticklabels(ends, fontsize=7)
    bar.outline.set_visible(False)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=6.2, nrows=3, ncols=3)
    figure.subplots_adjust(left=0.05, right=0.93, bottom=0.03, top=0.955, wspace=0.22, hspace=0.16)
    for column, alpha in enumerate(data["alpha"]):
        *models, measured = data["lobe"][column]
        off = [model - measured for model in models]
        top, most = measured.max(), np.abs(off).max()
        for row, (ax, lobe) in enumerate(zip(axes[:, column], [measured, *off], strict=True)):
            filled = plotting.hemisphere(ax, data["theta"], data["phi"], lobe, most if row else top, signed=bool(row))
            directions(ax, data, plotting.COLOURS["ink"] if row else "w")
            plotting.label(ax, (0, -1.16), words(data, column, row - 1 if row else MEASURED), fontsize=8)
            scale(figure, ax, filled, most if row else top, signed=bool(row))
        axes[0, column].set_title(rf"$\alpha = {alpha:.1f}$", loc="center")
    for ax, name in zip(axes[:, 0], ("measured", *(f"{one} less measured" for one in MODELS)), strict=True):
        plotting.label(ax, (-1.17, 0), name, rotation=90)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
