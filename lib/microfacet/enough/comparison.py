"""Candidates compared with the most complete model, at every point of a scene."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from microfacet.directions import whole
from microfacet.enough.candidates import Candidate, candidates_for
from microfacet.enough.lobes import Array, Reference, Ruled, surface, walked
from microfacet.enough.measures import Error, albedo_error, light_of, lobe_error, quotient, radiance_under
from microfacet.enough.scene import Point, Scene

SURFACES, WALKS = 8, 1 << 16


class Measured(NamedTuple):
    """A candidate's error at the worst of all points, and the lower and upper bound of the largest error."""

    error: Error
    least: float
    most: float


class Comparison:
    """All candidates for a scene compared with the most complete model, at every point of the scene.

    surfaces: number of ray-traced surfaces, for Gaussian slopes; walks: number of walks through Smith's model, for GGX.
    points: by default the scene's.
    """

    def __init__(
        self, scene: Scene, surfaces: int = SURFACES, walks: int = WALKS, points: tuple[Point, ...] | None = None
    ) -> None:
        self.scene, self.surfaces, self.walks = scene, whole("surfaces", surfaces, 2), whole("walks", walks, 2)
        self.points = scene.points if points is None else points
        self._lobes: dict[Candidate, list[Ruled]] = {}

    @cached_property
    def candidates(self) -> list[Candidate]:
        return candidates_for(self.scene)

    @cached_property
    def truth(self) -> list[Reference]:
        """The most complete model there is, one lobe for each point."""
        if self.scene.normals == "beckmann":
            return [surface(self.scene, point, self.surfaces) for point in self.points]
        return [walked(self.scene, point, self.walks) for point in self.points]

    def lobes(self, one: Candidate) -> list[Ruled]:
        if one not in self._lobes:
            self._lobes[one] = [one.lobe(self.scene, point, self.walks) for point in self.points]
        return self._lobes[one]

    def measured(self, one: Candidate, measure: str) -> Measured:
        """The error of a candidate over all points."""
        if measure == "picture":
            return self._worst([self._picture(one, group) for group in self._rings()])
        of = {"albedo": albedo_error, "lobe": lobe_error}[measure]
        return self._worst([of(lobe, truth) for lobe, truth in zip(self.lobes(one), self.truth, strict=True)])

    def _worst(self, errors: list[Error]) -> Measured:
        worst = max(errors, key=lambda error: error.value + error.bound)
        least = max(max(error.value - error.bound, 0.0) for error in errors)
        return Measured(worst, least, worst.value + worst.bound)

    def _rings(self) -> list[list[int]]:
        """The points that make up one sphere: of one roughness and one azimuth."""
        groups: dict[tuple[float, ...], list[int]] = {}
        for at, point in enumerate(self.points):
            groups.setdefault((point.alpha_x, point.alpha_y, point.phi), []).append(at)
        return list(groups.values())

    @cached_property
    def _skies(self) -> list[Array]:
        return [light_of(point, self.scene) for point in self.points]

    def _picture(self, one: Candidate, ring: list[int]) -> Error:
        """Mean over a sphere of the relative error of radiance, every ring weighted by its area in the picture."""
        theta = np.radians([self.points[at].theta for at in ring])
        area = np.sin(2 * theta) if len(ring) > 1 else np.ones(1)
        off, noise = np.zeros(len(ring)), np.zeros(len(ring))
        for k, at in enumerate(ring):
            light, truth, lobe = self._skies[at], self.truth[at], self.lobes(one)[at]
            expected, sent = (np.einsum("tij,ij->t", light, sums) for sums in (truth.lobe, lobe.lobe))
            scatter, rule, once = (
                truth.bound(radiance_under(light)),
                *(np.einsum("tij,ij->t", light, sums) for sums in (lobe.error(truth.once), truth.once.error())),
            )
            errors = [
                quotient(*numbers)
                for numbers in zip(abs(sent - expected), scatter + rule, expected, scatter + once, strict=True)
            ]
            off[k], noise[k] = np.mean(errors, axis=0)
        return Error(float(area @ off / area.sum()), float(area @ noise / area.sum()))
