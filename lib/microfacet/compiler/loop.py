"""From the text of a kernel to a compiled loop over arrays."""

from __future__ import annotations

import inspect
import linecache
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from microfacet.compiler.cache import key, load, require_compiler, store
from microfacet.compiler.kernels import Count, Table
from microfacet.compiler.processors import in_own_thread
from microfacet.compiler.program import Program, digest, fields_of, jit_once
from microfacet.directions import UNIT

Broadcast = tuple[bool, ...]
Checks = tuple[str, ...]
Varying = Any  # nested like the parameters: the index of each array in a list of them, None for everything else
Layout = Any  # nested like the parameters: the names of the fields, and the layouts of their values; see `layout`

HEADER = """\
from math import *
import numpy as np
from microfacet.compiler.program import jit_once, named
from microfacet.compiler.widest import widest
from numba import float32, float64, njit, types

R, T = {real}, np.{real}
"""


def layout(parameters: Any) -> Layout:
    """The structure of parameters: for each tuple the names of its fields, if it has any, and the layouts of its elements.

    None for a number or a table. Parameters of one layout are compiled alike if their numbers are of the same types.
    """
    if not isinstance(parameters, tuple) or isinstance(parameters, Table):
        return None
    return fields_of(type(parameters)), tuple(map(layout, parameters))


def loop_text(
    name: str,
    widths: Sequence[int],
    outputs: int,
    broadcast: Sequence[bool],
    checks: Sequence[str],
    parameters: str,
    varying: int,
) -> str:
    """The text of the loop over flat arrays, row after row. A `broadcast` argument has one row, which is used for all.

    parameters: the text of the kernel's parameters, see `rebuilt`; the last `varying` arrays are parameters that vary. The
    loop also checks the rows that it reads (`checks`: what each argument may hold), and returns whether all passed.
    Only with flat arrays and indices that are multiples of the counter does the compiler vectorize the loop.
    """
    arrays = [f"a{k}" for k in range(len(widths))]
    rows = [[f"b{k}_{c}" if broadcast[k] else f"a{k}[{w} * i + {c}]" for c in range(w)] for k, w in enumerate(widths)]
    taken = [row[0] if widths[k] == 1 else f"({', '.join(row)})" for k, row in enumerate(rows)]
    known = len(widths) - varying
    loads = [f"{row[c]} = a{k}[{c}]" for k, row in enumerate(rows) if broadcast[k] for c in range(len(row))]
    slices = [f"a{k} = a{k}[{w} * start : {w} * stop]" for k, w in enumerate(widths) if not broadcast[k]]
    slices.append(f"out = out[{outputs} * start : {outputs} * stop]")
    of_row = [*(f"v{k} = {value}" for k, value in enumerate(taken[known:])), f"q = {parameters}"]
    call = f"{name}({', '.join([*taken[:known], 'q'])})"
    store = ", ".join(f"out[{outputs} * i + {c}]" for c in range(outputs))
    inputs = "types.Array(R, 1, 'C', readonly=True), " * len(widths)
    once, each = (_check_lines([(checks[k], row) for k, row in enumerate(rows) if broadcast[k] is b]) for b in (True, False))
    before = "".join(f"        {line}\n" for line in [*loads, *slices, "good = True", *once, *([] if varying else of_row)])
    within = "".join(f"            {line}\n" for line in [*(of_row if varying else []), f"{store} = {call}", *each])
    described = repr((name, widths, outputs, broadcast, checks, parameters))
    unique = f"loop_{digest(described)}"  # loops of all programs share one name space
    return (
        f"def compiled(p):\n"
        f"    @njit((types.intp, types.intp, {inputs}p, R[::1]), nogil=True, error_model='numpy')\n"
        f"    def {unique}(start, stop, {', '.join(arrays)}, p, out):\n"
        f"        widest()\n"
        f"{before}"
        f"        for i in range(stop - start):\n"
        f"{within}"
        f"        return good\n"
        f"    return {unique}\n"
    )


def count_arrays(varying: Varying) -> int:
    """How many arrays the parameters hold."""
    return max(map(count_arrays, varying)) if isinstance(varying, tuple) else 0 if varying is None else varying + 1


def rebuilt(shape: Layout, varying: Varying, program: Program, path: str = "p") -> str:
    """The text of the parameters for one row, with fields: the k-th varying one is vk, the others are indexed from path."""
    if isinstance(varying, int):
        return f"v{varying}"
    if shape is None or not (varying or _names(shape)):
        return path
    fields, inner = shape
    places = varying or (None,) * len(inner)
    parts = [rebuilt(*both, program, f"{path}[{k}]") for k, both in enumerate(zip(inner, places, strict=True))]
    return f"{program.named_tuple(fields) if fields else ''}({', '.join(parts)},)"


def _names(shape: Layout) -> bool:
    """Whether there is a named tuple among parameters of this layout."""
    return shape is not None and (bool(shape[0]) or any(map(_names, shape[1])))


def _check_lines(rows: Sequence[tuple[str, Sequence[str]]]) -> list[str]:
    """Lines that clear `good` where an argument holds a number that its check does not allow.

    A sum is finite only if all its terms are. But a sum of finite terms may overflow, and a direction may be the zero vector
    that a sampler returned: the caller of the loop then checks each number (`_refuse`).
    """
    finite = [value for kind, row in rows if kind == "finite" for value in row]
    lines = [f"total = {' + '.join(finite)}", "good &= total - total == R(0.0)"] if finite else []
    for square in (" + ".join(f"{value} * {value}" for value in row) for kind, row in rows if kind == "direction"):
        lines += [f"square = {square}", f"good &= abs(square - R(1.0)) <= R({UNIT})"]
    fractions = [value for kind, row in rows if kind == "fraction" for value in row]
    return [*lines, *(f"good &= ({value} >= R(0.0)) & ({value} < R(1.0))" for value in fractions)]


@cache
def machine_code(text: str, kind: Any) -> Any:
    """The compiler's result for a program and the type of its parameters: from the cache, else compiled and stored there."""
    from microfacet.compiler import widest

    name = key(text, kind, inspect.getsource(jit_once), inspect.getsource(widest))
    code = load(name)
    if code is None:
        code = in_own_thread(lambda: _compile(text, kind))
        store(name, code)
    return code


def _compile(text: str, kind: Any) -> Any:
    require_compiler()
    file = f"<kernel {digest(text)}>"
    linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file  # for the compiler's messages
    scope: dict[str, Any] = {"__name__": __name__}  # a later process looks for this module
    exec(compile(text, file, "exec"), scope)
    (result,) = scope["compiled"](kind).overloads.values()
    return result


def separated(parameters: Any, arrays: list[np.ndarray]) -> tuple[Varying, Any]:
    """Where the parameters hold arrays, and the parameters with 0 in place of each array. The arrays are added to the list."""
    if isinstance(parameters, np.ndarray):
        known = [k for k, array in enumerate(arrays) if array is parameters]
        if not known:
            arrays.append(parameters)
        return known[0] if known else len(arrays) - 1, 0.0
    if not isinstance(parameters, tuple) or isinstance(parameters, Table):
        return None, parameters
    parts = [separated(part, arrays) for part in parameters]
    places = tuple(place for place, _ in parts)
    make = getattr(parameters, "_make", tuple)
    return (places if any(place is not None for place in places) else None), make(rest for _, rest in parts)


def cast_to(parameters: Any, real: type) -> Any:
    """The parameters as arguments of the loop: plain tuples of numbers, since the loop names their fields itself."""
    if isinstance(parameters, Table):
        return np.array(parameters, real)
    if isinstance(parameters, tuple):
        return tuple(cast_to(p, real) for p in parameters)
    return int(parameters) if isinstance(parameters, Count) else real(parameters)
