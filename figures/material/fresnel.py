r"""A facet reflects a part of the light that depends on its angle, and lets the rest in.

Left: a ray at $60^\circ$ to a facet of a dielectric of index 1.5 splits in two; the widths of the lines, and the
numbers, are the shares that Fresnel's equations give. Middle: reflectance over the angle $\theta$ between light and
facet: the dielectric from outside and from inside, where beyond the critical angle all is reflected, and two
conductors, of indices near those of aluminium and of iron in green light. Right: what Schlick's approximation is off
by, given the exact value at $0^\circ$; for the dielectric seen from inside it knows nothing of total reflection, and
its error leaves the frame.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (47, 48)
CURVES = ("outside", "inside", "metal_0", "metal_1")


def rays(ax: plotting.Axes, data: dict) -> None:
    """The incoming ray and its two parts, as wide as their shares."""
    plotting.scene(ax, x=(-1.05, 1.05), z=(-1.08, 1.0))
    plotting.ground(ax, [-1.05, 1.05], [0, 0], depth=1.08)
    share, turn = float(data["split"]), np.radians([data["degrees"], data["degrees"], data["refracted"]])
    ends = np.array([[-1, 1], [1, 1], [1, -1]]) * np.stack([np.sin(turn), np.cos(turn)], axis=1)
    colours = [plotting.COLOURS[name] for name in ("ink", "light", "view")]
    for end, width, colour in zip(ends, (1.0, share, 1 - share), colours, strict=True):
        ax.plot(
            *np.stack([0 * end, 0.95 * end], axis=1),
            color=colour,
            linestyle="-",
            linewidth=9 * width,
            solid_capstyle="butt",
            zorder=3,
        )
    plotting.arrow(ax, (0, 0), (0, 0.75), linewidth=0.7)
    plotting.label(ax, (0.0, 0.87), r"$\omega_m$")
    plotting.label(ax, (0.62, 0.62), f"{100 * share:.1f}%", color=colours[1])
    plotting.label(ax, (-0.05, -0.62), f"{100 - 100 * share:.1f}%", color=colours[2])
    plotting.label(ax, (-0.55, 0.74), "100%")


def draw(data: dict) -> plotting.Figure:
    figure, (scene, curves, errors) = plotting.canvas(__file__, height=2.55, ncols=3, width_ratios=(1, 1.25, 1.25))
    figure.subplots_adjust(left=0.01, right=0.985, bottom=0.37, top=0.91, wspace=0.27)
    rays(scene, data)
    names = ["dielectric 1.5, outside", "dielectric 1.5, inside", *(f"conductor {m}" for m in data["metals"])]
    for curve, name in zip(CURVES, names, strict=True):
        (line,) = curves.plot(data["theta"], data[curve], label=name)
        errors.plot(data["theta"], data[f"{curve}_schlick"] - data[curve], color=line.get_color())
    for ax, limits, title in ((curves, (0, 1.03), r"reflectance $F$"), (errors, (-0.2, 0.2), r"error of Schlick's $F$")):
        ax.set(xlim=(0, 90), ylim=limits, xticks=[0, 30, 60, 90], xlabel=r"$\theta$ (degrees)")
        ax.set_title(title)
    curves.set_yticks([0, 0.25, 0.5, 0.75, 1])
    errors.set_yticks([-0.2, -0.1, 0, 0.1, 0.2])
    errors.axhline(0, color="0.6", linestyle="-", linewidth=0.6, zorder=0)
    figure.legend(loc="lower center", ncols=2, bbox_to_anchor=(0.5, -0.02))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
