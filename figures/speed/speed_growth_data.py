"""Computes what the figure `speed_growth` shows: the powers with which recorded times grow; there is nothing to run."""

import sys

import numpy as np
from report.datafile import rounded, store

from benchmarks.record import mark, seconds, summary
from benchmarks.rivals_growth import EXPECTED, METHODS, RAYS


def power(sizes: np.ndarray, times: np.ndarray, first: int) -> tuple[float, float]:
    """The exponent fitted to what is known from a size on, and its standard error; NaN if that are fewer than three."""
    chosen = np.isfinite(times) & (sizes >= first)
    if chosen.sum() < 3:
        return np.nan, np.nan
    x, y = np.log(sizes[chosen]), np.log(times[chosen])
    slope, offset = np.polyfit(x, y, 1)
    rest = np.sum((y - slope * x - offset) ** 2) / (len(x) - 2)
    return float(slope), float(np.sqrt(rest / np.sum((x - x.mean()) ** 2)))


def compute() -> dict:
    data: dict = {"names": np.array(list(METHODS)), "words": np.array([m.label for m in METHODS.values()])}
    for name, method in METHODS.items():
        sizes, expected = np.array(method.sizes, float), EXPECTED[name]
        times = np.array(seconds("growth", name, method))
        fitted, error = power(sizes, times[:, 1], expected.first)
        data |= {f"{name}_sizes": sizes, f"{name}_times": times, f"{name}_power": fitted, f"{name}_power_error": error}
        data |= {f"{name}_expected": expected.power, f"{name}_first": expected.first, f"{name}_why": expected.why}
    told = {"record": np.array(summary("growth", METHODS)), "stale": mark("growth", METHODS)}
    return rounded(data | told | {"rays_traced": RAYS}, digits=3)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
