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
    """Every quantity measured so far, by name; empty without a record. A torn or foreign file ends the program."""
    path = path or RECORD
    if not path.exists():
        return {}
    try:
        record = json.loads(path.read_text("utf-8"))
        for entry in record.values():
            require_fields(entry)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        sys.exit(f"{path} is torn or no record of benchmarks: `git checkout {path}` brings it back.")
    return dict(record)


def require_fields(entry: Mapping[str, Any]) -> None:
    """An exception if a quantity's record lacks a required field."""
    if not (
        {"commit", "machine", "rounds", "rows"} <= entry.keys() and {"processor", "threads", "load"} <= entry["machine"].keys()
    ):
        raise ValueError("where and when it was timed is missing")
    for row in entry["rows"].values():
        if not ({"words", "fingerprint"} <= row.keys() and np.shape(row["seconds"]) == (len(row["sizes"]), 3)):
            raise ValueError("times are missing")


def rows(quantity: str) -> dict[str, dict[str, Any]]:
    return dict(read().get(quantity, {}).get("rows", {}))


def stale(quantity: str, methods: Mapping[str, Method]) -> list[str]:
    """Labels of the methods whose code has changed since they were timed."""
    entry = rows(quantity)
    return [m.label for name, m in methods.items() if name in entry and entry[name]["fingerprint"] != m.fingerprint]


def unmeasured(quantity: str, methods: Mapping[str, Method]) -> list[str]:
    """Labels of the methods that have no time on record."""
    return [m.label for name, m in methods.items() if name not in rows(quantity)]


def seconds(quantity: str, name: str, method: Method) -> list[list[float]]:
    """For each size of the method the lower quartile, the median and the upper quartile of its time; none if unmeasured."""
    entry = rows(quantity).get(name, {"sizes": []})
    known = {size: entry["seconds"][k] for k, size in enumerate(entry["sizes"])}
    return [known.get(size, [float("nan")] * 3) for size in method.sizes]


def note(quantity: str, methods: Mapping[str, Method]) -> str:
    """The source of the times, and the methods whose times are stale, for a caption or a paragraph."""
    if quantity not in read():
        return f"No times are on record: `make bench NAME={quantity}` measures them."
    entry = read()[quantity]
    at = entry["machine"]
    where = f"{at['processor']}, {at['threads']} threads, load {at['load']:.1f} when it began"
    text = f"Times: record of commit {entry['commit']}, {where}, {entry['rounds']} rounds."
    if missing := unmeasured(quantity, methods):
        text += f" Not measured yet: {', '.join(missing)} (`make bench NAME={quantity}`)."
    old = stale(quantity, methods)
    return text + (f" **Stale**: the code has changed since for {', '.join(old)}." if old else "")


def summary(quantity: str, methods: Mapping[str, Method]) -> list[str]:
    """The same as four cells of a table: commit, load at the start, rounds, and stale or missing methods."""
    if quantity not in read():
        return ["", "", "", "not measured"]
    entry, old, missing = read()[quantity], stale(quantity, methods), unmeasured(quantity, methods)
    state = [f"**changed** for {len(old)} of {len(methods)}: {'; '.join(old)}"] if old else []
    state += [f"not measured yet for {'; '.join(missing)}"] if missing else []
    return [entry["commit"], f"{entry['machine']['load']:.1f}", str(entry["rounds"]), "; ".join(state) or "as it was"]


def mark(quantity: str, methods: Mapping[str, Method]) -> str:
    """The remark on a chart if the code that it timed has changed since."""
    return "stale times" if stale(quantity, methods) else ""


def front(errors: Sequence[float], times: Sequence[float]) -> list[bool]:
    """The Pareto front: the points that no other beats in both error and time."""
    points = list(zip(errors, times, strict=True))
    return [bool(t == t) and not any(f <= e and s <= t and (f, s) != (e, t) for f, s in points if s == s) for e, t in points]


def fronts(kinds: Sequence[str], errors: Sequence[float], times: Sequence[float]) -> np.ndarray:
    """The same, each point among those of its kind only."""
    best = np.zeros(len(kinds), bool)
    for kind in set(kinds):
        chosen = [k for k, other in enumerate(kinds) if other == kind]
        best[chosen] = front([errors[k] for k in chosen], [times[k] for k in chosen])
    return best
