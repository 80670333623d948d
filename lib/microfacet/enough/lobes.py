"""Binned lobes: the light that a model reflects into each bin, and that of the most complete model.

Bins are sets of half vectors, of equal probability for GGX of the surface's roughness: `ROWS` of slope, `COLUMNS` of
azimuth after unstretching, counted from the view's. So they follow the lobe, however narrow it is.

A lobe is the fraction of the light from the view that leaves into each bin, (ROWS, COLUMNS). Light travels here from the
view to the lights, which reciprocity allows.

Sources: heitz2014 (single scattering, surfaces), heitz2016 (the random walk).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microfacet.brdf.microfacet import Microfacet
from microfacet.brdf.random_walk import Later, RandomWalk
from microfacet.confidence import RARE, student
from microfacet.enough.scene import Point, Scene
from microfacet.geometry.slopes import Distribution
from microfacet.material.fresnel import Fresnel, Mirror
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField
from microfacet.surface.lanes import ESCAPED
from microfacet.visibility.smith import Smith

Array = NDArray[np.float64]
ROWS, COLUMNS = 8, 12
NODES = 12  # along either side of a bin
COARSE_NODES = (6, 8, 9, 10)  # of coarser rules to compare with; the first suffices for a smooth reflectance
SIDE = 192  # rays along either side of a surface
BOUNCES = 64  # on a surface; light still under way then is lost, which happens to less than one ray in a million
PARTS = 32  # of the random walks
ROOT = 11  # of the seeds of the surfaces
LONGEST = 6.0  # correlation lengths in a period, at least


# --- models: by a rule over the bins --------------------------------------------------------------------------------------


class Nodes(NamedTuple):
    """Light directions (n, 3), the weight of each (solid angle times cos theta_i), its polar angle in degrees, and the half
    width of its neighbourhood in that angle."""

    wi: Array
    weight: Array
    theta: Array
    reach: Array


class Ruled(NamedTuple):
    """A lobe by the rule over the bins, and by coarser rules (n, ROWS, COLUMNS); the differences estimate its error."""

    lobe: Array
    coarse: Array

    def error(self, other: Ruled | None = None) -> Array:
        """Largest error of each bin; or, given another lobe, of the difference of the two."""
        off = self.lobe - self.coarse
        most: Array = abs(off if other is None else off - (other.lobe - other.coarse)).max(axis=0)
        return most


@lru_cache(maxsize=128)
def nodes(point: Point, fine: int = NODES) -> Nodes:
    """`fine`^2 half vectors to a bin, and the lights that they mirror: evenly in azimuth, Gauss's nodes along each radius.

    The radius of a row ends where the mirrored light would go below the horizon.
    """
    angle = 2 * math.pi * (np.arange(COLUMNS * fine) + 0.5) / (COLUMNS * fine) + _ahead(point)
    dx, dy = point.alpha_x * np.cos(angle), point.alpha_y * np.sin(angle)
    rim = _rim(point.wo, dx, dy)
    x, w = np.polynomial.legendre.leggauss(fine)
    with np.errstate(divide="ignore"):
        rows = np.sqrt(np.arange(ROWS + 1) / np.arange(ROWS, -1, -1))[:, None]  # GGX has as many slopes between any two
    edges = np.arcsinh(np.minimum(rows, rim))  # evenly near the centre, in equal ratios in the tails
    middle, half = (edges[1:] + edges[:-1])[:, None] / 2, np.diff(edges, axis=0)[:, None] / 2
    radius = np.sinh(middle + half * x[:, None]).reshape(ROWS * fine, -1)
    rule_weights = (half * w[:, None]).reshape(ROWS * fine, -1) / angle.size
    slope_x, slope_y = radius * dx, radius * dy
    upright = 1 / np.sqrt(1 + slope_x**2 + slope_y**2)
    wm = np.stack([-slope_x * upright, -slope_y * upright, upright], axis=-1)
    cosine = wm @ point.wo
    wi = 2 * cosine[..., None] * wm - point.wo
    area = 2 * math.pi * point.alpha_x * point.alpha_y * radius * np.sqrt(1 + radius**2) * upright**3 * rule_weights
    weight = np.where((cosine > 0) & (wi[..., 2] > 0), 4 * cosine * area * wi[..., 2], 0.0)
    wi /= np.linalg.norm(wi, axis=-1, keepdims=True)
    theta = np.degrees(np.arctan2(np.hypot(wi[..., 0], wi[..., 1]), wi[..., 2]))
    steps = np.gradient(np.pad(theta, ((0, 0), (1, 1)), "wrap"))
    reach = sum(abs(step[:, 1:-1]) for step in steps) / 2
    return Nodes(wi.reshape(-1, 3), weight.ravel(), theta.ravel(), reach.ravel())


def _rim(wo: Array, dx: Array, dy: Array) -> Array:
    """How far, in these directions of slope, facets mirror light from above the horizon."""
    lean, square = (dx * wo[0] + dy * wo[1]) / wo[2], dx**2 + dy**2
    root = np.sqrt(lean**2 + square)
    rim: Array = np.where(lean >= 0, 1 / (lean + root), (root - lean) / square)
    return rim


def lobe_of(evaluate: Callable[[Array, Array], Array], scene: Scene, point: Point, fine: int = NODES) -> Array:
    """The lobe of a BRDF, given as a function of view and lights."""
    rule = nodes(point, fine)
    light = np.asarray(evaluate(point.wo, rule.wi), float) * rule.weight * scene.illuminated_fraction(rule.theta, rule.reach)
    return binned(light, fine)


def ruled(evaluate: Callable[[Array, Array], Array], scene: Scene, point: Point) -> Ruled:
    """The lobe of a BRDF by all rules."""
    coarse = COARSE_NODES if total_reflection(scene.material) else COARSE_NODES[:1]
    lobe, *others = (lobe_of(evaluate, scene, point, fine) for fine in (NODES, *coarse))
    return Ruled(lobe, np.array(others))


def total_reflection(fresnel: Fresnel) -> bool:
    """Whether reflectance has a kink: where it does, two rules may agree by chance."""
    return not isinstance(fresnel, Mirror) and float(fresnel.F(1e-6)) == 1.0


def binned(values: Array, fine: int = NODES) -> Array:
    """Sums over the nodes in each bin."""
    total: Array = values.reshape(ROWS, fine, COLUMNS, fine).sum(axis=(1, 3))
    return total


def _ahead(point: Point) -> float:
    """The azimuth of the view after unstretching."""
    wo = point.wo
    return math.atan2(point.alpha_y * wo[1], point.alpha_x * wo[0])


def bins(point: Point, wi: Array) -> NDArray[np.int64]:
    """The bin of each light direction (n, 3), as a number below ROWS COLUMNS."""
    half = wi + point.wo
    slope_x, slope_y = -half[:, 0] / half[:, 2] / point.alpha_x, -half[:, 1] / half[:, 2] / point.alpha_y
    square = slope_x**2 + slope_y**2
    row = np.minimum((square / (1 + square) * ROWS).astype(int), ROWS - 1)
    azimuth = (np.arctan2(slope_y, slope_x) - _ahead(point)) / (2 * math.pi) % 1
    index: NDArray[np.int64] = row * COLUMNS + np.minimum((azimuth * COLUMNS).astype(int), COLUMNS - 1)
    return index


def counted(scene: Scene, point: Point, wi: Array, weight: Array) -> Array:
    """The lobe of light that left into the directions wi (n, 3), with the weights (n,)."""
    inside = scene.illuminates(wi)
    lobe: Array = np.bincount(bins(point, wi[inside]), weight[inside], ROWS * COLUMNS).astype(float).reshape(ROWS, COLUMNS)
    return (lobe + lobe[:, ::-1]) / 2 if point.isotropic else lobe


# --- the most complete model ----------------------------------------------------------------------------------------------


class Reference(NamedTuple):
    """A lobe as a mean of independent parts (n, ROWS, COLUMNS), whose scatter gives its error.

    label: the model in words. drawn: the light that was followed at random. rare: the fraction of it that may be where hardly
    any was found. lossless: whether all of it is in the lobe. unknown: light that may be anywhere. once: the lobe of one bounce
    by the rule over the bins.
    """

    lobes: Array
    label: str
    drawn: float = 0.0
    rare: float = 0.0
    lossless: bool = False
    unknown: float = 0.0
    once: Ruled = Ruled(np.zeros((ROWS, COLUMNS)), np.zeros((1, ROWS, COLUMNS)))

    @property
    def lobe(self) -> Array:
        mean: Array = self.lobes.mean(axis=0)
        return mean

    def bound(self, of: Callable[[Array], Array]) -> Array:
        """Largest error of a linear function of lobes (n, ROWS, COLUMNS) -> (n, ...), exceeded with probability `ODDS`."""
        each = of(np.eye(ROWS * COLUMNS).reshape(-1, ROWS, COLUMNS))
        none = each[:1] if self.lossless else np.zeros_like(each[:1])
        span = self.drawn * np.ptp(np.concatenate([each, none]), axis=0)
        scatter = np.std(of(self.lobes), axis=0, ddof=1) / math.sqrt(len(self.lobes))
        off: Array = np.minimum(student(len(self.lobes)) * scatter + self.rare * span, span) + self.unknown * abs(each).max(
            axis=0
        )
        return off

    def misplaced(self) -> float:
        """Upper bound of the light in wrong bins: half the sum over bins, as it would be for other walks or surfaces.

        The distances of the parts from their mean, up to a factor, predict that of the mean from the truth.
        """
        count = len(self.lobes)
        apart = 0.5 * abs(self.lobes - self.lobe).sum(axis=(1, 2)) / math.sqrt(count - 1)
        likely = float(apart.mean()) + student(count) * float(np.std(apart, ddof=1)) * math.sqrt(1 + 1 / count)
        return min(likely + self.rare * self.drawn, self.drawn) + self.unknown


def surface(scene: Scene, point: Point, surfaces: int) -> Reference:
    """From ray-traced Gaussian surfaces, whose distribution of normals is Beckmann's; every bounce with its reflectance."""
    fields = _fields(point.alpha_x, point.alpha_y, surfaces)
    lobes, rest = zip(*(_traced(field, scene, point, k) for k, field in enumerate(fields)), strict=True)
    rare = RARE / (SIDE**2 * surfaces)
    return Reference(np.array(lobes), f"{surfaces} ray-traced surfaces", 1.0, rare, _lossless(scene), max(rest))


def walked(scene: Scene, point: Point, walks: int, ndf: Distribution | None = None) -> Reference:
    """From Smith's random walk: the first bounce by the rule over the bins, all others from `walks` walks of two or more.

    ndf: the distribution of normals, by default the scene's. The light that goes on is known exactly: what mirrors do not send
    out at once.
    """
    model = Smith(point.ndf(scene.normals) if ndf is None else ndf)
    once = ruled(Microfacet(model, scene.material).evaluate, scene, point)
    if scene.bounces == "one":
        return Reference(np.array([once.lobe, once.lobe]), "Smith's model", once=once)
    walk = RandomWalk(model, scene.material)
    going_on, error = map(float, walk.going_on(point.wo))
    later, rare, under_way = _later(walk.later(point.wo, walks, ROOT), scene, point)
    unknown = error + going_on * under_way
    return Reference(once.lobe + going_on * later, "Smith's random walk", going_on, rare, _lossless(scene), unknown, once)


def _later(walks: Later, scene: Scene, point: Point) -> tuple[Array, float, float]:
    """Lobes of the light that goes on, by parts of the walks; the fraction of it that may be where hardly any walk went; and
    the fraction still under way.

    Walks count in proportion to their weights, so each part is corrected for its surplus of weight.
    """
    parts = min(PARTS, len(walks.counts))
    total = walks.counts.sum()
    if not total > 0:
        return np.zeros((2, ROWS, COLUMNS)), 1.0, 0.0
    weights, out = parts * walks.counts / total, walks.wi[:, 2] > 0
    lobes, much = [], np.empty(parts)
    for part in range(parts):
        mine = np.arange(part, len(weights), parts)
        left = mine[out[mine]]
        much[part] = weights[mine].sum()
        lobes.append(counted(scene, point, walks.wi[left], weights[left] * walks.weight[left]))
    mean = np.mean(lobes, axis=0)
    even = np.array(lobes) - (much - 1)[:, None, None] * mean
    light = np.where(out, 0.0, walks.weight)
    return even, RARE * float(walks.counts.max() / total), float((walks.counts * light).sum() / total)


def _lossless(scene: Scene) -> bool:
    """Whether all light is in the lobe: facets absorb none, and every direction counts."""
    return isinstance(scene.material, Mirror) and scene.bounces == "all" and scene.light == (0.0, 90.0)


@lru_cache(maxsize=2)
def _fields(alpha_x: float, alpha_y: float, surfaces: int) -> list[HeightField]:
    family = _family(alpha_x, alpha_y)
    return [HeightField(family.spectral(k)) for k in range(surfaces)]


def _family(alpha_x: float, alpha_y: float) -> GaussianField:
    """A grid large enough for the longer of the two correlation lengths."""
    length = 16 * max(math.sqrt(alpha_x / alpha_y), math.sqrt(alpha_y / alpha_x))
    return GaussianField(2 ** math.ceil(math.log2(max(512.0, 1.1 * LONGEST * length))), alpha_x, alpha_y, root=ROOT)


def _traced(field: HeightField, scene: Scene, point: Point, k: int) -> tuple[Array, float]:
    """The light that leaves one surface, traced from one ray in each square of a grid; and the light then still under way."""
    rng = np.random.default_rng([ROOT, k])
    square = np.stack(np.meshgrid(*2 * [np.arange(SIDE)], indexing="ij"), axis=-1).reshape(-1, 2)
    places = field.size / SIDE * (square + rng.uniform(size=square.shape))
    origins = np.column_stack([places, np.full(SIDE**2, field.highest)])
    directions, light, facets = np.broadcast_to(-point.wo, origins.shape), np.ones(SIDE**2), np.full(SIDE**2, -1)
    lobe = np.zeros((ROWS, COLUMNS))
    for bounce in range(BOUNCES + 1):
        hits = field.trace(origins, directions, facets)
        out = hits.facet == ESCAPED
        if bounce and (scene.bounces == "all" or bounce == 1):
            lobe += counted(scene, point, directions[out], light[out])
        on = hits.facet >= 0
        facets, light = hits.facet[on], light[on]
        if not on.any():
            break
        origins = field.points(origins[on], directions[on], hits.distance[on])
        directions, light = _mirrored(field.normals(facets), directions[on], light, scene.material)
    return lobe / SIDE**2, float(light.sum()) / SIDE**2


def _mirrored(wm: Array, d: Array, light: Array, fresnel: Fresnel) -> tuple[Array, Array]:
    """Directions after a reflection, and the light reflected into them."""
    cosine = -np.sum(d * wm, axis=-1, keepdims=True)
    reflected_light = light if isinstance(fresnel, Mirror) else light * fresnel.F(np.clip(cosine[:, 0], 0, 1))
    return d + 2 * cosine * wm, reflected_light
