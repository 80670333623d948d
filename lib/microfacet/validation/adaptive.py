"""The visible area of a surface with any function as its distribution of normals, with a bound of its error.

Nothing is known of the function: neither its shape nor its scale. Slopes are divided by how far they spread along each axis,
and rings around the origin are followed in polar coordinates: whole rings as far as the edge of visibility, a straight line,
then the arcs of a ring on this side of it, cut where V-cavities begin to mask. A function of the polar angle only, a table
for instance, has its kinks on rings; halving closes in on them. A survey of slopes of all sizes shows where the function
changes between neighbours: there the nodes of the first boxes of radius and azimuth lie as close. Boxes are then halved, those
of the largest errors first, in the direction of the error. Each round is one call of the function.

The outermost nodes of a box lie on its edges, so that no jump is between two boxes. The error follows from the decay of the
coefficients of each box's polynomials, plus the error that a jump beside the box may cause.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

from microfacet.directions import as_vectors, positive, whole
from microfacet.geometry.panels import halves
from microfacet.geometry.slopes import Distribution, spread

Function = Callable[[np.ndarray], np.ndarray]

ROUNDING = 1e-13  # relative, of a sum
STARTS = np.array([0.0, 0.6, 1.5, 3.0, 8.0])  # radii, in scales, where first boxes begin
APART = np.array([1.0, 6.0, 36.0, 216.0])  # and in units of a near edge of visibility, where arcs change within its distance
FARTHEST = 1e12  # an edge of visibility beyond this radius, in scales, is ignored
ROUNDS = 60
WORTH = 0.1  # of the largest error: boxes of smaller errors wait for a later round

NODES, GROUP = 17, 4  # in each direction of a box; coefficients of one group
INSIDE = 1e-13  # from the ends of coordinates, where slopes are infinite and normals at right angles to the view
ERROR_FACTOR = (
    1.5  # times the estimate from coefficients: this bounds the error of jumps, bends, ramps, bumps and poles anywhere
)
FALL = 4.0, 3  # ratio of one group of coefficients to the next that counts as decay; power of any excess over it
BESIDE = 0.02  # of the error per area of neighbours: a corner of a jump there may lie between a box's nodes
OUTSIDE = 0.55  # of a box's side, from its middle: the neighbours lie there
WHOLE = 2.0  # logarithm of radii beyond which boxes count as if it were this
GROWN = 1.5  # times as many boxes, until neighbours are examined again

SURVEY = (-5, 4)  # decades of radii surveyed, in scales
PER_DECADE, SURVEY_AZIMUTHS, FINER = 26, 80, 4  # radii and azimuths surveyed; their factor where facets are missing
MISSING = 1e-3  # of the area of all facets
UNEVEN = 0.25  # second difference over the largest of its values: above it the function is unresolved
FACETS = 1e-15  # of all facets: fewer near a point do not need small boxes
AROUND = 1, 2, 3  # steps by which uneven places are widened, one after the other: the function is uneven beside them too
CELLS = 10  # of the survey, the most that a box may span where the function is uneven


class Area(NamedTuple):
    """A visible area over cos theta_o, a bound of its error, and the number of evaluations."""

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
    r"""Visible projected area of any distribution, by adaptive quadrature.

    .. math:: \frac{1}{\cos\theta_o} \int_{\Omega} G_1(\omega_o, \omega_m)
              \left\langle \omega_o, \omega_m \right\rangle D(\omega_m) \, d\omega_m

    It is 1 for a physical model. Without G1 it is :math:`1 + \Lambda(\omega_o)` of Smith's model and, from straight above,
    the projected area of all microfacets. D and G1 may jump and bend anywhere.

    Parameters
    ----------
    D : Distribution or callable
        A distribution, or a function of unit normals (n, 3) above the horizon that gives (n,), 1/sr.
    wo : array_like, shape (3,), optional
        View direction above the horizon, a unit vector; by default straight above.
    G1 : callable, optional
        Masking, a function of normals like D; by default 1.
    tolerance : float, optional
        Relative error to reach, above 0.
    most : int, optional
        Number of evaluations after which the error is given as it is.
    scale : tuple of float, optional
        Spread of the slopes along x and y, above 0; by default it is found from D.

    Returns
    -------
    Area
        A named tuple of ``value``, ``error`` and ``evaluations``. The error is a bound if D and G1 have no feature
        narrower than a sixth of its distance from the origin, in slopes over the scales, which are tested from 1e-5 to 1e4.

    Raises
    ------
    ValueError
        For a direction that is not above the horizon, for other numbers, and where D or G1 is not finite.

    References
    ----------
    heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> area = mf.seen_area(mf.GGX(0.5), [0.6, 0.0, 0.8])
    >>> print(f"{area.value:.10f} {1 + mf.GGX(0.5).Lambda([0.6, 0.0, 0.8]):.10f}")
    1.0340002341 1.0340002341
    """
    view = as_vectors("wo", wo)
    if view.shape != (3,) or not view[2] > 0:
        raise ValueError(f"wo must be one direction above the horizon, got {wo!r}")
    if isinstance(D, Distribution):
        D.require_numbers("seen_area")
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
        """The first boxes, rows (region, low, high, first, last): ends along the radius' coordinate, fractions of the arc."""
        last = self.edge / (1 + self.edge) if self.edge < np.inf else 1.0
        starts = STARTS / (1 + STARTS)
        rows = [(0, *ends, first, first + 0.5) for ends in pairwise([*starts[starts < last], last]) for first in (0.0, 0.5)]
        if self.edge < np.inf:
            near = self.edge * APART
            lengths = np.concatenate([[0.0], near[near < STARTS[1]], STARTS[1:]])
            outer = [*(lengths / (1 + lengths)), 1.0]
            rows += [(region, *ends, 0.0, 1.0) for region in (1, 2, 3) for ends in pairwise(outer)]
        return np.array(rows)

    def place(self, radius: np.ndarray, azimuth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Region, radial coordinate and fraction of the arc of visible slopes, by radius and azimuth from the view's."""
        edge, azimuth = self._edge, azimuth % (2 * np.pi)
        length = np.sqrt(np.maximum(radius * radius - edge * edge, 0))
        begin = np.arctan2(length, edge)
        region = np.select([radius <= self.edge, np.abs(azimuth - np.pi) < begin, azimuth < np.pi], [0, 3, 1], default=2)
        start, arc = self._arcs(region, begin)
        length = np.where(region == 0, radius, length)
        fraction = (azimuth - start) / np.where(arc > 0, arc, 1.0)
        return region, length / (self._unit(region) + length), fraction

    def at(self, region: np.ndarray, along: np.ndarray, fraction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Radius and azimuth from the view's."""
        length, radius = self._lengths(region, np.clip(along, 0, 1 - INSIDE))
        start, arc = self._arcs(region, np.arctan2(length, self._edge))
        return radius, start + fraction * arc

    def extents(self, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of each box the logarithm of its outer over its inner radius, and the angle in its middle."""
        region, low, high, first, last = boxes.T
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(self._lengths(region, high)[1]) - np.log(self._lengths(region, low)[1])
        length = self._lengths(region, (low + high) / 2)[0]
        return ratio, self._arcs(region, np.arctan2(length, self._edge))[1] * (last - first)

    @property
    def _edge(self) -> float:
        return self.edge if self.edge < np.inf else 1.0

    def _unit(self, region: np.ndarray) -> np.ndarray:
        return np.where(region == 0, 1.0, max(1.0, self._edge))

    def _lengths(self, region: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The length that the coordinate stands for, along rings' radius or along the edge, and the radius there."""
        with np.errstate(divide="ignore"):
            length = self._unit(region) * along / (1 - along)
        return length, np.where(region == 0, length, np.hypot(self._edge, length))

    @staticmethod
    def _arcs(region: np.ndarray, begin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where the arc of a region starts, from the view's azimuth, and its length."""
        start = np.select([region == 0, region == 1, region == 2], [0.0, begin, np.pi + begin], np.pi - begin)
        return start, np.select([region == 0, region == 3], [2 * np.pi, 2 * begin], np.pi - 2 * begin)

    def __call__(self, region: np.ndarray, along: np.ndarray, fraction: np.ndarray) -> np.ndarray:
        """The integrand, over cos theta_o, with the stretch of its coordinates; shapes (n, 1, 1), (n, i, 1), (n, 1, j)."""
        along, fraction = np.minimum(along, 1 - INSIDE), np.clip(fraction, INSIDE, 1 - INSIDE)
        length, radius = self._lengths(region, along)
        stretch = self._unit(region) / (1 - along) ** 2 * length * self.scale.prod()
        start, arc = self._arcs(region, np.arctan2(length, self._edge))
        azimuth = (self.azimuth + start) + fraction * arc
        x, y = (self.scale[0] * radius) * np.cos(azimuth), (self.scale[1] * radius) * np.sin(azimuth)
        m, z = _normals(x, y)
        density = self.normals(m) if self.G1 is None else self.normals(m) * self.G1(m)
        facing = np.maximum(1 - (x * (self.view[0] / self.view[2]) + y * (self.view[1] / self.view[2])), 0)
        return np.asarray(facing * _finite(density).reshape(x.shape) * (z * z) ** 2 * (stretch * arc))


def _finite(values: Any) -> np.ndarray:
    values = np.asarray(values)
    if not np.isfinite(values).all():
        raise ValueError(f"D and G1 must be finite at all normals, got {values[~np.isfinite(values)][0]}")
    return values


def _normals(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normals (n, 3) of slopes, and their z in the shape of these."""
    m = np.empty((*x.shape, 3))
    z = np.divide(1, np.sqrt(1 + x * x + y * y), out=m[..., 2])
    np.multiply(x, -z, out=m[..., 0])
    np.multiply(y, -z, out=m[..., 1])
    return m.reshape(-1, 3), z


# --- a survey of all sizes ----------------------------------------------------------------------------------------------


def _first_boxes(integrand: _Rings, finer: int = 1) -> np.ndarray:
    """First boxes, no wider than a few steps of a survey where the function is uneven from step to step."""
    steps = np.log(10) / (finer * PER_DECADE), 2 * np.pi / (finer * SURVEY_AZIMUTHS)
    radius = 10.0 ** np.arange(*SURVEY, 1 / (finer * PER_DECADE))
    azimuth = (np.arange(finer * SURVEY_AZIMUTHS) + 0.5) * steps[1]
    x, y = (
        scale * np.outer(radius, f(azimuth + integrand.azimuth))
        for scale, f in zip(integrand.scale, (np.cos, np.sin), strict=True)
    )
    m, z = _normals(x, y)
    facets = _finite(integrand.normals(m)).reshape(x.shape) * (z * z) ** 2 * (radius * radius)[:, None]
    area = float(facets.sum()) * steps[0] * steps[1] * float(integrand.scale.prod())
    if finer == 1 and not abs(area - 1) < MISSING:
        return _first_boxes(integrand, FINER)
    facing = 1 - np.outer(radius, np.cos(azimuth)) / integrand.edge
    uneven = _uneven(facets, np.ones(x.shape))
    if integrand.G1 is not None:
        parts = np.select([facing <= 0, facing <= 2], [0, 1], 2)  # hidden; visible; and masked by V-cavities
        visible = facets * np.maximum(facing, 0)
        visible[parts > 0] *= _finite(integrand.G1(m[parts.ravel() > 0]))
        uneven = [one | other for one, other in zip(uneven, _uneven(visible, parts), strict=True)]
    boxes = integrand.boxes()
    for side, here in enumerate(uneven):
        ring, ray = np.nonzero(here & (facing > 0))
        boxes = _small(integrand, boxes, side, CELLS * steps[side], integrand.place(radius[ring], azimuth[ray]))
    return boxes


def _uneven(values: np.ndarray, parts: np.ndarray) -> list[np.ndarray]:
    """Masks of uneven values within one part, along rays and along rings, and of their neighbours. Part 0 does not count."""
    least = FACETS * np.abs(values).sum()
    uneven = []
    for axis in (0, 1):
        (before, part), (after, other) = (tuple(np.roll(array, step, axis) for array in (values, parts)) for step in (1, -1))
        largest = np.maximum(np.maximum(np.abs(before), np.abs(after)), np.abs(values))
        there = (np.abs(before + after - 2 * values) > UNEVEN * largest) & (largest > least)
        there &= (parts > 0) & (part == parts) & (other == parts)
        if axis == 0:
            there[[0, -1]] = False
        for side in (0, 1):
            for step in AROUND:
                there = there | np.roll(there, step, side) | np.roll(there, -step, side)
        uneven.append(there)
    return uneven


def _small(integrand: _Rings, boxes: np.ndarray, side: int, most: float, points: tuple[np.ndarray, ...]) -> np.ndarray:
    """Boxes that hold one of the points and are wider than `most` along one side, halved until none is."""
    region, along, fraction = points
    while True:
        wide = np.flatnonzero(integrand.extents(boxes)[side] > most)
        of, low, high, first, last = boxes[wide].T[:, :, None]
        inside = (of == region) & (low <= along) & (along <= high) & (first <= fraction) & (fraction <= last)
        wide = wide[inside.any(axis=1)]
        if not len(wide):
            return boxes
        boxes = np.concatenate([np.delete(boxes, wide, axis=0), halves(boxes[wide], np.full(len(wide), side == 1))])


# --- sums over boxes ----------------------------------------------------------------------------------------------------


@cache
def _rule() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss-Lobatto nodes on (0, 1), their weights, and the map to the last orthonormal Legendre coefficients."""
    inner = legendre.Legendre.basis(NODES - 1).deriv().roots()
    nodes = np.concatenate([[-1.0], np.sort(inner.real), [1.0]])
    expansion = np.linalg.inv(legendre.legvander(nodes, NODES - 1))
    last = np.arange(NODES - 3 * GROUP, NODES)
    return (1 + nodes) / 2, expansion[0], expansion[last] / np.sqrt(2 * last + 1)[:, None]


def _falling(values: np.ndarray) -> np.ndarray:
    """Error of the mean of the polynomials through values (n, NODES, j), from the decay of their coefficients: (n, j).

    A jump or a bend anywhere between the outermost nodes leaves coefficients that do not decay and exceed the error. The error
    is far smaller only where two successive groups of coefficients are each far below the one before, as in smooth functions.
    """
    coefficients = _rule()[2] @ values
    one, two, three = np.sqrt(np.square(coefficients).reshape(len(values), 3, GROUP, -1).sum(axis=2)).swapaxes(0, 1)
    tiny = np.finfo(float).tiny
    ratio = FALL[0] * np.maximum(three / np.maximum(two, tiny), two / np.maximum(one, tiny))
    return np.asarray(ERROR_FACTOR * np.maximum(two, three) * np.minimum(1, ratio) ** FALL[1])


def _integrate(integrand: _Rings, boxes: np.ndarray) -> np.ndarray:
    """Integral of each box, and its errors along the radius and along the arc: (n, 3)."""
    nodes, weights, _ = _rule()
    region, low, high, first, last = boxes.T[:, :, None, None]
    values = integrand(region, low + (high - low) * nodes[:, None], first + (last - first) * nodes)
    sums = [(values @ weights) @ weights, _falling(values) @ weights, _falling(values.swapaxes(1, 2)) @ weights]
    return np.asarray(np.stack(sums, axis=1) * ((high - low) * (last - first))[:, :, 0])


def _beside(integrand: _Rings, boxes: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Error of each box from a jump beside it: a corner of the jump may lie between the box's nodes."""
    ratio, angle = integrand.extents(boxes)
    size = np.minimum(ratio, WHOLE) * angle
    density = errors / size
    chosen = BESIDE * density * size.max() > WORTH * errors.max()
    region, low, high, first, last = boxes[chosen].T
    middle, centre = (low + high) / 2, (first + last) / 2
    aside, around = OUTSIDE * (high - low), OUTSIDE * (last - first)
    points = [integrand.at(region, middle + u * aside, centre + v * around) for u, v in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    of, along, fraction = np.concatenate([integrand.place(*point) for point in points], axis=1)
    there = np.tile(density[chosen], len(points))
    reached = np.zeros(len(boxes))
    for k, (region, low, high, first, last) in enumerate(boxes):
        inside = (of == region) & (low <= along) & (along <= high) & (first <= fraction) & (fraction <= last)
        reached[k] = np.max(there, initial=0.0, where=inside)
    return BESIDE * reached * size


def _refined(integrand: _Rings, tolerance: float, most: int) -> Area:
    """Halve boxes until the errors of all add up to the tolerance."""
    boxes = _first_boxes(integrand)
    sums, beside, known = _integrate(integrand, boxes), np.zeros(len(boxes)), 0
    each = NODES**2
    used = len(boxes) * each
    for _ in range(ROUNDS):
        errors = sums[:, 1:].sum(axis=1)
        goal = tolerance * abs(sums[:, 0].sum())
        left = (most - used) // (2 * each)
        if errors.sum() <= goal or left <= 0 or len(boxes) > GROWN * known:
            beside, known = _beside(integrand, boxes, errors), len(boxes)
        errors = errors + beside
        order = np.argsort(-errors)
        remaining = np.cumsum(errors[order][::-1])[::-1]  # of this box and all of smaller errors
        wanted = min(int(np.sum((remaining > goal / 2) & (errors[order] > WORTH * errors.max()))), left)
        if errors.sum() <= goal or wanted <= 0:
            break
        halved, rest = order[:wanted], order[wanted:]
        children = halves(boxes[halved], sums[halved, 1] < sums[halved, 2])
        boxes = np.concatenate([boxes[rest], children])
        sums = np.concatenate([sums[rest], _integrate(integrand, children)])
        beside = np.concatenate([beside[rest], np.zeros(len(children))])
        used += len(children) * each
    value, size = float(sums[:, 0].sum()), float(np.abs(sums[:, 0]).sum())
    return Area(value, float(errors.sum() + ROUNDING * size), used)
