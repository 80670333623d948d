"""The area that a direction sees of a surface whose distribution of normals is any function, with an error estimate.

Nothing is known of the function: neither its shape nor its scale. A coarse look at slopes of all sizes tells how far they
spread along each axis. In slopes divided by these, rings around the origin are followed in polar coordinates: whole rings
as far as the edge of visibility, a straight line, then the arcs of a ring on this side of it, cut where V-cavities begin
to mask. A function of the polar angle only, a table for instance, has its kinks on rings; halving closes in on them.
Boxes of radius and azimuth are halved, those of the largest errors first, in the direction that the error comes from.
Each round is one call of the function.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from microfacet.directions import as_vectors, positive, whole
from microfacet.geometry.panels import NODES, falling, halves, rule
from microfacet.geometry.slopes import Distribution, spread

Function = Callable[[np.ndarray], np.ndarray]

ROUNDING = 1e-13  # relative, of what is summed
NEAR = 8.0  # radius, in scales, up to which it is the coordinate; beyond, its inverse is
STARTS = (0.0, 0.06, 0.15, 0.3, 0.6, 1.0, 2.0)  # first boxes' ends along the coordinate of the radius
APART = np.array([1.0, 6.0, 36.0, 216.0])  # and in units of a near edge of visibility, where arcs change within its distance
FARTHEST = 1e12  # an edge of visibility beyond this radius, in scales, is none
ROUNDS = 60
WORTH = 0.1  # of the largest error: boxes of less wait for another round


class Area(NamedTuple):
    """An area seen, over cos theta_o; the estimate of its error, not proved; how often the function was evaluated."""

    value: float
    error: float
    evaluations: int


def seen_area(
    D: Distribution | Function,
    wo: Any = (0.0, 0.0, 1.0),
    G1: Function | None = None,
    tolerance: float = 1e-12,
    most: int = 40000,
    scale: tuple[float, float] | None = None,
) -> Area:
    """The integral of G1 <wo, wm> D over all normals, over cos theta_o; by default what is seen if nothing masks.

    D: a distribution, or any function of unit normals (n, 3), z > 0, that gives (n,), 1/sr. wo: one view direction (3,) above
    the horizon. G1: masking, a function of normals too; None for 1. With it the area is 1 for a physical model; without, it
    is 1 + Lambda of Smith's model, and from straight above the projected area of all facets. tolerance: the relative
    error to reach, above 0, unless that takes more than about `most` evaluations: then the error is told as it is. scale:
    how far slopes spread along x and y, above 0, if known. A feature between the slopes looked at, some four to a decade
    along each axis, can be missed if it is narrower than their distance. ValueError for a direction not above the horizon,
    for other numbers than these, and where D or G1 is no function or not finite. heitz2014.
    """
    view = as_vectors("wo", wo)
    if view.shape != (3,) or not view[2] > 0:
        raise ValueError(f"wo must be one direction above the horizon, got {wo!r}")
    normals = D.D if isinstance(D, Distribution) else D
    if not callable(normals):
        raise ValueError(f"D must be a distribution such as GGX(0.3) or a function of normals, got {D!r}")
    if not (G1 is None or callable(G1)):
        raise ValueError(f"G1 must be None or a function of normals, got {G1!r}")
    tolerance, most = positive("tolerance", tolerance), whole("most", most, 1)
    if scale is not None:
        scale = _two(scale)
    scales = scale or (D.slope_scale if isinstance(D, Distribution) else spread(normals))
    return _refined(_Rings(normals, G1, view, scales), tolerance, most)


def _two(scale: Any) -> tuple[float, float]:
    """The argument as two numbers above 0; anything else is a ValueError."""
    try:
        x, y = scale
    except (TypeError, ValueError):
        raise ValueError(f"scale must be two numbers above 0, got {scale!r}") from None
    return positive("scale", x), positive("scale", y)


class _Rings:
    """The integrand over boxes of four regions: whole rings, arcs on either side of the view's azimuth, arcs opposite."""

    def __init__(self, normals: Function, G1: Function | None, view: np.ndarray, scale: tuple[float, float]) -> None:
        self.normals, self.G1, self.view, self.scale = normals, G1, view, np.array(scale)
        lean = view[:2] * self.scale
        across = float(np.hypot(*lean))
        self.azimuth = float(np.arctan2(lean[1], lean[0]))
        self.edge = float(view[2]) / across if across * FARTHEST > view[2] else np.inf

    def boxes(self) -> np.ndarray:
        """The first boxes, rows (region, low, high, first, last): ends along the radius' coordinate, shares of the arc."""
        last = self._coordinate(self.edge)
        inner = [*(start for start in STARTS if start < last), last]
        rows = [(0, *ends, first, first + 0.5) for ends in pairwise(inner) for first in (0.0, 0.5)]
        if self.edge < np.inf:
            near = [start for start in self.edge / NEAR * APART if start < STARTS[1]]
            outer = list(pairwise([0.0, *near, *STARTS[1:]]))
            rows += [(region, *ends, 0.0, 1.0) for region in (1, 2, 3) for ends in outer]
        return np.array(rows)

    @staticmethod
    def _coordinate(radius: float) -> float:
        return radius / NEAR if radius <= NEAR else 2 - NEAR / radius

    def __call__(self, region: np.ndarray, along: np.ndarray, share: np.ndarray) -> np.ndarray:
        """The integrand, over cos theta_o, with the stretch of its coordinates; shapes (n, 1, 1), (n, i, 1), (n, 1, j)."""
        edge = self.edge if self.edge < np.inf else 1.0
        unit = NEAR * np.where(region == 0, 1.0, max(1.0, edge / NEAR))
        inverse = 1 / np.where(along > 1, 2 - along, 1.0)
        length = unit * np.where(along > 1, inverse, along)
        stretch = unit * inverse * inverse * length * self.scale.prod()
        radius = np.where(region == 0, length, np.hypot(edge, length))
        begin = np.arctan2(length, edge)
        arc = np.select([region == 0, region == 3], [2 * np.pi, 2 * begin], np.pi - 2 * begin)
        start = np.select([region == 0, region == 1, region == 2], [0.0, begin, np.pi + begin], np.pi - begin)
        turn = (self.azimuth + start) + share * arc
        x, y = (self.scale[0] * radius) * np.cos(turn), (self.scale[1] * radius) * np.sin(turn)
        m = np.empty((*x.shape, 3))
        z = np.divide(1, np.sqrt(1 + x * x + y * y), out=m[..., 2])
        np.multiply(x, -z, out=m[..., 0])
        np.multiply(y, -z, out=m[..., 1])
        flat = m.reshape(-1, 3)
        density = np.asarray(self.normals(flat) if self.G1 is None else self.normals(flat) * self.G1(flat))
        if not np.isfinite(density).all():
            raise ValueError(f"D and G1 must be finite at all normals, got {density[~np.isfinite(density)][0]}")
        facing = np.maximum(1 - (x * (self.view[0] / self.view[2]) + y * (self.view[1] / self.view[2])), 0)
        return np.asarray(facing * density.reshape(x.shape) * (z * z) ** 2 * (stretch * arc))


def _integrate(integrand: _Rings, boxes: np.ndarray) -> np.ndarray:
    """Of each box its integral and the errors of it along the radius and along the arc: (n, 3)."""
    nodes, weights, functionals = rule()
    region, low, high, first, last = boxes.T[:, :, None, None]
    values = integrand(region, low + (high - low) * nodes[:, None], first + (last - first) * nodes)
    sums = np.stack(
        [
            (values @ weights) @ weights,
            falling(functionals.T @ values) @ weights,
            falling(functionals.T @ values.swapaxes(1, 2)) @ weights,
        ],
        axis=1,
    )
    return np.asarray(sums * ((high - low) * (last - first))[:, :, 0])


def _refined(integrand: _Rings, tolerance: float, most: int) -> Area:
    """Halve boxes until the errors of all add up to the tolerance."""
    boxes = integrand.boxes()
    sums = _integrate(integrand, boxes)
    each = NODES**2
    used = len(boxes) * each
    for _ in range(ROUNDS):
        errors = np.abs(sums[:, 1:]).sum(axis=1)
        goal = tolerance * abs(sums[:, 0].sum())
        order = np.argsort(-errors)
        remaining = np.cumsum(errors[order][::-1])[::-1]  # of this box and all of smaller errors
        wanted = min(int(np.sum((remaining > goal / 2) & (errors[order] > WORTH * errors.max()))), (most - used) // (2 * each))
        if errors.sum() <= goal or wanted <= 0:
            break
        halved = order[:wanted]
        children = halves(boxes[halved], np.abs(sums[halved, 1]) < np.abs(sums[halved, 2]))
        kept = order[wanted:]
        boxes = np.concatenate([boxes[kept], children])
        sums = np.concatenate([sums[kept], _integrate(integrand, children)])
        used += len(children) * each
    value = float(sums[:, 0].sum())
    return Area(value, float(np.abs(sums[:, 1:]).sum() + ROUNDING * abs(value)), used)
