"""A microsurface in two dimensions: a periodic polyline over a unit segment, with exact visibility.

Every quantity is a property of the polyline itself. Nothing is sampled: one sweep along the horizon gives the part of
each facet that is visible from a direction, cut inside a facet where the horizon crosses it.

Lengths are in units of the segment, whose length is 1. Directions are unit pairs ``(x, z)`` that point away from the
surface; ``z`` is up. Angles are in radians, measured from ``z`` and positive towards ``x``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


def direction(theta: float) -> Array:
    """Unit direction at the angle ``theta`` (radians from ``z``, positive towards ``x``), shape (2,)."""
    if not np.isfinite(theta):
        raise ValueError(f"theta must be a finite angle in radians, got {theta!r}")
    return np.array([np.sin(theta), np.cos(theta)])


def angle(w: ArrayLike) -> Array:
    """Angle of directions of shape (..., 2), in radians from ``z`` and positive towards ``x``."""
    w = np.asarray(w, dtype=float)
    theta: Array = np.arctan2(w[..., 0], w[..., 1])
    return theta


def mirror(w: ArrayLike, wm: ArrayLike) -> Array:
    """Mirror ``w`` about the normals ``wm``: 2 (w.wm) wm - w, of the shape (..., 2) of ``wm``."""
    w, wm = np.asarray(w, dtype=float), np.asarray(wm, dtype=float)
    mirrored: Array = 2 * np.sum(w * wm, axis=-1, keepdims=True) * wm - w
    return mirrored


@dataclass(frozen=True, eq=False)
class Pieces:
    """One piece of each facet: from the fraction ``start`` to the fraction ``stop`` of its length, shape (n,)."""

    profile: Profile
    start: Array
    stop: Array

    @property
    def fraction(self) -> Array:
        """Part of each facet that belongs to the piece, in [0, 1]: for visible pieces, its masking G1."""
        return self.stop - self.start

    @property
    def ends(self) -> Array:
        """Both end points of each piece, shape (n, 2 ends, 2 coordinates)."""
        return np.stack([self.profile.point(self.start), self.profile.point(self.stop)], axis=1)

    @property
    def middle(self) -> Array:
        """Middle point of each piece, shape (n, 2)."""
        return self.profile.point((self.start + self.stop) / 2)

    def projected(self, w: ArrayLike) -> Array:
        """Length of each piece projected along ``w`` (one direction, or one per facet), zero from behind, shape (n,)."""
        cosine = np.sum(np.asarray(w, dtype=float) * self.profile.normals, axis=-1)
        projected: Array = self.fraction * self.profile.lengths * np.maximum(cosine, 0.0)
        return projected

    def both(self, other: Pieces) -> Pieces:
        """The intersection of this piece and the ``other`` one, facet by facet."""
        start = np.maximum(self.start, other.start)
        return Pieces(self.profile, start, np.maximum(np.minimum(self.stop, other.stop), start))

    def without(self, other: Pieces) -> tuple[Pieces, Pieces]:
        """The remainders of this piece before and behind the ``other`` one, facet by facet."""
        inner = self.both(other)
        empty = inner.fraction == 0.0
        before = Pieces(self.profile, self.start, np.where(empty, self.stop, inner.start))
        behind = Pieces(self.profile, np.where(empty, self.stop, inner.stop), self.stop)
        return before, behind


@dataclass(frozen=True, eq=False)
class Profile:
    """Heights ``z`` at the nodes ``x``, both of shape (n + 1,): n facets over [0, 1], repeated for ever."""

    x: Array
    z: Array

    def __post_init__(self) -> None:
        for name in ("x", "z"):
            values = np.array(getattr(self, name), dtype=float)
            if values.ndim != 1 or values.size < 2:
                raise ValueError(f"{name} must have the shape (n + 1,) with n >= 1, got shape {values.shape}")
            if not np.all(np.isfinite(values)):
                raise ValueError(f"{name} must be finite, got {values!r}")
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        if self.x.shape != self.z.shape:
            raise ValueError(f"x and z must have one shape, got {self.x.shape} and {self.z.shape}")
        if self.x[0] != 0 or self.x[-1] != 1 or np.any(np.diff(self.x) <= 0):
            raise ValueError(f"x must rise strictly from 0 to 1, got {self.x!r}")
        if self.z[0] != self.z[-1]:
            raise ValueError(f"z must end at the height it starts from, got {self.z[0]!r} and {self.z[-1]!r}")

    @classmethod
    def gaussian(cls, alpha: float, facets: int, waves: int = 6, seed: int = 0, jitter: float = 0.0) -> Profile:
        """A sum of ``waves`` cosines of random phase, cut into ``facets`` facets.

        The facets have equal widths, unless ``jitter`` in [0, 1) moves the nodes by up to half that part of a width.

        ``alpha`` is the roughness of the Beckmann model: the slopes of the smooth curve have the root mean square
        alpha / sqrt(2). One seed is one curve, however many facets it is cut into.
        """
        if not (np.isfinite(alpha) and alpha >= 0):
            raise ValueError(f"alpha must be finite and >= 0, got {alpha!r}")
        if facets < 1 or waves < 1:
            raise ValueError(f"facets and waves must be at least 1, got facets={facets!r} and waves={waves!r}")
        if not 0 <= jitter < 1:
            raise ValueError(f"jitter must lie in [0, 1), got {jitter!r}")
        rng, moves = (np.random.default_rng(part) for part in np.random.SeedSequence(seed).spawn(2))
        order = np.arange(1, waves + 1)
        phase = rng.uniform(0, 2 * np.pi, waves)
        amplitude = rng.normal(size=waves) * np.exp(-0.5 * (2 * order / waves) ** 2)
        amplitude *= alpha / np.sqrt(np.sum((2 * np.pi * order * amplitude) ** 2))
        x = np.linspace(0.0, 1.0, facets + 1)
        x[1:-1] += jitter / facets * moves.uniform(-0.5, 0.5, facets - 1)
        z = np.cos(2 * np.pi * x[:, None] * order + phase) @ amplitude
        z[-1] = z[0]
        return cls(x, z - z.min())

    def repeat(self, times: int) -> Profile:
        """The same surface, ``times`` of its periods shrunk into the unit segment."""
        if times < 1:
            raise ValueError(f"times must be at least 1, got {times!r}")
        x = np.concatenate([k + self.x[:-1] for k in range(times)] + [np.array([float(times)])]) / times
        return Profile(x, np.append(np.tile(self.z[:-1], times), self.z[-1]) / times)

    @cached_property
    def edges(self) -> Array:
        """Vector along each facet, shape (n, 2)."""
        return np.stack([np.diff(self.x), np.diff(self.z)], axis=-1)

    @cached_property
    def lengths(self) -> Array:
        """Length of each facet, shape (n,); their sum is the area of the microsurface."""
        return np.hypot(self.edges[:, 0], self.edges[:, 1])

    @cached_property
    def normals(self) -> Array:
        """Unit normal of each facet, wm, shape (n, 2)."""
        return np.stack([-self.edges[:, 1], self.edges[:, 0]], axis=-1) / self.lengths[:, None]

    @property
    def whole(self) -> Pieces:
        """Every facet, from end to end."""
        return Pieces(self, np.zeros(len(self.lengths)), np.ones(len(self.lengths)))

    def point(self, fraction: Array) -> Array:
        """Point at a ``fraction`` in [0, 1] of each facet's length, shape (n, 2)."""
        nodes = np.stack([self.x, self.z], axis=-1)[:-1]
        return nodes + fraction[:, None] * self.edges

    def bins(self, bounds: ArrayLike) -> Integers:
        """Index of the bin that holds each normal's angle, for rising ``bounds`` in radians, shape (n,)."""
        bounds = np.asarray(bounds, dtype=float)
        theta = angle(self.normals)
        if bounds.ndim != 1 or bounds.size < 2 or not np.all(np.diff(bounds) > 0):
            raise ValueError(f"bounds must be a row of rising angles, got {bounds!r}")
        if theta.min() < bounds[0] or theta.max() >= bounds[-1]:
            raise ValueError(f"bounds must enclose the normals' angles {theta.min()} to {theta.max()}, got {bounds!r}")
        return np.digitize(theta, bounds) - 1

    def visible(self, wo: ArrayLike) -> Pieces:
        """The parts of the facets that are visible from the direction ``wo``, shape (2,), by exact clipping."""
        wo = _checked(wo)
        return Pieces(self, *_clip(self.x, self.z, wo[0] / wo[1]))

    def escaping(self, wi: ArrayLike) -> Pieces:
        """The parts from which rays leave freely along ``wi``, shape (n, 2): one direction for each facet.

        Rays that start horizontally or downwards always meet the surface again.
        """
        wi = np.asarray(wi, dtype=float)
        if wi.shape != self.normals.shape or not np.all(np.isfinite(wi)):
            raise ValueError(f"wi must be finite, of shape {self.normals.shape}, got shape {wi.shape}: {wi!r}")
        bounds = np.zeros((len(wi), 2))
        for k in np.flatnonzero(wi[:, 1] > 0):
            start, stop = _clip(self.x, self.z, wi[k, 0] / wi[k, 1])
            bounds[k] = start[k], stop[k]
        return Pieces(self, bounds[:, 0], bounds[:, 1])

    def hit(self, facet: int, origin: ArrayLike, w: ArrayLike) -> float:
        """Length of the ray from ``origin`` on a ``facet`` along ``w`` to the next facet it meets; inf if none.

        A ray that meets a periodic surface again does so within one period.
        """
        origin, w = np.asarray(origin, dtype=float), np.asarray(w, dtype=float)
        n = len(self.lengths)
        shift = np.repeat([-1.0, 0.0, 1.0], n)
        start = np.tile(self.point(np.zeros(n)), (3, 1)) + np.stack([shift, 0 * shift], axis=-1) - origin
        edge = np.tile(self.edges, (3, 1))
        across = w[0] * edge[:, 1] - w[1] * edge[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / across
            place = (start[:, 0] * w[1] - start[:, 1] * w[0]) / across
        met = (along > 0) & (place >= 0) & (place <= 1) & (np.arange(3 * n) != n + facet)
        return float(np.min(along[met], initial=np.inf))


def _checked(wo: ArrayLike) -> Array:
    wo = np.asarray(wo, dtype=float)
    if wo.shape != (2,):
        raise ValueError(f"wo must have the shape (2,), got shape {wo.shape}: {wo!r}")
    if not np.all(np.isfinite(wo)):
        raise ValueError(f"wo must be finite, got {wo!r}")
    if abs(np.hypot(*wo) - 1) > 1e-6:
        raise ValueError(f"wo must have length 1, got {wo!r}")
    if wo[1] <= 0:
        raise ValueError(f"wo must point above the horizon, z > 0, got {wo!r}")
    return wo


def _clip(x: Array, z: Array, slope: float) -> tuple[Array, Array]:
    """First and last visible fraction of each facet, seen along the direction (slope, 1).

    Along that direction a point falls onto the plane z = 0 at s = x - slope z. For slope >= 0 it is visible if no
    point further right has a smaller s. So the horizon is the running minimum of s from the right; it starts with the
    minimum of the next period, which lies 1 further on. For slope < 0 the surface is mirrored.
    """
    if slope < 0:
        start, stop = _clip(1 - x[::-1], z[::-1], -slope)
        return 1 - stop[::-1], 1 - start[::-1]
    s = x - slope * z
    horizon = np.minimum(np.minimum.accumulate(s[::-1])[::-1], 1 + s.min())[1:]
    rise = np.diff(s)
    front = rise > 0
    stop = np.where(front, (horizon - s[:-1]) / np.where(front, rise, 1.0), 0.0)
    return np.zeros_like(stop), np.clip(stop, 0.0, 1.0)
