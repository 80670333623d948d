"""Time every method of benchmarks/rivals.py in interleaved rounds, and record the medians. Nothing else writes that record.

    python -m benchmarks.bench                  all quantities
    python -m benchmarks.bench sampling         only that one
    python -m benchmarks.bench --rounds 3 --largest 1000 --record try.json     quickly, into another file

In a round each method runs once, so that other load on the machine affects all of them alike. A loaded machine gives
worthless times: the load is recorded with them.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from microfacet.compiler.processors import threads
from report.datafile import put, refuse

from benchmarks import record, rivals, yardsticks

ROUNDS = 15
LEAST = 3e-3  # seconds: a shorter call is repeated for at least this long, or it would be timed with cold caches
MOST = 4.0  # seconds that all rounds of one call may last; but at least three are run
GAP = 0.1  # seconds after a guest, whose threads go on spinning for a while
VERSIONS = ("numpy", "numba", "scipy", "llvmlite")
RECORD = "records/benchmarks.json"


def machine() -> dict[str, Any]:
    return {
        "processor": processor(),
        "threads": threads(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        **{name: importlib.metadata.version(name) for name in VERSIONS},
    }


def processor() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def commit() -> str:
    """The commit of the code; changes of the records do not count."""
    return (_git("describe", "--always") or "unknown") + ("-dirty" if _git("status", "--porcelain", "--", ":!records") else "")


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], capture_output=True, text=True, check=False).stdout.strip()


# --- timing -----------------------------------------------------------------------------------------------------------------


def jobs(quantity: str, largest: int) -> list[yardsticks.Job]:
    """Name, size and call of everything that is timed for a quantity, except what does not fit into memory."""
    calls = []
    for name, method in rivals.QUANTITIES[quantity].items():
        for size in sorted({min(size, largest) for size in method.sizes}) if method.each else method.sizes:
            try:
                calls.append((name, size, method.prepare(size)))
            except MemoryError as why:
                print(f"{quantity}: {method.label}, size {size} is left out: {why}", flush=True)
    return calls


def measured(calls: list[yardsticks.Job], rounds: int) -> dict[str, dict[str, Any]]:
    """Quartiles of the seconds that each call takes, over rounds in which each runs once; a slow call skips some rounds."""
    plans = [plan_of(call, rounds) for _, _, call in calls]
    times: list[list[float]] = [[] for _ in calls]
    for round_ in range(rounds):
        for (name, _, call), (count, most), durations in zip(calls, plans, times, strict=True):
            if round_ < most:
                durations.append(duration(call, count))
                time.sleep(GAP if any(name in guests for guests in yardsticks.GUESTS.values()) else 0)
    rows: dict[str, dict[str, Any]] = {}
    for (name, size, _), durations in zip(calls, times, strict=True):
        row = rows.setdefault(name, {"sizes": [], "seconds": []})
        row["sizes"].append(size)
        row["seconds"].append([float(f"{value:.4g}") for value in np.percentile(durations, (25, 50, 75))])
    return rows


def duration(call: Callable[[], Any], count: int) -> float:
    begin = time.perf_counter()
    for _ in range(count):
        call()
    return (time.perf_counter() - begin) / count


def plan_of(call: Callable[[], Any], rounds: int) -> tuple[int, int]:
    """Repetitions of a call in a round, and the number of rounds; the first call, which may compile, does not count."""
    call()
    once = max(duration(call, 1), 1e-7)
    return max(1, round(LEAST / once)), min(rounds, max(3, int(MOST / once)))


def quantity(name: str, where: dict[str, Any], rounds: int, largest: int) -> dict[str, Any]:
    """The record of one quantity."""
    entry: dict[str, Any] = {**where, "rounds": rounds}
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stay:
        calls, errors = jobs(name, largest), {}
        if name in yardsticks.GUESTS:
            sizes = sorted({min(size, largest) for size in next(iter(rivals.QUANTITIES[name].values())).sizes})
            guests, entry["rivals"], errors = yardsticks.guest_jobs(name, folder, largest, stay)
            calls += [*yardsticks.cpp_jobs(folder, name, tuple(sizes)), *guests]
        rows = measured(calls, rounds)
    for key, row in rows.items():
        method = rivals.QUANTITIES[name].get(key)
        row["words"] = method.label if method else yardsticks.known(name)[key]
        row["fingerprint"] = method.fingerprint if method else ""
        row |= {"error": errors[key], "version": yardsticks.version(name, key)} if key in errors else {}
    return {**entry, "rows": rows}


def main() -> None:
    ask = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    ask.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(rivals.QUANTITIES)}; all if none is named")
    ask.add_argument("--rounds", type=int, default=ROUNDS)
    ask.add_argument("--largest", type=int, default=10**8, help="size above which arrays are not timed")
    ask.add_argument("--record", type=Path, default=Path(RECORD))
    asked = ask.parse_args()
    if unknown := [name for name in asked.names if name not in rivals.QUANTITIES]:
        sys.exit(f"No benchmark {', '.join(unknown)}; there are {', '.join(rivals.QUANTITIES)}.")
    refuse(asked.record)
    record.read(asked.record)
    where = {"commit": commit(), "machine": machine()}  # before the first: afterwards the load would be our own
    print(f"load {where['machine']['load']:.1f} before", flush=True)
    for name in asked.names or rivals.QUANTITIES:
        begin, result = time.perf_counter(), quantity(name, where, asked.rounds, asked.largest)
        recorded = record.read(asked.record)
        put(asked.record, json.dumps({**recorded, name: result}, indent=1, sort_keys=True) + "\n")
        print(f"{name}: {len(result['rows'])} methods in {time.perf_counter() - begin:.0f} s", flush=True)


if __name__ == "__main__":
    main()
