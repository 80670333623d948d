"""Planes above square blocks of a height field, which no point of their block exceeds."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from microfacet.compiler.cache import compiled
from microfacet.surface.lanes import BASE, STEP, Integers, Singles

_jit: Any = compiled(nogil=True, error_model="numpy")
SLACK = 1e-6  # of a block's own height and slope, and a tenth of it in cells: how much planes are rounded up


class Planes(NamedTuple):
    """A plane over each block in one word, which is one read of memory: 32 bits of height, 16 each of the slopes along x and y.

    A part is read with the bits below it, which costs less than to remove them: the height over the block's middle is height
    times the word, the slopes are slope times the word shifted up by 32 and by 48 bits. The m x m blocks of one size stand in
    the entries m^2 to 2 m^2 - 1.
    """

    words: Integers
    height: float
    slope: float


def planes_above(z: Singles, top: int) -> Planes:
    """Planes over all blocks. No slope of least squares exceeds the steepest step between two nodes."""
    steepest = max(float(abs(np.diff(z, axis=axis, append=z.take([0], axis)).astype(float)).max()) for axis in (0, 1))
    slope = steepest / 32767 / 2**48 or 1.0
    height = (float(abs(z).max()) + (2 << top) * steepest) / 2**62 or 1.0
    words = np.zeros(2 * (len(z) >> BASE) ** 2, np.int64)
    for shift in range(BASE, top + 1, STEP):
        count = (len(z) >> shift) ** 2
        _cover(z, shift, height, slope, words[count : 2 * count])
    return Planes(words, height, slope)


@_jit
def _cover(z: Singles, shift: int, height: float, slope: float, words: Integers) -> None:  # pragma: no cover - compiled
    """For each block of 2^shift cells a side the plane of least squares, raised until no node of the block is above it."""
    blocks = z.shape[0] >> shift
    side = 1 << shift
    moment = 0.0
    for p in range(side + 1):
        moment += (p - 0.5 * side) ** 2
    moment *= side + 1
    for block in range(blocks * blocks):
        i, j = (block // blocks) << shift, (block % blocks) << shift
        along, across = _moments(z, i, j, side)
        b, c = round(along / moment / slope / 2.0**48), round(across / moment / slope / 2.0**48)
        low = ((b & 0xFFFF) << 16) | (c & 0xFFFF)
        rise, tilt = slope * (low << 32), slope * (low << 48)
        least = _above(z, i, j, side, rise, tilt)
        size = abs(least) + side * (abs(rise) + abs(tilt))
        words[block] = (math.ceil((least + SLACK * (size + 0.1)) / height / 2.0**32) << 32) | low


@_jit
def _moments(z: Singles, i: int, j: int, side: int) -> tuple[float, float]:  # pragma: no cover - compiled
    along, across = 0.0, 0.0
    mask = z.shape[0] - 1
    for p in range(side + 1):
        row = z[(i + p) & mask]
        for q in range(side + 1):
            along += (p - 0.5 * side) * row[(j + q) & mask]
            across += (q - 0.5 * side) * row[(j + q) & mask]
    return along, across


@_jit
def _above(z: Singles, i: int, j: int, side: int, b: float, c: float) -> float:  # pragma: no cover - compiled
    """Least height over the block's middle of a plane of the slopes (b, c) that no node exceeds."""
    least = -math.inf
    mask = z.shape[0] - 1
    for p in range(side + 1):
        row = z[(i + p) & mask]
        for q in range(side + 1):
            least = max(least, row[(j + q) & mask] - b * (p - 0.5 * side) - c * (q - 0.5 * side))
    return least
