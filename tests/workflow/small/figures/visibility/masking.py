r"""Rougher surfaces hide more of themselves.

The masking function $G_1$ over the angle, after @heitz2014.
"""

import sys

import matplotlib.pyplot as plt
import microfacet as mf
import numpy as np

SLIDES = (37, 38, 39)

data, *outputs = sys.argv[1:]
arrays = np.load(data)
plt.rcParams |= {"svg.hashsalt": "microfacet", "svg.fonttype": "path"}
figure, axes = plt.subplots(figsize=(6, 2.5))
axes.plot(arrays["x"], mf.GGX(1.0) * arrays["y"])
for path in outputs:
    dated = {"svg": "Date", "pdf": "CreationDate"}.get(path[-3:])
    figure.savefig(path, metadata={dated: None} if dated else None)
