"""The validation equations of any model over any distribution: sums over panels of its slopes, cut by the edge of visibility.

Panels on which D is as good as a polynomial are kept once for all views. From each view those that the edge of visibility cuts,
or the line opposite, where V-cavities begin to mask, are cut in trapezoids and integrated anew. The errors follow from how the
coefficients of the integrand fall on each piece. Only small kernels are compiled: D, Lambda, G1 and G2.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from microfacet.arithmetic import two_sum
from microfacet.geometry.panels import SQUARES, density_at, falling, rule, slopes_at
from microfacet.geometry.slopes import Distribution
from microfacet.kernels import Batch
from microfacet.material.reflection import reflected
from microfacet.visibility.masking import Masking, visible_normals

ROUNDING = 1e-13  # of a sum of some 10^4 terms
KEPT = 4  # distributions of which nodes are kept, some 10^4 or 10^5 each
DRAWN, MORE = 32, 256  # normals, seen from a view, at which light is followed, and where these do not decide
CLOSE = 1e-12  # what G2 may exceed G1 by, of it
SURE = 4.0  # standard deviations
_MAPS = np.array(SQUARES)


class Kernels(NamedTuple):
    """The kernels of a model over arrays, and what they take last."""

    Lambda: Batch  # of directions
    G1: Batch  # of Lambda, directions and normals
    G2: Batch  # of Lambda of two directions, both, and normals
    parameters: Any


@cache
def _batches(Lambda: Any, G1: Any, G2: Any) -> tuple[Batch, Batch, Batch]:
    return Batch(Lambda, [3]), Batch(G1, [1, 3, 3]), Batch(G2, [1, 1, 3, 3, 3])


def kernels_of(model: Masking) -> Kernels:
    """What a model is asked for. They are small, so that a user's own distribution takes no long to compile."""
    return Kernels(*_batches(model.Lambda_kernel, model.G1_of_facet, model.G2_of_facet), model.parameters)


class Pieces(NamedTuple):
    """Parts of slope space with nodes. normals: (n, k, k, 3). mass: (n, k, k), facets' area there, but for the weights."""

    normals: np.ndarray
    mass: np.ndarray

    def part(self, chosen: np.ndarray) -> Pieces:
        return Pieces(self.normals[chosen], self.mass[chosen])


class Sight:
    """What one view sees. area: what G1 leaves visible, over cos theta_o, and its error."""

    def __init__(self, area: tuple[float, float], draw: Callable[[], _Drawn]) -> None:
        self.area, self._draw = area, draw

    @cached_property
    def _drawn(self) -> _Drawn:
        return self._draw()

    @property
    def norm(self) -> tuple[float, float]:
        """The same for the integral of D_visible, which is what is seen over the cosine: the same sum."""
        return self.area

    @cached_property
    def furnace(self) -> tuple[float, float]:
        """The same for mirrored light without shadowing."""
        (area, error), apart = self.area, self._drawn.furnace()
        return area * (1 + float(apart.mean())), error + float(np.ptp(apart))

    @cached_property
    def _reflected(self) -> tuple[tuple[float, float], float]:
        return self._drawn.albedo(*self.area)

    @property
    def albedo(self) -> tuple[float, float]:
        """Of mirror facets, and its error."""
        return self._reflected[0]

    @property
    def limit(self) -> float:
        """What the albedo cannot exceed, infinite if nothing is known."""
        return self._reflected[1]


def pieces_of(ndf: Distribution, square: np.ndarray, u: np.ndarray, v: np.ndarray, area: np.ndarray) -> Pieces:
    """Nodes at points of the squares. area: that of the squares per node, but for the weights."""
    scale = ndf.panels.scale
    x, y, w = slopes_at(square, u, v, scale)
    normals, density = density_at(ndf.D, x, y, w, scale)
    return Pieces(normals, density * area)


@lru_cache(maxsize=KEPT)
def whole_panels(ndf: Distribution) -> Pieces:
    """All panels of a distribution, which no view cuts."""
    square, low, high, first, last = ndf.panels.boxes.T[:, :, None, None]
    nodes = rule()[0]
    area = (high - low) * (last - first)
    return pieces_of(ndf, square, low + (high - low) * nodes[:, None], first + (last - first) * nodes, area)


class Sights:
    """A model seen from any view."""

    def __init__(self, model: Masking) -> None:
        self.model, self.kernels = model, kernels_of(model)
        self.found = model.ndf.panels
        self.whole = whole_panels(model.ndf)

    def spread(self, count: int) -> np.ndarray:
        """Normals at equal steps of the facets' area."""
        heaped = np.cumsum(np.abs(self._areas().ravel()))
        at = np.searchsorted(heaped, (np.arange(count) + 0.5) / count * heaped[-1])
        return np.asarray(self.whole.normals.reshape(-1, 3)[np.minimum(at, len(heaped) - 1)])

    def negative(self) -> tuple[float, np.ndarray]:
        """The area of facets of negative density, and the normal with most of them."""
        areas = self._areas().ravel()
        return float(-np.minimum(areas, 0).sum()), np.asarray(self.whole.normals.reshape(-1, 3)[np.argmin(areas)])

    def _areas(self) -> np.ndarray:
        return np.asarray(self.whole.mass * np.outer(rule()[1], rule()[1]))

    def __call__(self, wo: np.ndarray) -> list[Sight]:
        """Of views (n, 3), above the horizon."""
        Lambda_o = self.kernels.Lambda([wo], self.kernels.parameters)
        return [self._sight(view, float(of_view)) for view, of_view in zip(wo, Lambda_o, strict=True)]

    def _sight(self, wo: np.ndarray, Lambda_o: float) -> Sight:
        parts = self._visible(wo)
        values = [self._seen(part, wo, Lambda_o) for part in parts]
        weights = rule()[1]
        area = sum(float(((value @ weights) @ weights).sum()) for value in values)
        error = sum(_error(value) for value in values) + self.found.error + ROUNDING

        def draw() -> _Drawn:
            normals = np.concatenate([part.normals.reshape(-1, 3) for part in parts])
            shares = np.concatenate([(value * np.outer(weights, weights)).ravel() for value in values])
            return _Drawn(self, wo, Lambda_o, normals, shares)

        return Sight((area, error), draw)

    def _seen(self, part: Pieces, wo: np.ndarray, Lambda_o: float) -> np.ndarray:
        """What G1 leaves of the facets, projected towards the view, over cos theta_o."""
        m = part.normals.reshape(-1, 3)
        cosine = m @ wo
        masked = self.kernels.G1([np.array(Lambda_o), wo, m], self.kernels.parameters)
        return np.asarray(np.where(cosine > 0, masked * cosine / (wo[2] * m[:, 2]), 0)).reshape(part.mass.shape) * part.mass

    def _visible(self, wo: np.ndarray) -> list[Pieces]:
        """The pieces turned to the view."""
        lines = self._lines(wo)
        if lines is None:
            return [self.whole]
        _, low, high, first, last = self.found.boxes.T
        along, across = lines[..., 1], lines[..., 2]
        middle = lines[..., 0] + (along * (low + high) + across * (first + last)) / 2
        reach = (np.abs(along) * (high - low) + np.abs(across) * (last - first)) / 2
        cut = (np.abs(middle) < reach).any(axis=0)
        whole = ~cut & (middle[0] < 0)
        return [self.whole.part(whole), *([self._cut(self.found.boxes[cut], lines[:, cut])] if cut.any() else [])]

    def _lines(self, wo: np.ndarray) -> np.ndarray | None:
        """W times the slope along the view, less and plus cot theta_o, as sums of 1, u and v for each panel: (2, n, 3)."""
        across = float(np.hypot(wo[0], wo[1]))
        if across == 0.0:
            return None
        maps = _MAPS[self.found.boxes[:, 0].astype(int)]
        slope = (wo[0] * self.found.scale[0] * maps[:, 0] + wo[1] * self.found.scale[1] * maps[:, 1]) / across
        cot = wo[2] / across * maps[:, 2]
        return np.stack([slope - cot, slope + cot])

    def _cut(self, boxes: np.ndarray, lines: np.ndarray) -> Pieces:
        """Trapezoids between both lines and the edges of panels, those turned to the view."""
        square, u, v, area = trapezoids(boxes, lines)
        return pieces_of(self.model.ndf, square[:, None, None], u, v, area)


def trapezoids(boxes: np.ndarray, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (m, k, k) on the pieces into which lines (2, n, 3), sums of 1, u and v, cut boxes: where the first is below 0.

    The square of each, u, v, and the area per node. A piece runs from line to line or edge, along the side of its box on which
    the first line's sum changes more, between the places on the other side where a line enters or leaves.
    """
    nodes = rule()[0]
    size = boxes[:, [2, 4]] - boxes[:, [1, 3]]
    turned = np.abs(lines[0, :, 1]) * size[:, 0] < np.abs(lines[0, :, 2]) * size[:, 1]
    low, high, first, last = (np.where(turned, boxes[:, k], boxes[:, j]) for k, j in ((3, 1), (4, 2), (1, 3), (2, 4)))
    one, along, aside = lines[..., 0], *(np.where(turned, lines[..., k], lines[..., j]) for k, j in ((2, 1), (1, 2)))
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = [np.nan_to_num(-(one + along * end) / aside, nan=0.0, posinf=1e30, neginf=-1e30) for end in (low, high)]
        breaks = np.sort(np.concatenate([[first, last], *(np.clip(end, first, last) for end in ends)]), axis=0)
        box, start, width = (
            part.ravel() for part in np.broadcast_arrays(np.arange(len(boxes)), breaks[:-1], np.diff(breaks, axis=0))
        )
        kept = width > 0
        box, start, width = box[kept], start[kept], width[kept]
        b = start[:, None] + width[:, None] * nodes
        at = -(one[:, box, None] + aside[:, box, None] * b) / along[:, box, None]
    limits = low[box, None] + 0 * b, high[box, None] + 0 * b
    edges = np.sort(np.stack([*limits, *np.clip(np.nan_to_num(at, posinf=1e30, neginf=-1e30), *limits)]), axis=0)
    lengths = np.diff(edges, axis=0)
    part, piece = np.nonzero(lengths.max(axis=2) > 0)
    box, b, length = box[piece], b[piece, :, None], lengths[part, piece][:, :, None]
    a = edges[part, piece][:, :, None] + length * nodes
    area = width[piece, None, None] * length
    half = len(nodes) // 2
    seen = one[0, box] + along[0, box] * a[:, half, half] + aside[0, box] * b[:, half, 0] < 0
    box, a, b, area = box[seen], a[seen], np.broadcast_to(b[seen], a[seen].shape), area[seen]
    swap = turned[box, None, None]
    return boxes[box, 0], np.where(swap, b, a), np.where(swap, a, b), area + 0 * a


def _error(values: np.ndarray) -> float:
    """Of the sum of values at nodes (n, k, k), from how their coefficients fall along both sides."""
    _, weights, functionals = rule()
    return float(sum((falling(functionals.T @ side) @ weights).sum() for side in (values, values.swapaxes(1, 2))))


class _Drawn:
    """Normals drawn as the view sees them: at equal steps of the area seen."""

    def __init__(self, sights: Sights, wo: np.ndarray, Lambda_o: float, normals: np.ndarray, shares: np.ndarray) -> None:
        self.sights, self.wo, self.Lambda_o, self.normals = sights, wo, Lambda_o, normals
        self.heaped = np.cumsum(np.abs(shares))

    def _draw(self, count: int) -> np.ndarray:
        at = np.searchsorted(self.heaped, (np.arange(count) + 0.5) / count * self.heaped[-1])
        return self.normals[np.minimum(at, len(self.normals) - 1)]

    def furnace(self) -> np.ndarray:
        """How much more light, relatively, goes to the mirror direction than its normal is seen, if none is shadowed.

        It goes through the half vector of the light direction. What rounding leaves out of that direction is kept: near
        grazing, the half vector is small beside it.
        """
        m, o, kernels = self._draw(DRAWN), self.wo, self.sights.kernels
        cosine = m @ o
        summed: Any = two_sum  # of arrays, too
        i, rest = summed(2 * cosine[:, None] * m, -o)
        h = o + i + rest
        h /= np.linalg.norm(h, axis=1, keepdims=True)
        at_h, at_m = (kernels.G1([np.array(self.Lambda_o), o, n], kernels.parameters) for n in (h, m))
        there, here = (self.sights.model.ndf.D(n) for n in (h, m))
        visible = visible_normals.scalar(at_m, cosine, here, o[2])
        mirrored = reflected.scalar(at_h, there, o[2]) * 4 * cosine
        return np.asarray(mirrored / np.where(visible == 0, 1, visible) - (visible != 0))

    def albedo(self, area: float, error: float) -> tuple[tuple[float, float], float]:
        """Of mirror facets, with its error: what is seen, times the share of it that goes on to light; and its limit.

        If G2 nowhere exceeds G1 it is no more than what is seen, however few normals are drawn.
        """
        for count in (DRAWN, MORE):
            ratios = self._on(self._draw(count))
            spread = SURE * float(ratios.std()) / np.sqrt(count) + 1 / count * float(np.ptp(ratios) > 0)
            value = area * float(ratios.mean())
            off = abs(area) * spread + error
            limit = area + error if ratios.max() <= 1 + CLOSE else np.inf
            if not value - off <= 1 < min(value + off, limit) - 2 * error:
                break
        return (value, off), limit

    def _on(self, m: np.ndarray) -> np.ndarray:
        """G2 over G1, of the normals that mirror light from above the horizon; 0 for others."""
        o, kernels = self.wo, self.sights.kernels
        i = 2 * (m @ o)[:, None] * m - o
        up = i[:, 2] > 0
        i, m = i[up], m[up]
        ratios = np.zeros(len(up))
        if up.any():
            Lambda_i = kernels.Lambda([i], kernels.parameters)
            both = kernels.G2([np.array(self.Lambda_o), Lambda_i, o, i, m], kernels.parameters)
            one = kernels.G1([np.array(self.Lambda_o), o, m], kernels.parameters)
            ratios[up] = both / np.where(one == 0, 1, one)
        return ratios
