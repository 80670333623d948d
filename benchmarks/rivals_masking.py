"""Ways to have Lambda of Beckmann, and with it the masking function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from microfacet.compiler.batch import Batch
from microfacet.geometry.beckmann import Lambda as LAMBDA
from scipy import special

from benchmarks.method import LONG, Method, worst

A = np.geomspace(0.01, 5, 400)
LAMBDA_SIZES = (10**6,)


def lambda_erfc(a: np.ndarray) -> np.ndarray:
    return -0.5 * special.erfc(a) + np.exp(-a * a) / (2 * np.sqrt(np.pi) * a)


def lambda_erfcx(a: np.ndarray) -> np.ndarray:
    return np.exp(-a * a) * (1 / (2 * np.sqrt(np.pi) * a) - 0.5 * special.erfcx(a))


def walter(a: float, p: tuple[()]) -> float:
    return (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a) if a < 1.6 else 0.0


WALTER = Batch(walter, [1])  # compiled as the library's own is


def lambda_walter(a: np.ndarray) -> np.ndarray:
    return np.asarray(WALTER([a]))


def lambda_library(a: np.ndarray) -> np.ndarray:
    return np.asarray(LAMBDA.kernel(a))


def _masking_error(method: Callable[..., Any], real: type) -> float:
    """Of G1 = 1/(1 + Lambda), which is what a renderer uses."""
    a = A.astype(real)
    exact = np.array([float(LAMBDA.exact(float(v))) for v in a], LONG)
    return worst(1 / (1 + np.asarray(method(a), LONG)), 1 / (1 + exact))


def _lambda(label: str, method: Callable[..., Any], real: type, code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        a = np.geomspace(0.01, 5, size).astype(real)
        return lambda: method(a)

    return Method(label, prepare, lambda size: _masking_error(method, real), LAMBDA_SIZES, code)


METHODS = {
    "erfc": _lambda("SciPy's erfc, double", lambda_erfc, np.float64, (lambda_erfc,)),
    "erfc_single": _lambda("SciPy's erfc, single", lambda_erfc, np.float32, (lambda_erfc,)),
    "erfcx": _lambda("SciPy's erfcx, double", lambda_erfcx, np.float64, (lambda_erfcx,)),
    "erfcx_single": _lambda("SciPy's erfcx, single", lambda_erfcx, np.float32, (lambda_erfcx,)),
    "walter": _lambda("Walter's fit, double", lambda_walter, np.float64, (WALTER,)),
    "walter_single": _lambda("Walter's fit, single", lambda_walter, np.float32, (WALTER,)),
    "library": _lambda("this library, double", lambda_library, np.float64, (LAMBDA._batch,)),
    "library_single": _lambda("this library, single", lambda_library, np.float32, (LAMBDA._batch,)),
}
