"""The models to choose from: one form of each part, from the crudest to the most complete."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from microfacet.brdf.compensation import Compensated
from microfacet.brdf.microfacet import Microfacet
from microfacet.brdf.random_walk import RandomWalk
from microfacet.enough.lobes import Ruled, ruled, walked
from microfacet.enough.scene import PRECISIONS, Point, Scene, normals_by_name
from microfacet.families import families, key_of
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution, alpha_of
from microfacet.material.fresnel import Fresnel, Mirror, Schlick
from microfacet.visibility.masking import Masking
from microfacet.visibility.smith import Smith
from microfacet.visibility.unphysical import Implicit, Kelemen, SchlickSmith
from microfacet.visibility.v_cavity import VCavity

Evaluate = Callable[[Any, Any], Any]


def schlick_smith(ndf: Distribution) -> SchlickSmith:
    """Schlick's masking with the k that suits the distribution: half of GGX's alpha, Beckmann's times sqrt(2/pi)."""
    return SchlickSmith(ndf, max(alpha_of(ndf)) / 2 if isinstance(ndf, GGX) else None)


MASKINGS: dict[str, tuple[str, Callable[[Any], Masking]]] = {
    "implicit": ("implicit", Implicit),
    "schlick": ("Schlick-Smith", schlick_smith),
    "separable": ("Smith, separable", lambda ndf: Smith(ndf, "none")),
    "height": ("Smith, height-correlated", Smith),
    "v_cavity": ("V-cavities", VCavity),
}
LEFT_OUT = (Smith, SchlickSmith, Kelemen)  # families with forms of their own above, or that no scene needs


def maskings() -> dict[str, tuple[str, Callable[[Any], Masking]]]:
    """Label and constructor of each masking function to choose from: those above, then all other families."""
    known = (*LEFT_OUT, *(make for _, make in MASKINGS.values()))
    more = {key_of(kind): (kind.label, kind) for kind in families(Masking) if kind not in known}
    return {**MASKINGS, **more}


COMPENSATIONS = {"none": "single scattering", "scaled": "scaled", "lobe": "lobe added", "walk": "random walk"}


@dataclass(frozen=True)
class Candidate:
    """One form of each part, by name.

    normals: a key of `normals_by_name`. masking: one of `maskings`. fresnel: "mirror", "schlick" or "exact". anisotropic: two
    roughnesses, or their geometric mean for both. compensation: the treatment of multiple scattering, a key of
    `COMPENSATIONS`. single: whether it computes in single precision.
    """

    normals: str
    masking: str
    fresnel: str
    anisotropic: bool
    compensation: str
    single: bool

    @property
    def real(self) -> type:
        return np.float32 if self.single else np.float64

    def ndf(self, point: Point) -> Distribution:
        mean = math.sqrt(point.alpha_x * point.alpha_y)
        return (point if self.anisotropic else point._replace(alpha_x=mean, alpha_y=mean)).ndf(self.normals)

    def reflectance(self, exact: Fresnel) -> Fresnel:
        return Schlick(float(exact.F(1.0))) if self.fresnel == "schlick" else exact

    def brdf(self, exact: Fresnel, point: Point) -> Microfacet:
        """The BRDF without compensation."""
        return Microfacet(maskings()[self.masking][1](self.ndf(point)), self.reflectance(exact))

    def evaluate(self, exact: Fresnel, point: Point) -> Evaluate:
        """The whole BRDF: (wo, wi) -> values, 1/sr."""
        brdf = self.brdf(exact, point)
        if self.compensation == "none":
            return brdf.evaluate
        if self.compensation != "walk":
            return _compensated(self, exact, point._replace(theta=0.0, phi=0.0)).evaluate
        walk = RandomWalk(Smith(self.ndf(point)), brdf.fresnel)
        return lambda wo, wi: walk.evaluate(wo, wi, walks=2)

    def lobe(self, scene: Scene, point: Point, walks: int) -> Ruled:
        """The candidate's lobe, light by bin; the random walk's own is a mean over many walks."""
        if self.compensation == "walk":
            reference = walked(scene, point, walks, self.ndf(point))
            return Ruled(reference.lobe, reference.once.coarse + (reference.lobe - reference.once.lobe))
        evaluate = self.evaluate(scene.material, point)
        return ruled(lambda wo, wi: evaluate(wo.astype(self.real), wi.astype(self.real)), scene, point)

    @property
    def label(self) -> str:
        """All parts in one line."""
        return ", ".join(self.parts())

    def parts(self) -> tuple[str, ...]:
        kind = normals_by_name()[self.normals].__name__ + (" of two roughnesses" if self.anisotropic else "")
        fresnel = {"mirror": "no Fresnel", "schlick": "Schlick's Fresnel", "exact": "exact Fresnel"}[self.fresnel]
        return (
            kind,
            maskings()[self.masking][0],
            fresnel,
            COMPENSATIONS[self.compensation],
            "single precision" if self.single else "double precision",
        )


@lru_cache(maxsize=256)
def _compensated(one: Candidate, exact: Fresnel, point: Point) -> Compensated:
    """Prepared once for all views of a roughness."""
    return Compensated(one.brdf(exact, point), one.compensation)


def candidates_for(scene: Scene) -> list[Candidate]:
    """All models for a scene, the crudest first: more complete distributions, maskings, ... come later."""
    first = list(dict.fromkeys(["ggx", scene.normals]))
    forms: list[list[Any]] = [
        [one == np.float32 for one in PRECISIONS[scene.precision][::-1]],
        list(COMPENSATIONS) if scene.bounces == "all" else ["none"],
        [False, True] if scene.ratio[1] > 1 else [False],
        ["mirror"] if isinstance(scene.material, Mirror) else ["schlick", "exact"],
        list(maskings()),
        first,
    ]
    made = [Candidate(*reversed(parts)) for parts in product(*forms)]
    return [one for one in made if _sensible(one)]


def _sensible(one: Candidate) -> bool:
    """Compensation is for the energy that Smith's model loses; the walk is the most complete model of all."""
    if one.compensation == "none":
        return True
    whole = one.masking == "height"
    return whole and (one.compensation != "walk" or (one.fresnel != "schlick" and not one.single))
