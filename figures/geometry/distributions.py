r"""Of five distributions of normals, three project to the whole surface, and two do not.

Left: five distributions at $\alpha = 0.5$; for Blinn-Phong the exponent that matches small roughness, $n = 2/\alpha^2
- 2$. Middle: the projected area $\int (\omega_m \cdot \omega_g)\, D(\omega_m)\, d\omega_m$ over $\alpha$, which must
be 1. Right: its distance from 1, by quadrature in slope space; what is smaller than the quadrature's own error is
drawn at the edge of the grey band. Blinn-Phong as first used crosses 1 at a single exponent, $n = 2 \pi - 2$, and
Ward without a fourth power of the cosine comes near it only where the surface is smooth. The legend's yes and no are
verdicts on the curves shown. Only a distribution's shape matters here, so no masking function is involved.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (53, 54, 55)


def axes_of(axes: plotting.Array, data: dict) -> None:
    shape, area, apart = axes
    shape.set(xlim=(0, 90), ylim=(0, 1.4), xticks=[0, 30, 60, 90], xlabel=r"$\theta_m$ (degrees)")
    shape.set_title(r"$D(\omega_m)$ (1/sr)")
    area.set(xlim=(0, 0.8), ylim=(0, 2.1), yticks=[0, 0.5, 1, 1.5, 2], xlabel=r"$\alpha$")
    area.set_title("projected area")
    apart.set(xlim=(0, 0.8), ylim=(data["floor"] / 10, 10), yscale="log", xlabel=r"$\alpha$")
    apart.set_title("distance from 1")
    apart.axhspan(data["floor"] / 10, data["floor"], color="0.9", linewidth=0, zorder=0)
    apart.set_yticks(10.0 ** np.arange(-12, 1, 3))


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.75, ncols=3)
    figure.subplots_adjust(left=0.055, right=0.985, bottom=0.35, top=0.91, wspace=0.34)
    axes_of(axes, data)
    widths = np.linspace(2.4, 1.1, len(data["names"]))
    for k, name in enumerate(data["names"]):
        says = "yes" if data["verdict"][k] == "holds" else "no"
        axes[0].plot(data["theta"], data["density"][k], linewidth=widths[k], label=f"{name}: {says}")
        axes[1].plot(data["alpha"], data["integral"][k], linewidth=widths[k])
        axes[2].plot(data["alpha"], data["apart"][k], linewidth=widths[k])
    figure.legend(loc="lower center", ncols=3, title="physically based?", bbox_to_anchor=(0.5, -0.02))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
