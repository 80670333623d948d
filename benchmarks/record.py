"""The record of benchmarks: what `make bench` measured, where, and whether the code it timed is still the same."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.method import Method

RECORD = Path("records/benchmarks.json")


def read(path: Path | None = None) -> dict[str, Any]:
    """Every quantity measured so far, by name; nothing if there is no record, and the end if it is torn or something else."""
    path = path or RECORD
    if not path.exists():
        return {}
    try:
        record = json.loads(path.read_text("utf-8"))
        for kept in record.values():
            look_through(kept)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        sys.exit(f"{path} is torn or no record of benchmarks: `git checkout {path}` brings it back.")
    return dict(record)


def look_through(kept: Mapping[str, Any]) -> None:
    """An exception if a quantity's record lacks what is read of it."""
    if not (
        {"commit", "machine", "rounds", "rows"} <= kept.keys() and {"processor", "threads", "load"} <= kept["machine"].keys()
    ):
        raise ValueError("where and when it was timed is missing")
    for row in kept["rows"].values():
        if not ({"words", "fingerprint"} <= row.keys() and np.shape(row["seconds"]) == (len(row["sizes"]), 3)):
            raise ValueError("times are missing")


def rows(quantity: str) -> dict[str, dict[str, Any]]:
    return dict(read().get(quantity, {}).get("rows", {}))


def stale(quantity: str, methods: Mapping[str, Method]) -> list[str]:
    """The methods whose code has changed since they were timed, in words."""
    kept = rows(quantity)
    return [m.words for name, m in methods.items() if name in kept and kept[name]["fingerprint"] != m.fingerprint]


def unmeasured(quantity: str, methods: Mapping[str, Method]) -> list[str]:
    """The methods that have no time on record, in words."""
    return [m.words for name, m in methods.items() if name not in rows(quantity)]


def seconds(quantity: str, name: str, method: Method) -> list[list[float]]:
    """For each size of the method the lower quartile, the median and the upper quartile of its time; none if unmeasured."""
    kept = rows(quantity).get(name, {"sizes": []})
    known = {size: kept["seconds"][k] for k, size in enumerate(kept["sizes"])}
    return [known.get(size, [float("nan")] * 3) for size in method.sizes]


def told(quantity: str, methods: Mapping[str, Method]) -> str:
    """Where the times come from and which of them no longer hold, for a caption or a paragraph."""
    if quantity not in read():
        return f"No times are on record: `make bench NAME={quantity}` measures them."
    kept = read()[quantity]
    at = kept["machine"]
    where = f"{at['processor']}, {at['threads']} threads, load {at['load']:.1f} when it began"
    told = f"Times: record of commit {kept['commit']}, {where}, {kept['rounds']} rounds."
    if missing := unmeasured(quantity, methods):
        told += f" Not measured yet: {', '.join(missing)} (`make bench NAME={quantity}`)."
    old = stale(quantity, methods)
    return told + (f" **Stale**: the code has changed since for {', '.join(old)}." if old else "")


def summary(quantity: str, methods: Mapping[str, Method]) -> list[str]:
    """The same in four words for a table: commit, load when it began, rounds, and what no longer holds or never did."""
    if quantity not in read():
        return ["", "", "", "not measured"]
    kept, old, missing = read()[quantity], stale(quantity, methods), unmeasured(quantity, methods)
    state = [f"**changed** for {len(old)} of {len(methods)}: {'; '.join(old)}"] if old else []
    state += [f"not measured yet for {'; '.join(missing)}"] if missing else []
    return [kept["commit"], f"{kept['machine']['load']:.1f}", str(kept["rounds"]), "; ".join(state) or "as it was"]


def mark(quantity: str, methods: Mapping[str, Method]) -> str:
    """What a chart says of itself if the code that it timed has changed since."""
    return "stale times" if stale(quantity, methods) else ""


def front(errors: Sequence[float], times: Sequence[float]) -> list[bool]:
    """Which of the points no other beats in both error and time."""
    points = list(zip(errors, times, strict=True))
    return [bool(t == t) and not any(f <= e and s <= t and (f, s) != (e, t) for f, s in points if s == s) for e, t in points]


def fronts(kinds: Sequence[str], errors: Sequence[float], times: Sequence[float]) -> np.ndarray:
    """The same, each point among those of its kind only."""
    best = np.zeros(len(kinds), bool)
    for kind in set(kinds):
        chosen = [k for k, other in enumerate(kinds) if other == kind]
        best[chosen] = front([errors[k] for k in chosen], [times[k] for k in chosen])
    return best
