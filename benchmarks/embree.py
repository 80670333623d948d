"""Embree's rays, through embreex, in single precision. It has one thread, so several processes share the rays."""

from __future__ import annotations

import multiprocessing
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from microfacet.compiler.processors import threads

from benchmarks import rivals_rays

MARGIN = 256  # cells around one period, which Embree does not repeat: more than a ray crosses below the highest point
OFFSETS = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)


def scene_of(heights: np.ndarray) -> Any:
    """One period of the surface and a margin around it, as Embree's triangles."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    z = np.pad(heights, MARGIN, mode="wrap")
    i, j = np.meshgrid(*2 * [np.arange(-MARGIN, len(heights) + MARGIN)], indexing="ij")
    corner = np.arange(z.size).reshape(z.shape)[:-1, :-1].ravel()
    first, second = (corner, corner + len(z), corner + len(z) + 1), (corner, corner + len(z) + 1, corner + 1)
    facets = np.stack([np.stack(first, -1), np.stack(second, -1)], axis=1).reshape(-1, 3)
    scene = EmbreeScene()
    TriangleMesh(scene, np.stack([i, j, z], axis=-1).reshape(-1, 3).astype(np.float32), facets.astype(np.int32))
    return scene


class Sharers:
    """As many processes as the library has threads, each of which traces its part of the rays on request."""

    def __init__(self, scene: Any, origins: np.ndarray, ways: np.ndarray) -> None:
        fork = multiprocessing.get_context("fork")
        self.ends: list[Connection] = []
        self.processes = []
        for rays in zip(np.array_split(origins, threads()), np.array_split(ways, threads()), strict=True):
            here, there = fork.Pipe()
            process = fork.Process(target=_answer, args=(there, scene, *rays), daemon=True)
            process.start()
            self.ends.append(here)
            self.processes.append(process)

    def __call__(self) -> None:
        for end in self.ends:
            end.send(True)
        for end in self.ends:
            end.recv()

    def close(self) -> None:
        for end, process in zip(self.ends, self.processes, strict=True):
            end.send(False)
            process.join()


def _answer(end: Connection, scene: Any, origins: np.ndarray, ways: np.ndarray) -> None:
    while end.recv():
        scene.run(origins, ways)
        end.send(True)


def errors(task: str, scene: Any) -> np.ndarray:
    """The fraction of rays from facets whose verdict, blocked or not, is wrong, for each of `OFFSETS` along the ray.

    Rays that the surface beyond the margin blocks are left out.
    """
    if task not in ("reflected_sorted", "shadow_sorted"):
        return np.zeros(0)
    surface, (origins, ways, facets) = rivals_rays.surface(), rivals_rays.rays(task, rivals_rays.RAYS[0])
    hits = surface.trace(origins, ways, facets)
    free = hits.distance == np.inf
    ends = origins + np.where(free, 0, hits.distance)[:, None] * ways
    there = (abs(ends[:, :2] - surface.size / 2) < surface.size / 2 + MARGIN - 1).all(axis=1)
    starts = [(origins + offset * ways).astype(np.float32) for offset in OFFSETS]
    return np.array([np.mean(((scene.run(start, ways.astype(np.float32)) < 0) != free)[there]) for start in starts])
