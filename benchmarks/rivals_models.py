"""Cost of each model that `choose` may choose in chapter 9, and of each sampler of directions.

Names are those of `microfacet.enough.cost`; the error is the relative difference of a value from double precision.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from microfacet.brdf import compensation, reflectance, walk
from microfacet.enough import cost
from microfacet.enough.candidates import Candidate, candidates_for
from microfacet.enough.scene import PRECISIONS, Scene, normals_by_name
from microfacet.material.fresnel import Fresnel

from benchmarks.method import Method

SIZES, WALK_SIZES = (2 * 10**5,), (2 * 10**3,)


def _code(one: Candidate, material: Fresnel) -> tuple[Any, ...]:
    more = {"none": (), "walk": (walk.connections,)}.get(one.compensation, (compensation.compensated,))
    brdf = one.brdf(material, cost.TIMED)
    return type(brdf.model.ndf), type(brdf.model), type(brdf.fresnel), reflectance, *more


def _error(one: Candidate, material: Fresnel) -> Callable[[int], float]:
    def error(size: int) -> float:
        values = cost.evaluation(one, material, 1000)()
        wide = cost.evaluation(replace(one, single=False), material, 1000)()
        return float(np.max(np.abs(values / wide - 1)))

    return error


def _model(one: Candidate, material: Fresnel) -> Method:
    sizes = WALK_SIZES if one.compensation == "walk" else SIZES
    return Method(
        one.label, lambda size: cost.evaluation(one, material, size), _error(one, material), sizes, _code(one, material)
    )


def _sampler(sampler: str, normals: str, real: type) -> Method:
    guide = cost.guide(sampler, normals, cost.TIMED)
    label = f"{normals_by_name()[normals].__name__}, {cost.SAMPLERS[sampler]}, {cost.precision_of(real)}"
    code = (type(guide.model.ndf), guide.model.sampler or type(guide.model.ndf).sample_kernel)
    return Method(
        label, lambda size: cost.sampling(sampler, normals, real, size), lambda size: float(np.finfo(real).eps), SIZES, code
    )


NORMALS = ("ggx", "beckmann")  # those of the models of a scene over Gaussian slopes
METHODS = {
    cost.name_of(one, material): _model(one, material)
    for material in cost.MATERIALS.values()
    for one in candidates_for(Scene(0.3, normals="beckmann", fresnel=None if material.parameters == () else material))
} | {
    cost.sampler_name(sampler, normals, real): _sampler(sampler, normals, real)
    for sampler in cost.SAMPLERS
    for normals in NORMALS
    for real in PRECISIONS["either"]
}
