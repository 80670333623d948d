"""Ways to evaluate the BRDF of GGX."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import microfacet as mf
import numpy as np

from benchmarks.method import ALPHA, LONG, Method, directions, worst

BLOCK = 16384  # values that NumPy takes at once when blocked: its arrays stay in the cache


BRDF = mf.Microfacet(mf.Smith(mf.GGX(*ALPHA)))
BRDF_SIZES = (100, 1000, 10**4, 10**5, 10**6, 4 * 10**6)


def parts(wo: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """D of the half vector, and both Lambdas, as the papers print them."""
    ax, ay = (wo.dtype.type(value) for value in ALPHA)
    half = wo + wi
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    D = 1 / (wo.dtype.type(np.pi) * ax * ay * ((half[:, 0] / ax) ** 2 + (half[:, 1] / ay) ** 2 + half[:, 2] ** 2) ** 2)
    return D, [(np.sqrt(1 + ((ax * w[:, 0]) ** 2 + (ay * w[:, 1]) ** 2) / w[:, 2] ** 2) - 1) / 2 for w in (wo, wi)]


def brdf_numpy(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """In whole arrays, masking and shadowing correlated by height."""
    D, (view, light) = parts(wo, wi)
    return np.asarray(D / (1 + view + light) / (4 * wo[:, 2] * wi[:, 2]))


def brdf_separable(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """With masking and shadowing independent."""
    D, (view, light) = parts(wo, wi)
    return np.asarray(D / ((1 + view) * (1 + light)) / (4 * wo[:, 2] * wi[:, 2]))


def brdf_blocked(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    out = np.empty(len(wo), wo.dtype)
    for k in range(0, len(wo), BLOCK):
        out[k : k + BLOCK] = brdf_numpy(wo[k : k + BLOCK], wi[k : k + BLOCK])
    return out


def brdf_library(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    return np.asarray(BRDF.evaluate(wo, wi))


def _brdf(label: str, method: Callable[..., Any], real: type, code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        wo, wi = directions(size, 1, real), directions(size, 2, real)
        return lambda: method(wo, wi)

    def error(size: int) -> float:
        wo, wi = directions(2000, 3, real), directions(2000, 4, real)
        return worst(method(wo, wi), brdf_numpy(wo.astype(LONG), wi.astype(LONG)))

    return Method(label, prepare, error, BRDF_SIZES, code)


def brdf_of_arrays(size: int, real: type) -> mf.Microfacet:
    """The same with a roughness for each value, as from a texture."""
    return mf.Microfacet(mf.Smith(mf.GGX(*(np.full(size, value, real) for value in ALPHA))))


def _brdf_of_arrays(label: str, real: type) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        brdf, wo, wi = brdf_of_arrays(size, real), directions(size, 1, real), directions(size, 2, real)
        return lambda: brdf.evaluate(wo, wi)

    def error(size: int) -> float:
        wo, wi = directions(2000, 3, real), directions(2000, 4, real)
        return worst(brdf_of_arrays(2000, real).evaluate(wo, wi), brdf_numpy(wo.astype(LONG), wi.astype(LONG)))

    return Method(label, prepare, error, BRDF_SIZES, (brdf_of_arrays(1, real).evaluation[0],))


METHODS = {
    "plain": _brdf("NumPy, double", brdf_numpy, np.float64, (brdf_numpy, parts)),
    "plain_single": _brdf("NumPy, single", brdf_numpy, np.float32, (brdf_numpy, parts)),
    "blocked": _brdf("NumPy blocked, double", brdf_blocked, np.float64, (brdf_numpy, brdf_blocked, parts)),
    "blocked_single": _brdf("NumPy blocked, single", brdf_blocked, np.float32, (brdf_numpy, brdf_blocked, parts)),
    "library": _brdf("this library, double", brdf_library, np.float64, (BRDF.evaluation[0],)),
    "library_single": _brdf("this library, single", brdf_library, np.float32, (BRDF.evaluation[0],)),
    "arrays": _brdf_of_arrays("array of roughness, double", np.float64),
    "arrays_single": _brdf_of_arrays("array of roughness, single", np.float32),
}
