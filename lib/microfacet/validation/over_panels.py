"""The validation equations of any model over any distribution: sums over panels of its slopes, cut by the edge of visibility.

Panels on which D is as good as a polynomial are cached for all views. For each view, panels that cross the edge of visibility
or the opposite line, where V-cavities begin to mask, are cut into trapezoids and integrated again. The errors follow from the
decay of the integrand's coefficients on each piece. Only small kernels are compiled: D, Lambda, G1 and G2.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from microfacet.arithmetic import two_sum
from microfacet.compiler.batch import Batch
from microfacet.geometry.panels import SQUARES, density_at, falling, rule, slopes_at
from microfacet.geometry.slopes import Distribution
from microfacet.material.reflection import reflected
from microfacet.visibility.masking import Masking, visible_normals

ROUNDING = 1e-13  # of a sum of some 10^4 terms
CACHED_DISTRIBUTIONS = 4  # distributions whose nodes are cached, some 10^4 or 10^5 each
FEW_SAMPLES, MANY_SAMPLES = 32, 256  # visible normals at which light is followed, and their number where these do not decide
CLOSE = 1e-12  # relative excess of G2 over G1 that counts as rounding
STANDARD_DEVIATIONS = 4.0  # of the mean over sampled normals, in its error
_MAPS = np.array(SQUARES)


class Kernels(NamedTuple):
    """The kernels of a model over arrays, and their last argument."""

    Lambda: Batch  # of directions
    G1: Batch  # of Lambda, directions and normals
    G2: Batch  # of Lambda of two directions, both, and normals
    parameters: Any


@cache
def _batches(Lambda: Any, G1: Any, G2: Any) -> tuple[Batch, Batch, Batch]:
    return Batch(Lambda, [3]), Batch(G1, [1, 3, 3]), Batch(G2, [1, 1, 3, 3, 3])


def kernels_of(model: Masking) -> Kernels:
    """The kernels of a model. They are small, so that a user's own distribution compiles quickly."""
    return Kernels(*_batches(model.Lambda_kernel, model.G1_of_facet, model.G2_of_facet), model.parameters)


class Pieces(NamedTuple):
    """Parts of slope space with nodes. normals: (n, k, k, 3). mass: (n, k, k), facets' area, without the rule's weights."""

    normals: np.ndarray
    mass: np.ndarray

    def part(self, chosen: np.ndarray) -> Pieces:
        return Pieces(self.normals[chosen], self.mass[chosen])


class Sight:
    """Integrals of one view. area: what G1 leaves visible, over cos theta_o, and its error."""

    def __init__(self, area: tuple[float, float], draw: Callable[[], _Drawn]) -> None:
        self.area, self._draw = area, draw

    @cached_property
    def _drawn(self) -> _Drawn:
        return self._draw()

    @property
    def norm(self) -> tuple[float, float]:
        """The integral of D_visible and its error: the same sum as the visible area over the cosine."""
        return self.area

    @cached_property
    def furnace(self) -> tuple[float, float]:
        """The integral of mirrored light without shadowing, and its error."""
        (area, error), apart = self.area, self._drawn.furnace()
        return area * (1 + float(apart.mean())), error + float(np.ptp(apart))

    @cached_property
    def _reflected(self) -> tuple[tuple[float, float], float]:
        return self._drawn.albedo(*self.area)

    @property
    def albedo(self) -> tuple[float, float]:
        """Albedo of mirror facets, and its error."""
        return self._reflected[0]

    @property
    def limit(self) -> float:
        """Upper bound of the albedo, infinite if none is known."""
        return self._reflected[1]


def pieces_of(ndf: Distribution, square: np.ndarray, u: np.ndarray, v: np.ndarray, area: np.ndarray) -> Pieces:
    """Nodes at points of the squares. area: that of the squares per node, without the weights of the rule."""
    scale = ndf.panels.scale
    x, y, w = slopes_at(square, u, v, scale)
    normals, density = density_at(ndf.D, x, y, w, scale)
    return Pieces(normals, density * area)


@lru_cache(maxsize=CACHED_DISTRIBUTIONS)
def whole_panels(ndf: Distribution) -> Pieces:
    """Nodes of all panels of a distribution, uncut."""
    square, low, high, first, last = ndf.panels.boxes.T[:, :, None, None]
    nodes = rule()[0]
    area = (high - low) * (last - first)
    return pieces_of(ndf, square, low + (high - low) * nodes[:, None], first + (last - first) * nodes, area)


class Sights:
    """The visible normals of a model, from any view."""

    def __init__(self, model: Masking) -> None:
        self.model, self.kernels = model, kernels_of(model)
        self.panels = model.ndf.panels
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
        """The integrals of views (n, 3) above the horizon."""
        Lambda_o = self.kernels.Lambda([wo], self.kernels.parameters)
        return [self._sight(view, float(of_view)) for view, of_view in zip(wo, Lambda_o, strict=True)]

    def _sight(self, wo: np.ndarray, Lambda_o: float) -> Sight:
        parts = self._visible_pieces(wo)
        values = [self._visible_area(part, wo, Lambda_o) for part in parts]
        weights = rule()[1]
        area = sum(float(((value @ weights) @ weights).sum()) for value in values)
        error = sum(_error(value) for value in values) + self.panels.error + ROUNDING

        def draw() -> _Drawn:
            normals = np.concatenate([part.normals.reshape(-1, 3) for part in parts])
            areas = np.concatenate([(value * np.outer(weights, weights)).ravel() for value in values])
            return _Drawn(self, wo, Lambda_o, normals, areas)

        return Sight((area, error), draw)

    def _visible_area(self, part: Pieces, wo: np.ndarray, Lambda_o: float) -> np.ndarray:
        """Visible area of the facets by G1, projected towards the view, over cos theta_o."""
        m = part.normals.reshape(-1, 3)
        cosine = m @ wo
        masked = self.kernels.G1([np.array(Lambda_o), wo, m], self.kernels.parameters)
        return np.asarray(np.where(cosine > 0, masked * cosine / (wo[2] * m[:, 2]), 0)).reshape(part.mass.shape) * part.mass

    def _visible_pieces(self, wo: np.ndarray) -> list[Pieces]:
        """The pieces that face the view."""
        lines = self._lines(wo)
        if lines is None:
            return [self.whole]
        _, low, high, first, last = self.panels.boxes.T
        along, across = lines[..., 1], lines[..., 2]
        middle = lines[..., 0] + (along * (low + high) + across * (first + last)) / 2
        reach = (np.abs(along) * (high - low) + np.abs(across) * (last - first)) / 2
        cut = (np.abs(middle) < reach).any(axis=0)
        whole = ~cut & (middle[0] < 0)
        return [self.whole.part(whole), *([self._cut(self.panels.boxes[cut], lines[:, cut])] if cut.any() else [])]

    def _lines(self, wo: np.ndarray) -> np.ndarray | None:
        """W times the slope along the view, less and plus cot theta_o, as sums of 1, u and v for each panel: (2, n, 3)."""
        across = float(np.hypot(wo[0], wo[1]))
        if across == 0.0:
            return None
        maps = _MAPS[self.panels.boxes[:, 0].astype(int)]
        slope = (wo[0] * self.panels.scale[0] * maps[:, 0] + wo[1] * self.panels.scale[1] * maps[:, 1]) / across
        cot = wo[2] / across * maps[:, 2]
        return np.stack([slope - cot, slope + cot])

    def _cut(self, boxes: np.ndarray, lines: np.ndarray) -> Pieces:
        """Trapezoids between both lines and the edges of panels, those that face the view."""
        square, u, v, area = trapezoids(boxes, lines)
        return pieces_of(self.model.ndf, square[:, None, None], u, v, area)


def trapezoids(boxes: np.ndarray, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (m, k, k) on the pieces into which lines (2, n, 3), sums of 1, u and v, cut boxes: where the first is below 0.

    The square of each, u, v, and the area per node. A piece runs from line to line or edge, along the side of its box on which
    the first line's sum changes more, between the places on the other side where a line enters or leaves.
    """
    nodes = rule()[0]
    size = boxes[:, [2, 4]] - boxes[:, [1, 3]]
    swapped = np.abs(lines[0, :, 1]) * size[:, 0] < np.abs(lines[0, :, 2]) * size[:, 1]
    low, high, first, last = (np.where(swapped, boxes[:, k], boxes[:, j]) for k, j in ((3, 1), (4, 2), (1, 3), (2, 4)))
    one, along, aside = lines[..., 0], *(np.where(swapped, lines[..., k], lines[..., j]) for k, j in ((2, 1), (1, 2)))
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = [np.nan_to_num(-(one + along * end) / aside, nan=0.0, posinf=1e30, neginf=-1e30) for end in (low, high)]
        breaks = np.sort(np.concatenate([[first, last], *(np.clip(end, first, last) for end in ends)]), axis=0)
        box, start, width = (
            part.ravel() for part in np.broadcast_arrays(np.arange(len(boxes)), breaks[:-1], np.diff(breaks, axis=0))
        )
        wide = width > 0
        box, start, width = box[wide], start[wide], width[wide]
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
    visible = one[0, box] + along[0, box] * a[:, half, half] + aside[0, box] * b[:, half, 0] < 0
    box, a, b, area = box[visible], a[visible], np.broadcast_to(b[visible], a[visible].shape), area[visible]
    swap = swapped[box, None, None]
    return boxes[box, 0], np.where(swap, b, a), np.where(swap, a, b), area + 0 * a


def _error(values: np.ndarray) -> float:
    """Error of the sum of values at nodes (n, k, k), from the decay of their coefficients along both sides."""
    _, weights, functionals = rule()
    return float(sum((falling(functionals.T @ side) @ weights).sum() for side in (values, values.swapaxes(1, 2))))


class _Drawn:
    """Visible normals, sampled at equal steps of the visible area."""

    def __init__(self, sights: Sights, wo: np.ndarray, Lambda_o: float, normals: np.ndarray, areas: np.ndarray) -> None:
        self.sights, self.wo, self.Lambda_o, self.normals = sights, wo, Lambda_o, normals
        self.heaped = np.cumsum(np.abs(areas))

    def _draw(self, count: int) -> np.ndarray:
        at = np.searchsorted(self.heaped, (np.arange(count) + 0.5) / count * self.heaped[-1])
        return self.normals[np.minimum(at, len(self.normals) - 1)]

    def furnace(self) -> np.ndarray:
        """Relative excess of the light in the mirror direction over the visible area of its normal, without shadowing.

        The normal is found again as the half vector of the light direction. The rounding error of that direction is carried
        along, since near grazing the half vector is small compared with it.
        """
        m, o, kernels = self._draw(FEW_SAMPLES), self.wo, self.sights.kernels
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
        """Albedo of mirror facets with its error: the visible area times the unshadowed fraction of it; and its upper bound.

        If G2 nowhere exceeds G1, the visible area bounds the albedo, however few normals are sampled.
        """
        for count in (FEW_SAMPLES, MANY_SAMPLES):
            ratios = self._on(self._draw(count))
            spread = STANDARD_DEVIATIONS * float(ratios.std()) / np.sqrt(count) + 1 / count * float(np.ptp(ratios) > 0)
            value = area * float(ratios.mean())
            off = abs(area) * spread + error
            limit = area + error if ratios.max() <= 1 + CLOSE else np.inf
            if not value - off <= 1 < min(value + off, limit) - 2 * error:
                break
        return (value, off), limit

    def _on(self, m: np.ndarray) -> np.ndarray:
        """G2 over G1 for normals that mirror light from above the horizon; 0 for others."""
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
