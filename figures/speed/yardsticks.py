"""What the BRDF is compared with from outside Python: a loop in C++, and guests that are timed if they are installed.

A guest (jax, Mitsuba) runs in a process of its own, guest.py, so that its threads and its faults stay there. Both are in the
optional extra `bench`. One that is absent, or cannot start, has a sentence on record in place of times, and nothing fails.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from method import ALPHA, directions, worst
from microfacet.processors import threads
from rivals_brdf import brdf_numpy, brdf_separable

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
GUESTS = {  # name on record -> words, package, precision
    "jax": ("jax, double", "jax", np.float64),
    "jax_single": ("jax, single", "jax", np.float32),
    "mitsuba": ("Mitsuba's llvm variant, single, masking and shadowing independent", "mitsuba", np.float32),
}
SIZES = (10**6, 4 * 10**6)  # of guests: what starts a call from another process must not count
START = 120  # seconds after which a guest that has said nothing is sent away

Job = tuple[str, int, Callable[[], Any]]


# --- C++ --------------------------------------------------------------------------------------------------------------------


def compiled(folder: str, name: str, flags: tuple[str, ...]) -> Any:
    source, library = Path(folder) / "brdf.cpp", Path(folder) / f"{name}.so"
    source.write_text(CPP)
    subprocess.run(["g++", "-O3", "-march=native", "-shared", "-fPIC", *flags, source, "-o", library], check=True)
    return ctypes.CDLL(str(library)).brdf


def in_cpp(function: Any, size: int) -> Callable[[], Any]:
    """A loop in C++ over the same arrays, in as many threads as the library uses."""
    count = threads()
    pool, wo, wi, out = ThreadPoolExecutor(count), directions(size, 1), directions(size, 2), np.empty(size)
    arrays = [ctypes.c_void_p(a.ctypes.data) for a in (wo, wi)]
    scales = [ctypes.c_double(value) for value in ALPHA]
    ends = [(k * size // count, (k + 1) * size // count) for k in range(count)] if size > 32768 else [(0, size)]

    def part(begin: int, end: int) -> None:
        function(ctypes.c_long(begin), ctypes.c_long(end), *arrays, *scales, ctypes.c_void_p(out.ctypes.data))

    def call() -> Any:
        if len(ends) == 1:
            return part(*ends[0])
        return [done.result() for done in [pool.submit(part, *pair) for pair in ends]], wo, wi

    return call


def cpp_jobs(folder: str, sizes: tuple[int, ...]) -> list[Job]:
    """None without a compiler."""
    if not shutil.which("g++"):
        return []
    loops = {name: compiled(folder, name, flags) for name, (_, flags) in FLAGS.items()}
    return [(name, size, in_cpp(loop, size)) for name, loop in loops.items() for size in sizes]


# --- guests -----------------------------------------------------------------------------------------------------------------


class Refused(Exception):
    """A guest that cannot be timed, and why, in words."""


class Guest:
    """A process that evaluates arrays kept in a folder whenever it is told to."""

    def __init__(self, name: str, folder: str, size: int) -> None:
        _, self.package, real = GUESTS[name]
        if importlib.util.find_spec(self.package) is None:
            raise Refused("not installed")
        here, self.files = Path(__file__).parent, Path(folder) / f"{name}_{size}"
        self.files.mkdir()
        for file, seed in (("wo", 1), ("wi", 2)):
            np.save(self.files / f"{file}.npy", directions(size, seed, real))
        command = [sys.executable, str(here / "guest.py"), self.package, str(self.files), *map(str, ALPHA)]
        pipe = subprocess.PIPE
        with (self.files / "said").open("w") as said:
            self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=said, text=True)
        self.call()

    def call(self) -> None:
        """Evaluate once more; Refused if the process has ended."""
        assert self.process.stdin
        assert self.process.stdout
        try:
            self.process.stdin.write("once\n")
            self.process.stdin.flush()
            answer = self.process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if answer != "done\n":
            code = self.process.wait(START)
            lines = [line.strip() for line in (self.files / "said").read_text().splitlines() if line.strip()]
            errors = [line for line in lines if "error" in line.lower()] or lines or ["it did not say why"]
            raise Refused(f"installed, but it ended with status {code}: {errors[-1][:100]}")

    def error(self) -> float:
        """Largest relative error of what it found, over the first few values."""
        arrays = [np.load(self.files / f"{file}.npy")[:2000] for file in ("wo", "wi", "found")]
        wo, wi, found = (array.astype(np.longdouble) for array in arrays)
        exact = brdf_separable if self.package == "mitsuba" else brdf_numpy
        return worst(found, exact(wo, wi))


def guest_jobs(folder: str, largest: int) -> tuple[list[Job], dict[str, str], dict[str, float]]:
    """The calls of the guests that are there, why the others are not, and the errors of those that are."""
    jobs: list[Job] = []
    refused: dict[str, str] = {}
    errors: dict[str, float] = {}
    for name in GUESTS:
        try:
            for size in sorted({min(size, largest) for size in SIZES}):
                guest = Guest(name, folder, size)
                jobs.append((name, size, guest.call))
                errors[name] = float(f"{guest.error():.2g}")
        except Refused as why:
            refused[name] = str(why)
    return jobs, refused, errors


def words(name: str) -> str:
    return FLAGS[name][0] if name in FLAGS else GUESTS[name][0]


def version(name: str) -> str:
    return importlib.metadata.version(GUESTS[name][1])
