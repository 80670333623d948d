"""Ray-traced measurements of Gaussian surfaces: masking, visible normals, shadowing, reflection lobes, albedo by bounces.

Every result is a count or a sum per surface, so that results of many surfaces can be added, and the scatter between
independent surfaces, which dominates the error, gives the standard errors. A shard is a range of surfaces; surface k
and its rays depend on the family of surfaces, the plan and k only, so `gather` gives the same numbers however many shards
there were.

Directions are unit vectors that point away from the surface; facets are mirrors that reflect all light. A view is one wo.
Azimuths are relative to the view's, whose azimuth is 0 if it is vertical. Arrays of one view, per surface:

    faced, seen      (s,)       area of the facets that face wo, and of their visible parts, projected along wo, per area of
                                the plane, by slope along the view in units of alpha_o; see `Plan.slopes`
    normals          (s, s)     fraction of the view taken by each slope, in units of (alpha_x, alpha_y)
    facing, lit      (t, p)     fraction of the view that faces wi, and that wi illuminates, for each wi; see `Plan.lights`
    lobe             (2, t, p)  fraction of the light that leaves into each bin after one reflection, and after more
    escaped          (b,)       fraction of the light that leaves after 1, 2, ... reflections; the rest is still under way

Sources: heitz2014 (what is measured), beckmann1963 (Gaussian surfaces), efron1982 (jackknife).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.confidence import Estimate
from microfacet.directions import as_vectors, spherical
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField, Hits
from microfacet.surface.lanes import ESCAPED

Array = NDArray[np.float64]
Measurement = dict[str, NDArray[Any]]
METHODS = ("spectral", "gabor")
RAYS, POINTS = 1, 2  # purposes of seeds


@dataclass(frozen=True, eq=False)
class Plan:
    """What to measure, from each direction of `views` (v, 3).

    side: side^2 rays per view and surface, one in each square of a grid over the period. slopes: number of bins from
    -reach to reach, in units of alpha. lights: polar angles and azimuths of wi, radians. bounces: reflections to follow;
    with none, there is no `lobe` and no `escaped`. bins: number of bins in polar angle and azimuth for `lobe`. method: how
    surfaces are made, "spectral" or "gabor".
    """

    views: ArrayLike
    side: int = 256
    slopes: int = 24
    reach: float = 3.0
    lights: tuple[Sequence[float], Sequence[float]] = ((), ())
    bounces: int = 4
    bins: tuple[int, int] = (45, 72)
    method: str = "spectral"

    def __post_init__(self) -> None:
        views = as_vectors("views", self.views).astype(float)
        if views.ndim != 2 or np.any(views[:, 2] <= 0) or np.any(abs(np.linalg.norm(views, axis=1) - 1) > 1e-6):
            raise ValueError(f"views must be unit vectors above the horizon, of shape (v, 3), got {self.views!r}")
        for name, value, least in (("side", self.side, 1), ("slopes", self.slopes, 1), ("bounces", self.bounces, 0)):
            if value != int(value) or value < least:
                raise ValueError(f"{name} must be a whole number of at least {least}, got {value!r}")
        if len(self.bins) != 2 or min(self.bins) < 1:
            raise ValueError(f"bins must be two whole numbers of at least 1, got {self.bins!r}")
        if not 0 < self.reach < math.inf:
            raise ValueError(f"reach must be a finite number above 0, got {self.reach!r}")
        if any(not 0 <= theta < math.pi / 2 for theta in self.lights[0]):
            raise ValueError(f"lights must have polar angles in [0, pi/2), got {self.lights[0]!r}")
        if self.method not in METHODS:
            raise ValueError(f"method must be one of {', '.join(METHODS)}, got {self.method!r}")
        object.__setattr__(self, "views", views)

    @property
    def slope_edges(self) -> Array:
        """Bounds of the bins of slopes, in units of alpha; the outermost bins hold everything beyond them too."""
        return np.linspace(-self.reach, self.reach, self.slopes + 1)

    @property
    def lobe_edges(self) -> tuple[Array, Array]:
        """Bounds of the bins of wi: polar angles in [0, pi/2], azimuths in [-pi, pi], radians."""
        return np.linspace(0, math.pi / 2, self.bins[0] + 1), np.linspace(-math.pi, math.pi, self.bins[1] + 1)

    @property
    def solid_angle(self) -> Array:
        """Solid angle of each bin of wi, shape `bins`: a lobe divided by it is the mean of the BRDF times cos theta_i."""
        theta, phi = self.lobe_edges
        return np.outer(-np.diff(np.cos(theta)), np.diff(phi))


def shard(family: GaussianField, plan: Plan, first: int, last: int) -> Measurement:
    """Measure the surfaces first..last-1: arrays (surfaces, views, ...) and their numbers, under "surface"."""
    if not 0 <= first < last:
        raise ValueError(f"first and last must be whole numbers with 0 <= first < last, got {first!r} and {last!r}")
    surfaces = [_surface(family, plan, k) for k in range(first, last)]
    return {"surface": np.arange(first, last), **{name: np.stack([m[name] for m in surfaces]) for name in surfaces[0]}}


def gather(shards: Iterable[Mapping[str, NDArray[Any]]]) -> Measurement:
    """All shards as one, in the order of the surfaces, which must be 0, 1, 2, ... without a gap."""
    parts = sorted(shards, key=lambda part: int(part["surface"][0]))
    if not parts or any(part.keys() != parts[0].keys() for part in parts):
        raise ValueError(f"shards must be results of one plan, got {[sorted(part) for part in parts]}")
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    if not np.array_equal(whole["surface"], np.arange(len(whole["surface"]))):
        raise ValueError(f"shards must hold every surface once, got {whole['surface'].tolist()}")
    return whole


def estimate(numerator: ArrayLike, denominator: ArrayLike = 1.0) -> Estimate:
    """Sum over surfaces (the first axis) of one array over that of another, with the jackknife's standard error. efron1982."""
    above, below = np.broadcast_arrays(np.asarray(numerator, float), np.asarray(denominator, float))
    count = len(above) if above.ndim else 0
    if count < 2:
        raise ValueError(f"numerator must hold at least 2 surfaces, got {count}")
    with np.errstate(divide="ignore", invalid="ignore"):
        value = above.sum(axis=0) / below.sum(axis=0)
        without = (above.sum(axis=0) - above) / (below.sum(axis=0) - below)
        return Estimate(value, _scatter(without))


def estimate_of(function: Callable[[Array], ArrayLike], values: ArrayLike) -> Estimate:
    """A function of the mean over surfaces (the first axis), with the jackknife's standard error. efron1982."""
    of = np.asarray(values, float)
    count = len(of) if of.ndim else 0
    if count < 2:
        raise ValueError(f"values must hold at least 2 surfaces, got {count}")
    total = of.sum(axis=0)
    without = np.array([function((total - one) / (count - 1)) for one in of])
    return Estimate(np.asarray(function(total / count), float), _scatter(without))


def _scatter(without: Array) -> Array:
    """The jackknife's standard error, from the values with each one of the surfaces left out."""
    count = len(without)
    error: Array = np.sqrt((count - 1) / count * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
    return error


# --- one surface --------------------------------------------------------------------------------------------------------


def _surface(family: GaussianField, plan: Plan, k: int) -> Measurement:
    surface = HeightField(getattr(family, plan.method)(k))
    alpha = np.array(family.facet_alpha)
    views = [_view(surface, alpha, plan, wo, family, (k, at)) for at, wo in enumerate(np.asarray(plan.views))]
    return {name: np.stack([view[name] for view in views]) for name in views[0]}


def _view(
    surface: HeightField, alpha: Array, plan: Plan, wo: Array, family: GaussianField, number: tuple[int, int]
) -> Measurement:
    k, view = number
    rays, points = (np.random.default_rng(family.seed(k, purpose, view)) for purpose in (RAYS, POINTS))
    origins = np.column_stack([_places(surface, plan, rays), np.full(plan.side**2, surface.highest)])
    hits = surface.trace(origins, -wo)
    positions = surface.points(origins, -wo, hits.distance)
    return {
        **_masking(surface, alpha, plan, wo, _places(surface, plan, points)),
        "normals": _normals(surface, alpha, plan, hits),
        **_shadowing(surface, plan, wo, positions, hits),
        **(_reflection(surface, plan, wo, positions, hits) if plan.bounces else {}),
    }


def _places(surface: HeightField, plan: Plan, rng: np.random.Generator) -> Array:
    """One point in each square of a grid over the period, shape (side^2, 2)."""
    square = np.stack(np.meshgrid(*2 * [np.arange(plan.side)], indexing="ij"), axis=-1).reshape(-1, 2)
    return surface.size / plan.side * (square + rng.uniform(size=square.shape))


def _masking(surface: HeightField, alpha: Array, plan: Plan, wo: Array, places: Array) -> Measurement:
    facets, z = surface.locate(*places.T)
    slopes = surface.slopes[facets]
    area = wo[2] - slopes @ wo[:2]
    front = area > 0
    free = surface.escapes(np.column_stack([places, z])[front], wo, facets[front])
    ahead = _ahead(wo)
    along = (slopes[front] @ ahead) / math.hypot(*(alpha * ahead))
    along = np.clip(along, -plan.reach, plan.reach)
    weights = {"faced": area[front], "seen": area[front] * free}
    return {name: np.histogram(along, plan.slope_edges, weights=w)[0] / len(places) for name, w in weights.items()}


def _normals(surface: HeightField, alpha: Array, plan: Plan, hits: Hits) -> Array:
    relative = np.clip(surface.slopes[hits.facet] / alpha, -plan.reach, plan.reach)
    fractions: Array = np.histogram2d(relative[:, 0], relative[:, 1], bins=(plan.slope_edges, plan.slope_edges))[0] / len(
        relative
    )
    return fractions


def _shadowing(surface: HeightField, plan: Plan, wo: Array, positions: Array, hits: Hits) -> Measurement:
    facing, illuminated = np.zeros((2, *(len(axis) for axis in plan.lights)))
    wm, ahead = surface.normals(hits.facet), _ahead(wo)
    for at in np.ndindex(*facing.shape):
        wi = spherical(plan.lights[0][at[0]], math.atan2(ahead[1], ahead[0]) + plan.lights[1][at[1]])
        faces_light = wm @ wi > 0
        facing[at] = faces_light.mean()
        illuminated[at] = surface.escapes(positions[faces_light], wi, hits.facet[faces_light]).sum() / len(wm)
    return {"facing": facing, "lit": illuminated}


def _reflection(surface: HeightField, plan: Plan, wo: Array, positions: Array, hits: Hits) -> Measurement:
    lobe, escaped = np.zeros((2, *plan.bins)), np.zeros(plan.bounces)
    directions, facets, ahead = np.broadcast_to(-wo, positions.shape), hits.facet, _ahead(wo)
    for bounce in range(plan.bounces):
        wm = surface.normals(facets)
        directions = directions - 2 * np.sum(directions * wm, axis=-1, keepdims=True) * wm
        hits = surface.trace(positions, directions, facets)
        out = directions[hits.facet == ESCAPED]
        theta = np.arctan2(np.hypot(out[:, 0], out[:, 1]), out[:, 2])
        phi = np.arctan2(ahead[0] * out[:, 1] - ahead[1] * out[:, 0], out[:, :2] @ ahead)
        lobe[min(bounce, 1)] += np.histogram2d(theta, phi, bins=plan.lobe_edges)[0] / plan.side**2
        escaped[bounce] = len(out) / plan.side**2
        on = hits.facet >= 0
        positions, directions = surface.points(positions[on], directions[on], hits.distance[on]), directions[on]
        facets = hits.facet[on]
        if not len(facets):
            break
    return {"lobe": lobe, "escaped": escaped}


def _ahead(wo: Array) -> Array:
    """The horizontal unit vector along wo; x if wo is vertical."""
    length = math.hypot(wo[0], wo[1])
    return wo[:2] / length if length > 0 else np.array([1.0, 0.0])
