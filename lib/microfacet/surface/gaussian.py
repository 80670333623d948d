"""Periodic Gaussian height fields of a stated autocorrelation, made in two independent ways.

A field has one height per node of a square grid, z[i, j] at x = i, y = j, repeated for ever with period ``size``. All
lengths, heights too, are in units of the grid's cell. Heights are normally distributed with

    <z(x, y) z(x + dx, y + dy)> = sigma^2 exp(-(dx/l_x)^2 - (dy/l_y)^2),

so the slopes of the smooth surface are Beckmann's, with alpha_x = 2 sigma/l_x and alpha_y = 2 sigma/l_y.

A grid flattens. Each cell is cut into two facets (see microfacet.surface.height_field) whose slopes are differences of
neighbouring heights; they are normally distributed too, but with

    alpha_x = 2 sigma sqrt(1 - exp(-1/l_x^2)) < 2 sigma/l_x.

By default sigma and l_y are chosen so that the facets, not the smooth surface, have the alpha asked for.

Sources: beckmann1963 (Gaussian surfaces and their slopes), lagae2009 (Gabor noise).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike, NDArray

from microfacet.compiler.cache import compiled
from microfacet.compiler.processors import parallel_map
from microfacet.directions import positive, whole

Array = NDArray[np.float64]
PERIODS = 6.0  # correlation lengths in a period, at least: its ends are then independent to exp(-36)
REACH = 5.0  # a Gabor kernel ends at so many standard deviations, where it is 4e-6 of its maximum
BAND = 128  # rows of the grid that a thread fills at once


@dataclass(frozen=True)
class GaussianField:
    """An endless family of Gaussian height fields: the same number `k` always gives the same surface.

    size: nodes per side and period, a whole number. alpha_x, alpha_y: Beckmann's roughness (equal if alpha_y is omitted).
    correlation: cells per correlation length, l_x sqrt(alpha_x/alpha_y). root: seed of the family; surface k is drawn from
    SeedSequence(root, spawn_key=(k,)). corrected: facets have the alpha asked for; otherwise the smooth surface has it.
    """

    size: int
    alpha_x: float
    alpha_y: float | None = None
    correlation: float = 16.0
    root: int = 0
    corrected: bool = True

    def __post_init__(self) -> None:
        whole("size", self.size, 2)
        whole("root", self.root, 0)
        ax = positive("alpha_x", self.alpha_x)
        ay = ax if self.alpha_y is None else positive("alpha_y", self.alpha_y)
        for name, value in (("alpha_x", ax), ("alpha_y", ay), ("correlation", positive("correlation", self.correlation))):
            object.__setattr__(self, name, value)
        if self.corrected and self._rise(ax) * (ay / ax) ** 2 >= 1:
            raise ValueError(
                f"correlation must be larger for this anisotropy: no grid of unit cells has it, got {self.correlation}"
            )
        if self.size < PERIODS * max(self.lengths):
            raise ValueError(f"size must be at least {PERIODS:g} correlation lengths of {max(self.lengths):g}, got {self.size}")

    def _alphas(self) -> tuple[float, float]:
        assert self.alpha_y is not None
        return self.alpha_x, self.alpha_y

    def _rise(self, alpha_x: float) -> float:
        """1 - exp(-1/l_x^2), half the relative variance of a difference of neighbours along x."""
        ax, ay = self._alphas()
        return -math.expm1(-ax / ay / self.correlation**2)

    @cached_property
    def lengths(self) -> tuple[float, float]:
        """Correlation lengths (l_x, l_y) in cells."""
        ax, ay = self._alphas()
        along = self.correlation * math.sqrt(ay / ax)
        if not self.corrected:
            return along, along * ax / ay
        return along, 1 / math.sqrt(-math.log1p(-self._rise(ax) * (ay / ax) ** 2))

    @cached_property
    def sigma(self) -> float:
        """Root mean square height in cells."""
        ax, _ = self._alphas()
        return ax / 2 * (1 / math.sqrt(self._rise(ax)) if self.corrected else self.lengths[0])

    @cached_property
    def facet_alpha(self) -> tuple[float, float]:
        """Roughness (alpha_x, alpha_y) of the facets, exactly."""
        lx, ly = self.lengths
        return 2 * self.sigma * math.sqrt(-math.expm1(-(lx**-2))), 2 * self.sigma * math.sqrt(-math.expm1(-(ly**-2)))

    @cached_property
    def facet_correlation(self) -> float:
        """Coefficient of correlation between the two slopes of one facet, which comes from cutting all cells alike."""
        ax, ay = self.facet_alpha
        return -ax * ay / (2 * self.sigma) ** 2 / 2

    def autocovariance(self, dx: ArrayLike, dy: ArrayLike) -> Array:
        """Covariance of the heights of two points dx, dy cells apart, cells^2; shapes broadcast."""
        lx, ly = self.lengths
        product: Array = self.sigma**2 * self._wrapped(dx, lx) * self._wrapped(dy, ly)
        return product

    def _wrapped(self, distance: ArrayLike, length: float) -> Array:
        shift = np.asarray(distance, float)
        return np.sum([np.exp(-(((shift + turn * self.size) / length) ** 2)) for turn in (-1, 0, 1)], axis=0)

    def seed(self, k: int, *purpose: int) -> np.random.SeedSequence:
        """The seed of surface k, or of something else to be drawn for it."""
        return np.random.SeedSequence(self.root, spawn_key=(whole("k", k, 0), *purpose))

    def spectral(self, k: int) -> Array:
        """Heights of surface k, shape (size, size): white noise with the spectrum of the autocovariance. Exact at the nodes."""
        white = np.random.default_rng(self.seed(k)).standard_normal((self.size, self.size))
        across = np.arange(self.size)
        lx, ly = self.lengths
        gain_x, gain_y = (np.sqrt(np.maximum(scipy.fft.fft(self._wrapped(across, w)).real, 0)) for w in (lx, ly))
        waves = scipy.fft.rfft2(white, overwrite_x=True)
        waves *= gain_x[:, None]
        waves *= gain_y[None, : self.size // 2 + 1]
        heights: Array = scipy.fft.irfft2(waves, s=(self.size, self.size), overwrite_x=True)
        heights *= self.sigma
        return heights

    def gabor(self, k: int, density: float = 150.0) -> Array:
        """Heights of surface k, shape (size, size), by Gabor noise: Gaussians times waves of random frequency and phase.

        density: kernels in the area pi s_x s_y of a kernel's envelope; heights have the excess kurtosis 0.75/density.
        A kernel's envelope and the spread of its frequencies each give half of 1/l^2. lagae2009.
        """
        positive("density", density)
        envelope = tuple(w / math.sqrt(2) for w in self.lengths)
        area = math.pi * envelope[0] * envelope[1]
        count = max(1, round(density * self.size**2 / area))
        rng = np.random.default_rng(self.seed(k, 0))
        kernels = np.empty((count, 5))
        kernels[:, :2] = rng.uniform(0, self.size, (count, 2))
        kernels[:, 2:4] = rng.standard_normal((count, 2)) / self.lengths
        kernels[:, 4] = rng.uniform(0, 2 * math.pi, count)
        kernels = kernels[np.argsort(kernels[:, 0], kind="stable")]
        heights = np.zeros((self.size, self.size))
        nodes = [min(2 * math.ceil(REACH * w) + 1, self.size) for w in envelope]
        jobs: list[tuple[Any, ...]]
        jobs = [
            (heights, first, min(first + BAND, self.size), kernels, *envelope, *(np.empty((2, w)) for w in nodes))
            for first in range(0, self.size, BAND)
        ]
        parallel_map(_splat, jobs)
        heights *= self.sigma * math.sqrt(2 * self.size**2 / (count * area))
        return heights


_bare = compiled(nogil=True, _nrt=False)  # no counting of references in the inner loops


@_bare
def _splat(
    z: Array, first: int, last: int, kernels: Array, sx: float, sy: float, rows: Array, columns: Array
) -> None:  # pragma: no cover - compiled
    """Add to the rows first..last-1 of z all kernels (x, y, frequency_x, frequency_y, phase), in their order."""
    n = z.shape[0]
    half_x, half_y = rows.shape[1] // 2, columns.shape[1] // 2
    for k in range(kernels.shape[0]):
        x, y = kernels[k, 0], kernels[k, 1]
        if _gap(x, first, last, n) > half_x:
            continue
        i0, j0 = math.floor(x) - half_x, math.floor(y) - half_y
        _wave(rows, i0 - x, sx, kernels[k, 2], kernels[k, 4])
        _wave(columns, j0 - y, sy, kernels[k, 3], 0.0)
        for a in range(rows.shape[1]):
            i = (i0 + a) % n
            if first <= i < last:
                _add_row(z, i, j0 % n, columns, rows[0, a], rows[1, a])


@_bare
def _wave(wave: Array, away: float, s: float, f: float, phase: float) -> None:  # pragma: no cover - compiled
    """exp(-r^2/(2 s^2)) times cos and sin of f r + phase at r = away, away + 1, ...: each value from the one before it."""
    value = math.exp(-0.5 * (away / s) ** 2) * complex(math.cos(f * away + phase), math.sin(f * away + phase))
    step = math.exp(-(away + 0.5) / s**2) * complex(math.cos(f), math.sin(f))
    change = math.exp(-1 / s**2)
    for b in range(wave.shape[1]):
        wave[0, b], wave[1, b] = value.real, value.imag
        value *= step
        step *= change


@_bare
def _gap(x: float, first: int, last: int, n: int) -> float:  # pragma: no cover - compiled
    """Least distance on a circle of length n from x to the whole numbers first..last-1."""
    if first <= x <= last - 1:
        return 0.0
    return min((first - x) % n, (x - (last - 1)) % n)


@_bare
def _add_row(z: Array, i: int, start: int, wave: Array, c: float, s: float) -> None:  # pragma: no cover - compiled
    """Add the real part of (c + i s) times a wave to row i, from the column `start` on; the row is periodic."""
    count, n = wave.shape[1], z.shape[1]
    before = min(count, n - start)
    for b in range(before):
        z[i, start + b] += c * wave[0, b] - s * wave[1, b]
    for b in range(before, count):
        z[i, start + b - n] += c * wave[0, b] - s * wave[1, b]
