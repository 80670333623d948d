"""Computes what the figure `speed_rays` shows: how long a ray takes here and in Embree, and how often verdicts are wrong."""

import sys

import numpy as np
from report.datafile import rounded, store

from benchmarks.embree import OFFSETS
from benchmarks.record import mark, read, rows, seconds, summary
from benchmarks.rivals_rays import METHODS, RAYS, SIDE, TASKS
from benchmarks.yardsticks import GUESTS

UNKNOWN = [float("nan")] * 3


def embree() -> dict:
    """Nanoseconds a ray, and the shares of wrong verdicts over the offset of the rays that start on facets; from the record."""
    kept, why = rows("rays"), read().get("rays", {}).get("rivals", {})
    times = [kept[name]["seconds"][-1] if name in kept else UNKNOWN for name in GUESTS["rays"]]
    wrong = {kind: kept.get(f"embree_{kind}_sorted", {}).get("error") for kind in ("reflected", "shadow")}
    versions = {row["version"] for row in kept.values() if "version" in row}
    return {
        "embree_times": 1e9 * np.array(times) / RAYS[0],
        "embree_said": next(iter(why.values()), "" if kept else "not measured"),
        "embree_version": next(iter(versions), ""),
        **{f"embree_{kind}": np.array(shares or [np.nan] * len(OFFSETS)) for kind, shares in wrong.items()},
    }


def compute() -> dict:
    times = 1e9 * np.array([seconds("rays", name, method)[-1] for name, method in METHODS.items()]) / RAYS[0]
    checked = [METHODS[name].error(RAYS[0]) for name in ("primary_unsorted", "shadow_unsorted")]
    theirs = embree()
    data = theirs | {
        "names": np.array(list(METHODS)),
        "words": np.array(list(TASKS.values())),
        "times": times,
        "ratio": theirs["embree_times"][:, 1] / times[:, 1],
        "false": max(checked),
        "wrong": round(sum(checked) * RAYS[0]),
        "checked": len(checked) * RAYS[0],
        "rays": RAYS[0],
        "spacing": np.spacing(np.float32(SIDE - 1)),
        "offsets": np.array(OFFSETS),
        "record": np.array(summary("rays", METHODS)),
        "stale": mark("rays", METHODS),
    }
    return rounded(data, digits=4)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
