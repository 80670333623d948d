r"""Error against time for one validation integral.

The projected area of the facets that a viewer at $75^\circ$ sees of a Beckmann surface with $\alpha = 0.1$, by rules of
more and more nodes. Filled dots are on the front: nothing is both faster and nearer. The library's rules are one dot each,
because they choose their nodes themselves: the star for a distribution that the library can compile, the other for any
function; an estimate of the error is in the time of both. Arb's error is the radius of a ball that is proved to hold
the area; at more digits than can be drawn here it goes on falling.
"""

import sys

import numpy as np
from report import plotting

SLIDES = ()
LOOKS = {
    "midpoint": ("grey", "o"),
    "gauss_angles": ("grey", "s"),
    "gauss_slopes": ("view", "D"),
    "gauss_cdf": ("view", "h"),
    "tanh_sinh": ("green", "^"),
    "cubature": ("amber", "v"),
    "monte_carlo": ("sky", "P"),
    "sobol": ("ink", "X"),
    "arb": ("lost", "p"),
    "any": ("light", "s"),
    "library": ("light", "*"),
}


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=3.4)
    figure.subplots_adjust(left=0.095, right=0.66, bottom=0.13, top=0.94)
    for name, words in zip(data["names"], data["words"], strict=True):
        (hue, marker), times, errors = LOOKS[str(name)], data[f"{name}_times"], data[f"{name}_errors"]
        colour, best = plotting.COLOURS[hue], data[f"{name}_best"]
        size = 8 if marker == "*" else 4
        ax.plot(times, errors, marker, color=colour, linestyle="-", markerfacecolor="white", markersize=size, label=str(words))
        ax.plot(times[best], errors[best], marker, color=colour, linestyle="", markersize=size)
    if not any(np.isfinite(data[f"{name}_times"]).any() for name in data["names"]):
        plotting.label(ax, (0.5, 0.5), "no times on record", transform=ax.transAxes)
        ax.set_xlim(2e-5, 1)
    ax.axhline(data["asked"], color=plotting.COLOURS["grey"], linewidth=0.6, linestyle=":")
    ax.set(xscale="log", yscale="log", ylim=(3e-17, 3), xlabel="time (seconds)", ylabel="relative error")
    ax.set_title(str(data["stale"]))
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
