r"""A flat piece of surface, seen close enough, is a microsurface.

Left: the geometric surface, a unit segment with its one normal $\omega_g$. Right: what light meets instead, here a
periodic polyline of twelve microfacets, each with its own normal $\omega_m$. Its nodes lie on a random smooth curve, whose
slopes have the root mean square of a Beckmann surface of $\alpha = 1$; the facets are its chords, and flatter. Most
drawings that follow show this polyline, others the same curve cut into more facets; the lengths printed are measured.
"""

import sys

from report import plotting

SLIDES = (30, 31, 32)


def draw(data: dict) -> plotting.Figure:
    figure, (flat, rough) = plotting.canvas(__file__, height=1.35, ncols=2)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1, wspace=0)
    for ax, z, length, name in (
        (flat, 0 * data["x"], "1", "geometric surface"),
        (rough, data["z"], f"{data['length']:.2f}", "microsurface"),
    ):
        plotting.scene(ax, x=(-0.06, 1.06), z=(-0.22, 0.275))
        plotting.ground(ax, data["x"], z, depth=0.06, nodes=ax is rough)
        plotting.label(ax, (0.5, -0.15), f"{name}, length {length}")
    plotting.arrow(flat, (0.5, 0), (0.5, 0.17))
    plotting.label(flat, (0.56, 0.15), r"$\omega_g$")
    for start, normal in zip(data["middle"], data["normals"], strict=True):
        plotting.arrow(rough, start, start + 0.08 * normal, color=plotting.COLOURS["view"])
    tip = data["middle"][8] + 0.08 * data["normals"][8]
    plotting.label(rough, (tip[0] + 0.05, tip[1] + 0.02), r"$\omega_m$", color=plotting.COLOURS["view"])
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
