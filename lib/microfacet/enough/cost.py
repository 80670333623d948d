"""Cost of a candidate: nanoseconds per value in large arrays, timed now or from a record of benchmarks."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from microfacet.brdf.microfacet import Microfacet
from microfacet.directions import spherical
from microfacet.enough.candidates import Candidate
from microfacet.enough.scene import Point, normals_by_name
from microfacet.material.fresnel import Conductor, Dielectric, Fresnel, Mirror
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity

QUANTITY = "models"  # the name in the record
SAMPLERS = {"normals": "all normals", "visible": "visible normals"}
MATERIALS: dict[str, Fresnel] = {"mirror": Mirror(), "dielectric": Dielectric(1.5), "conductor": Conductor(0.2, 3.9)}
TIMED = Point(0.3, 0.3, 50.0, 0.0)  # times hardly depend on roughness or view
COUNT, ROUNDS = 1 << 15, 15

Costs = Mapping[str, float]
Call = Callable[[], Any]


def name_of(one: Candidate, material: Fresnel) -> str:
    """The name of a candidate's time: neither roughness nor anisotropy matters."""
    kind = "schlick" if one.fresnel == "schlick" else type(material).__name__.lower()
    return ".".join((one.normals, one.masking, kind, one.compensation, precision_of(one.real)))


def sampler_name(sampler: str, normals: str, real: type) -> str:
    return f"{normals}.{sampler}.{precision_of(real)}"


def precision_of(real: type) -> str:
    return "single" if real is np.float32 else "double"


def directions(count: int, seed: int, real: type) -> Any:
    """Directions (count, 3) of the upper hemisphere, evenly in solid angle."""
    u = np.random.default_rng(seed).random((2, count))
    return spherical(np.arccos(0.001 + 0.999 * u[0]), 2 * math.pi * u[1]).astype(real)


def evaluation(one: Candidate, material: Fresnel, count: int) -> Call:
    """A call that evaluates the candidate for `count` pairs of directions."""
    wo, wi = directions(count, 1, one.real), directions(count, 2, one.real)
    evaluate = one.evaluate(material, TIMED)
    return lambda: evaluate(wo, wi)


def samplers_of(normals: str) -> list[str]:
    """The samplers of a distribution."""
    kind = normals_by_name()[normals]
    kernels = {"normals": kind.sample_kernel, "visible": kind.sample_visible_kernel}
    return [name for name in SAMPLERS if kernels[name] is not None]


def guide(sampler: str, normals: str, point: Point) -> Microfacet:
    """A BRDF whose `sample` and `pdf` are those of all normals or of visible ones."""
    ndf = point.ndf(normals)
    return Microfacet(VCavity(ndf) if sampler == "normals" else Smith(ndf))


def sampling(sampler: str, normals: str, real: type, count: int) -> Call:
    """A call that draws `count` directions and computes their densities."""
    brdf, wo = guide(sampler, normals, TIMED), directions(count, 1, real)
    u = np.minimum(np.random.default_rng(3).random((count, 2)).astype(real), np.nextafter(real(1), real(0)))
    return lambda: brdf.pdf(wo, brdf.sample(wo, u))


def recorded(path: Path) -> dict[str, float]:
    """Nanoseconds by name, from the recorded medians for the largest arrays; empty without a record."""
    try:
        record = json.loads(path.read_text("utf-8"))
        rows = record.get(QUANTITY, {}).get("rows", {})
        return {name: 1e9 * row["seconds"][-1][1] / row["sizes"][-1] for name, row in rows.items()}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError) as fault:
        raise ValueError(f"{path} is not a record of benchmarks: {type(fault).__name__}: {fault}") from None


def timed(calls: Iterable[tuple[str, Call]], count: int = COUNT) -> dict[str, float]:
    """Nanoseconds by name, measured now on this machine: the minimum over rounds in which every call runs once."""
    jobs = dict(calls)
    for call in jobs.values():
        call()  # may compile
    best = dict.fromkeys(jobs, math.inf)
    for _ in range(ROUNDS):
        for name, call in jobs.items():
            begin = time.perf_counter()
            call()
            best[name] = min(best[name], time.perf_counter() - begin)
    return {name: 1e9 * seconds / count for name, seconds in best.items()}
