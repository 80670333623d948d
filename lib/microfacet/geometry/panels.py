"""Adaptive panels of slope space for a distribution: small where its density changes, each with the moments of its facets.

Only values of the distribution are needed. Slopes in units of a scale are mapped to five squares: those up to one scale along
both axes by the identity, those beyond by the inverse of the larger one. Each map takes straight lines to straight lines, so
that the edge of visibility, a line in slope space, cuts a panel in a trapezoid. A grid of samples finds lobes that lie between
the nodes of the first panels; then the panels of largest error are halved until the sum of errors is small.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

SIDE_NODES, TAIL = 14, 4  # in each direction of a panel; coefficients from which the error is estimated
GOAL = 2e-13  # bound of the sum of errors, relative
MOST_EVALUATIONS, ROUNDS = 1_500_000, 100  # evaluations of the distribution; rounds of halving
WORTH = 1e-3  # relative to the largest error: panels of smaller errors wait for another round
SAMPLES, FINER_SAMPLES = 40, 160  # along each side of a first panel: at first, and if area is missing
MISSED_LOBE = 30.0  # if samples differ from a panel's polynomial by this many times its last coefficients, it has missed a lobe
ERRORS, DOUBTS = slice(3, 6), 5  # among the sums of a panel
DOUBT = 1e-3  # error of a half, relative to the difference between both halves and the whole panel
INSIDE = 1e-6  # distance of samples from the sides of a panel, where slopes may be infinite
STRIPED = 4.0  # a panel is cut into stripes if its density changes this many times more along one side than along the other
MISSING_AREA = 1e-9  # deviation of the area from 1 above which finer samples are taken
ENOUGH = 1e-14  # error that fewer nodes may add to a panel, relative to the whole integral

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

    moments: (n, 3), for each panel the projected area of its facets and the integrals of both slopes over it. errors: (n,),
    of these, with slopes in units of the scale. degrees: (n,), of the polynomials in u and v that suffice.
    evaluations: how often D was evaluated. closest: the distance between samples, in units of the scale.
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
def rule(count: int = SIDE_NODES) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes on (0, 1), their weights, and the functionals that give the last 8 coefficients of the
    interpolating polynomial in orthonormal Legendre polynomials: (nodes, 8)."""
    nodes, weights = legendre.leggauss(count)
    normal = np.sqrt(2 * np.arange(count) + 1)
    functionals = legendre.legvander(nodes, count - 1) * normal * weights[:, None] / 2
    return (nodes + 1) / 2, weights / 2, functionals[:, -2 * TAIL :]


@cache
def _expansion() -> np.ndarray:
    """The matrix from values at the nodes to coefficients of orthonormal Legendre polynomials, (SIDE_NODES, SIDE_NODES)."""
    nodes, weights, _ = rule()
    return np.asarray(
        legendre.legvander(2 * nodes - 1, SIDE_NODES - 1) * np.sqrt(2 * np.arange(SIDE_NODES) + 1) * weights[:, None]
    )


def expanded(values: np.ndarray) -> np.ndarray:
    """Coefficients of the polynomials through values at all pairs of nodes, (n, SIDE_NODES, SIDE_NODES)."""
    return np.asarray(_expansion().T @ values @ _expansion())


def _beyond(coefficients: np.ndarray) -> np.ndarray:
    """For each degree the norm of the coefficients of at least that degree along either side, (n, SIDE_NODES)."""
    square = np.square(coefficients)
    degree = np.maximum(*np.indices((SIDE_NODES, SIDE_NODES)))
    return np.sqrt(np.stack([np.where(degree >= d, square, 0).sum(axis=(1, 2)) for d in range(SIDE_NODES)], axis=1))


def falling(coefficients: np.ndarray) -> np.ndarray:
    """Estimated error of the integral of a polynomial through all nodes, from the decay of its coefficients.

    coefficients: the last 8 of each, (n, 8, j); the result has the shape (n, j).

    If the last four are not far below the four before them, as at a kink, the error is of their size. If they are, as for a
    smooth function, it is far smaller.
    """
    before, last = np.sqrt(np.square(coefficients).reshape(len(coefficients), 2, TAIL, -1).sum(axis=2)).swapaxes(0, 1)
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
    """Sums over panels: moments, errors along both sides, a column for doubts, and the norms of `_beyond`."""

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

    def has_missed_lobes(self, boxes: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
        """Whether the density in a box differs from the polynomial through its nodes, at a grid of samples.

        Also how much the density changes from sample to sample along u and along v, (n, 2).
        """
        points = np.linspace(INSIDE, 1 - INSIDE, samples)  # as far as the edges, over which a lobe beside a panel reaches
        through = legendre.legvander(2 * points - 1, SIDE_NODES - 1) * np.sqrt(2 * np.arange(SIDE_NODES) + 1)
        coefficients = expanded(self.values(boxes, rule()[0])[3])
        there = self.values(boxes, points)[3]
        differences = np.abs(through @ coefficients @ through.T - there).mean(axis=(1, 2))
        self.evaluations = 0
        changes = np.stack([np.abs(np.diff(there, axis=k)).mean(axis=(1, 2)) for k in (1, 2)], axis=1)
        return differences > MISSED_LOBE * (_beyond(coefficients)[:, SIDE_NODES - TAIL] + GOAL * np.abs(there).mean()), changes


def _quarters(boxes: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """Quarters of boxes, or four stripes where the density changes along one side only."""
    along, across = changes[:, 0] > STRIPED * changes[:, 1], changes[:, 1] > STRIPED * changes[:, 0]
    boxes = halves(boxes, across)
    return halves(boxes, ~np.tile(along, 2))


def _sampled(summed: _Summed, samples: int) -> np.ndarray:
    """First boxes; those with missed lobes are quartered until their nodes are as close as the samples."""
    done, boxes = [], first_boxes()
    while len(boxes) and samples > SIDE_NODES:
        missed, changes = summed.has_missed_lobes(boxes, samples)
        done.append(boxes[~missed])
        boxes, samples = _quarters(boxes[missed], changes[missed]), samples // 2
    return np.concatenate([*done, boxes])


def _refined(summed: _Summed, boxes: np.ndarray, goal: float) -> tuple[np.ndarray, np.ndarray]:
    """Halve boxes until the sum of errors meets the goal, or no more evaluations are left.

    Where both halves do not add up to the whole, there may be a lobe between their nodes: this doubt counts as an error too.
    """
    sums = summed(boxes)
    for _ in range(ROUNDS):
        errors = sums[:, ERRORS].sum(axis=1)
        order = np.argsort(-errors)
        remaining = np.cumsum(errors[order][::-1])[::-1]  # of this box and all of smaller errors
        left = (MOST_EVALUATIONS - summed.evaluations) // (2 * SIDE_NODES**2)
        aim = goal * np.abs(sums[:, 0]).sum()
        wanted = min(int(np.sum((remaining > aim / 2) & (errors[order] > WORTH * errors.max()))), left)
        if errors.sum() <= aim or wanted <= 0:
            break
        halved, others = order[:wanted], order[wanted:]
        children = halves(boxes[halved], np.abs(sums[halved, 3]) < np.abs(sums[halved, 4]))
        child_sums = summed(children)
        differences = np.abs(child_sums[:wanted, 0] + child_sums[wanted:, 0] - sums[halved, 0])
        child_sums[:, DOUBTS] = np.tile(DOUBT * (differences + sums[halved, DOUBTS]), 2)
        boxes = np.concatenate([boxes[others], children])
        sums = np.concatenate([sums[others], child_sums])
    return boxes, sums


def panels(D: Function, scale: tuple[float, float]) -> Panels:
    """Panels on each of which D, a function of unit normals (n, 3) -> (n,) in 1/sr, is well approximated by a polynomial.

    If the area of the facets is not 1, finer samples are taken. ValueError where D is not finite.
    """
    summed = _Summed(D, scale)
    boxes, sums = _refined(summed, _sampled(summed, SAMPLES), GOAL)
    samples = SAMPLES
    if abs(sums[:, 0].sum() - 1) > MISSING_AREA:
        samples = FINER_SAMPLES
        boxes, sums = _refined(summed, _sampled(summed, samples), GOAL)
    errors = sums[:, ERRORS].sum(axis=1)
    degrees = np.sum(sums[:, DOUBTS + 1 :] > ENOUGH * np.abs(sums[:, 0]).sum(), axis=1)
    return Panels(scale, boxes, sums[:, :3], errors, degrees, summed.evaluations, 2 / INNER / samples)
