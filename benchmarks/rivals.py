"""For each quantity the ways to have it that are timed and charted against one another: a module `rivals_*` each.

To add a rival: write it as a function in the module of its quantity and give it an entry in the table METHODS there, whose
key is its name in the record. Its error is charted with the next build, its time after `make bench NAME=quantity`; until
then it is drawn as unmeasured. To add a quantity: a module with such a table, and a line below. A program that runs as a
process of its own, or needs a compiler, has its place in yardsticks.py.
"""

from __future__ import annotations

from benchmarks import (
    rivals_brdf,
    rivals_estimate,
    rivals_fresnel,
    rivals_growth,
    rivals_integral,
    rivals_masking,
    rivals_models,
    rivals_normals,
    rivals_rays,
    rivals_render,
    rivals_sampling,
    rivals_tracing,
)
from benchmarks.method import Method

QUANTITIES: dict[str, dict[str, Method]] = {
    "masking": rivals_masking.METHODS,
    "normals": rivals_normals.METHODS,
    "brdf": rivals_brdf.METHODS,
    "integral": rivals_integral.METHODS,
    "sampling": rivals_sampling.METHODS,
    "fresnel": rivals_fresnel.METHODS,
    "models": rivals_models.METHODS,
    "estimate": rivals_estimate.METHODS,
    "render": rivals_render.METHODS,
    "rays": rivals_rays.METHODS,
    "tracing": rivals_tracing.METHODS,
    "growth": rivals_growth.METHODS,
}
