"""Random BRDFs and views over the whole domain of the albedo, and its distance to another sum.

Alike in number over the logarithm of roughness, of its ratio, of distances from the horizon, the pole, the axes, and the angles
at which total reflection begins or touches the horizon.
"""

from __future__ import annotations

from typing import Any

import microfacet as mf
import numpy as np
import rays

MODELS: dict[str, Any] = {
    "height": mf.Smith,
    **{name: lambda ndf, name=name: mf.Smith(ndf, name) for name in ("none", "direction", "height-direction")},
    "v_cavity": mf.VCavity,
    "implicit": mf.Implicit,
    "kelemen": mf.Kelemen,
    "schlick_smith": mf.SchlickSmith,
}
# Few pairs, because each compiles for itself: every family, masking and reflectance with several of the others.
CLOSED = [
    *[("height", mf.GGX, kind) for kind in ("mirror", "dielectric", "conductor")],
    *[("none", mf.GGX, "dielectric"), ("direction", mf.GGX, "dielectric"), ("direction", mf.GGX, "tint")],
    *[("height-direction", mf.GGX, kind) for kind in ("mirror", "conductor", "schlick")],
    *[("v_cavity", mf.GGX, kind) for kind in ("dielectric", "conductor")],
    *[("implicit", mf.GGX, "dielectric"), ("kelemen", mf.GGX, "dielectric"), ("schlick_smith", mf.GGX, "dielectric")],
    *[("height", mf.Beckmann, kind) for kind in ("dielectric", "conductor", "tint")],
    *[("none", mf.Beckmann, "dielectric"), ("direction", mf.Beckmann, "schlick")],
    *[("height-direction", mf.Beckmann, "dielectric"), ("v_cavity", mf.Beckmann, "dielectric")],
    *[("kelemen", mf.Beckmann, "mirror"), ("v_cavity", mf.Ward, "mirror"), ("v_cavity", mf.Ward, "dielectric")],
    *[("kelemen", mf.Ward, "conductor"), ("schlick_smith", mf.Ward, "dielectric"), ("implicit", mf.Ward, "schlick")],
    *[("v_cavity", mf.BlinnPhong, "conductor"), ("schlick_smith", mf.NormalizedBlinnPhong, "dielectric")],
    ("v_cavity", mf.NormalizedBlinnPhong, "dielectric"),
]
INTEGRALS = [  # of which Lambda is an integral itself
    *[("height", mf.Ward, "dielectric"), ("direction", mf.Ward, "mirror"), ("height", mf.BlinnPhong, "dielectric")],
    *[("height-direction", mf.NormalizedBlinnPhong, "conductor"), ("none", mf.NormalizedBlinnPhong, "schlick")],
]
KINDS = CLOSED + INTEGRALS
CASES = [32] * len(CLOSED) + [8] * len(INTEGRALS)


def alphas(g: np.random.Generator) -> tuple[float, float]:
    """From 1e-8 to 1e3, equal in a third of the cases, else of a ratio up to 1e4."""
    first = 10 ** g.uniform(-8, 3)
    ratio = 10 ** g.uniform(-4, 4) if g.random() < 2 / 3 else 1.0
    return float(first), float(np.clip(first * ratio, 1e-8, 1e3))


def index(g: np.random.Generator) -> float:
    """Of refraction, from 1/4 to 4, a third of them next to 1."""
    near = 1 + g.choice([-1, 1]) * 10 ** g.uniform(-6, -0.2)
    return float(near if g.random() < 1 / 3 else 4 ** g.uniform(-1, 1))


def reflectance(kind: str, g: np.random.Generator) -> Any | None:
    if kind == "dielectric":
        return mf.Dielectric(index(g))
    if kind == "conductor":
        return mf.Conductor(
            index(g), float((0.0, 10 ** g.uniform(-8, -2), 10 ** g.uniform(-2, 1), g.uniform(0, 10))[g.integers(4)])
        )
    if kind == "schlick":
        return mf.Schlick(float(g.choice([0.0, g.uniform(0, 1)])), float(g.choice([1.0, g.uniform(0, 1)])))
    return None if kind == "mirror" else mf.F82Tint(float(g.uniform(0.3, 1)), float(g.uniform(0.7, 1)))


def heights(fresnel: Any, g: np.random.Generator) -> list[float]:
    """Of a view: anywhere, near the horizon, near the pole, both ends, and near where total reflection begins, for the mirror
    facet and for one that sends light along the horizon."""
    found = [g.uniform(1e-8, 1), 10 ** g.uniform(-8, 0), 1 - 10 ** g.uniform(-15, 0), g.choice([1e-8, 1.0])]
    level = 1 - fresnel.parameters[0] ** 2 if isinstance(fresnel, mf.Dielectric | mf.Conductor) else 1.0
    if 0 < level < 1:
        near = 1 + g.choice([-1, 1]) * 10 ** g.uniform(-12, -1)
        found += [min(near * c, 1.0) for c in (np.sqrt(level), 2 * np.sqrt(level * (1 - level)))]
    return [max(float(z), 1e-8) for z in found]


def view(fresnel: Any, g: np.random.Generator) -> np.ndarray:
    z = g.choice(heights(fresnel, g))
    quarter = np.pi / 2 * g.integers(4)
    phi = g.choice([g.uniform(0, 2 * np.pi), quarter, quarter + 10 ** g.uniform(-8, 0)])
    across = np.sqrt((1 - z) * (1 + z))
    return np.array([across * np.cos(phi), across * np.sin(phi), z])


def case(kind: int, k: int) -> tuple[mf.Microfacet, np.ndarray]:
    g = np.random.default_rng([kind, k])
    model, family, name = KINDS[kind]
    both = alphas(g)
    if family in (mf.BlinnPhong, mf.NormalizedBlinnPhong):
        ndf = family(float(10 ** g.uniform(-6, 16)))
    else:
        ndf = family(*(both[:1] if kind >= len(CLOSED) else both))
    fresnel = reflectance(name, g)
    return mf.Microfacet(MODELS[model](ndf), fresnel), view(fresnel, g)


def compared(brdf: mf.Microfacet, wo: np.ndarray) -> tuple[float, float, float]:
    """The distance to another sum over the error told, the error told and that of the other sum, both relative."""
    value, error = map(float, brdf.albedo_with_error(wo))
    truth, off = rays.albedo(brdf, wo, value, error / 10)
    return abs(value - truth) / error, error / value, off / value
