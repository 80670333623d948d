"""Ways to shade a picture: one sample of a pixel, from its normal and two uniform numbers to the light it brings.

A sphere of metal is seen along z under a sky with two broad lights. A sample turns the view into the surface's frame, draws a
light direction, and looks up the light that comes from there; this is what is timed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import exp, sqrt
from typing import Any

import numpy as np
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Pair, Vector
from microfacet.visibility.masking import ModelParameters

from benchmarks.method import Method, uniform
from benchmarks.rivals_estimate import SAMPLERS, Sampler, kernel_of

ALPHAS = (0.3, 0.3)


def light(x: float, y: float, z: float) -> float:
    """Radiance from a direction, y up: a sky that darkens to the ground, a light at the left above and one behind."""
    sky = 0.15 + 0.35 / (1.0 + exp(-6.0 * y))
    return (
        sky
        + 2.5 * exp(9.0 * (-0.62 * x + 0.62 * y + 0.48 * z - 1.0))
        + 3.0 * exp(12.0 * (0.83 * x + 0.29 * y - 0.48 * z - 1.0))
    )


@cache
def shading(sampler: Sampler) -> Batch:
    """The light that samples bring (n,), from normals (n, 3) of a sphere and uniform numbers (n, 2)."""
    estimate = kernel_of(sampler)

    def shaded(normal: Vector, u: Pair, p: ModelParameters) -> float:
        x, y, z = normal
        length = sqrt(x * x + z * z)
        ax, az = z / length, -x / length
        bx, by, bz = y * az, z * ax - x * az, -y * ax
        ix, iy, iz, weight = estimate((az, bz, z), u, p)
        return weight * light(ix * ax + iy * bx + iz * x, iy * by + iz * y, ix * az + iy * bz + iz * z)

    return Batch(shaded, [3, 2])


def sphere(side: int) -> tuple[np.ndarray, np.ndarray]:
    """Normals (n, 3) of a sphere's pixels that face the viewer, and which pixels of a square (side, side) they are."""
    across = ((np.arange(side) + 0.5) / side * 2 - 1) * 1.02
    x, y = np.meshgrid(across, -across)
    inside = x * x + y * y < 0.999
    x, y = x[inside], y[inside]
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)], -1), inside


def _method(sampler: Sampler) -> Method:
    parameters = sampler.model(*ALPHAS).parameters

    def prepare(size: int) -> Callable[[], Any]:
        normal, u = sphere(int(np.sqrt(size)))[0], uniform(size, 6)
        normal = np.resize(normal, (size, 3))
        return lambda: shading(sampler)([normal, u], parameters)

    return Method(f"{sampler.label}, a sample of a pixel", prepare, lambda size: np.nan, (10**6,), (shading(sampler),))


METHODS = {name: _method(SAMPLERS[sampler]) for name, sampler in {"normals": "normals", "visible": "caps"}.items()}
