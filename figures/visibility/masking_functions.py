r"""Of the masking functions in use, only two show a viewer as much surface as there is to see.

The share $\int G_1 \left\langle \omega_o, \omega_m \right\rangle D \, d\omega_m / \cos\theta_o$ that a viewer at
$\theta_o$ sees, which must be 1: with Beckmann at $\alpha = 0.4$ (left) and with GGX at $\alpha = 1$ (middle); right,
its distance from 1 for the former; what is smaller than the quadrature's own error is drawn at the edge of the grey
band. Implicit and both forms of Schlick-Smith pass at normal incidence, so a check there alone is worth nothing. The
second form, $k = \alpha/2$, is Smith's function itself for GGX at $\alpha = 1$, and at no other roughness. Yes and no
in the legend are verdicts over both distributions.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (56, 57, 58)


def axes_of(axes: plotting.Array, data: dict) -> None:
    for ax, title in zip(axes, (r"Beckmann, $\alpha = 0.4$", r"GGX, $\alpha = 1$", "distance from 1"), strict=True):
        ax.set(xlim=(0, 90), xticks=[0, 30, 60, 90], xlabel=r"$\theta_o$ (degrees)")
        ax.set_title(title)
    axes[0].set(ylim=(0, 1.2))
    axes[1].set(ylim=(0, 2.1), yticks=[0, 0.5, 1, 1.5, 2])
    axes[2].set(ylim=(data["floor"] / 10, 10), yscale="log")
    axes[2].axhspan(data["floor"] / 10, data["floor"], color="0.9", linewidth=0, zorder=0)
    axes[2].set_yticks(10.0 ** np.arange(-12, 1, 3))


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.75, ncols=3)
    figure.subplots_adjust(left=0.055, right=0.985, bottom=0.35, top=0.91, wspace=0.34)
    axes_of(axes, data)
    widths = np.linspace(2.4, 1.1, len(data["names"]))
    for k, name in enumerate(data["names"]):
        says = "yes" if np.all(data["verdict"][:, k] == "holds") else "no"
        axes[0].plot(data["theta"], data["share"][0, k], linewidth=widths[k], label=f"{name}: {says}")
        axes[1].plot(data["theta"], data["share"][1, k], linewidth=widths[k])
        axes[2].plot(data["theta"], data["apart"][0, k], linewidth=widths[k])
    figure.legend(loc="lower center", ncols=3, title="physically based?", bbox_to_anchor=(0.5, -0.02))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
