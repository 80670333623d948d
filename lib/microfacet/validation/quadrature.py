"""Integrals over the normals that a direction sees, in slope space, where the edge of visibility is a straight line.

Slopes are turned so that q runs along the view direction: a facet is seen from its front where q < cot theta_o. The line
q = -cot theta_o, where V-cavities begin to mask, is a panel's edge too. Along q and across it tangents stretch the
nodes to the tails, around the ridge of a stretched isotropic distribution.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import atan, cos, pi, sqrt, tan
from typing import Any

import numpy as np

from microfacet.kernels import Batch

COARSE, FINE = 64, 96


def gauss_legendre(count: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Nodes and weights on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(map(float, (nodes + 1) / 2)), tuple(map(float, weights / 2))


NODES, WEIGHTS = (fine + coarse for fine, coarse in zip(gauss_legendre(FINE), gauss_legendre(COARSE), strict=True))


@cache
def seen_integrals(
    view: Callable[..., float], integrand: Callable[..., tuple[float, float, float]]
) -> Callable[..., tuple[float, float, float]]:
    """The kernel of three integrals of integrand(view(o, p), o, m, p) over the normals m with wo.wm > 0.

    low, high: which of `NODES` to take, along and across. Parameters: (p, scale), where p goes to the integrand and scale
    holds the two slope scales.
    """

    def strip(
        low: int,
        high: int,
        known: float,
        ox: float,
        oy: float,
        oz: float,
        c: float,
        s: float,
        start: float,
        stop: float,
        p: Any,
    ) -> tuple[float, float, float]:
        """The part of the integrals between two slopes along the view, given as angles."""
        alpha_x, alpha_y = p[1]
        along = sqrt((c * alpha_x) * (c * alpha_x) + (s * alpha_y) * (s * alpha_y))
        aside = alpha_x * alpha_y / along
        shift = s * c * (alpha_y * alpha_y - alpha_x * alpha_x) / (along * along)
        first, second, third = 0.0, 0.0, 0.0
        for k in range(low, high):
            angle = start + (stop - start) * NODES[k]
            q = along * tan(angle)
            widening = aside / cos(angle)
            for j in range(low, high):
                turn = pi * (NODES[j] - 0.5)
                r = shift * q + widening * tan(turn)
                x, y = c * q - s * r, s * q + c * r
                m = 1.0 / sqrt(1.0 + x * x + y * y)
                stretch = along * widening / ((cos(turn) * cos(turn)) * (cos(angle) * cos(angle)))
                weight = WEIGHTS[k] * WEIGHTS[j] * (m * m * m) * stretch
                f, g, h = integrand(known, ox, oy, oz, -x * m, -y * m, m, p[0])
                first, second, third = first + weight * f, second + weight * g, third + weight * h
        area = (stop - start) * pi
        return first * area, second * area, third * area

    def integrals(low: int, high: int, ox: float, oy: float, oz: float, p: Any) -> tuple[float, float, float]:
        across = sqrt(ox * ox + oy * oy)
        c = ox / across if across > 0.0 else 1.0
        s = oy / across if across > 0.0 else 0.0
        along = sqrt((c * p[1][0]) * (c * p[1][0]) + (s * p[1][1]) * (s * p[1][1]))
        edge = atan(oz / (across * along)) if across > 0.0 else 0.5 * pi
        known = view(ox, oy, oz, p[0])
        f1, g1, h1 = strip(low, high, known, ox, oy, oz, c, s, -0.5 * pi, -edge, p)
        f2, g2, h2 = strip(low, high, known, ox, oy, oz, c, s, -edge, edge, p)
        return f1 + f2, g1 + g2, h1 + h2

    return integrals


@cache
def seen_batch(view: Callable[..., float], integrand: Callable[..., tuple[float, float, float]]) -> Batch:
    """Both rules over arrays of view directions: (..., 3) -> (..., 6), the fine one first."""
    integrals = seen_integrals(view, integrand)

    def both(ox: float, oy: float, oz: float, p: Any) -> tuple[float, float, float, float, float, float]:
        f1, f2, f3 = integrals(0, FINE, ox, oy, oz, p)
        g1, g2, g3 = integrals(FINE, FINE + COARSE, ox, oy, oz, p)
        return f1, f2, f3, g1, g2, g3

    return Batch(both, [3], 6)
