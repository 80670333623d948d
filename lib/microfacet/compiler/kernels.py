"""Scalar functions of plain floats become compiled loops over arrays, cached on disk.

A kernel is written (or generated from a statement) as an ordinary Python function of floats, so it can be read, called
and tested without a compiler. `Batch` collects the text of that function and of every function it calls into one
program, and compiles a loop over arrays from it. The file name of compiled code in the cache is a digest of that text (see
`cache`), so it can never be stale: a changed text has another name.

Arguments of a kernel: for an array with a last axis, one row as a tuple (a direction is (x, y, z), two uniform numbers are
(u1, u2)); for any other array, one number; and last the parameters, a named tuple of numbers and of such tuples: D(wm, p)
reads p.alpha_x. A plain tuple works as well.

Rules for a kernel: floats only (write 2.0, not 2), no global state except constants, tuples of numbers, classes of named tuples
and other kernels. Literals become single precision in a single-precision loop. A kernel must terminate for any input, NaN
included, since arguments are checked only while the loop runs.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from types import FunctionType
from typing import Any

Vector = tuple[float, float, float]
Pair = tuple[float, float]
Parameters = tuple[Any, ...]


class ByPrecision(float):
    """A constant of a kernel that differs between the precisions; in plain Python it is the double one."""

    single: float

    def __new__(cls, double: float, single: float) -> ByPrecision:
        made = super().__new__(cls, double)
        made.single = single
        return made


def source(function: FunctionType) -> str:
    """The text of a kernel: generated functions carry it, for others it is looked up."""
    text = getattr(function, "__source__", None)
    if text is None:
        text = textwrap.dedent(inspect.getsource(function))
        if function.__name__ != "<lambda>" and f"def {function.__name__}(" not in text:
            raise RuntimeError(f"{inspect.getsourcefile(function)} has changed since it was imported: start again")
    return str(text)


class Table(tuple[float, ...]):
    """A parameter of a kernel that holds any number of values: compiled as an array, so that one loop serves all lengths."""


class Count(int):
    """A parameter of a kernel that stays an integer: a count or an index. Other integers become floats."""


def packed(function: Callable[..., Any], free: int, parameters: int) -> FunctionType:
    """A function of numbers as a kernel: the last of them are packed in one tuple, as `Batch` passes parameters."""
    names = [f"v{k}" for k in range(free)]
    unpack = [f"p[{k}]" for k in range(parameters)]
    text = f"def {function.__name__}_packed({', '.join([*names, 'p'])}):\n    return inner({', '.join(names + unpack)})\n"
    scope: dict[str, Any] = {"inner": function}
    exec(text, scope)
    made: FunctionType = scope[f"{function.__name__}_packed"]
    made.__source__ = text  # type: ignore[attr-defined]
    return made
