"""Random numbers in kernels: streams of any length from a seed of two numbers, the same on every thread. steele2014."""

from __future__ import annotations

import struct

import numpy as np

WORD = (1 << 64) - 1
GOLDEN, FIRST, SECOND = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB  # of steele2014


def _mixed(z: int) -> int:
    z = ((z ^ (z >> 30)) * FIRST) & WORD
    z = ((z ^ (z >> 27)) * SECOND) & WORD
    return z ^ (z >> 31)


def _bits(x: float) -> int:
    return int(struct.unpack("<Q", struct.pack("<d", x))[0])


def stream(u1: float, u2: float, k: int) -> int:
    """The key of the k-th stream of random numbers that is seeded by a pair of floats."""
    return _mixed((_mixed((_mixed(_bits(u1)) + _bits(u2)) & WORD) + GOLDEN * (k + 1)) & WORD)


def drawn(key: int, k: int) -> float:
    """The k-th number of a stream, uniform in (0, 1): splitmix64 with random access. steele2014."""
    return ((_mixed((key + GOLDEN * (k + 1)) & WORD) >> 12) + 0.5) * 2.0**-52


_MIX = f"""
    z = (z ^ (z >> np.uint64(30))) * np.uint64({FIRST})
    z = (z ^ (z >> np.uint64(27))) * np.uint64({SECOND})
    z = z ^ (z >> np.uint64(31))"""
_STREAM = f"""def unnamed(u1, u2, k):
    z = np.float64(u1).view(np.uint64){_MIX}
    z = z + np.float64(u2).view(np.uint64){_MIX}
    z = z + np.uint64({GOLDEN}) * np.uint64(k + 1){_MIX}
    return z"""
_DRAWN = f"""def unnamed(key, k):
    z = key + np.uint64({GOLDEN}) * np.uint64(k + 1){_MIX}
    return (np.float64(z >> np.uint64(12)) + 0.5) * 2.220446049250313e-16"""
stream.__compiled__ = {np.float64: _STREAM}  # type: ignore[attr-defined]
drawn.__compiled__ = {np.float64: _DRAWN}  # type: ignore[attr-defined]
