r"""Rougher surfaces hide more of themselves.

The masking function $G_1$ over the angle, after @heitz2014.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import microfacet as mf
import numpy as np

SLIDES = (37, 38, 39)


def move() -> str:
    """A square that goes to and fro."""
    square = '<rect id="square" width="20" height="20" fill="#0072B2"/>'
    style = "@keyframes go { 50% { transform: translate(80px, 0) } } #square { animation: go 2s infinite }"
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 20"><style>{style}</style>{square}</svg>\n'


data, *outputs = sys.argv[1:]
if outputs[0].endswith(".moving.svg"):
    Path(outputs[0]).write_text(move(), "utf-8")
    sys.exit()
arrays = np.load(data)
plt.rcParams |= {"svg.hashsalt": "microfacet", "svg.fonttype": "path"}
figure, axes = plt.subplots(figsize=(6, 2.5))
axes.plot(arrays["x"], mf.GGX(1.0) * arrays["y"])
for path in outputs:
    dated = {"svg": "Date", "pdf": "CreationDate"}.get(path[-3:])
    figure.savefig(path, metadata={dated: None} if dated else None)
