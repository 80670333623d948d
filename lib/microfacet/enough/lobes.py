"""Lobes in bins: what a model sends into each, and what the most complete model sends there.

Bins are sets of half vectors, of equal probability for GGX of the surface's roughness: `ROWS` of slope, `COLUMNS` of
azimuth after unstretching, counted from the view's. So they follow the lobe, however narrow it is.

A lobe is the share of the light from the view that leaves into each bin, (ROWS, COLUMNS). That the view sends and lights
receive is no matter, since light and viewer may change places.

Sources: heitz2014 (single scattering, surfaces), heitz2016 (the random walk).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microfacet.brdf.random_walk import RandomWalk
from microfacet.brdf.specular import Microfacet
from microfacet.enough.scene import NORMALS, Point, Scene
from microfacet.geometry.slopes import Distribution
from microfacet.material.fresnel import Fresnel, Mirror
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.trace import ESCAPED, HeightField
from microfacet.visibility.smith import Smith

Array = NDArray[np.float64]
ROWS, COLUMNS = 8, 12
NODES = 12  # along either side of a bin
SIDE = 192  # rays along either side of a surface
BOUNCES = 64  # on a surface; what is still under way then is lost, which happens to no ray in a million
PARTS = 16  # of the random walks
ROOT = 11  # of the seeds of the surfaces
LONGEST = 6.0  # correlation lengths in a period, at least


# --- models: by a rule over the bins --------------------------------------------------------------------------------------


class Nodes(NamedTuple):
    """Light directions (n, 3), what each stands for (the solid angle times cos theta_i), and what may be evaluated of them."""

    wi: Array
    weight: Array


@lru_cache(maxsize=128)
def nodes(point: Point, fine: int = NODES) -> Nodes:
    """`fine`^2 half vectors to a bin, and the lights that they mirror: evenly in azimuth, Gauss's nodes along each radius.

    The radius of a row ends where the mirrored light would go below the horizon.
    """
    angle = 2 * math.pi * (np.arange(COLUMNS * fine) + 0.5) / (COLUMNS * fine) + _ahead(point)
    dx, dy = point.alpha_x * np.cos(angle), point.alpha_y * np.sin(angle)
    rim = _rim(point.wo, dx, dy)
    x, w = np.polynomial.legendre.leggauss(fine)
    rows = np.arcsin(np.sqrt(np.arange(ROWS + 1) / ROWS))[:, None]  # GGX has its slopes evenly in the sine's square
    edges = np.minimum(rows, np.arctan(rim))
    middle, half = (edges[1:] + edges[:-1])[:, None] / 2, np.diff(edges, axis=0)[:, None] / 2
    lean = (middle + half * x[:, None]).reshape(ROWS * fine, -1)
    radius, share = np.tan(lean), (half * w[:, None]).reshape(ROWS * fine, -1) / angle.size
    slope_x, slope_y = radius * dx, radius * dy
    upright = 1 / np.sqrt(1 + slope_x**2 + slope_y**2)
    wm = np.stack([-slope_x * upright, -slope_y * upright, upright], axis=-1)
    cosine = wm @ point.wo
    wi = 2 * cosine[..., None] * wm - point.wo
    area = 2 * math.pi * point.alpha_x * point.alpha_y * radius * (1 + radius**2) * upright**3 * share
    weight = np.where((cosine > 0) & (wi[..., 2] > 0), 4 * cosine * area * wi[..., 2], 0.0)
    wi /= np.linalg.norm(wi, axis=-1, keepdims=True)
    return Nodes(wi.reshape(-1, 3), weight.ravel())


def _rim(wo: Array, dx: Array, dy: Array) -> Array:
    """How far, in these directions of slope, facets mirror light from above the horizon."""
    lean, square = (dx * wo[0] + dy * wo[1]) / wo[2], dx**2 + dy**2
    root = np.sqrt(lean**2 + square)
    rim: Array = np.where(lean >= 0, 1 / (lean + root), (root - lean) / square)
    return rim


def lobe_of(evaluate: Callable[[Array, Array], Array], scene: Scene, point: Point, fine: int = NODES) -> Array:
    """The lobe of a BRDF, given as a function of view and lights."""
    rule = nodes(point, fine)
    light = np.asarray(evaluate(point.wo, rule.wi), float) * rule.weight * scene.lit(rule.wi)
    return binned(light, fine)


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
    turn = (np.arctan2(slope_y, slope_x) - _ahead(point)) / (2 * math.pi) % 1
    found: NDArray[np.int64] = row * COLUMNS + np.minimum((turn * COLUMNS).astype(int), COLUMNS - 1)
    return found


def counted(scene: Scene, point: Point, wi: Array, weight: Array) -> Array:
    """The lobe of light that left into the directions wi (n, 3), with so much (n,) in each."""
    inside = scene.lit(wi)
    lobe: Array = np.bincount(bins(point, wi[inside]), weight[inside], ROWS * COLUMNS).astype(float).reshape(ROWS, COLUMNS)
    return (lobe + lobe[:, ::-1]) / 2 if point.isotropic else lobe


def rule_error(evaluate: Callable[[Array, Array], Array], scene: Scene, point: Point) -> float:
    """How much light the rule over the bins gains or loses: twice what a rule of twice the nodes makes of it."""
    sums = [float(lobe_of(evaluate, scene, point, fine).sum()) for fine in (NODES, 2 * NODES)]
    return 2 * abs(sums[0] - sums[1])


# --- the most complete model ----------------------------------------------------------------------------------------------


class Reference(NamedTuple):
    """A lobe from independent parts (n, ROWS, COLUMNS), whose scatter tells its error; and in words what it is."""

    lobes: Array
    words: str

    @property
    def lobe(self) -> Array:
        mean: Array = self.lobes.mean(axis=0)
        return mean

    def error(self, of: Callable[[Array], Array] = lambda lobes: lobes) -> Array:
        """Standard error of a linear function of lobes (n, ROWS, COLUMNS) -> (n, ...)."""
        scatter: Array = np.std(of(self.lobes), axis=0, ddof=1) / math.sqrt(len(self.lobes))
        return scatter


def surface(scene: Scene, point: Point, surfaces: int) -> Reference:
    """From ray-traced Gaussian surfaces, whose distribution of normals is Beckmann's; every bounce with its reflectance."""
    lobes = [_traced(field, scene, point, k) for k, field in enumerate(_fields(point.alpha_x, point.alpha_y, surfaces))]
    return Reference(np.array(lobes), f"{surfaces} ray-traced surfaces")


def walked(scene: Scene, point: Point, walks: int, ndf: Distribution | None = None) -> Reference:
    """From Smith's random walk: the first bounce by the rule over the bins, all others from so many walks, in `PARTS`.

    ndf: the distribution of normals, by default the scene's.

    How many of the walks go on after the first bounce is known exactly: what mirrors do not send out at once.
    """
    model = Smith(NORMALS[scene.normals](point.alpha_x, point.alpha_y) if ndf is None else ndf)
    once = lobe_of(Microfacet(model, scene.material).evaluate, scene, point)
    if scene.bounces == "one":
        return Reference(np.array([once, once]), "Smith's model")
    walk, going_on = RandomWalk(model, scene.material), 1 - float(Microfacet(model).albedo(point.wo))
    lobes = []
    for part in range(PARTS):
        u = np.random.default_rng([ROOT, part]).random((walks // PARTS, 2))
        wi, light, bounces = walk.sample(point.wo, u)
        more = bounces > 1
        out = more & (wi[:, 2] > 0)
        lobes.append(once + going_on / max(more.sum(), 1) * counted(scene, point, wi[out], light[out]))
    return Reference(np.array(lobes), "Smith's random walk")


@lru_cache(maxsize=2)
def _fields(alpha_x: float, alpha_y: float, surfaces: int) -> list[HeightField]:
    family = _family(alpha_x, alpha_y)
    return [HeightField(family.spectral(k)) for k in range(surfaces)]


def _family(alpha_x: float, alpha_y: float) -> GaussianField:
    """A grid large enough for the longer of the two correlation lengths."""
    length = 16 * max(math.sqrt(alpha_x / alpha_y), math.sqrt(alpha_y / alpha_x))
    return GaussianField(2 ** math.ceil(math.log2(max(512.0, 1.1 * LONGEST * length))), alpha_x, alpha_y, root=ROOT)


def _traced(field: HeightField, scene: Scene, point: Point, k: int) -> Array:
    """The light that leaves one surface, followed from one ray in each square of a grid."""
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
        if not on.any():
            break
        facets, light = hits.facet[on], light[on]
        origins = field.points(origins[on], directions[on], hits.distance[on])
        directions, light = _mirrored(field.normals(facets), directions[on], light, scene.material)
    return lobe / SIDE**2


def _mirrored(wm: Array, d: Array, light: Array, fresnel: Fresnel) -> tuple[Array, Array]:
    """Directions after a reflection, and what is left of the light."""
    cosine = -np.sum(d * wm, axis=-1, keepdims=True)
    kept = light if isinstance(fresnel, Mirror) else light * fresnel.F(np.clip(cosine[:, 0], 0, 1))
    return d + 2 * cosine * wm, kept
