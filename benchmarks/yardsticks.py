"""What the BRDF, samples of it and rays are compared with from outside: loops in C++, and guests, timed if installed.

A guest (jax, Mitsuba, Embree) runs in a process of its own, guest.py, so that its threads and its faults stay there. All are
in the optional extra `bench`. A guest that is absent or cannot start has a sentence on record in place of times.
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
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from microfacet.compiler.processors import threads

from benchmarks.method import ALPHA, directions, uniform, worst
from benchmarks.rivals_brdf import brdf_numpy, brdf_separable
from benchmarks.rivals_rays import RAYS, TASKS, rays
from benchmarks.rivals_sampling import misplaced

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
extern "C" void sampling(long begin, long end, const double* o, const double* u, double ax, double ay, double* out) {
    for (long k = begin; k < end; k++) {
        double x = ax * o[3 * k], y = ay * o[3 * k + 1], z = o[3 * k + 2], turn = 6.283185307179586 * u[2 * k];
        double length = std::sqrt(x * x + y * y + z * z);
        x /= length, y /= length, z /= length;
        double rise = 1 + z, above = (1 - u[2 * k + 1]) * rise;
        double radius = std::sqrt((above + (x * x + y * y) / rise) * u[2 * k + 1] * rise);
        double mx = ax * (radius * std::cos(turn) + x), my = ay * (radius * std::sin(turn) + y);
        double scale = 1 / std::sqrt(mx * mx + my * my + above * above);
        out[3 * k] = scale * mx, out[3 * k + 1] = scale * my, out[3 * k + 2] = scale * above;
    }
}
"""
FLAGS = {
    "cpp": ("C++ -O3 -march=native, double", ()),
    "cpp_no_errno": ("the same with -fno-math-errno", ("-fno-math-errno",)),
}
LOOPS = ("brdf", "sampling")
SIZES = (10**6, 4 * 10**6)  # of arrays for guests: what starts a call from another process must not count


class Entry(NamedTuple):
    """A guest: words, the package it is in, the precision of its arrays, what it does there, and with how many values."""

    label: str
    package: str
    real: type
    task: str
    sizes: tuple[int, ...] = SIZES


GUESTS = {  # quantity -> name on record -> guest
    "brdf": {
        "jax": Entry("jax, double", "jax", np.float64, "brdf"),
        "jax_single": Entry("jax, single", "jax", np.float32, "brdf"),
        "mitsuba": Entry("Mitsuba's llvm variant, single, masking and shadowing independent", "mitsuba", np.float32, "brdf"),
    },
    "sampling": {
        "mitsuba_ggx": Entry("GGX, Mitsuba's llvm variant, single", "mitsuba", np.float32, "ggx"),
        "mitsuba_beckmann": Entry("Beckmann, Mitsuba's llvm variant, single", "mitsuba", np.float32, "beckmann"),
    },
    "rays": {
        f"embree_{task}": Entry(f"rays {words}, Embree", "embreex", np.float32, task, RAYS) for task, words in TASKS.items()
    },
}
START = 120  # seconds after which a silent guest is ended

Job = tuple[str, int, Callable[[], Any]]


# --- C++ --------------------------------------------------------------------------------------------------------------------


def compiled(folder: str, name: str, flags: tuple[str, ...], quantity: str) -> Any:
    source, library = Path(folder) / "loops.cpp", Path(folder) / f"{name}.so"
    source.write_text(CPP)
    subprocess.run(["g++", "-O3", "-march=native", "-shared", "-fPIC", *flags, source, "-o", library], check=True)
    return getattr(ctypes.CDLL(str(library)), quantity)


def arguments(quantity: str, size: int, real: type, task: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Views, and lights or random numbers; or rays: those that the library gets."""
    if quantity == "rays":
        origins, ways, _ = rays(task, size)
        return origins.astype(real), ways.astype(real)
    if quantity == "brdf":
        return directions(size, 1, real), directions(size, 2, real)
    return directions(size, 5, real), uniform(size, 6, real)


def in_cpp(function: Any, quantity: str, size: int) -> Callable[[], Any]:
    """A loop in C++ over the same arrays, in as many threads as the library uses."""
    count = threads()
    wo, other = arguments(quantity, size, np.float64)
    pool, out = ThreadPoolExecutor(count), np.empty(size if quantity == "brdf" else (size, 3))
    arrays = [ctypes.c_void_p(a.ctypes.data) for a in (wo, other)]
    scales = [ctypes.c_double(value) for value in ALPHA]
    ends = [(k * size // count, (k + 1) * size // count) for k in range(count)] if size > 32768 else [(0, size)]

    def part(begin: int, end: int) -> None:
        function(ctypes.c_long(begin), ctypes.c_long(end), *arrays, *scales, ctypes.c_void_p(out.ctypes.data))

    def call() -> Any:
        if len(ends) == 1:
            return part(*ends[0])
        return [done.result() for done in [pool.submit(part, *pair) for pair in ends]], wo, other

    return call


def cpp_jobs(folder: str, quantity: str, sizes: tuple[int, ...]) -> list[Job]:
    """The jobs of the C++ loops; none without a compiler, or for a quantity without a loop."""
    if quantity not in LOOPS or not shutil.which("g++"):
        return []
    loops = {name: compiled(folder, name, flags, quantity) for name, (_, flags) in FLAGS.items()}
    return [(name, size, in_cpp(loop, quantity, size)) for name, loop in loops.items() for size in sizes]


# --- guests -----------------------------------------------------------------------------------------------------------------


class Refused(Exception):
    """A guest that cannot be timed, and the reason."""


class Guest:
    """A process that evaluates arrays from a folder at each call."""

    def __init__(self, quantity: str, name: str, folder: str, size: int) -> None:
        self.entry = GUESTS[quantity][name]
        if importlib.util.find_spec(self.entry.package) is None:
            raise Refused("not installed")
        root, self.files = Path(__file__).parents[1], (Path(folder) / f"{name}_{size}").absolute()
        self.files.mkdir()
        for file, array in zip(("wo", "other"), arguments(quantity, size, self.entry.real, self.entry.task), strict=True):
            np.save(self.files / f"{file}.npy", array)
        what = [self.entry.package, self.entry.task, str(self.files), *map(str, ALPHA)]
        command = [sys.executable, "-m", "benchmarks.guest", *what]
        pipe = subprocess.PIPE
        with (self.files / "said").open("w") as said:
            self.process = subprocess.Popen(command, cwd=root, stdin=pipe, stdout=pipe, stderr=said, text=True)
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

    def leave(self) -> None:
        """End the process and free its memory."""
        assert self.process.stdin
        self.process.stdin.close()
        self.process.wait(START)

    def error(self) -> float | list[float] | None:
        """Largest error of its result, over the first few values: relative, or of Beckmann's normals in probability.

        For rays, the fractions of wrong verdicts, for each offset. None for normals of GGX: there is more than one way to send
        numbers to them.
        """
        if self.entry.package == "embreex":
            return [float(f"{fraction:.4g}") for fraction in np.load(self.files / "found.npy")]
        arrays = [np.load(self.files / f"{file}.npy")[:2000] for file in ("wo", "other", "found")]
        wo, other, found = (array.astype(np.longdouble) for array in arrays)
        if self.entry.task == "ggx":
            return None
        if self.entry.task == "beckmann":
            return misplaced(*(array.astype(float) for array in (wo, other, found)))
        exact = brdf_separable if self.entry.package == "mitsuba" else brdf_numpy
        return worst(found, exact(wo, other))


def guest_jobs(quantity: str, folder: str, largest: int, stay: ExitStack) -> tuple[list[Job], dict[str, str], dict[str, Any]]:
    """Calls of the available guests, reasons for the others, and errors of the available ones; `stay` ends their processes."""
    jobs: list[Job] = []
    refused: dict[str, str] = {}
    errors: dict[str, Any] = {}
    for name, entry in GUESTS.get(quantity, {}).items():
        try:
            for size in sorted({min(size, largest) for size in entry.sizes}):
                guest = Guest(quantity, name, folder, size)
                stay.callback(guest.leave)
                jobs.append((name, size, guest.call))
                error = guest.error()
                errors[name] = float(f"{error:.2g}") if isinstance(error, float) else error
        except Refused as why:
            refused[name] = str(why)
    return jobs, refused, errors


def known(quantity: str) -> dict[str, str]:
    """Everything that a quantity may be compared with: name on record -> label."""
    return {name: label for name, (label, _) in FLAGS.items() if quantity in LOOPS} | {
        name: guest.label for name, guest in GUESTS.get(quantity, {}).items()
    }


def version(quantity: str, name: str) -> str:
    return importlib.metadata.version(GUESTS[quantity][name].package)
