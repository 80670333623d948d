"""Vectors of 512 bits for compiled loops. A module of its own, so that to generate kernels loads no compiler."""

from __future__ import annotations

from typing import Any, cast

from numba import types
from numba.extending import intrinsic


@cast(Any, intrinsic)
def widest(context: Any) -> Any:
    """Lets the calling function use vectors of 512 bits where the processor has them; LLVM prefers shorter ones.

    No result changes. Long kernels gain most: they are bound by latency rather than by throughput.
    """

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), generate
