"""Computes what the figure `equal_time` shows: a picture by each sampler in the same time, and variance times time."""

import sys

import numpy as np
from report.datafile import rounded, store

from benchmarks.method import uniform
from benchmarks.record import mark, read, seconds, summary
from benchmarks.rivals_estimate import METHODS as ESTIMATE
from benchmarks.rivals_estimate import SAMPLERS, variance
from benchmarks.rivals_render import ALPHAS, METHODS, shading, sphere

NAMES = {"normals": "normals", "visible": "caps"}  # of the picture's methods, and what they sample with
SIDE, SAMPLES, REFERENCE, RENDERS = 150, 16, 1024, 8  # pixels; samples of a pixel by visible normals, in the reference
ALPHA = (0.1, 0.3, 0.6, 1.0)
THETA = np.array([0.0, 15.0, 30.0, 45.0, 55.0, 65.0, 70.0, 75.0, 80.0, 84.0, 87.0, 89.0])
SIGMA = 1.96  # standard errors on either side hold 95 %


def time(quantity: str, name: str, methods: dict) -> tuple[float, float]:
    """Seconds a sample, and the relative standard error of that median, as if times were normally distributed."""
    low, middle, high = np.array(seconds(quantity, name, methods[name])[-1]) / methods[name].sizes[-1]
    rounds = read().get(quantity, {}).get("rounds", 1)
    return middle, 1.2533 * (high - low) / 1.349 / middle / np.sqrt(rounds)


def render(name: str, normal: np.ndarray, samples: int, seed: int) -> np.ndarray:
    """The mean of so many samples of each pixel."""
    sampler, total = SAMPLERS[NAMES[name]], np.zeros(len(normal))
    for k in range(samples):
        total += shading(sampler)([normal, uniform(len(normal), 10**6 * seed + k)], sampler.model(*ALPHAS).parameters)
    return total / samples


def pictures() -> dict:
    """Two renders in equal time, what they should show, and how far they are from it, over several such renders."""
    normal, inside = sphere(SIDE)
    spent = {name: time("render", name, METHODS)[0] for name in NAMES}
    ratio = spent["visible"] / spent["normals"]
    samples = {"visible": SAMPLES, "normals": max(1, round(SAMPLES * ratio)) if np.isfinite(ratio) else SAMPLES}
    exact = render("visible", normal, REFERENCE, 99)
    data = {"timed": np.isfinite(ratio), "ratio": ratio, "inside": inside, "exact": exact}
    for name in NAMES:
        found = np.array([render(name, normal, samples[name], seed) for seed in range(RENDERS)])
        errors = np.sqrt(np.mean((found - exact) ** 2, axis=1)) / exact.mean()
        error = SIGMA * errors.std(ddof=1) / np.sqrt(RENDERS)
        data |= {f"{name}_picture": found[0], f"{name}_samples": samples[name]}
        data |= {f"{name}_error": errors.mean(), f"{name}_error_error": error}
    return data


def gains() -> dict:
    """Variance times time of normals over that of visible normals, with the bounds of a confidence interval."""
    (slow, slow_error), (fast, fast_error) = (time("estimate", kept, ESTIMATE) for kept in NAMES.values())
    timed = np.isfinite(slow / fast)
    ratio, spread = (slow / fast, slow_error**2 + fast_error**2) if timed else (1.0, 0.0)
    found = np.empty((len(ALPHA), len(THETA), 3))
    for at in np.ndindex(found.shape[:2]):
        (above, a), (below, b) = (variance(SAMPLERS[k], ALPHA[at[0]], np.radians(THETA[at[1]])) for k in NAMES.values())
        error = SIGMA * np.sqrt((a / above) ** 2 + (b / below) ** 2 + spread)
        found[at] = ratio * above / below * np.exp([-error, 0, error])
    return {
        "alpha": ALPHA,
        "theta": THETA,
        "gain": found,
        "gain_timed": timed,
        "time_ratio": ratio,
        "variance_ratio": found / ratio,
    }


def compute() -> dict:
    stale = mark("render", METHODS) or mark("estimate", {name: ESTIMATE[name] for name in NAMES.values()})
    told = {"record": np.array(summary("render", METHODS)), "stale": stale}
    return rounded(pictures() | gains() | told, digits=4)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
