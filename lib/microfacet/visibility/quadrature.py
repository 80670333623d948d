"""Integrals over the normals that a direction sees, in slope space, where the edge of visibility is a straight line.

Slopes are turned so that q runs along the view direction: a facet is seen from its front where q < cot theta_o. The line
q = -cot theta_o, where V-cavities begin to mask, is a panel's edge too. The nodes are
stretched to the tails, around the ridge of a stretched isotropic distribution: by tangents, right for tails that fall as
a power, and by inverse hyperbolic tangents, right for tails that fall exponentially.

Both kinds begin with few nodes, which suffice if the density across the view is that of GGX or a Gaussian; which kind
goes first, a look at the tails tells. If no two of these rules agree, both kinds are tried with more and more nodes,
without any assumption on what lies across. Along the view, nodes are those of Gauss and Legendre, and in the end across
power tails too; across exponential tails equal steps are better still.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import atan, atanh, cos, pi, sqrt, tan, tanh
from typing import Any, NamedTuple

import numpy as np

from microfacet.geometry.roughness import SlopeScale
from microfacet.kernels import Batch, ByPrecision, Pair, Vector

LEVELS = (12, 16, 24, 32, 48, 64, 96)  # nodes along and across, rule after rule
FIRST_HEAVY = ((10, 3), (12, 4), (14, 5), (16, 6))  # nodes along and across of the first rules, for tails of a power
FIRST_LIGHT = ((20, 2), (24, 3), (30, 2), (36, 3))  # and for exponential ones; the last two for one panel, from tail to tail
AGREED = ByPrecision(5e-13, 2e-6)  # relative difference of two rules after which no third is tried
LIGHT = 3.0  # inverse hyperbolic tangents of nodes are stretched by this: the one best for a Gaussian
NEAREST, FARTHEST = 5.5, 7.5  # where equal steps across exponential tails end, from the first rule to the last
BEYOND = ByPrecision(1.0 - 1e-9, 1.0 - 1e-5)  # an edge of visibility at this share or farther is beyond all tails of a power,
BEYOND_LIGHT = 0.995  # and at this one, nine scales out, beyond exponential ones
PROBE, FALLEN = 4.0, 1e-4  # tails are exponential if at so many scales the density has fallen below this

Nodes = tuple[np.ndarray, np.ndarray]


def gauss_legendre(count: int) -> Nodes:
    """Nodes and weights on (-1, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def periodic(count: int) -> Nodes:
    """Tangents of equal steps of half a turn: exact for GGX."""
    angles = np.pi * ((np.arange(count) + 0.5) / count - 0.5)
    return np.tan(angles), np.pi / count / np.cos(angles) ** 2


def legendre_tangents(count: int) -> Nodes:
    """Tangents of Gauss-Legendre nodes of half a turn."""
    nodes, weights = gauss_legendre(count)
    return np.tan(np.pi / 2 * nodes), weights * np.pi / 2 / np.cos(np.pi / 2 * nodes) ** 2


def hermite(count: int) -> Nodes:
    """Gauss-Hermite, with the exponential put back: exact for a Gaussian times a polynomial."""
    nodes, weights = np.polynomial.hermite.hermgauss(count)
    return nodes, weights * np.exp(nodes**2)


def equal_steps(count: int) -> Nodes:
    """Midpoints of equal steps; the more there are, the farther they go, so that a tail cut off shows as a difference."""
    reach = NEAREST + (FARTHEST - NEAREST) * LEVELS.index(count) / (len(LEVELS) - 1)
    nodes = reach * (2 * (np.arange(count) + 0.5) / count - 1)
    return nodes, np.full(count, 2 * reach / count)


def _joined(rules: list[Nodes]) -> tuple[tuple[float, ...], tuple[float, ...], tuple[int, ...]]:
    """Nodes and weights of all rules one after another, and where each begins."""
    starts = np.cumsum([0, *(len(nodes) for nodes, _ in rules)])
    nodes, weights = (np.concatenate([rule[part] for rule in rules]) for part in (0, 1))
    return tuple(map(float, nodes)), tuple(map(float, weights)), tuple(map(int, starts))


# the first rules of the two kinds, then those of each level
RULES = [
    *((gauss_legendre(along), periodic(across)) for along, across in FIRST_HEAVY),
    *((gauss_legendre(along), hermite(across)) for along, across in FIRST_LIGHT),
    *((gauss_legendre(count), legendre_tangents(count)) for count in LEVELS),
    *((gauss_legendre(max(count, FIRST_LIGHT[0][0])), equal_steps(count)) for count in LEVELS),
]
FEW, HIGH = len(FIRST_HEAVY), len(LEVELS) - 3  # the last three levels come when both kinds have failed
HEAVY_LEVELS = 2 * FEW
LIGHT_LEVELS = HEAVY_LEVELS + len(LEVELS)
FOR_LIGHT = tuple(FEW <= rule < HEAVY_LEVELS or rule >= LIGHT_LEVELS for rule in range(len(RULES)))


def schedule() -> tuple[int, ...]:
    """The rules in the order in which they are tried if tails of a power are likely, then if exponential ones are."""
    heavy = [*range(FEW), *range(HEAVY_LEVELS, HEAVY_LEVELS + HIGH)]
    light = [*range(FEW, 2 * FEW), *range(LIGHT_LEVELS, LIGHT_LEVELS + HIGH)]
    last = [(HEAVY_LEVELS + k, LIGHT_LEVELS + k) for k in range(HIGH, len(LEVELS))]
    heavy_first = heavy + light + [rule for pair in last for rule in pair]
    light_first = light + heavy + [rule for pair in last for rule in reversed(pair)]
    return tuple(heavy_first + light_first)


SCHEDULE = schedule()
TURNS = len(RULES)
NODES, WEIGHTS, STARTS = _joined([rule[0] for rule in RULES])
ONE_PANEL = 2  # the rule to begin with if no facet that counts is turned away
UNKNOWN = float("nan")
ACROSS, PORTIONS, ACROSS_STARTS = _joined([rule[1] for rule in RULES])


@cache
def slope_strip(integrand: Callable[..., float]) -> Callable[..., float]:
    """The kernel of the integral of integrand(Lambda_o, wo, wm, p) over the normals wm between two slopes along the view.

    rule: which of `RULES`. light: whether it is one for tails that fall exponentially. Lambda_o: of wo, for models that have
    it. azimuth: the cosine and the sine of that of wo. ends: the slopes, as shares of a quarter turn or as tanh.
    """

    def strip(
        rule: int, light: bool, Lambda_o: float, wo: Vector, azimuth: Pair, ends: Pair, scale: SlopeScale, p: Any
    ) -> float:
        (c, s), (start, stop), alpha_x, alpha_y = azimuth, ends, scale.scale_x, scale.scale_y
        along = sqrt((c * alpha_x) * (c * alpha_x) + (s * alpha_y) * (s * alpha_y))
        aside = alpha_x * alpha_y / along
        shift = s * c * (alpha_y * alpha_y - alpha_x * alpha_x) / (along * along)
        total = 0.0
        for k in range(STARTS[rule], STARTS[rule + 1]):
            share = start + (stop - start) * (0.5 + 0.5 * NODES[k])
            if light:
                q = along * LIGHT * atanh(share)
                widening = aside
                stretch = along * LIGHT / (1.0 - share * share)
            else:
                angle = 0.5 * pi * share
                q = along * tan(angle)
                widening = aside / cos(angle)
                stretch = along * 0.5 * pi / (cos(angle) * cos(angle))
            strong = 0.5 * WEIGHTS[k] * stretch * widening
            for j in range(ACROSS_STARTS[rule], ACROSS_STARTS[rule + 1]):
                r = shift * q + widening * ACROSS[j]
                x, y = c * q - s * r, s * q + c * r
                m = 1.0 / sqrt(1.0 + x * x + y * y)
                total += strong * PORTIONS[j] * (m * m * m) * integrand(Lambda_o, wo, (-x * m, -y * m, m), p)
        return total * (stop - start)

    return strip


@cache
def light_tails(normals: Callable[..., float]) -> Callable[..., bool]:
    """The kernel that looks whether a density of slopes has all but vanished at a few scales along each axis.

    normals: the kernel of D, and p its parameters.
    """

    def light_tails(scale: SlopeScale, p: Any) -> bool:
        centre, tail = 0.0, 0.0
        for k in range(3):
            x = PROBE * scale.scale_x if k == 1 else 0.0
            y = PROBE * scale.scale_y if k == 2 else 0.0
            m = 1.0 / sqrt(1.0 + x * x + y * y)
            density = normals((-x * m, -y * m, m), p) * ((m * m) * (m * m))
            centre = density if k == 0 else centre
            tail = 0.0 if k == 0 else tail + density
        return tail < FALLEN * centre

    return light_tails


@cache
def settled(integrand: Callable[..., float], hidden: bool = False) -> Callable[..., Pair]:
    """The kernel of the integral over all normals with wo.wm > 0, or < 0 if `hidden`: it goes from rule to rule until two
    agree, and returns them, first that of more nodes. For the integrand see `slope_strip`.

    begin: the first rules to pass over. guess: whether exponential tails are likely. floor: what the integral is added
    to, so that it needs no more digits than the sum has. enough: the relative difference at which two rules agree.
    """
    strip = slope_strip(integrand)

    def settled(
        begin: int, guess: bool, floor: float, enough: float, Lambda_o: float, wo: Vector, scale: SlopeScale, p: Any
    ) -> Pair:
        ox, oy, oz = wo
        across = sqrt(ox * ox + oy * oy)
        c = ox / across if across > 0.0 else 1.0
        s = oy / across if across > 0.0 else 0.0
        along = sqrt((c * scale.scale_x) * (c * scale.scale_x) + (s * scale.scale_y) * (s * scale.scale_y))
        slope = oz / (across * along) if across > 0.0 else 1e30
        edge_heavy, edge_light = atan(slope) / (0.5 * pi), tanh(slope / LIGHT)
        heavy, steps, coarse_heavy, coarse_steps = UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN
        for turn in range(begin, TURNS):
            rule = SCHEDULE[turn + TURNS if guess else turn]
            light = FOR_LIGHT[rule] > 0
            fine = 0.0
            if hidden:
                exponential = light and edge_light < BEYOND
                edge = edge_light if exponential else edge_heavy
                fine = strip(rule, exponential, Lambda_o, wo, (c, s), (edge, 1.0), scale, p)
            else:
                edge = edge_light if light else edge_heavy
                edge = 1.0 if edge > (BEYOND_LIGHT if light else BEYOND) else edge
                for part in range(2):
                    start, stop = (-1.0, -edge) if part == 0 else (-edge, edge)
                    fine += strip(rule, light, Lambda_o, wo, (c, s), (start, stop), scale, p) if stop > start else 0.0
            coarse = steps if light else heavy
            coarse_steps, steps = (steps, fine) if light else (coarse_steps, steps)
            coarse_heavy, heavy = (coarse_heavy, heavy) if light else (heavy, fine)
            if abs(coarse - fine) <= enough * (floor + abs(fine)):
                return fine, coarse
        # none agreed: of the two kinds, the one that moved less
        if abs(coarse_steps - steps) < abs(coarse_heavy - heavy):
            return steps, coarse_steps
        return heavy, coarse_heavy

    return settled


class Seen(NamedTuple):
    """Parameters of an integral over the normals that a direction sees: the distribution's, the model's own, and the scale."""

    ndf: Any
    model: Any
    scale: SlopeScale


@cache
def seen_batch(Lambda: Callable[..., float], integrand: Callable[..., float], normals: Callable[..., float]) -> Batch:
    """The last two rules over arrays of view directions: (..., 3) -> (..., 2), the one of more nodes first.

    Lambda, integrand: see `slope_strip`. normals: the kernel of D. Parameters: see `Seen`.
    """
    settle, fall = settled(integrand), light_tails(normals)

    def both(wo: Vector, p: Seen) -> Pair:
        guess = fall(p.scale, p.ndf)
        across = sqrt(wo[0] * wo[0] + wo[1] * wo[1])
        whole = guess and wo[2] > FARTHEST * max(p.scale.scale_x, p.scale.scale_y) * across
        return settle(ONE_PANEL if whole else 0, guess, 0.0, AGREED, Lambda(wo, p), wo, p.scale, p)

    return Batch(both, [3], 2)
