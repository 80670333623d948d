"""Vectors of 512 bits for compiled loops. A module of its own, so that what only writes kernels does not load the compiler."""

from __future__ import annotations

from typing import Any, cast

from numba import types
from numba.extending import intrinsic


@cast(Any, intrinsic)
def widest(context: Any) -> Any:
    """Lets the function that calls it use vectors of 512 bits where there are such; LLVM prefers shorter ones.

    No result changes. Long kernels gain most: they wait for results more than for a free unit, and wait half as often.
    """

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), generate
