"""Two models compared with measured surfaces, as the rows of a table: which is nearer."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def contest(measured: Mapping[str, Array], one: str, other: str, least: float = 0.0) -> list[list[str]]:
    """Rows of a table: how far two models are off in albedo and in shape for each roughness and view, and which is nearer.

    measured: the arrays of the figure `measured_distances`. least: the smallest polar angle of the view, degrees. Neither is
    nearer where the difference is below two standard errors.
    """
    names = list(measured["names"][0])
    a, b = names.index(one), names.index(other)
    short = one.split(",")[0], other.split(",")[0]
    rows = []
    for k, v in np.ndindex(measured["noise"].shape):
        if measured["theta_o"][v] < least:
            continue
        albedo, error = measured["albedo"][k, v]
        off = measured["model_albedo"][k, v] - albedo
        shape, errors = np.moveaxis(measured["distance"][k, v], -1, 0)
        nearer_albedo = _nearer(*short, abs(off[b]) - abs(off[a]), 2 * error if off[a] * off[b] < 0 else 0.0)
        nearer_shape = _nearer(*short, shape[b] - shape[a], math.hypot(errors[a], errors[b]))
        here = [f"{measured['alpha'][k]:.1f}", f"{measured['theta_o'][v]:.0f}°", f"{albedo:.4f} ± {error:.4f}"]
        rows.append(
            [*here, f"{off[a]:+.4f}", f"{off[b]:+.4f}", nearer_albedo, f"{shape[a]:.3f}", f"{shape[b]:.3f}", nearer_shape]
        )
    return rows


def _nearer(one: str, other: str, lead: float, error: float) -> str:
    """The nearer model, from the lead of the first; neither if that is within two standard errors."""
    return "–" if abs(lead) <= 2 * error else one if lead > 0 else other
