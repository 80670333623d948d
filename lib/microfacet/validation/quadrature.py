"""Integrals over the normals that a direction sees, in slope space, where the edge of visibility is a straight line.

Slopes are turned so that q runs along the view direction: a facet is seen from its front where q < cot theta_o. The line
q = -cot theta_o, where V-cavities begin to mask, is a panel's edge too. The nodes are
stretched to the tails, around the ridge of a stretched isotropic distribution: by tangents, right for tails that fall as
a power, and by inverse hyperbolic tangents, right for tails that fall exponentially. Both are tried with more and more
nodes until two rules of one kind agree.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import atan, atanh, cos, pi, sqrt, tan, tanh
from typing import Any

import numpy as np

from microfacet.kernels import Batch

LEVELS = (12, 16, 24, 32, 48, 64, 96)  # nodes along and across, rule after rule
AGREED = 1e-13  # relative difference of two rules after which no third is tried


def gauss_legendre(count: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Nodes and weights on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(map(float, (nodes + 1) / 2)), tuple(map(float, weights / 2))


_RULES = [gauss_legendre(count) for count in LEVELS]
NODES, WEIGHTS = (tuple(value for rule in _RULES for value in rule[part]) for part in (0, 1))
STARTS = tuple(float(sum(LEVELS[:k])) for k in range(len(LEVELS) + 1))  # where each rule begins
LIGHT = 3.0  # inverse hyperbolic tangents of nodes are stretched by this: the one best for a Gaussian


def _across(light: bool) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Slopes across, in units of their scale, and their weights."""
    nodes, weights = 2 * np.array(NODES) - 1, 2 * np.array(WEIGHTS)
    if light:
        return tuple(LIGHT * np.arctanh(nodes)), tuple(weights * LIGHT / (1 - nodes**2))
    return tuple(np.tan(np.pi / 2 * nodes)), tuple(weights * np.pi / 2 / np.cos(np.pi / 2 * nodes) ** 2)


ACROSS, PORTIONS = (heavy + light for heavy, light in zip(_across(False), _across(True), strict=True))
TOTAL = sum(LEVELS)


@cache
def seen_integrals(
    view: Callable[..., float], integrand: Callable[..., tuple[float, float, float]]
) -> Callable[..., tuple[float, float, float]]:
    """The kernel of three integrals of integrand(view(o, p), o, m, p) over the normals m with wo.wm > 0.

    low, high: which of `NODES` to take, along and across. light: 1 for tails that fall exponentially, 0 for a power of the
    slope. Parameters: (p, scale), where p goes to the integrand and scale
    holds the two slope scales.
    """

    def strip(
        low: int,
        high: int,
        light: float,
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
        """The part of the integrals between two slopes along the view, given as shares of a quarter turn or as tanh."""
        alpha_x, alpha_y = p[1]
        along = sqrt((c * alpha_x) * (c * alpha_x) + (s * alpha_y) * (s * alpha_y))
        aside = alpha_x * alpha_y / along
        shift = s * c * (alpha_y * alpha_y - alpha_x * alpha_x) / (along * along)
        offset = TOTAL if light > 0.5 else 0
        first, second, third = 0.0, 0.0, 0.0
        for k in range(low, high):
            share = start + (stop - start) * NODES[k]
            if light > 0.5:
                q = along * LIGHT * atanh(share)
                widening = aside
                stretch = along * LIGHT / (1.0 - share * share)
            else:
                angle = 0.5 * pi * share
                q = along * tan(angle)
                widening = aside / cos(angle)
                stretch = along * 0.5 * pi / (cos(angle) * cos(angle))
            strong = WEIGHTS[k] * stretch * widening
            for j in range(low, high):
                r = shift * q + widening * ACROSS[offset + j]
                x, y = c * q - s * r, s * q + c * r
                m = 1.0 / sqrt(1.0 + x * x + y * y)
                weight = strong * PORTIONS[offset + j] * (m * m * m)
                f, g, h = integrand(known, ox, oy, oz, -x * m, -y * m, m, p[0])
                first, second, third = first + weight * f, second + weight * g, third + weight * h
        return first * (stop - start), second * (stop - start), third * (stop - start)

    def integrals(low: int, high: int, light: float, ox: float, oy: float, oz: float, p: Any) -> tuple[float, float, float]:
        across = sqrt(ox * ox + oy * oy)
        c = ox / across if across > 0.0 else 1.0
        s = oy / across if across > 0.0 else 0.0
        along = sqrt((c * p[1][0]) * (c * p[1][0]) + (s * p[1][1]) * (s * p[1][1]))
        slope = oz / (across * along) if across > 0.0 else 1e30
        edge = tanh(slope / LIGHT) if light > 0.5 else atan(slope) / (0.5 * pi)
        known = view(ox, oy, oz, p[0])
        f1, g1, h1, f2, g2, h2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for part in range(2):
            start, stop = (-1.0, -edge) if part == 0 else (-edge, edge)
            if stop > start:
                f1, g1, h1 = strip(low, high, light, known, ox, oy, oz, c, s, start, stop, p)
                f2, g2, h2 = f2 + f1, g2 + g1, h2 + h1
        return f2, g2, h2

    return integrals


@cache
def seen_batch(view: Callable[..., float], integrand: Callable[..., tuple[float, float, float]]) -> Batch:
    """The last two rules over arrays of view directions: (..., 3) -> (..., 6), the one of more nodes first."""
    integrals = seen_integrals(view, integrand)

    def both(ox: float, oy: float, oz: float, p: Any) -> tuple[float, float, float, float, float, float]:
        heavy = integrals(0, int(STARTS[1]), 0.0, ox, oy, oz, p)
        light = integrals(0, int(STARTS[1]), 1.0, ox, oy, oz, p)
        before = heavy
        for k in range(1, 7):
            low, high = int(STARTS[k]), int(STARTS[k + 1])
            before, heavy = heavy, integrals(low, high, 0.0, ox, oy, oz, p)
            if agree(before, heavy):
                break
            coarse, light = light, integrals(low, high, 1.0, ox, oy, oz, p)
            if agree(coarse, light):
                before, heavy = coarse, light
                break
        return heavy[0], heavy[1], heavy[2], before[0], before[1], before[2]

    return Batch(both, [3], 6)


def agree(coarse: tuple[float, float, float], fine: tuple[float, float, float]) -> bool:
    return (
        abs(coarse[0] - fine[0]) <= AGREED * abs(fine[0])
        and abs(coarse[1] - fine[1]) <= AGREED * abs(fine[1])
        and abs(coarse[2] - fine[2]) <= AGREED * abs(fine[2])
    )
