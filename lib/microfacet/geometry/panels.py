"""Where a distribution of slopes is: panels of slope space, small where it changes, each with its share of the facets.

Nothing is known of the distribution but its values. Slopes in units of a scale are mapped to five squares: those up to one
scale along both axes as they are, those beyond by the inverse of the larger one. Each map takes straight lines to straight
lines, so that the edge of visibility, a line in slopes, cuts a panel in a trapezoid. A look at many points finds lobes that lie
between the nodes of the first panels; panels are halved where the error comes from until all of it is small.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

NODES, LAST = 14, 4  # in each direction of a panel; coefficients that tell the error
GOAL = 2e-13  # what all errors may add up to, of the whole
MOST, ROUNDS = 1_500_000, 100  # evaluations of the distribution; rounds of halving
WORTH = 1e-3  # of the largest error: panels of less wait for another round
LOOKS, CLOSER = 40, 160  # points looked at along each side of a first panel, and where area is missing
UNLIKE = 30.0  # a panel that differs by so many times its last coefficients from its polynomial has more in it
ERRORS, DOUBTS = slice(3, 6), 5  # among the sums of a panel
DOUBT = 1e-3  # of what is apart
INSIDE = 1e-6  # of a panel's side: slopes are infinite at an edge
STRIPED = 4.0  # how many times more a density changes along one side of a panel than along the other for it to have stripes
MISSING = 1e-9  # area not found for which a closer look is taken
ENOUGH = 1e-14  # of the whole: what a panel may be off by where fewer nodes are taken

# X, Y and W as sums of 1, u and v for each square: the slopes are X/W and Y/W in units of the scale
SQUARES = (
    ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    ((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
)
_SQUARES = np.array(SQUARES)
INNER, OUTER = 8, 4  # first panels along each side of the square of small slopes, and along the others

Function = Callable[[np.ndarray], np.ndarray]


class Panels(NamedTuple):
    """Panels of slope space. scale: the two slopes that are 1 in the squares. boxes: (n, 5), square and ends along u and v.

    moments: (n, 3), of each panel the area of its facets' projection and the integrals of both slopes over it. errors: (n,),
    of these, where a slope counts in units of the scale. degrees: (n,), of the polynomials in u and v that suffice.
    evaluations: how often D was evaluated. closest: the distance of points in the finest look, in units of the scale.
    """

    scale: tuple[float, float]
    boxes: np.ndarray
    moments: np.ndarray
    errors: np.ndarray
    degrees: np.ndarray
    evaluations: int
    closest: float

    @property
    def area(self) -> float:
        """The projected area of all facets: 1 for a distribution of normals."""
        return float(self.moments[:, 0].sum())

    @property
    def error(self) -> float:
        """Estimated, of the area and of the integrals of slopes in units of the scale."""
        return float(self.errors.sum())


def slopes_at(square: np.ndarray, u: np.ndarray, v: np.ndarray, scale: tuple[float, float]) -> tuple[np.ndarray, ...]:
    """X, Y and W at points of the squares: the slopes there are X/W and Y/W."""
    rows = _SQUARES[square.astype(int)]
    x, y, w = (rows[..., k, 0] + rows[..., k, 1] * u + rows[..., k, 2] * v for k in range(3))
    return scale[0] * x, scale[1] * y, w


def density_at(D: Function, x: np.ndarray, y: np.ndarray, w: np.ndarray, scale: tuple[float, float]) -> tuple[np.ndarray, Any]:
    """The normals (..., 3) of slopes (x/w, y/w), and the density of slopes per area of the squares."""
    length = np.sqrt(x * x + y * y + w * w)
    normals = np.empty((*length.shape, 3))
    np.divide(-x, length, out=normals[..., 0])
    np.divide(-y, length, out=normals[..., 1])
    np.divide(w, length, out=normals[..., 2])
    values = np.asarray(D(normals.reshape(-1, 3))).reshape(length.shape)
    if not np.isfinite(values).all():
        at = normals[~np.isfinite(values)][0]
        raise ValueError(f"D must be finite at all normals, got {values[~np.isfinite(values)][0]} at {tuple(at.tolist())}")
    square = length * length
    return normals, values * w * (scale[0] * scale[1]) / (square * square)


@cache
def rule(count: int = NODES) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes on (0, 1), their weights, and the functionals that give the last 8 coefficients of the
    interpolating polynomial in orthonormal Legendre polynomials: (nodes, 8)."""
    nodes, weights = legendre.leggauss(count)
    normal = np.sqrt(2 * np.arange(count) + 1)
    functionals = legendre.legvander(nodes, count - 1) * normal * weights[:, None] / 2
    return (nodes + 1) / 2, weights / 2, functionals[:, -2 * LAST :]


@cache
def _expansion() -> np.ndarray:
    """What gives the coefficients in orthonormal Legendre polynomials on (0, 1), (NODES, NODES)."""
    nodes, weights, _ = rule()
    return np.asarray(legendre.legvander(2 * nodes - 1, NODES - 1) * np.sqrt(2 * np.arange(NODES) + 1) * weights[:, None])


def expanded(values: np.ndarray) -> np.ndarray:
    """Coefficients of the polynomials through values at all pairs of nodes, (n, NODES, NODES)."""
    return np.asarray(_expansion().T @ values @ _expansion())


def _beyond(coefficients: np.ndarray) -> np.ndarray:
    """The norm of what is of at least each degree along either side, (n, NODES)."""
    square = np.square(coefficients)
    degree = np.maximum(*np.indices((NODES, NODES)))
    return np.sqrt(np.stack([np.where(degree >= d, square, 0).sum(axis=(1, 2)) for d in range(NODES)], axis=1))


def falling(coefficients: np.ndarray) -> np.ndarray:
    """How far the integral of a polynomial through all nodes may be off, from how its coefficients fall: (n, 8, j) -> (n, j).

    Where the last four are not far below the four before them, as by a kink, the error is of their size. Where they
    are, as of a smooth function, it is far smaller.
    """
    before, last = np.sqrt(np.square(coefficients).reshape(len(coefficients), 2, LAST, -1).sum(axis=2)).swapaxes(0, 1)
    return np.asarray(last * np.minimum(1, (4 * last / np.maximum(before, np.finfo(float).tiny)) ** 2))


def halves(boxes: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Both halves of each box, along its first side, or along the second where `across`."""
    lower, upper = boxes.copy(), boxes.copy()
    for low, high, chosen in ((1, 2, ~across), (3, 4, across)):
        middle = (boxes[chosen, low] + boxes[chosen, high]) / 2
        lower[chosen, high] = upper[chosen, low] = middle
    return np.concatenate([lower, upper])


def first_boxes() -> np.ndarray:
    """The panels to begin with."""
    inner, far, wide = np.linspace(-1, 1, INNER + 1), np.linspace(0, 1, OUTER + 1), np.linspace(-1, 1, OUTER + 1)
    rows = [(0, a, b, c, d) for a, b in pairwise(inner) for c, d in pairwise(inner)]
    rows += [(k, a, b, c, d) for k in range(1, 5) for a, b in pairwise(far) for c, d in pairwise(wide)]
    return np.array(rows, float)


class _Summed:
    """Sums over panels: moments, errors along both sides, a place for doubts, and what is of at least each degree."""

    def __init__(self, D: Function, scale: tuple[float, float]) -> None:
        self.D, self.scale, self.evaluations = D, scale, 0

    def values(self, boxes: np.ndarray, nodes: np.ndarray) -> tuple[np.ndarray, ...]:
        """X, Y, W and the density per area of the squares at all pairs of nodes of each box."""
        square, low, high, first, last = boxes.T[:, :, None, None]
        x, y, w = slopes_at(square, low + (high - low) * nodes[:, None], first + (last - first) * nodes, self.scale)
        self.evaluations += x.size
        return x, y, w, density_at(self.D, x, y, w, self.scale)[1]

    def __call__(self, boxes: np.ndarray) -> np.ndarray:
        nodes, weights, functionals = rule()
        x, y, w, density = self.values(boxes, nodes)
        far = density * np.sqrt(w * w + (x / self.scale[0]) ** 2 + (y / self.scale[1]) ** 2) / w
        sums = [(part @ weights) @ weights for part in (density, density * x / w, density * y / w)]
        sums += [
            falling(functionals.T @ far) @ weights,
            falling(functionals.T @ far.swapaxes(1, 2)) @ weights,
            np.zeros(len(boxes)),
            *_beyond(expanded(far)).T,
        ]
        area = (boxes[:, 2] - boxes[:, 1]) * (boxes[:, 4] - boxes[:, 3])
        return np.asarray(np.stack(sums, axis=1) * area[:, None])

    def unlike(self, boxes: np.ndarray, looks: int) -> tuple[np.ndarray, np.ndarray]:
        """Whether a box holds what the polynomial through its nodes does not show, at so many points along each side.

        And how much the density changes from point to point along u and along v, (n, 2).
        """
        points = np.linspace(INSIDE, 1 - INSIDE, looks)  # as far as the edges, over which a lobe beside a panel reaches
        through = legendre.legvander(2 * points - 1, NODES - 1) * np.sqrt(2 * np.arange(NODES) + 1)
        coefficients = expanded(self.values(boxes, rule()[0])[3])
        there = self.values(boxes, points)[3]
        apart = np.abs(through @ coefficients @ through.T - there).mean(axis=(1, 2))
        self.evaluations = 0
        changes = np.stack([np.abs(np.diff(there, axis=k)).mean(axis=(1, 2)) for k in (1, 2)], axis=1)
        return apart > UNLIKE * (_beyond(coefficients)[:, NODES - LAST] + GOAL * np.abs(there).mean()), changes


def _quarters(boxes: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """Quarters of boxes, or four stripes where the density changes along one side only."""
    along, across = changes[:, 0] > STRIPED * changes[:, 1], changes[:, 1] > STRIPED * changes[:, 0]
    boxes = halves(boxes, across)
    return halves(boxes, ~np.tile(along, 2))


def _looked(summed: _Summed, looks: int) -> np.ndarray:
    """First boxes; those with more in them than their nodes show are quartered until their nodes are as close as the look."""
    done, boxes = [], first_boxes()
    while len(boxes) and looks > NODES:
        unlike, changes = summed.unlike(boxes, looks)
        done.append(boxes[~unlike])
        boxes, looks = _quarters(boxes[unlike], changes[unlike]), looks // 2
    return np.concatenate([*done, boxes])


def _refined(summed: _Summed, boxes: np.ndarray, goal: float) -> tuple[np.ndarray, np.ndarray]:
    """Halve boxes until the errors of all add up to the goal, or no more evaluations are left.

    Where both halves do not add up to the whole, a lobe may now lie between their nodes: that doubt is an error too.
    """
    sums = summed(boxes)
    for _ in range(ROUNDS):
        errors = sums[:, ERRORS].sum(axis=1)
        order = np.argsort(-errors)
        remaining = np.cumsum(errors[order][::-1])[::-1]  # of this box and all of smaller errors
        left = (MOST - summed.evaluations) // (2 * NODES**2)
        aim = goal * np.abs(sums[:, 0]).sum()
        wanted = min(int(np.sum((remaining > aim / 2) & (errors[order] > WORTH * errors.max()))), left)
        if errors.sum() <= aim or wanted <= 0:
            break
        halved, kept = order[:wanted], order[wanted:]
        children = halves(boxes[halved], np.abs(sums[halved, 3]) < np.abs(sums[halved, 4]))
        found = summed(children)
        apart = np.abs(found[:wanted, 0] + found[wanted:, 0] - sums[halved, 0])
        found[:, DOUBTS] = np.tile(DOUBT * (apart + sums[halved, DOUBTS]), 2)
        boxes = np.concatenate([boxes[kept], children])
        sums = np.concatenate([sums[kept], found])
    return boxes, sums


def panels(D: Function, scale: tuple[float, float]) -> Panels:
    """Panels on which D, a function of unit normals (n, 3) that gives (n,), 1/sr, is as good as its polynomials.

    Where the area of the facets found is not 1, a closer look is taken. ValueError where D is not finite.
    """
    summed = _Summed(D, scale)
    boxes, sums = _refined(summed, _looked(summed, LOOKS), GOAL)
    looks = LOOKS
    if abs(sums[:, 0].sum() - 1) > MISSING:
        looks = CLOSER
        boxes, sums = _refined(summed, _looked(summed, looks), GOAL)
    errors = sums[:, ERRORS].sum(axis=1)
    degrees = np.sum(sums[:, DOUBTS + 1 :] > ENOUGH * np.abs(sums[:, 0]).sum(), axis=1)
    return Panels(scale, boxes, sums[:, :3], errors, degrees, summed.evaluations, 2 / INNER / looks)
