"""How far a candidate is from the truth: in albedo, in lobe, and in a picture of spheres under a sky."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from microfacet.brdf.microfacet import Microfacet
from microfacet.enough.lobes import Array, Reference, Ruled, binned, nodes
from microfacet.enough.scene import Point, Scene
from microfacet.visibility.smith import Smith

SUN, SKY = (0.6, 0.64, 0.48), (0.3, 0.7, 5.0, 20.0)  # direction of the sun; ground, sky, sun, its concentration
RING_AZIMUTHS = 12  # points along each ring of the sphere


class Error(NamedTuple):
    """A candidate's error, and a bound on the uncertainty of that."""

    value: float
    bound: float


def albedo_error(lobe: Ruled, truth: Reference) -> Error:
    """Absolute difference of the two albedos."""
    return Error(abs(float(lobe.lobe.sum() - truth.lobe.sum())), float(lobe.error(truth.once).sum()) + _light_error(truth))


def lobe_error(lobe: Ruled, truth: Reference) -> Error:
    """Half the sum of all differences, over the total light, which is itself uncertain."""
    light = float(truth.lobe.sum())
    light_bound = _light_error(truth) + float(truth.once.error().sum())
    off = 0.5 * float(abs(lobe.lobe - truth.lobe).sum())
    bound = truth.misplaced() + 0.5 * float(lobe.error(truth.once).sum())
    return quotient(off, bound, light, light_bound)


def quotient(above: float, above_bound: float, below: float, below_bound: float) -> Error:
    """A quotient of two numbers that are known within bounds; its bound is infinite where the denominator may be 0."""
    if not below > below_bound:
        return Error(0.0, math.inf)
    value = above / below
    return Error(value, (above + above_bound) / (below - below_bound) - value)


def _light_error(truth: Reference) -> float:
    return float(truth.bound(lambda lobes: lobes.sum(axis=(1, 2))))


def sky(w: Array) -> Array:
    """Radiance from the directions w (..., 3), y up: a sky brighter than the ground, and one broad sun."""
    ground, above, sun, narrow = SKY
    light: Array = ground + above * (1 + w[..., 1]) / 2 + sun * np.exp(narrow * (w @ np.array(SUN) / np.linalg.norm(SUN) - 1))
    return light


def light_of(point: Point, scene: Scene) -> Array:
    """Mean radiance in each bin for each point of a ring of the sphere, (RING_AZIMUTHS, ROWS, COLUMNS)."""
    rule = nodes(point)
    weight = rule.weight * Microfacet(Smith(point.ndf(scene.normals))).evaluate(point.wo, rule.wi)
    total = np.maximum(binned(weight), 1e-300)
    theta, phi = math.radians(point.theta), math.radians(point.phi)
    global_wi = rule.wi @ np.array([[math.cos(phi), -math.sin(phi), 0], [math.sin(phi), math.cos(phi), 0], [0, 0, 1]])
    return np.array(
        [
            binned(weight * sky(global_wi @ _axes(theta, azimuth))) / total
            for azimuth in 2 * math.pi * np.arange(RING_AZIMUTHS) / RING_AZIMUTHS
        ]
    )


def radiance_under(light: Array) -> Callable[[Array], Array]:
    """Radiance that lobes (n, ...) send to the viewer from each point of a ring, (n, RING_AZIMUTHS)."""

    def radiance(lobes: Array) -> Array:
        total: Array = np.einsum("tij,nij->nt", light, lobes)
        return total

    return radiance


def _axes(theta: float, azimuth: float) -> Array:
    """Local axes, one a row, at a point of a sphere viewed from +z: towards the view, across it, the normal."""
    c, s = math.cos(azimuth), math.sin(azimuth)
    towards = [-math.cos(theta) * c, -math.cos(theta) * s, math.sin(theta)]
    return np.array([towards, [s, -c, 0], [math.sin(theta) * c, math.sin(theta) * s, math.cos(theta)]])
