"""The record of benchmarks: what `make bench` measured, where, and whether the code it timed is still the same."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rivals import QUANTITIES, Method

RECORD = Path("records/benchmarks.json")


def read() -> dict[str, Any]:
    """Every quantity measured so far, by name; nothing if there is no record."""
    return dict(json.loads(RECORD.read_text("utf-8"))) if RECORD.exists() else {}


def rows(quantity: str) -> dict[str, dict[str, Any]]:
    return dict(read().get(quantity, {}).get("rows", {}))


def stale(quantity: str) -> list[str]:
    """The methods whose code has changed since they were timed, in words."""
    kept = rows(quantity)
    return [m.words for name, m in QUANTITIES[quantity].items() if name in kept and kept[name]["fingerprint"] != m.fingerprint]


def unmeasured(quantity: str) -> list[str]:
    return [m.words for name, m in QUANTITIES[quantity].items() if name not in rows(quantity)]


def seconds(quantity: str, name: str, method: Method) -> list[list[float]]:
    """For each size of the method the lower quartile, the median and the upper quartile of its time; none if unmeasured."""
    kept = rows(quantity).get(name, {"sizes": []})
    known = {size: kept["seconds"][k] for k, size in enumerate(kept["sizes"])}
    return [known.get(size, [float("nan")] * 3) for size in method.sizes]


def told(quantity: str) -> str:
    """One sentence on where the times come from, for a caption or a paragraph."""
    if quantity not in read():
        return "No times are on record: `make bench` measures them."
    kept = read()[quantity]
    at = kept["machine"]
    where = f"{at['processor']}, {at['threads']} threads, load {at['load']:.1f} when it began"
    told = f"Times: record of commit {kept['commit']}, {where}, {kept['rounds']} rounds."
    old = stale(quantity) + unmeasured(quantity)
    return told + (f" **Stale**: the code has changed since for {', '.join(old)}." if old else "")


def front(errors: list[float], times: list[float]) -> list[bool]:
    """Which of the points no other beats in both error and time."""
    points = list(zip(errors, times, strict=True))
    return [bool(t == t) and not any(f <= e and s <= t and (f, s) != (e, t) for f, s in points if s == s) for e, t in points]
