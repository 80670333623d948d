r"""The lobe of Gaussian surfaces has the shape that Smith's model gives it, and not that of V-cavities.

Light that leaves after one reflection, seen from $60^\circ$ (white dots; crosses: where a flat mirror would send it):
$\rho \cos\theta_i$ over the hemisphere, whose rim is the horizon, in a projection that keeps solid angles. Above,
the BRDFs of V-cavities and of Smith's height-correlated model over Beckmann's distribution; below, what rays find on
Gaussian surfaces of the same roughness. Colours mean the same within a column. Under each model stand its albedo and
the total variation between its lobe's shape and the measured one; under the latter, the albedo with its standard error
over surfaces, and the total variation that noise alone would show.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (60,)
MODEL = (
    "ray-traced surfaces, one bounce, perfect mirrors; Smith's model and V-cavities",
    "a lobe of one bounce is held against models of one",
)
ROWS = ("V-cavities", "Smith", "measured")


def disc(ax: plotting.Axes, data: dict, lobe: plotting.Array, top: float) -> None:
    """A lobe over the hemisphere, with the directions of the view and of the mirror."""
    plotting.hemisphere(ax, data["theta"], data["phi"], lobe, top)
    at = np.sqrt(2) * np.sin(np.radians(data["degrees"]) / 2)
    ax.plot([at], [0], "+", color="w", markersize=5, markeredgewidth=0.8)
    ax.plot([-at], [0], "o", color="w", markersize=2.5)


def words(data: dict, column: int, row: int) -> str:
    albedo = data["albedo"][column, row]
    if row == 2:
        return rf"{albedo:.3f} $\pm$ {data['albedo_error'][column]:.3f};  {data['noise'][column]:.3f}"
    return rf"{albedo:.3f};  {data['distance'][column, row]:.3f}"


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=6.2, nrows=3, ncols=3)
    figure.subplots_adjust(left=0.05, right=0.99, bottom=0.03, top=0.955, wspace=0.04, hspace=0.16)
    for column, alpha in enumerate(data["alpha"]):
        lobes = data["lobe"][column]
        for row in range(3):
            disc(axes[row, column], data, lobes[row], lobes.max())
            plotting.label(axes[row, column], (0, -1.16), words(data, column, row), fontsize=8)
        axes[0, column].set_title(rf"$\alpha = {alpha:.1f}$", loc="center")
    for ax, name in zip(axes[:, 0], ROWS, strict=True):
        plotting.label(ax, (-1.17, 0), name, rotation=90)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
