"""A guest's process: evaluates a BRDF, samples normals or traces rays, from arrays in a folder, once for each input line.

    python -m benchmarks.guest jax brdf FOLDER ALPHA_X ALPHA_Y
    python -m benchmarks.guest mitsuba brdf|ggx|beckmann FOLDER ALPHA_X ALPHA_Y
    python -m benchmarks.guest embreex primary_sorted FOLDER ALPHA_X ALPHA_Y

It reads wo.npy and other.npy (lights, or random numbers; for rays, origins and directions), takes them apart into x, y and z
if that suits it best, answers "done" to each line, and saves its first result as found.npy.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np


def jax(wo: Any, wi: Any, ax: float, ay: float) -> Callable[[], Any]:
    """The fraction as a user of jax would write it, in the precision of the arrays."""
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    ax, ay = wo.dtype.type(ax), wo.dtype.type(ay)

    @jax.jit
    def brdf(o: Any, i: Any) -> Any:
        hx, hy, hz = o[0] + i[0], o[1] + i[1], o[2] + i[2]
        s = hx * hx + hy * hy + hz * hz
        t = (hx / ax) ** 2 + (hy / ay) ** 2 + hz * hz
        ro, ri = (jnp.sqrt((ax * w[0]) ** 2 + (ay * w[1]) ** 2 + w[2] * w[2]) for w in (o, i))
        value = s * s / (wo.dtype.type(2 * np.pi) * ax * ay * t * t * (o[2] * ri + i[2] * ro))
        return jnp.where((o[2] > 0) & (i[2] > 0), value, 0)

    there = [tuple(jax.device_put(np.ascontiguousarray(part)) for part in w.T) for w in (wo, wi)]
    return lambda: brdf(*there).block_until_ready()


def mitsuba(wo: Any, wi: Any, ax: float, ay: float) -> Callable[[], Any]:
    """Mitsuba's rough conductor, which here reflects everything; the cosine that it contains is divided out."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_mono")
    bsdf = mi.load_dict({"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha_u": ax, "alpha_v": ay})
    view, light = (mi.Vector3f(np.ascontiguousarray(w.T)) for w in (wo, wi))
    context = mi.BSDFContext()
    dr.eval(view, light)

    def evaluate() -> Any:
        interaction = dr.zeros(mi.SurfaceInteraction3f, len(wo))
        interaction.wi = view
        value = bsdf.eval(context, interaction, light)[0]
        dr.eval(value)
        dr.sync_thread()
        return lambda: np.array(value) / wi[:, 2]

    return evaluate


def mitsuba_normals(kind: str) -> Callable[..., Callable[[], Any]]:
    """Its sampler of visible normals; their density, which it would give too, is never asked for, and so not computed."""

    def prepared(wo: Any, u: Any, ax: float, ay: float) -> Callable[[], Any]:
        import drjit as dr
        import mitsuba as mi

        mi.set_variant("llvm_ad_mono")
        distribution = mi.MicrofacetDistribution(getattr(mi.MicrofacetType, kind), ax, ay, True)
        view, numbers = mi.Vector3f(np.ascontiguousarray(wo.T)), mi.Point2f(np.ascontiguousarray(u.T))
        dr.eval(view, numbers)

        def draw() -> Any:
            normals, _ = distribution.sample(view, numbers)
            dr.eval(normals)
            dr.sync_thread()
            return lambda: np.array(normals).T

        return draw

    return prepared


def embree(task: str) -> Callable[..., Callable[[], Any]]:
    """Its tracer, on the surface that the library's rays meet."""

    def prepared(origins: Any, ways: Any, ax: float, ay: float) -> Callable[[], Any]:
        from benchmarks import embree, rivals_rays

        scene = embree.scene_of(rivals_rays.surface().heights)
        sharers = embree.Sharers(scene, origins, ways)

        def trace() -> Any:
            sharers()
            return lambda: embree.errors(task, scene)

        return trace

    return prepared


TASKS = {
    ("jax", "brdf"): jax,
    ("mitsuba", "brdf"): mitsuba,
    ("mitsuba", "ggx"): mitsuba_normals("GGX"),
    ("mitsuba", "beckmann"): mitsuba_normals("Beckmann"),
}


def main(package: str, task: str, folder: Path, ax: float, ay: float) -> None:
    wo, other = np.load(folder / "wo.npy"), np.load(folder / "other.npy")
    prepared = embree(task) if package == "embreex" else TASKS[package, task]
    evaluate, output = prepared(wo, other, ax, ay), folder / "found.npy"
    for _ in sys.stdin:
        result = evaluate()
        if not output.exists():
            np.save(output, result() if callable(result) else result)
        print("done", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5]))
