"""Computes what the figure `speed_samplers` shows: how far samplers are from their density, and variance times time."""

import sys

import numpy as np
from report.datafile import rounded, store

from benchmarks.record import fronts, mark, seconds, summary
from benchmarks.rivals_estimate import METHODS, SAMPLERS, Sampler, variance

ALPHA, DEGREES = 0.5, np.array([0.0, 20.0, 40.0, 55.0, 67.0, 75.0, 81.0, 85.0])
FLOOR = 1e-8  # nearer the difference quotients do not tell distances apart
SIGMA = 1.96


def variances() -> dict[tuple, np.ndarray]:
    """Of each weight, over the angles: value and standard error. Samplers of one density share a weight, and its variance."""
    first: dict[tuple, Sampler] = {}
    for sampler in SAMPLERS.values():
        first.setdefault((sampler.ndf, sampler.weigh), sampler)
    return {key: np.array([variance(s, ALPHA, np.radians(d), each=2**10) for d in DEGREES]) for key, s in first.items()}


def compute() -> dict:
    errors = [max(method.error(method.sizes[-1]), FLOOR) for method in METHODS.values()]
    times = np.array([1e9 * np.array(seconds("estimate", name, m)[-1]) / m.sizes[-1] for name, m in METHODS.items()])
    kinds, noise = [method.kind for method in METHODS.values()], variances()
    rows = np.array([noise[s.ndf, s.weigh] for s in SAMPLERS.values()])
    level = np.exp(np.log(rows[..., 0]).mean(axis=1))
    efforts = level[:, None] * times
    alone = {f"{name}_{part}": value for name, e, t, v in zip(METHODS, errors, times[:, 1], efforts[:, 1], strict=True)
             for part, value in (("error", e), ("ns", t), ("effort", v))}  # fmt: skip
    data = alone | {
        "names": np.array(list(METHODS)),
        "words": np.array([s.label for s in SAMPLERS.values()]),
        "kinds": np.array(kinds),
        "errors": np.array(errors),
        "times": times,
        "efforts": efforts,
        "best": fronts(kinds, errors, efforts[:, 1]),
        "alpha": ALPHA,
        "degrees": DEGREES,
        "variance": rows[..., 0],
        "spread": SIGMA * rows[..., 1],
        "product": rows[..., 0] * times[:, 1, None],
        "floor": FLOOR,
        "record": np.array(summary("estimate", METHODS)),
        "stale": mark("estimate", METHODS),
    }
    return rounded(data, digits=4)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
