r"""A microfacet model is built in four stages, and each stage has something to check.

The geometry of the microsurface, what is visible of it, and what its material does with light lead to the BRDF; for
mirror facets it is Cook and Torrance's. The usual validation looks at the last stage only, by three criteria that
many a wrong formula meets. The validation in this report has a check at every stage: three conservation laws that
hold with equality, and a bound at the end. All ticks and numbers are computed, here for the polyline in the boxes,
seen at $50^\circ$ from the normal ($\cos 50^\circ = 0.643$, facets of reflectance 1). The lobe is the light that 1200
polylines of $\alpha = 0.4$ reflect into each angle.
"""

import sys

import numpy as np
from report import plotting

SLIDES = tuple(range(17, 30))
MODEL = (
    "the relief drawn, ray by ray, one bounce",
    "it is its own most complete model, and later bounces are named as missing",
)
PITCH, WIDE, HIGH, BASE, SIZE = 1.51, 1.29, 0.7, 2.62, 1.08
STAGES = ("geometry", "visibility", "material", "BRDF")
GIVES = ("$D$", "$G_1$", "mirror, $F$", r"$\rho=\frac{F\,G_2\,D}{4\,\cos\theta_o\,\cos\theta_i}$")
CLASSIC = ("positive", "reciprocal", "energy $\\leq 1$")
CHECKS = (
    (r"$\int\;\,(\omega_m\cdot\omega_g)\,D\,d\omega_m$", r"$= 1$"),
    (r"$\int\;\,G_1\,\langle\omega_o,\omega_m\rangle\,D\,d\omega_m$", r"$= \cos\theta_o$"),
    (r"$\int\;\,\frac{G_1\,D}{4\,\cos\theta_o}\,d\omega_i$", r"$= 1$"),
    (r"$\int\;\,\rho\,\cos\theta_i\,d\omega_i$", r"$\leq 1$"),
)
VIEW, LIGHT = plotting.COLOURS["view"], plotting.COLOURS["light"]


def lobe(ax: plotting.Axes, data: dict, left: float) -> None:
    foot, floor = np.array([left + 0.68, BASE + 0.1]), left + np.array([0, WIDE])
    reach = 0.5 * data["lobe"] / data["lobe"].max()
    tips = foot + (reach * np.array([np.sin(data["theta"]), np.cos(data["theta"])])).T
    ax.fill(*tips.T, facecolor=LIGHT, alpha=0.25, edgecolor="none")
    ax.plot(*tips.T, color=LIGHT, linestyle="-", linewidth=1)
    plotting.ground(ax, floor, np.full(2, foot[1]), depth=-BASE, linewidth=0.8)
    plotting.arrow(ax, foot, foot + 0.5 * data["wo"], color=VIEW)


def surface(ax: plotting.Axes, data: dict, stage: int, left: float) -> None:
    corner = np.array([left + (WIDE - SIZE) / 2, BASE + 0.2])
    x, z = corner[0] + SIZE * data["x"], corner[1] + SIZE * data["z"]
    plotting.ground(ax, np.r_[left, x, left + WIDE], np.r_[z[0], z, z[-1]], depth=-BASE, linewidth=0.8)
    if stage == 0:
        return
    plotting.pieces(ax, corner + SIZE * data["ends"], [VIEW] * len(data["ends"]), linewidth=2)
    for middle, way in zip(data["middle"], data["ways"][stage - 1], strict=True):
        start, colour = corner + SIZE * middle, (VIEW, LIGHT)[stage - 1]
        plotting.arrow(ax, start, start + 0.15 * way, color=colour, mutation_scale=4, linewidth=0.8)


def validation(ax: plotting.Axes, data: dict, k: int, middle: float) -> None:
    if k < 3:
        plotting.label(ax, (middle, 1.45), "nothing", color=plotting.COLOURS["grey"])
    else:
        for height, name, holds in zip((1.64, 1.45, 1.26), CLASSIC, data["classic"], strict=True):
            plotting.label(ax, (middle - 0.45, height), name, ha="left")
            plotting.verdict(ax, (middle + 0.45, height), holds)
    for height, text in zip((0.64, 0.37), CHECKS[k], strict=True):
        plotting.label(ax, (middle, height), text)
    plotting.label(ax, (middle - 0.06, 0.12), f"{data['sums'][k]:.3f}")
    plotting.verdict(ax, (middle + 0.25, 0.12), data["holds"][k])


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=3.6)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    plotting.scene(ax, x=(0, 6), z=(0, 3.6))
    for k, stage in enumerate(STAGES):
        left = 0.09 + PITCH * k
        lobe(ax, data, left) if k == 3 else surface(ax, data, k, left)
        ax.add_patch(plotting.box((left, BASE), WIDE, HIGH))
        plotting.label(ax, (left + WIDE / 2, BASE + HIGH + 0.13), stage)
        plotting.label(ax, (left + WIDE / 2, BASE - 0.24), GIVES[k])
        if k:
            plotting.arrow(ax, (left - PITCH + WIDE + 0.03, BASE + HIGH / 2), (left - 0.03, BASE + HIGH / 2))
        validation(ax, data, k, left + WIDE / 2)
    for height, text in ((2.0, "usually validated:"), (1.0, "validated here:")):
        ax.plot([0.09, 5.91], [height - 0.11] * 2, color="0.6", linestyle="-", linewidth=0.5)
        plotting.label(ax, (0.09, height), text, ha="left")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
