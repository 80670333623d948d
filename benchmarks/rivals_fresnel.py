"""Ways to have the reflectance of glass."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import microfacet as mf
import numpy as np
from microfacet.compiler.batch import Batch

from benchmarks.method import LONG, Method, worst

GLASS = 1.5
EXACT, FITTED = mf.Dielectric(GLASS), mf.Schlick(((GLASS - 1) / (GLASS + 1)) ** 2)
FRESNEL_SIZES = (10**6,)


def fresnel_numpy(c: np.ndarray) -> np.ndarray:
    g = np.sqrt(c.dtype.type(GLASS) ** 2 - 1 + c * c)
    return np.asarray(((g - c) / (g + c)) ** 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2) / 2)


def fresnel_exact(c: np.ndarray) -> np.ndarray:
    return np.asarray(EXACT.F(c))


def fresnel_schlick(c: np.ndarray) -> np.ndarray:
    return np.asarray(FITTED.F(c))


def _fresnel(label: str, method: Callable[..., Any], real: type, code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        c = np.linspace(0, 1, size).astype(real)
        return lambda: method(c)

    def error(size: int) -> float:
        c = np.linspace(0, 1, 5001).astype(real)
        return worst(method(c), fresnel_numpy(c.astype(LONG)))

    return Method(label, prepare, error, FRESNEL_SIZES, code)


def _loop_of_fresnel(kind: type) -> Batch:
    from microfacet.material.fresnel import _over_cosines

    return _over_cosines(kind.kernel)  # type: ignore[attr-defined]


METHODS = {
    "plain": _fresnel("exact, NumPy, double", fresnel_numpy, np.float64, (fresnel_numpy,)),
    "library": _fresnel("exact, this library, double", fresnel_exact, np.float64, (_loop_of_fresnel(mf.Dielectric),)),
    "library_single": _fresnel("exact, this library, single", fresnel_exact, np.float32, (_loop_of_fresnel(mf.Dielectric),)),
    "schlick": _fresnel("Schlick, this library, double", fresnel_schlick, np.float64, (_loop_of_fresnel(mf.Schlick),)),
    "schlick_single": _fresnel("Schlick, this library, single", fresnel_schlick, np.float32, (_loop_of_fresnel(mf.Schlick),)),
}
