"""Functions of normals that jump, bend, or have narrow lobes, with the area that a view sees of them in closed form.

Slopes are stretched by a pair of scales. A facet of slopes s shows 1 - s.q of itself, over cos theta_o, where q is the view's
horizontal part over its height; in unstretched slopes q is stretched instead. V-cavities leave 1 visible of whatever is alike
at opposite slopes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import asin, erfc, exp, pi, sqrt
from typing import Any, NamedTuple

import mpmath as mp
import numpy as np
from microfacet.directions import spherical
from scipy.special import i0e

Density = Callable[[np.ndarray, np.ndarray], np.ndarray]  # of unstretched slopes
WIDER = 12  # times its width, at most, a lobe is away from the origin
CLOSER = 48  # the same where facets would be missing
LEAST = 1e-20  # an area of which the closed form itself has enough digits


class Hostile(NamedTuple):
    """A function of normals, a masking, a view, and the area seen over cos theta_o."""

    name: str
    D: Any
    G1: Any
    wo: np.ndarray
    area: float


def of_normals(density: Density, scale: tuple[float, float]) -> Any:
    def D(m: np.ndarray) -> np.ndarray:
        x, y = -m[:, 0] / m[:, 2] / scale[0], -m[:, 1] / m[:, 2] / scale[1]
        return np.asarray(density(x, y) / (scale[0] * scale[1] * (m[:, 2] ** 2) ** 2))

    return D


def cavities(wo: np.ndarray) -> Any:
    return lambda m: np.minimum(1, 2 * m[:, 2] * wo[2] / np.maximum(m @ wo, 1e-300))


# --- shapes, and how much of them is seen: the mean of what 1 - q u leaves above 0 for slopes u along the view ------------


class Part(NamedTuple):
    """A density of slopes around a centre, and what is seen of it where the slope along the view is `u` at the centre."""

    density: Density
    seen: Callable[[float, float], float]


def disc(x: float, y: float, radius: float) -> Part:
    def seen(u: float, q: float) -> float:
        if q == 0:
            return 1.0
        t = (1 / q - u) / radius
        if t >= 1:
            return 1 - q * u
        if t <= -1:
            return 0.0
        share = 0.5 + (asin(t) + t * sqrt(1 - t * t)) / pi
        return (1 - q * u) * share + q * radius * 2 / (3 * pi) * (1 - t * t) ** 1.5

    return Part(lambda a, b: (np.hypot(a - x, b - y) < radius) / (pi * radius**2), seen)


def gaussian(x: float, y: float, width: float) -> Part:
    def seen(u: float, q: float) -> float:
        if q == 0:
            return 1.0
        t = (1 / q - u) / width
        return q * width * (t * erfc(-t) / 2 + exp(-t * t) / (2 * sqrt(pi)))

    return Part(lambda a, b: np.exp(-((a - x) ** 2 + (b - y) ** 2) / width**2) / (pi * width**2), seen)


def heavy(x: float, y: float, width: float) -> Part:
    """Tails as of GGX."""

    def seen(u: float, q: float) -> float:
        if q == 0:
            return 1.0
        t = (1 / q - u) / width
        above = sqrt(1 + t * t) + t if t > 0 else 1 / (sqrt(1 + t * t) - t)
        return q * width * above / 2

    return Part(lambda a, b: 1 / (pi * width**2 * (1 + ((a - x) ** 2 + (b - y) ** 2) / width**2) ** 2), seen)


def mixed(parts: list[tuple[float, float, float, Part]], q: np.ndarray) -> tuple[Density, float]:
    """The density of parts (share, x, y, part), and the area seen."""
    steep = float(np.hypot(*q))
    along = q / steep if steep else q
    area = sum(share * part.seen(float(x * along[0] + y * along[1]), steep) for share, x, y, part in parts)
    return lambda a, b: sum(share * part.density(a, b) for share, _, _, part in parts), area


def table(theta: np.ndarray, values: np.ndarray, linear: bool) -> Any:
    """A function of normals of the polar angle only, by a table, scaled so that its facets project to 1."""
    rise = np.diff(values) / np.diff(theta) if linear else 0 * np.diff(theta)
    start = values[:-1] - rise * theta[:-1]

    def antiderivative(k: int, t: float) -> mp.mpf:
        return -(mp.mpf(start[k]) + rise[k] * mp.mpf(t)) * mp.cos(2 * mp.mpf(t)) / 2 + rise[k] * mp.sin(2 * mp.mpf(t)) / 4

    with mp.workdps(40):
        pieces = [antiderivative(k, theta[k + 1]) - antiderivative(k, theta[k]) for k in range(len(rise))]
        norm = float(mp.pi * sum(pieces))

    def D(m: np.ndarray) -> np.ndarray:
        at = np.arctan2(np.hypot(m[:, 0], m[:, 1]), m[:, 2])
        k = np.clip(np.searchsorted(theta, at, side="right") - 1, 0, len(theta) - 2)
        return np.where(at < theta[-1], start[k] + rise[k] * at, 0) / norm

    return D


# --- at random ------------------------------------------------------------------------------------------------------------

KINDS = ("disc", "annulus", "steps", "linear", "lobes", "spike", "wedges", "notch", "half", "masked", "twins", "tilted")


def hostile(count: int, seed: int) -> Iterator[Hostile]:
    """Functions of each kind in turn."""
    g = np.random.default_rng(seed)
    for k in range(count):
        yield _one(KINDS[k % len(KINDS)], g)


def _off(g: np.random.Generator, width: float, most: float) -> tuple[float, float]:
    """A centre away from the origin by up to so many times the width."""
    distance, azimuth = width * most * g.uniform(0, 1) ** 2, g.uniform(0, 2 * pi)
    return distance * np.cos(azimuth), distance * np.sin(azimuth)


def _view(g: np.random.Generator) -> np.ndarray:
    """From above, at any angle, or near grazing; at any azimuth or along an axis."""
    theta = (0.0, g.uniform(0, 89.9), 90 - 10 ** g.uniform(-1, 1.5))[int(g.choice(3, p=(0.1, 0.45, 0.45)))]
    return spherical(np.radians(theta), g.uniform(0, 2 * pi) if g.integers(4) else pi / 2 * g.integers(4))


def _one(kind: str, g: np.random.Generator) -> Hostile:
    wo, size = _view(g), float(10 ** g.uniform(-6, 1))
    ratio = float(10 ** g.uniform(-1, 0)) if g.integers(2) else 1.0
    scale = (size, size * ratio) if g.integers(2) else (size * ratio, size)
    q = wo[:2] / wo[2] * np.array(scale)
    lobe = gaussian if g.integers(2) else heavy
    if kind in ("steps", "linear"):
        inner = np.sort(g.uniform(0.01, 1.5, int(g.integers(2, 7))))
        theta = np.concatenate([[0.0], inner[np.diff(inner, prepend=-1) > 0.1]])
        values = g.uniform(0, 1, len(theta)) * g.integers(0, 2, len(theta))
        values[0] = 1.0
        values[-1] *= kind == "steps"
        return Hostile(kind, table(theta, values, kind == "linear"), cavities(wo), wo, 1.0)
    if kind in ("wedges", "notch"):
        density = _turning(kind, g, lobe(0, 0, 1.0).density)
        return Hostile(kind, of_normals(density, scale), cavities(wo), wo, 1.0)
    if kind in ("half", "masked"):
        return _cut(kind, g, wo, scale, q)
    density, area = mixed(_parts(kind, g, lobe), q)
    if kind == "twins":
        return Hostile(kind, of_normals(density, scale), cavities(wo), wo, 1.0)
    if area < LEAST:
        return _one(kind, g)
    return Hostile(kind, of_normals(density, scale), None, wo, area)


def _parts(kind: str, g: np.random.Generator, lobe: Any) -> list[tuple[float, float, float, Part]]:
    if kind == "disc":
        x, y = _off(g, 1.0, 6) if g.integers(4) else (0.0, 0.0)
        return [(1.0, x, y, disc(x, y, 1.0))]
    if kind == "annulus":
        x, y = _off(g, 1.0, 3)
        hole = g.uniform(0.3, 0.8)
        norm = 1 - hole**2
        return [(1 / norm, x, y, disc(x, y, 1.0)), (-(hole**2) / norm, x, y, disc(x, y, hole))]
    if kind == "lobes":
        shares = g.dirichlet(np.ones(int(g.integers(1, 5))))
        widths = [float(10 ** g.uniform(-1.3, 0)) for _ in shares]
        places = [_off(g, width, CLOSER / 2) for width in widths]
        return [(share, *at, lobe(*at, width)) for share, at, width in zip(shares, places, widths, strict=True) if share > 0.01]
    if kind == "spike":
        width, share = float(10 ** g.uniform(-2, -0.5)), float(10 ** g.uniform(-4, -1))
        at = _off(g, width, WIDER)
        return [(1 - share, 0.0, 0.0, lobe(0.0, 0.0, 1.0)), (share, *at, gaussian(*at, width))]
    width = float(10 ** g.uniform(-1, 0))
    x, y = _off(g, width, WIDER)
    if kind == "tilted":
        return [(1.0, x, y, lobe(x, y, width))]
    shape = disc if g.integers(2) else lobe
    return [(0.5, sign * x, sign * y, shape(sign * x, sign * y, width)) for sign in (1, -1)]


def _turning(kind: str, g: np.random.Generator, density: Density) -> Density:
    """A density around the origin times a function of the azimuth that is alike in opposite directions."""
    turn = g.uniform(0, pi) if g.integers(4) else 0.0
    if kind == "wedges":
        half = g.uniform(0.3, 1.2)
        return lambda a, b: density(a, b) * (np.cos(2 * (np.arctan2(b, a) - turn)) > np.cos(2 * half)) * (pi / 2 / half)
    narrow, depth = float(10 ** g.uniform(-1, 0)), g.uniform(0.1, 1)
    norm = 1 - depth * float(i0e(1 / narrow**2))

    def notched(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        aside = (1 - np.cos(2 * (np.arctan2(b, a) - turn))) / narrow**2
        return np.asarray(density(a, b) * (1 - depth * np.exp(-aside)) / norm)

    return notched


def _cut(kind: str, g: np.random.Generator, wo: np.ndarray, scale: tuple[float, float], q: np.ndarray) -> Hostile:
    """Gaussian slopes beyond a line that runs along the view; or all of them, masked beyond one across the view."""
    steep = float(np.hypot(*q))
    along = q / steep if steep else np.array([1.0, 0.0])
    round_ = gaussian(0, 0, 1.0)
    at = g.uniform(-1, 1)
    if kind == "half":
        share = erfc(at) / 2

        def half(a: np.ndarray, b: np.ndarray) -> np.ndarray:
            return np.asarray(round_.density(a, b) * (along[0] * b - along[1] * a > at) / share)

        return Hostile(kind, of_normals(half, scale), None, wo, round_.seen(0.0, steep))
    end = min(at, 1 / steep) if steep else at
    rest = g.uniform(0, 1)

    def below(t: float) -> float:
        return erfc(-t) / 2 + steep * exp(-t * t) / (2 * sqrt(pi))

    def G1(m: np.ndarray) -> np.ndarray:
        x, y = -m[:, 0] / m[:, 2] / scale[0], -m[:, 1] / m[:, 2] / scale[1]
        return np.where(along[0] * x + along[1] * y < at, 1.0, rest)

    area = below(end) + rest * (round_.seen(0.0, steep) - below(end))
    return Hostile(kind, of_normals(round_.density, scale), G1, wo, area)
