r"""What there is to choose from, for metal of $\alpha$ from 0.05 to 0.3 and a picture that may be off by 1 %.

Each dot is a model, by its error and by its time for one value in large arrays; open dots are of single precision. The
grey line joins those that no other beats in both, the dashed line is the tolerance, and the ring is the choice.
"""

import sys

import numpy as np
from microfacet.enough import chart
from report import plotting

SLIDES = (73, 74, 75)
MODEL = (
    "all candidates for GGX, and random walks, exact Fresnel reflectance",
    "for GGX nothing more complete is known; the text says how far that is from surfaces",
)


def draw(data: dict) -> plotting.Figure:
    figure, ax = plotting.canvas(__file__, height=2.9)
    figure.subplots_adjust(left=0.1, right=0.76, bottom=0.15, top=0.97)
    if data["timed"]:
        chart.draw(ax, data)
    else:
        rank = dict(data) | {"cost": np.arange(1.0, 1 + len(data["error"]))}
        chart.draw(ax, rank)
        ax.set(xscale="linear", xlabel="models, the crudest first (no times on record: make bench NAME=models)")
    ax.set_ylabel("relative error of the picture")
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
