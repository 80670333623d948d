r"""Stretching breaks none of the four validation equations, unless the masking function ignores it.

The largest relative residual of the four equations at each view direction, for GGX with $\alpha_x = 0.1$ and
$\alpha_y = 0.6$: Smith with $\alpha_o$ (left), V-cavities (middle), and Smith with the mean roughness $\sqrt{\alpha_x
\alpha_y}$ at every azimuth (right). The first two stay below what the quadrature can tell
from 0; the third is right from straight above and at the one azimuth where $\alpha_o$ happens to be the mean. One
pair of roughnesses stands for many: over a grid of 25 pairs from 0.05 to 1, with Beckmann as well as GGX, Smith and
V-cavities hold everywhere.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (72,)
TITLES = {"smith": r"Smith, $\alpha_o$", "v_cavity": "V-cavities", "mean": r"Smith, $\sqrt{\alpha_x \alpha_y}$"}
LEVELS = np.arange(-10, 0.1, 1.0)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.4, ncols=3, sharey=True)
    figure.subplots_adjust(left=0.1, right=0.87, bottom=0.2, top=0.89, wspace=0.14)
    for ax, (name, title) in zip(axes, TITLES.items(), strict=True):
        apart = np.clip(np.log10(data[name]), LEVELS[0] + 1e-6, LEVELS[-1])
        filled = ax.contourf(data["phi"], data["theta"], apart, LEVELS, cmap="cividis")
        ax.set(xticks=[0, 30, 60, 90], yticks=[0, 30, 60, 88], xlabel=r"$\phi_o$ (degrees)")
        ax.set_title(title)
        says = "all hold" if data[f"{name}_verdict"] == "holds" else "fails"
        shade = "w" if data[f"{name}_verdict"] == "holds" else "k"
        plotting.label(ax, (45, 44), says, color=shade)
    axes[0].set_ylabel(r"$\theta_o$ (degrees)")
    bar = figure.colorbar(filled, cax=figure.add_axes((0.895, 0.2, 0.02, 0.69)))
    bar.set_ticks([-10, -7, -4, -1], labels=[r"$\leq 10^{-10}$", "$10^{-7}$", "$10^{-4}$", "$10^{-1}$"])
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
