"""The BRDF of matt facets by another sum: over slopes along x and along y, on panels that get smaller towards every line at
which the integrand changes."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import microfacet as mf
import numpy as np

RATIO, NODES = 3.0, 10  # of the ends of panels beside a line, and nodes of each
CLOSE = 1e-2  # of the least length over which something changes
HARD = 1e5  # from which slope over that of an edge on more digits are taken


def by_lines(model: Any, wo: np.ndarray, wi: np.ndarray) -> float:
    """Under Smith's masking, correlated by height, or in V-cavities, over GGX or Beckmann."""
    cavity, light = isinstance(model, mf.VCavity), isinstance(model.ndf, mf.Beckmann)
    q = np.stack([np.array(model.ndf.slope_scale) * w[:2].astype(np.longdouble) / w[2] for w in (wo, wi)])
    steepest, scale = float(np.abs(q).max()), np.array(model.ndf.slope_scale)
    real = np.longdouble if steepest > HARD else np.float64
    q = q.astype(real)
    reach = 6.5 if light else 1e8 * max(1, min(1, steepest) / float(scale.min()))
    least = CLOSE / max(1, steepest, float(scale.max()))
    steps = least * RATIO ** np.arange(np.ceil(np.log(2 * reach / least) / np.log(RATIO)))
    steps = np.concatenate([-steps[::-1], [0], steps]).astype(real)
    lines = [(*q[0], 1), (*q[1], 1), (0, 1, 0), *([(*q[0], -1), (*q[1], -1), (*(q[0] - q[1]), 0)] if cavity else [])]
    crossings = [(c * e - b * f) / (a * e - b * d) for (a, b, c), (d, e, f) in combinations(lines, 2) if a * e != b * d]
    x, weight = _nodes(np.array([0, *crossings], real), steps, reach)
    total = 0.0
    for some in np.array_split(np.arange(x.size), x.size // 64 + 1):
        across = x.ravel()[some]
        at = np.stack([(c - a * across) / b for a, b, c in lines if b != 0], axis=-1)
        y, along = _nodes(at, steps, reach)
        inner = _integrand(q, scale, across[:, None, None], y, cavity, light) * along
        total += float((inner.sum(axis=(1, 2)) * weight.ravel()[some]).sum())
    G2 = 1.0 if cavity else 1 / (sum(1 / float(model.G1(w, [0, 0, 1])) for w in (wo, wi)) - 1)
    return total * G2 / np.pi


def _nodes(points: np.ndarray, steps: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights (..., m, NODES) of panels that begin at steps from points (..., k)."""
    ends = np.sort(np.clip(points[..., None] + steps, -reach, reach).reshape(*points.shape[:-1], -1), axis=-1)
    x, w = np.polynomial.legendre.leggauss(NODES)
    width = np.diff(ends, axis=-1)[..., None]
    return ends[..., :-1, None] + width * (x + 1).astype(ends.dtype) / 2, width * w.astype(ends.dtype) / 2


def _integrand(q: np.ndarray, scale: np.ndarray, x: np.ndarray, y: np.ndarray, cavity: bool, light: bool) -> np.ndarray:
    shown, shone = (np.maximum(1 - x * a - y * b, 0) for a, b in q)
    square = x * x + y * y
    facets = np.exp(-square) / np.pi if light else 1 / (np.pi * (1 + square) ** 2)
    value = facets * shown * shone / np.sqrt(1 + (scale[0] * x) ** 2 + (scale[1] * y) ** 2)
    return value / np.maximum(1, np.maximum(shown, shone) / 2) if cavity else value
