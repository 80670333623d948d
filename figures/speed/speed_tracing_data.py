"""Computes what the figure `speed_tracing` shows: error against time of masking traced on surfaces, over rays and grids."""

import sys

import numpy as np
from microfacet.surface.measure import estimate
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

from benchmarks.record import front, mark, seconds, summary
from benchmarks.rivals_tracing import GRIDS, METHODS, SIDES, SURFACES, VIEW

ENTRIES = ("lobes_07",)
GOAL = 1e-3


def campaign() -> dict:
    """The relative error of the same masking in the report's own campaign, and its surfaces."""
    found = read(ENTRIES[0])
    view = THETA_O.index(float(np.degrees(VIEW).round()))
    value, error = estimate(found["seen"][:, view].sum(axis=-1), found["faced"][:, view].sum(axis=-1))
    family, plan = CAMPAIGN[ENTRIES[0]].family, CAMPAIGN[ENTRIES[0]].plan
    return {"campaign_error": error / value, "campaign_surfaces": len(found["surface"]), "campaign_side": plan.side,
            "campaign_size": family.size}  # fmt: skip


def compute() -> dict:
    errors = np.array([[m.error(side) for side in m.sizes] for m in METHODS.values()])
    times = np.array([[t[1] for t in seconds("tracing", name, m)] for name, m in METHODS.items()])
    least = np.array(front(errors.ravel().tolist(), times.ravel().tolist())).reshape(errors.shape)
    effort = errors**2 * times
    known = np.isfinite(effort).any()
    best = np.unravel_index(np.nanargmin(effort), effort.shape) if known else (0, 0)
    data = {
        "grids": GRIDS,
        "sides": SIDES,
        "errors": errors,
        "times": times,
        "front": least,
        "best": np.array(best),
        "best_grid": GRIDS[best[0]] if known else np.nan,
        "best_side": SIDES[best[1]] if known else np.nan,
        "goal": GOAL,
        "sure": 1 / np.sqrt(2 * (SURFACES - 1)),  # relative standard error of a standard deviation
        "surfaces": SURFACES,
        "goal_seconds": effort[best] / GOAL**2,
        "worst_ratio": np.nanmax(effort) / effort[best] if known else np.nan,
        "record": np.array(summary("tracing", METHODS)),
        "stale": mark("tracing", METHODS),
    }
    return rounded(data | campaign(), digits=3)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
