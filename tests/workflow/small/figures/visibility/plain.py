"""A figure that computes nothing."""

import sys

import matplotlib.pyplot as plt

SLIDES = tuple(range(41, 43))

plt.rcParams |= {"svg.hashsalt": "microfacet", "svg.fonttype": "path"}
figure, axes = plt.subplots(figsize=(6, 1))
for path in sys.argv[1:]:
    dated = {"svg": "Date", "pdf": "CreationDate"}.get(path[-3:])
    figure.savefig(path, metadata={dated: None} if dated else None)
