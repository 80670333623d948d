"""Integrals over the normals that face a direction, in slope space, where the edge of visibility is a straight line.

Slopes are rotated so that q runs along the view direction: a facet is front-facing where q < cot theta_o. The line
q = -cot theta_o, where V-cavities begin to mask, is an edge of a panel too. The nodes are stretched to the tails, around the
ridge of a stretched isotropic distribution: by tangents, suited to tails that fall as a power, or by inverse hyperbolic
tangents, suited to tails that fall exponentially.

Both kinds of rules begin with few nodes, which suffice if the density across the view is that of GGX or a Gaussian; a test of
the tails decides which kind is tried first. If no two of these rules agree, both kinds are tried with more and more nodes and
without assumptions on the density across the view. Along the view the nodes are Gauss-Legendre nodes, and so are the last ones
across the view for power tails; for exponential tails equal steps are better there.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import atan, atanh, cos, pi, sqrt, tan, tanh
from typing import Any, NamedTuple

import numpy as np

from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import ByPrecision, Pair, Vector
from microfacet.geometry.roughness import SlopeScale

LEVELS = (12, 16, 24, 32, 48, 64, 96)  # nodes along and across, rule after rule
FIRST_POWER = ((10, 3), (12, 4), (14, 5), (16, 6))  # nodes along and across of the first rules, for tails of a power
FIRST_EXPONENTIAL = ((20, 2), (24, 3), (30, 2), (36, 3))  # and for exponential tails; the last two for a single panel
AGREED = ByPrecision(5e-13, 2e-6)  # relative difference of two rules after which no third is tried
EXPONENTIAL_STRETCH = 3.0  # factor of the inverse hyperbolic tangents of nodes: the best one for a Gaussian
NEAREST, FARTHEST = 5.5, 7.5  # where equal steps across exponential tails end, from the first rule to the last
EDGE_BEYOND_POWER = ByPrecision(1.0 - 1e-9, 1.0 - 1e-5)  # in (-1, 1): from here on an edge is beyond all power tails
EDGE_BEYOND_EXPONENTIAL = 0.995  # and here, nine scales out, beyond exponential ones
PROBE, VANISHED = 4.0, 1e-4  # tails are exponential if the density at PROBE scales is below VANISHED times that at the centre

Nodes = tuple[np.ndarray, np.ndarray]


def gauss_legendre(count: int) -> Nodes:
    """Nodes and weights on (-1, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def periodic(count: int) -> Nodes:
    """Tangents of equally spaced angles in (-pi/2, pi/2): exact for GGX."""
    angles = np.pi * ((np.arange(count) + 0.5) / count - 0.5)
    return np.tan(angles), np.pi / count / np.cos(angles) ** 2


def legendre_tangents(count: int) -> Nodes:
    """Tangents of Gauss-Legendre nodes in (-pi/2, pi/2)."""
    nodes, weights = gauss_legendre(count)
    return np.tan(np.pi / 2 * nodes), weights * np.pi / 2 / np.cos(np.pi / 2 * nodes) ** 2


def hermite(count: int) -> Nodes:
    """Gauss-Hermite, with the exponential put back: exact for a Gaussian times a polynomial."""
    nodes, weights = np.polynomial.hermite.hermgauss(count)
    return nodes, weights * np.exp(nodes**2)


def equal_steps(count: int) -> Nodes:
    """Midpoints of equal steps; the more nodes, the longer the interval, so that rules differ if a tail is truncated."""
    reach = NEAREST + (FARTHEST - NEAREST) * LEVELS.index(count) / (len(LEVELS) - 1)
    nodes = reach * (2 * (np.arange(count) + 0.5) / count - 1)
    return nodes, np.full(count, 2 * reach / count)


def _joined(rules: list[Nodes]) -> tuple[tuple[float, ...], tuple[float, ...], tuple[int, ...]]:
    """Nodes and weights of all rules, concatenated, and the index at which each rule begins."""
    starts = np.cumsum([0, *(len(nodes) for nodes, _ in rules)])
    nodes, weights = (np.concatenate([rule[part] for rule in rules]) for part in (0, 1))
    return tuple(map(float, nodes)), tuple(map(float, weights)), tuple(map(int, starts))


# the first rules of the two kinds, then those of each level
RULES = [
    *((gauss_legendre(along), periodic(across)) for along, across in FIRST_POWER),
    *((gauss_legendre(along), hermite(across)) for along, across in FIRST_EXPONENTIAL),
    *((gauss_legendre(count), legendre_tangents(count)) for count in LEVELS),
    *((gauss_legendre(max(count, FIRST_EXPONENTIAL[0][0])), equal_steps(count)) for count in LEVELS),
]
FIRST_COUNT, HIGH = len(FIRST_POWER), len(LEVELS) - 3  # the last three levels come when both kinds have failed
POWER_LEVELS = 2 * FIRST_COUNT
EXPONENTIAL_LEVELS = POWER_LEVELS + len(LEVELS)
FOR_EXPONENTIAL = tuple(FIRST_COUNT <= rule < POWER_LEVELS or rule >= EXPONENTIAL_LEVELS for rule in range(len(RULES)))


def schedule() -> tuple[int, ...]:
    """The order in which rules are tried if power tails are likely, followed by the order if exponential tails are."""
    power = [*range(FIRST_COUNT), *range(POWER_LEVELS, POWER_LEVELS + HIGH)]
    exponential = [*range(FIRST_COUNT, 2 * FIRST_COUNT), *range(EXPONENTIAL_LEVELS, EXPONENTIAL_LEVELS + HIGH)]
    last = [(POWER_LEVELS + k, EXPONENTIAL_LEVELS + k) for k in range(HIGH, len(LEVELS))]
    power_first = power + exponential + [rule for pair in last for rule in pair]
    exponential_first = exponential + power + [rule for pair in last for rule in reversed(pair)]
    return tuple(power_first + exponential_first)


SCHEDULE = schedule()
RULE_COUNT = len(RULES)
NODES, WEIGHTS, STARTS = _joined([rule[0] for rule in RULES])
ONE_PANEL = 2  # the rule to begin with if no facet of significance faces away
UNKNOWN = float("nan")
NODES_ACROSS, WEIGHTS_ACROSS, STARTS_ACROSS = _joined([rule[1] for rule in RULES])


@cache
def integrate_between_slopes(integrand: Callable[..., float]) -> Callable[..., float]:
    """The kernel of the integral of integrand(Lambda_o, wo, wm, p) over the normals wm between two slopes along the view.

    rule: index into `RULES`. exponential: whether that rule is for exponential tails. Lambda_o: of wo, for models that have
    it. azimuth: cosine and sine of the azimuth of wo. ends: the slopes along the view in units of their scale, as 2/pi atan,
    or as tanh of a third of them if exponential.
    """

    def between_slopes(
        rule: int, exponential: bool, Lambda_o: float, wo: Vector, azimuth: Pair, ends: Pair, scale: SlopeScale, p: Any
    ) -> float:
        (c, s), (start, stop), alpha_x, alpha_y = azimuth, ends, scale.scale_x, scale.scale_y
        along = sqrt((c * alpha_x) * (c * alpha_x) + (s * alpha_y) * (s * alpha_y))
        aside = alpha_x * alpha_y / along
        shift = s * c * (alpha_y * alpha_y - alpha_x * alpha_x) / (along * along)
        total = 0.0
        for k in range(STARTS[rule], STARTS[rule + 1]):
            t = start + (stop - start) * (0.5 + 0.5 * NODES[k])
            if exponential:
                q = along * EXPONENTIAL_STRETCH * atanh(t)
                widening = aside
                stretch = along * EXPONENTIAL_STRETCH / (1.0 - t * t)
            else:
                angle = 0.5 * pi * t
                q = along * tan(angle)
                widening = aside / cos(angle)
                stretch = along * 0.5 * pi / (cos(angle) * cos(angle))
            weight = 0.5 * WEIGHTS[k] * stretch * widening
            for j in range(STARTS_ACROSS[rule], STARTS_ACROSS[rule + 1]):
                r = shift * q + widening * NODES_ACROSS[j]
                x, y = c * q - s * r, s * q + c * r
                m = 1.0 / sqrt(1.0 + x * x + y * y)
                total += weight * WEIGHTS_ACROSS[j] * (m * m * m) * integrand(Lambda_o, wo, (-x * m, -y * m, m), p)
        return total * (stop - start)

    return between_slopes


@cache
def has_exponential_tails(normals: Callable[..., float]) -> Callable[..., bool]:
    """The kernel that tests whether a density of slopes is almost 0 at a few scales along each axis.

    normals: the kernel of D, and p its parameters.
    """

    def has_exponential_tails(scale: SlopeScale, p: Any) -> bool:
        centre, tail = 0.0, 0.0
        for k in range(3):
            x = PROBE * scale.scale_x if k == 1 else 0.0
            y = PROBE * scale.scale_y if k == 2 else 0.0
            m = 1.0 / sqrt(1.0 + x * x + y * y)
            density = normals((-x * m, -y * m, m), p) * ((m * m) * (m * m))
            centre = density if k == 0 else centre
            tail = 0.0 if k == 0 else tail + density
        return tail < VANISHED * centre

    return has_exponential_tails


@cache
def integrate_adaptively(integrand: Callable[..., float], hidden: bool = False) -> Callable[..., Pair]:
    """The kernel of the integral over all normals with wo.wm > 0, or < 0 if `hidden`: it tries rule after rule until two
    agree, and returns the results of these two, that of more nodes first. For the integrand see `integrate_between_slopes`.

    begin: how many rules of the schedule to skip. exponential_likely: which kind of rules goes first. floor: a number to which
    the integral is added later, so that it needs only the digits of the sum. enough: relative difference at which rules agree.
    """
    between_slopes = integrate_between_slopes(integrand)

    def integrate_adaptively(
        begin: int,
        exponential_likely: bool,
        floor: float,
        enough: float,
        Lambda_o: float,
        wo: Vector,
        scale: SlopeScale,
        p: Any,
    ) -> Pair:
        ox, oy, oz = wo
        across = sqrt(ox * ox + oy * oy)
        c = ox / across if across > 0.0 else 1.0
        s = oy / across if across > 0.0 else 0.0
        along = sqrt((c * scale.scale_x) * (c * scale.scale_x) + (s * scale.scale_y) * (s * scale.scale_y))
        slope = oz / (across * along) if across > 0.0 else 1e30
        edge_power, edge_exponential = atan(slope) / (0.5 * pi), tanh(slope / EXPONENTIAL_STRETCH)
        last_power, last_exponential, previous_power, previous_exponential = UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN
        for position in range(begin, RULE_COUNT):
            rule = SCHEDULE[position + RULE_COUNT if exponential_likely else position]
            exponential = FOR_EXPONENTIAL[rule] > 0
            fine = 0.0
            if hidden:
                stretched = exponential and edge_exponential < EDGE_BEYOND_POWER
                edge = edge_exponential if stretched else edge_power
                fine = between_slopes(rule, stretched, Lambda_o, wo, (c, s), (edge, 1.0), scale, p)
            else:
                edge = edge_exponential if exponential else edge_power
                edge = 1.0 if edge > (EDGE_BEYOND_EXPONENTIAL if exponential else EDGE_BEYOND_POWER) else edge
                for part in range(2):
                    start, stop = (-1.0, -edge) if part == 0 else (-edge, edge)
                    ends = (start, stop)
                    fine += between_slopes(rule, exponential, Lambda_o, wo, (c, s), ends, scale, p) if stop > start else 0.0
            coarse = last_exponential if exponential else last_power
            if exponential:
                previous_exponential, last_exponential = last_exponential, fine
            else:
                previous_power, last_power = last_power, fine
            if abs(coarse - fine) <= enough * (floor + abs(fine)):
                return fine, coarse
        # no two rules agreed: take the kind whose last two rules differ less
        if abs(previous_exponential - last_exponential) < abs(previous_power - last_power):
            return last_exponential, previous_exponential
        return last_power, previous_power

    return integrate_adaptively


class VisibleParameters(NamedTuple):
    """Parameters of an integral over front-facing normals: those of the distribution, the model's own, and the slope scale."""

    ndf: Any
    model: Any
    scale: SlopeScale


@cache
def visible_integral(Lambda: Callable[..., float], integrand: Callable[..., float], normals: Callable[..., float]) -> Batch:
    """The results of the last two rules for arrays of view directions: (..., 3) -> (..., 2), that of more nodes first.

    Lambda, integrand: see `integrate_between_slopes`. normals: the kernel of D. Parameters: see `VisibleParameters`.
    """
    integral, exponential_tails = integrate_adaptively(integrand), has_exponential_tails(normals)

    def last_two_rules(wo: Vector, p: VisibleParameters) -> Pair:
        exponential_likely = exponential_tails(p.scale, p.ndf)
        across = sqrt(wo[0] * wo[0] + wo[1] * wo[1])
        whole = exponential_likely and wo[2] > FARTHEST * max(p.scale.scale_x, p.scale.scale_y) * across
        return integral(ONE_PANEL if whole else 0, exponential_likely, 0.0, AGREED, Lambda(wo, p), wo, p.scale, p)

    return Batch(last_two_rules, [3], 2)
