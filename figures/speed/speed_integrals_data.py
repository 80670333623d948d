"""Computes what the figure `speed_integrals` shows: errors of rules over their numbers of nodes; times are on record."""

import sys

import numpy as np
from report.datafile import rounded, store

from benchmarks.record import front, mark, seconds, summary
from benchmarks.rivals_integral import METHODS as AREAS

ASKED = 1e-12


def compute() -> dict:
    """Curves of error and of seconds, one point a size; points on the front; the least time that reaches `ASKED`."""
    data: dict = {"names": np.array(list(AREAS)), "words": np.array([m.label for m in AREAS.values()])}
    errors = {name: [max(method.error(size), 1e-16) for size in method.sizes] for name, method in AREAS.items()}
    times = {name: [t[1] for t in seconds("integral", name, method)] for name, method in AREAS.items()}
    every = [(e, t) for name in AREAS for e, t in zip(errors[name], times[name], strict=True)]
    best = iter(front([e for e, _ in every], [t for _, t in every]))
    for name in AREAS:
        data |= {f"{name}_errors": np.array(errors[name]), f"{name}_times": np.array(times[name])}
        data[f"{name}_best"] = np.array([next(best) for _ in errors[name]])
        reached = [t for e, t in zip(errors[name], times[name], strict=True) if e <= ASKED]
        data[f"{name}_reaches"] = np.nanmin(reached) if reached and np.isfinite(reached).any() else np.inf
    return rounded(
        data | {"asked": ASKED, "record": np.array(summary("integral", AREAS)), "stale": mark("integral", AREAS)}, digits=3
    )


if __name__ == "__main__":
    store(sys.argv[1], **compute())
