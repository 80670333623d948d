"""Microfacet models: distributions of normals, masking and shadowing, and whether a model is one.

import microfacet as mf
model = mf.Smith(mf.GGX(0.3, 0.1))
mf.Microfacet(model).evaluate(wo, wi)
mf.validate(model)
mf.equations["geometry.ggx.Lambda"].latex
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

PUBLIC = {
    "BRDF": "brdf.base",
    "Beckmann": "geometry.beckmann",
    "BlinnPhong": "geometry.blinn_phong",
    "Compensated": "brdf.compensation",
    "Conductor": "material.fresnel",
    "Dielectric": "material.fresnel",
    "Diffuse": "brdf.diffuse",
    "Distribution": "geometry.slopes",
    "F82Tint": "material.fresnel",
    "Frame": "frame",
    "Fresnel": "material.fresnel",
    "GGX": "geometry.ggx",
    "Implicit": "visibility.unphysical",
    "Kelemen": "visibility.unphysical",
    "Masking": "visibility.masking",
    "Microfacet": "brdf.microfacet",
    "NormalizedBlinnPhong": "geometry.blinn_phong",
    "RandomWalk": "brdf.random_walk",
    "Schlick": "material.fresnel",
    "SchlickSmith": "visibility.unphysical",
    "Smith": "visibility.smith",
    "VCavity": "visibility.v_cavity",
    "Ward": "geometry.ward",
    "alpha_from_roughness": "geometry.roughness",
    "choose": "enough.choice",
    "equations": "statements.statement",
    "half_vector": "directions",
    "reflect": "directions",
    "seen_area": "validation.adaptive",
    "spherical": "directions",
    "stretched_alpha": "geometry.roughness",
    "validate": "validation.equations",
}


def __getattr__(name: str) -> Any:
    if name not in PUBLIC:
        raise AttributeError(f"microfacet has no {name!r}; it has {', '.join(sorted(PUBLIC))}")
    value = getattr(importlib.import_module(f"microfacet.{PUBLIC[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*PUBLIC, "__version__"])
