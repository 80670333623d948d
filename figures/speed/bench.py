"""Times every method of figures/speed/rivals.py, in turns, and puts the medians on record. Nothing else writes that record.

    python figures/speed/bench.py                  all quantities
    python figures/speed/bench.py sampling         only that one
    python figures/speed/bench.py --rounds 3 --largest 1000 --record try.json     quickly, into another file

In a round each method runs once, so that whatever else the machine does meets all of them alike. A machine with other work
to do gives worthless times: the load is recorded with them.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.metadata
import importlib.util
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import rivals
from microfacet.processors import threads

ROUNDS = 15
LEAST = 3e-3  # seconds: a shorter call is repeated until it lasts so long, or it would be timed with cold caches
OPTIONAL = ("jax", "mitsuba")  # rivals that are named whether they are installed or not
VERSIONS = ("numpy", "numba", "scipy", "llvmlite")
RECORD = "records/benchmarks.json"

CPP = """
#include <cmath>
extern "C" void brdf(long begin, long end, const double* o, const double* i, double ax, double ay, double* out) {
    for (long k = begin; k < end; k++) {
        const double *p = o + 3 * k, *q = i + 3 * k;
        double x = p[0] + q[0], y = p[1] + q[1], z = p[2] + q[2], s = x * x + y * y + z * z;
        double a = x / ax, b = y / ay, t = a * a + b * b + z * z;
        double ro = std::sqrt(ax * p[0] * ax * p[0] + ay * p[1] * ay * p[1] + p[2] * p[2]);
        double ri = std::sqrt(ax * q[0] * ax * q[0] + ay * q[1] * ay * q[1] + q[2] * q[2]);
        double value = s * s / (6.283185307179586 * ax * ay * t * t * (p[2] * ri + q[2] * ro));
        out[k] = p[2] > 0 && q[2] > 0 && s > 0 ? value : 0;
    }
}
"""
FLAGS = {
    "cpp": ("C++ -O3 -march=native, double", ()),
    "cpp_no_errno": ("the same with -fno-math-errno", ("-fno-math-errno",)),
}


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
    said = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return said.stdout.strip() or "unknown"


# --- C++ --------------------------------------------------------------------------------------------------------------------


def compiled(folder: str, name: str, flags: tuple[str, ...]) -> Any:
    source, library = Path(folder) / "brdf.cpp", Path(folder) / f"{name}.so"
    source.write_text(CPP)
    subprocess.run(["g++", "-O3", "-march=native", "-shared", "-fPIC", *flags, source, "-o", library], check=True)
    return ctypes.CDLL(str(library)).brdf


def yardstick(function: Any) -> Callable[[int], Callable[[], Any]]:
    """A loop in C++ over the same arrays, in as many threads as the library uses."""
    from concurrent.futures import ThreadPoolExecutor

    pool, count = ThreadPoolExecutor(threads()), threads()

    def prepare(size: int) -> Callable[[], Any]:
        wo, wi, out = rivals.directions(size, 1), rivals.directions(size, 2), np.empty(size)
        arrays = [ctypes.c_void_p(a.ctypes.data) for a in (wo, wi)]
        ends = [(k * size // count, (k + 1) * size // count) for k in range(count)] if size > 32768 else [(0, size)]

        def part(begin: int, end: int) -> None:
            scales = [ctypes.c_double(value) for value in rivals.ALPHA]
            function(ctypes.c_long(begin), ctypes.c_long(end), *arrays, *scales, ctypes.c_void_p(out.ctypes.data))

        def call() -> Any:
            if len(ends) == 1:
                return part(*ends[0])
            return [done.result() for done in [pool.submit(part, *pair) for pair in ends]], wo, wi

        return call

    return prepare


# --- timing -----------------------------------------------------------------------------------------------------------------


def jobs(quantity: str, folder: str, largest: int) -> Iterator[tuple[str, int, Callable[[], Any]]]:
    """Name, size and call of everything that is timed for a quantity."""
    for name, method in rivals.QUANTITIES[quantity].items():
        for size in sorted({min(size, largest) for size in method.sizes}) if method.each else method.sizes:
            yield name, size, method.prepare(size)
    if quantity == "brdf" and shutil.which("g++"):
        sizes = next(iter(rivals.BRDFS.values())).sizes
        for name, (_, flags) in FLAGS.items():
            prepare = yardstick(compiled(folder, name, flags))
            yield from ((name, size, prepare(size)) for size in sizes if size <= largest)


def measured(calls: list[tuple[str, int, Callable[[], Any]]], rounds: int) -> dict[str, dict[str, Any]]:
    """Quartiles of the seconds that each call takes, over rounds in which each runs once."""
    repeats = [repeats_of(call) for _, _, call in calls]
    times: list[list[float]] = [[] for _ in calls]
    for _ in range(rounds):
        for (_, _, call), count, kept in zip(calls, repeats, times, strict=True):
            kept.append(duration(call, count))
    rows: dict[str, dict[str, Any]] = {}
    for (name, size, _), kept in zip(calls, times, strict=True):
        row = rows.setdefault(name, {"sizes": [], "seconds": []})
        row["sizes"].append(size)
        row["seconds"].append([float(f"{value:.4g}") for value in np.percentile(kept, (25, 50, 75))])
    return rows


def duration(call: Callable[[], Any], count: int) -> float:
    begin = time.perf_counter()
    for _ in range(count):
        call()
    return (time.perf_counter() - begin) / count


def repeats_of(call: Callable[[], Any]) -> int:
    """How often a call is repeated to last long enough to be timed; the first call, which may compile, does not count."""
    call()
    return max(1, round(LEAST / max(duration(call, 1), 1e-7)))


def quantity(name: str, rounds: int, largest: int) -> dict[str, Any]:
    kept = {"commit": commit(), "machine": machine(), "rounds": rounds}
    with tempfile.TemporaryDirectory() as folder:
        rows = measured(list(jobs(name, folder, largest)), rounds)
    for key, row in rows.items():
        method = rivals.QUANTITIES[name].get(key)
        row["words"] = method.words if method else FLAGS[key][0]
        row["fingerprint"] = method.fingerprint if method else ""
    if name in ("brdf", "sampling"):
        kept["rivals"] = {rival: installed(rival) for rival in OPTIONAL}
    return {**kept, "rows": rows}


def installed(rival: str) -> str:
    return f"installed ({importlib.metadata.version(rival)}), not timed" if importlib.util.find_spec(rival) else "not installed"


def main() -> None:
    ask = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    ask.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(rivals.QUANTITIES)}; all if none is named")
    ask.add_argument("--rounds", type=int, default=ROUNDS)
    ask.add_argument("--largest", type=int, default=10**8, help="size above which arrays are not timed")
    ask.add_argument("--record", type=Path, default=Path(RECORD))
    asked = ask.parse_args()
    if unknown := [name for name in asked.names if name not in rivals.QUANTITIES]:
        sys.exit(f"No benchmark {', '.join(unknown)}; there are {', '.join(rivals.QUANTITIES)}.")
    for name in asked.names or rivals.QUANTITIES:
        found = quantity(name, asked.rounds, asked.largest)
        kept = json.loads(asked.record.read_text("utf-8")) if asked.record.exists() else {}
        asked.record.parent.mkdir(parents=True, exist_ok=True)
        asked.record.write_text(json.dumps({**kept, name: found}, indent=1, sort_keys=True) + "\n", "utf-8")
        print(f"{name}: {len(found['rows'])} methods, load {found['machine']['load']:.1f} before", flush=True)


if __name__ == "__main__":
    main()
