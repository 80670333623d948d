r"""Error against time for masking that is traced, by the size of a surface and the number of its rays.

The mean masking of a Gaussian surface, $\alpha = 0.7$ seen at $60^\circ$, from one surface: the scatter between surfaces over
the time to make one, trace it, and count. A line goes from few rays to many on one grid. Filled dots are on the front of a
single surface; but surfaces can be repeated, and then a dot slides down along the grey lines, on which the error falls with the
root of the time. So the best plan is the dot with the ring, which no such line passes below.
"""

import sys

import numpy as np
from report import plotting

SLIDES = ()
LOOKS = (("sky", "o", ":"), ("view", "s", "--"), ("light", "D", "-"), ("lost", "^", "-."))


def slopes(ax: plotting.Axes, data: dict) -> None:
    """Lines of equal error^2 times time, the lowest through the best dot."""
    reach, high, effort = np.array(ax.get_xlim()), ax.get_ylim(), data["goal_seconds"] * data["goal"] ** 2
    for factor in 4.0 ** np.arange(6):
        ax.plot(reach, np.sqrt(factor * effort / reach), color=plotting.COLOURS["grey"], linestyle="-", linewidth=0.4, zorder=0)
    ax.set(xlim=reach, ylim=high)


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=3.3)
    figure.subplots_adjust(left=0.12, right=0.72, bottom=0.135, top=0.94)
    for (hue, marker, dash), size, errors, times, front in zip(
        LOOKS, data["grids"], data["errors"], data["times"], data["front"], strict=True
    ):
        look = {"color": plotting.COLOURS[hue], "marker": marker, "markersize": 4.5}
        ax.plot(times, errors, linestyle=dash, markerfacecolor="white", label=rf"{size} $\times$ {size} nodes", **look)
        ax.plot(times[front], errors[front], linestyle="", **look)
    ax.set(xscale="log", yscale="log", xlabel="time for one surface (seconds)", ylabel=r"relative error of $G_1$")
    if np.isfinite(data["times"]).any():
        best = tuple(data["best"])
        ax.plot(
            data["times"][best], data["errors"][best], "o", markersize=11, markerfacecolor="none", color=plotting.COLOURS["ink"]
        )
        slopes(ax, data)
    else:
        plotting.label(ax, (0.5, 0.5), "not measured yet: make bench NAME=tracing", transform=ax.transAxes)
        ax.set(xlim=(1e-3, 1), ylim=(1e-3, 1e-1))
    ax.set_title(str(data["stale"]))
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
