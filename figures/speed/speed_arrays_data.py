"""Computes what the figure `speed_arrays` shows: errors of the ways to have a value; their times are on record."""

import sys

import numpy as np
from report.datafile import rounded, store

from benchmarks.record import fronts, mark, note, read, rows, seconds, summary
from benchmarks.rivals_brdf import METHODS as BRDF
from benchmarks.rivals_fresnel import METHODS as FRESNEL
from benchmarks.rivals_masking import METHODS as MASKING
from benchmarks.rivals_normals import METHODS as NORMALS
from benchmarks.rivals_sampling import METHODS as SAMPLING
from benchmarks.yardsticks import known

SHOWN = {"masking": MASKING, "normals": NORMALS, "brdf": BRDF, "sampling": SAMPLING, "fresnel": FRESNEL}


def panel(quantity: str) -> dict:
    """Error, and nanoseconds per value in the largest arrays: quartiles and median."""
    methods = SHOWN[quantity]
    errors = [max(method.error(method.sizes[-1]), 2**-64) for method in methods.values()]
    times = [1e9 * np.array(seconds(quantity, name, m)[-1]) / m.sizes[-1] for name, m in methods.items()]
    best = fronts([method.kind for method in methods.values()], errors, [t[1] for t in times])
    alone = {f"{quantity}_{name}_{part}": value for name, e, t in zip(methods, errors, times, strict=True)
             for part, value in (("error", e), ("ns", t[1]))}  # fmt: skip
    return alone | {
        f"{quantity}_names": np.array(list(methods)),
        f"{quantity}_words": np.array([method.label for method in methods.values()]),
        f"{quantity}_kinds": np.array([method.kind for method in methods.values()]),
        f"{quantity}_errors": np.array(errors),
        f"{quantity}_times": np.array(times),
        f"{quantity}_best": best,
        f"{quantity}_told": note(quantity, methods),
        f"{quantity}_record": np.array(summary(quantity, methods)),
        f"{quantity}_stale": mark(quantity, methods),
    }


def call_cost() -> dict:
    """The BRDF over sizes of arrays: seconds a call, and the exponent with which they grow from the largest but two."""
    methods = BRDF
    sizes = np.array(next(iter(methods.values())).sizes)
    times = np.array([[t[1] for t in seconds("brdf", name, m)] for name, m in methods.items()])
    kept = rows("brdf")
    yardsticks = {name: row for name, row in kept.items() if name not in methods}
    other = [[dict(zip(row["sizes"], row["seconds"], strict=True)).get(int(n), [np.nan] * 3)[1] for n in sizes]
             for row in yardsticks.values()]  # fmt: skip
    exponent = [np.polyfit(np.log(sizes[-3:]), np.log(t[-3:]), 1)[0] if np.isfinite(t).all() else np.nan for t in times]
    alone = {f"growth_{name}_{part}": value for name, t, e in zip(methods, times, exponent, strict=True)
             for part, value in (("call_us", 1e6 * t[0]), ("exponent", e))}  # fmt: skip
    yard = {f"yardstick_{name}_ns": 1e9 * t[-1] / sizes[-1] for name, t in zip(yardsticks, other, strict=True)}
    return (
        {"yardstick_cpp_ns": np.nan, "yardstick_cpp_no_errno_ns": np.nan}
        | alone
        | yard
        | {
            "growth_sizes": sizes,
            "growth_times": times,
            "growth_exponents": np.array(exponent),
            "yardstick_words": np.array([row["words"] for row in yardsticks.values()] or [""]),
            "yardstick_times": np.array(other or [[np.nan] * len(sizes)]),
        }
    )


def others(quantity: str) -> dict:
    """What else has the quantity: words, nanoseconds a value among many, its error, and what is said where there is none."""
    kept, why = rows(quantity), read().get(quantity, {}).get("rivals", {})
    names = list(known(quantity))
    times = [kept[name]["seconds"][-1][1] / kept[name]["sizes"][-1] * 1e9 if name in kept else np.nan for name in names]
    said = ["" if name in kept else why.get(name, "not measured") for name in names]
    versions = [f" {kept[name]['version']}" if "version" in kept.get(name, {}) else "" for name in names]
    told = [said.replace("variant,", f"variant{version},").replace("jax,", f"jax{version},")
            for said, version in zip(known(quantity).values(), versions, strict=True)]  # fmt: skip
    errors = [kept.get(name, {}).get("error") or np.nan for name in names]
    found = {"words": told, "ns": times, "said": said, "error": errors}
    return {f"{quantity}_others_{part}": np.array(values) for part, values in found.items()}


def compute() -> dict:
    data = {name: values for quantity in SHOWN for name, values in panel(quantity).items()}
    return rounded(data | call_cost() | others("brdf") | others("sampling"), digits=3)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
