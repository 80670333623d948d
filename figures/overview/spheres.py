r"""By its roughness alone, one metal is a mirror, a satin, or brushed.

Spheres of one metal under one sky with three round lights, shaded by the library: Smith's masking and shadowing over
GGX (above) and Beckmann (below), with a lobe for the light that bounces again. From left to right the roughness
$\alpha$ rises; at the right the metal is brushed along the circles of latitude, so that it is smooth along and rough
across them, and highlights are drawn out to fans. GGX's slopes have the heavier tail, which shows as a haze around
every highlight.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (3,)
MODEL = (
    "Smith's model with a lobe for later bounces, exact Fresnel reflectance",
    "within a few per cent for a picture of metal of one roughness; one bounce would be too dark",
)


def name(alphas: plotting.Array) -> str:
    if alphas[0] == alphas[1]:
        return rf"$\alpha = {alphas[0]:g}$"
    return rf"$\alpha_x = {alphas[0]:g}$, $\alpha_y = {alphas[1]:g}$"


def draw(data: dict) -> plotting.Figure:
    rows, columns = data["images"].shape[:2]
    figure, axes = plotting.canvas(__file__, height=3.2, nrows=rows, ncols=columns)
    figure.subplots_adjust(left=0.045, right=1, bottom=0.005, top=0.925, wspace=0.03, hspace=0.03)
    for place in np.ndindex(rows, columns):
        axes[place].imshow(data["images"][place], interpolation="none")
        axes[place].axis("off")
    for ax, alphas in zip(axes[0], data["alphas"], strict=True):
        ax.set_title(name(alphas), loc="center")
    for ax, words in zip(axes[:, 0], ("GGX", "Beckmann"), strict=True):
        ax.text(-0.05, 0.5, words, rotation=90, ha="right", va="center", transform=ax.transAxes)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
