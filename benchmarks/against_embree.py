"""Rays per second and false verdicts over sizes of surfaces, here and in Embree, in one run. Needs embreex; not a test.

    python -m benchmarks.against_embree [nodes per side ...]             one thread each
    MICROFACET_THREADS=2 python -m benchmarks.against_embree             two

Runs of the two alternate, and the best of each counts: use the ratios. embreex has one thread; for more, several processes
share the rays. "Sorted" rays come tile by tile. False verdicts: visible facets whose shadow ray back to the viewer is blocked.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable

os.environ.setdefault("MICROFACET_THREADS", "1")
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from microfacet.directions import spherical
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField

from benchmarks.embree import Sharers, scene_of

RAYS, RUNS = 1_000_000, 7


def best(works: list[Callable[[], object]]) -> list[float]:
    """Million rays per second of each of the works, the best of alternating runs."""
    seconds = [np.inf] * len(works)
    for _ in range(RUNS):
        for k, work in enumerate(works):
            start = time.perf_counter()
            work()
            seconds[k] = min(seconds[k], time.perf_counter() - start)
    return [RAYS / s / 1e6 for s in seconds]


def main(size: int) -> None:
    start = time.process_time()
    field = HeightField(GaussianField(size, 0.7).spectral(0))
    built = time.process_time() - start
    rng, wo = np.random.default_rng(1), spherical(np.radians(60), 0.3)
    origins = np.column_stack([rng.uniform(0, size, (RAYS, 2)), np.full(RAYS, field.highest)])
    start = time.process_time()
    scene = scene_of(field.heights)
    scene.run(origins[:1].astype(np.float32), -wo[None].astype(np.float32))
    print(f"{size}^2: made and built in {built:.1f} s here, built in {time.process_time() - start:.1f} s by Embree")
    tiles = np.lexsort((origins[:, 1] // 64, origins[:, 0] // 64))
    for name, order in (("unsorted", slice(None)), ("sorted", tiles)):
        o, d = origins[order], np.broadcast_to(-wo, (RAYS, 3)).copy()
        hits = field.trace(o, d)
        p, wm = field.points(o, d, hits.distance), field.normals(hits.facet)
        mirrored = d - 2 * np.sum(d * wm, axis=-1, keepdims=True) * wm
        for kind, a, b, own in (("primary", o, d, None), ("reflected", p, mirrored, hits.facet), ("shadow", p, -d, hits.facet)):
            a4, b4 = a.astype(np.float32), b.astype(np.float32)
            sharers = Sharers(scene, a4, b4)
            ours, theirs = best([lambda a=a, b=b, own=own: field.trace(a, b, own), sharers])
            sharers.close()
            print(f"  {name:9}{kind:10} {ours:6.2f} here {theirs:6.2f} Embree   ratio {ours / theirs:.1f}", flush=True)
    ours = np.mean(~field.escapes(p, -d, hits.facet))
    print(f"  false verdicts {ours:.2g} here {np.mean(scene.run(a4, b4) >= 0):.2g} Embree, without an offset", flush=True)


if __name__ == "__main__":
    for side in [int(word) for word in sys.argv[1:]] or [1024, 2048, 4096]:
        main(side)
