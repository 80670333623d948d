r"""Sampling the normals that the viewer sees leaves less noise in the same time, far less at grazing views.

Above, a rough sphere ($\alpha = 0.3$) in equal time: by all normals, by visible normals, and converged; under each the
root mean square error over the mean. Below, how many times longer all normals take to the same noise, for the light
reflected under a white sky: variance times time of one over that of the other, over the angle of the view. Bands are
95 % confidence intervals. Below the dotted line all normals would be the better choice.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (15,)
MODEL = (
    "Smith's model, one bounce",
    "noise is compared between two pictures of one model, and both lack the same light",
)
EXPOSURE = 0.9
HUES = ("sky", "view", "light", "lost")
DASHES = ("-", "--", "-.", ":")


def picture(ax: plotting.Axes, data: dict, values: plotting.Array, title: str, below: str) -> None:
    image = np.ones(data["inside"].shape)
    image[data["inside"]] = (1 - np.exp(-EXPOSURE * values)) ** (1 / 2.2)
    ax.imshow(image, cmap="gray", vmin=0, vmax=1, interpolation="none")
    ax.set_title(title, loc="center")
    ax.text(0.5, -0.02, below, ha="center", va="top", transform=ax.transAxes, fontsize=8)
    ax.axis("off")


def pictures(axes: plotting.Array, data: dict) -> None:
    for ax, name, words in zip(axes, ("normals", "visible"), ("all normals", "visible normals"), strict=False):
        samples = f"{data[f'{name}_samples']} samples" + ("" if data["timed"] else ", untimed")
        error = rf"error ({100 * data[f'{name}_error']:.1f} $\pm$ {100 * data[f'{name}_error_error']:.1f}) %"
        picture(ax, data, data[f"{name}_picture"], f"{words}\n{samples}", error)
    picture(axes[2], data, data["exact"], "what both would show\nwith endless samples", "")


def gains(ax: plotting.Axes, data: dict) -> None:
    for k, (alpha, rows) in enumerate(zip(data["alpha"], data["gain"], strict=True)):
        colour = plotting.COLOURS[HUES[k]]
        low, middle, high = rows.T
        ax.fill_between(data["theta"], low, high, color=colour, alpha=0.25, linewidth=0)
        ax.plot(data["theta"], middle, color=colour, linestyle=DASHES[k], label=rf"$\alpha = {alpha:g}$")
    ax.axhline(1, color=plotting.COLOURS["grey"], linestyle=":", linewidth=0.7)
    what = r"variance $\times$ time" if data["gain_timed"] else "variance (not timed yet)"
    ax.set_title(str(data["stale"]))
    ax.set(xlabel=r"$\theta_o$ (degrees)", ylabel=f"{what},\nall normals over visible", yscale="log", xlim=(0, 90))
    ax.set_xticks(range(0, 91, 15))
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=4.5, nrows=2, ncols=3, height_ratios=(1.05, 1))
    figure.subplots_adjust(left=0.02, right=0.98, bottom=0.11, top=0.9, wspace=0.05, hspace=0.33)
    pictures(axes[0], data)
    for ax in axes[1]:
        ax.remove()
    gains(figure.add_axes((0.12, 0.105, 0.68, 0.33)), data)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
