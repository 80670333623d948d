"""Computes what the figure `stretching` shows: one Gaussian surface before and after stretching, and its slopes."""

import sys

import numpy as np
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.gaussian import GaussianField
from report.datafile import rounded, store

ALPHA, STRETCH, LENGTH = 0.5, 2.0, 16.0
SIZE, SHOWN, SLOPES = 192, 400, 1.25


def facet_slopes(heights: np.ndarray, wide: float) -> np.ndarray:
    """Slopes of the periodic grid's facets, cells `wide` along x; shape (2, size, size)."""
    return np.stack([(np.roll(heights, -1, axis=0) - heights) / wide, np.roll(heights, -1, axis=1) - heights])


def compute() -> dict:
    field = GaussianField(SIZE, ALPHA, correlation=LENGTH, root=3)
    heights = field.spectral(0)
    heights -= heights.mean()
    few = np.random.default_rng(1).choice(SIZE**2, SHOWN, replace=False)
    grid = np.linspace(-SLOPES, SLOPES, 101)
    whole = np.pad(heights, ((0, 1), (0, 1)), mode="wrap")[::3, ::3] / LENGTH
    data = {"heights": whole, "cells": np.arange(0, SIZE + 1, 3) / LENGTH, "grid": grid, "stretch": STRETCH}
    for name, wide in (("before", 1.0), ("after", STRETCH)):
        slopes = facet_slopes(heights, wide)
        ndf = Beckmann(ALPHA / wide, ALPHA)
        if name == "before":
            data["marked"] = np.argsort(slopes[0].ravel()[few])[[3, 40, -40, -6]]
        data[f"{name}_slopes"] = slopes.reshape(2, -1)[:, few]
        data[f"{name}_P22"] = ndf.P22(*np.meshgrid(grid, grid, indexing="ij"))
        data[f"{name}_measured"] = np.sqrt(2 * np.mean(slopes**2, axis=(1, 2)))
        data[f"{name}_alphas"] = np.array(ndf.slope_scale)
    return rounded(data, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
