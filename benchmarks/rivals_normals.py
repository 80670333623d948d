"""Ways to evaluate the distribution of normals of GGX."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import microfacet as mf
import numpy as np
from microfacet.geometry import slopes

from benchmarks.method import ALPHA, LONG, Method, directions, worst

BLOCK = 16384  # values that NumPy takes at once when blocked: its arrays stay in the cache
NDF = mf.GGX(*ALPHA)
PI = LONG("3.14159265358979323846264338327950288")


def normals_numpy(wm: np.ndarray) -> np.ndarray:
    """In whole arrays."""
    real, (ax, ay) = wm.dtype.type, (wm.dtype.type(value) for value in ALPHA)
    return np.asarray(1 / (real(PI) * ax * ay * ((wm[:, 0] / ax) ** 2 + (wm[:, 1] / ay) ** 2 + wm[:, 2] ** 2) ** 2))


def normals_blocked(wm: np.ndarray) -> np.ndarray:
    out = np.empty(len(wm), wm.dtype)
    for k in range(0, len(wm), BLOCK):
        out[k : k + BLOCK] = normals_numpy(wm[k : k + BLOCK])
    return out


def normals_library(wm: np.ndarray) -> np.ndarray:
    return np.asarray(NDF.D(wm))


def _normals(label: str, method: Callable[..., Any], real: type, code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        wm = directions(size, 1, real)
        return lambda: method(wm)

    def error(size: int) -> float:
        wm = directions(2000, 3, real)
        return worst(method(wm), normals_numpy(wm.astype(LONG)))

    return Method(label, prepare, error, (4 * 10**6,), code)


LOOP = (slopes._over_normals(type(NDF).kernel),)
METHODS = {
    "plain": _normals("NumPy, double", normals_numpy, np.float64, (normals_numpy,)),
    "plain_single": _normals("NumPy, single", normals_numpy, np.float32, (normals_numpy,)),
    "blocked": _normals("NumPy blocked, double", normals_blocked, np.float64, (normals_numpy, normals_blocked)),
    "blocked_single": _normals("NumPy blocked, single", normals_blocked, np.float32, (normals_numpy, normals_blocked)),
    "library": _normals("this library, double", normals_library, np.float64, LOOP),
    "library_single": _normals("this library, single", normals_library, np.float32, LOOP),
}
