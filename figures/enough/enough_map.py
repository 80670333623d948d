r"""Which model is enough depends on the roughness and on the tolerance.

For a metal like silver, seen from $0$ to $80^\circ$: the cheapest model whose error is known to be below the tolerance.
Left to right: errors of the albedo, of the lobe, and of spheres in a picture. Above, GGX, relative to Smith's random
walk with exact Fresnel reflectance; below, Gaussian slopes, relative to ray-traced surfaces. Black line: the error of
single scattering by Smith's height-correlated model with exact reflectance. Below it one bounce is enough only in forms
whose errors make up for one another. Ticks at the top: roughnesses that were measured; between them errors are
interpolated. Grey: the cheapest is a model of GGX, with or without energy put back. In the white part at the bottom no
model is known to be enough.
"""

import sys

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from report import plotting

SLIDES = (73, 74, 75)
MODEL = (
    "all candidates, random walks and ray-traced surfaces, exact Fresnel reflectance",
    "errors are relative to the most complete one that there is for each distribution",
)
ROWS = {"ggx": "GGX", "beckmann": "Gaussian slopes"}
TOLERANCE = np.geomspace(1e-3, 1, 181)
KINDS = {  # what the map tells apart: the form of masking and the precision are not
    "one bounce, Schlick": "#CFE6F5",
    "one bounce, exact Fresnel": "#56B4E9",
    "scaled, Schlick": "#FBD9A0",
    "scaled, exact Fresnel": "#E69F00",
    "lobe added, Schlick": "#E9A7A0",
    "lobe added, exact Fresnel": "#C75000",
    "random walk": "#8F3B76",
    "GGX in place of Beckmann": "#B8B2A7",
}


def kind(words: str, normals: str) -> int:
    """The number of a model's kind, from its description."""
    first, *_, fresnel, more, _ = words.split(", ")
    if more == "random walk":
        name = "random walk"
    elif first.startswith("GGX") and normals == "beckmann":
        name = "GGX in place of Beckmann"
    else:
        fresnel = "Schlick" if "Schlick" in fresnel else "exact Fresnel"
        name = f"{more.replace('single scattering', 'one bounce')}, {fresnel}"
    return list(KINDS).index(name)


def between(most: plotting.Array, alpha: plotting.Array, fine: plotting.Array) -> plotting.Array:
    """Errors (roughnesses, candidates) at finer roughnesses, interpolated in logarithms of both."""
    return np.exp([np.interp(np.log(fine), np.log(alpha), np.log(np.maximum(one, 1e-9))) for one in most.T]).T


def first_within(errors: plotting.Array) -> plotting.Array:
    """The first candidate within each tolerance, as a number from 0, or NaN: (tolerances, roughnesses)."""
    within = errors[None] <= TOLERANCE[:, None, None]
    return np.where(within.any(axis=2), within.argmax(axis=2), np.nan)


def panel(ax: plotting.Axes, data: dict, normals: str, m: int) -> None:
    alpha = data["alpha"]
    fine = np.geomspace(alpha[0], alpha[-1], 121)
    errors = between(data[f"{normals}_most"][m], alpha, fine)
    kinds = np.array([kind(str(words), normals) for words in data[f"{normals}_words"]])
    first = first_within(errors)
    shown = np.where(np.isnan(first), np.nan, kinds[np.nan_to_num(first).astype(int)])
    shades = ListedColormap(list(KINDS.values()))
    ax.pcolormesh(fine, TOLERANCE, shown, cmap=shades, vmin=-0.5, vmax=len(KINDS) - 0.5, rasterized=True)
    ax.plot(fine, errors[:, data[f"{normals}_complete"][0]], color=plotting.COLOURS["ink"], linestyle="-", linewidth=1.2)
    ax.plot(alpha, np.full(len(alpha), TOLERANCE[-1]), "|", color=plotting.COLOURS["ink"], markersize=5, clip_on=False)
    ax.set(xscale="log", yscale="log", xlim=(alpha[0], alpha[-1]), ylim=(TOLERANCE[0], TOLERANCE[-1]))
    ax.set(xticks=[0.05, 0.1, 0.2, 0.5, 1], xticklabels=["0.05", "0.1", "0.2", "0.5", "1"])
    ax.minorticks_off()


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.8, nrows=2, ncols=3, sharex=True, sharey=True)
    figure.subplots_adjust(left=0.095, right=0.98, bottom=0.22, top=0.945, wspace=0.1, hspace=0.14)
    for row, normals in zip(axes, ROWS, strict=True):
        for m, ax in enumerate(row):
            panel(ax, data, normals, m)
        row[0].set_ylabel(f"{ROWS[normals]}: tolerance")
    for ax, title in zip(axes[0], data["measures"], strict=True):
        ax.set_title(str(title))
    for ax in axes[1]:
        ax.set_xlabel(r"roughness $\alpha$")
    patches = [Patch(facecolor=shade, label=name) for name, shade in KINDS.items()]
    line = Line2D([], [], color=plotting.COLOURS["ink"], linewidth=1.2, linestyle="-", label="one bounce, Smith, exact")
    figure.legend(handles=[*patches, line], loc="lower center", ncols=3, bbox_to_anchor=(0.53, -0.01))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
