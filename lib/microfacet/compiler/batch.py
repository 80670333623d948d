"""`Batch`: a kernel applied over arrays that broadcast, on all processors."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from microfacet.compiler.kernels import Parameters
from microfacet.compiler.loop import (
    HEADER,
    Broadcast,
    Checks,
    Layout,
    Varying,
    cast_to,
    count_arrays,
    layout,
    loop_text,
    machine_code,
    rebuilt,
    separated,
)
from microfacet.compiler.processors import QUICK, Pace, spread
from microfacet.compiler.program import HAS_LOOP, Program
from microfacet.directions import Argument

Loop = Callable[..., bool]
QUICKEST = 1e-9  # lower bound of the seconds per element ...
LONG = 1e-6  # ... and the same for a kernel with an inner loop, whose time may vary from element to element
PARAMETER_SETS = 64  # how many sets of parameters a kernel caches with the loop prepared for each


class _Ready(NamedTuple):
    """A loop prepared for one set of parameters: its pace, the parameters cast to its types, as given, and their layout."""

    loop: Loop
    pace: Pace
    taken: Any
    given: Parameters
    shape: Layout


class Batch:
    """A kernel applied over arrays.

    Unlike numba.guvectorize, it takes tuples of parameters and checks its arguments within the loop.

    function: a kernel of one row of each array, followed by the tuple of parameters.
    widths: for each array the length of its last axis, whose rows are passed as tuples; 1 if it has none: its rows are numbers.
    outputs: the number of floats the kernel returns; 1 gives a result without a last axis.
    varying: which of the parameters vary from row to row, as the last of the arrays; by default none.
    """

    def __init__(self, function: Callable[..., Any], widths: Sequence[int], outputs: int = 1, varying: Varying = None) -> None:
        self.function, self.widths, self.outputs, self.varying = function, tuple(widths), outputs, varying
        self._of_arrays: dict[Varying, Batch] = {}
        self._known: tuple[Parameters, Varying, Parameters, list[np.ndarray]] | None = None  # of the last call with arrays
        self._loops: dict[tuple[type, Any, Layout, Broadcast, Checks], tuple[Loop, Pace]] = {}
        self._ready: dict[tuple[type, Parameters, Broadcast, Checks], _Ready] = {}

    def text(self, real: type, broadcast: Broadcast = (), checks: Checks = (), shape: Layout = None) -> str:
        """The whole program in the given precision.

        broadcast: which arguments have a single row, by default none. checks: what each argument is checked for, by default
        nothing. shape: the layout of the parameters, by default without names.
        """
        program = Program(real)
        name = program.add(self.function)  # type: ignore[arg-type]
        header = HEADER.format(real=np.dtype(real).name)
        none = len(self.widths)
        parameters = rebuilt(shape, self.varying, program)
        broadcast, checks = broadcast or (False,) * none, checks or ("",) * none
        loop = loop_text(name, self.widths, self.outputs, broadcast, checks, parameters, count_arrays(self.varying))
        return "\n\n".join([header, *program.texts, loop])

    def _compiled(self, real: type, kind: Any, shape: Layout, broadcast: Broadcast, checks: Checks) -> tuple[Loop, Pace]:
        """The compiled loop itself, without numba's dispatcher, which would inspect the types of all arguments at each call."""
        known = (real, kind, shape, broadcast, checks)
        if known not in self._loops:
            text = self.text(real, broadcast, checks, shape)
            pace = Pace(LONG if HAS_LOOP in text else QUICKEST)
            self._loops[known] = machine_code(text, kind).entry_point, pace
        return self._loops[known]

    def _prepare(self, real: type, parameters: Parameters, broadcast: Broadcast, checks: Checks) -> _Ready:
        """The loop, its pace and the cast parameters: cached, since to prepare them costs more than a hundred rows.

        Tuples of equal numbers compare equal whatever their fields are, so the layout is compared as well.
        """
        import numba

        ready, shape = self._ready.get((real, parameters, broadcast, checks)), layout(parameters)
        if ready is None or ready.shape != shape:
            if len(self._ready) >= PARAMETER_SETS:
                self._ready.clear()
            cast_ = cast_to(parameters, real)
            loop, pace = self._compiled(real, numba.typeof(cast_), shape, broadcast, checks)
            ready = self._ready[real, parameters, broadcast, checks] = _Ready(loop, pace, cast_, parameters, shape)
        return ready

    def _varied(
        self, arrays: Sequence[Any], shape: tuple[int, ...], parameters: Parameters, real: type, out: np.ndarray | None
    ) -> Any:
        """The call where some parameters are arrays, which are cast to the precision of the arguments."""
        if self._known is None or self._known[0] is not parameters:
            varying_arrays: list[np.ndarray] = []
            self._known = (parameters, *separated(parameters, varying_arrays), varying_arrays)
        _, varying, others, given = self._known
        try:
            np.broadcast_shapes(shape, *(array.shape for array in given))
        except ValueError:
            shapes = ", ".join(str(array.shape) for array in given)
            raise ValueError(f"parameters of shapes {shapes} do not broadcast with directions of shape {shape}") from None
        if varying not in self._of_arrays:
            widths = [*self.widths, *[1] * len(given)]
            self._of_arrays[varying] = Batch(self.function, widths, self.outputs, varying)
        return self._of_arrays[varying]([*arrays, *(np.asarray(array, real) for array in given)], others, out)

    def __call__(self, arrays: Sequence[Any], parameters: Parameters = (), out: np.ndarray | None = None) -> Any:
        """Apply to arrays that broadcast against each other; float32 in gives float32 out, everything else is float64.

        Parameters that are arrays broadcast with them. An `Argument` is checked while it is read. If it holds an invalid
        number, a ValueError names the argument and the number, and the contents of `out` are undefined.
        """
        inputs, checks, shapes = [], [], []
        real: type = np.float32
        for given, width in zip(arrays, self.widths, strict=True):
            _, array, kind = given if type(given) is Argument else ("", np.asarray(given), "")
            inputs.append(array)
            checks.append(kind)
            shapes.append(array.shape[:-1] if width > 1 else array.shape)
            if array.dtype != _SINGLE:
                real = np.float64
        shape = shapes[0]
        if shapes.count(shape) != len(shapes):
            shape = np.broadcast_shapes(*shapes)
        count = math.prod(shape)
        broadcast = tuple([count != 1 and array.size == width for array, width in zip(inputs, self.widths, strict=True)])
        try:
            ready = self._ready.get((real, parameters, broadcast, tuple(checks)))
        except TypeError:  # arrays have no hash
            return self._varied(arrays, shape, parameters, real, out)
        if ready is None or ready.given is not parameters:
            ready = self._prepare(real, parameters, broadcast, tuple(checks))
        loop, pace, taken, _, _ = ready
        flat = [_flatten(*one, shape, real) for one in zip(inputs, self.widths, shapes, strict=True)]
        result = _result(out, (*shape, self.outputs) if self.outputs > 1 else shape, real, inputs)
        target = result.reshape(-1)
        if count < 2 or count * pace.seconds < QUICK:
            good = count > 0 and loop(0, count, *flat, taken, target)
        else:
            good = spread(lambda start, stop: loop(start, stop, *flat, taken, target), count, pace)
        if not good:
            _refuse(arrays)
        return result if result.ndim or out is not None else result[()]


_SINGLE = np.dtype(np.float32)


def _flatten(array: np.ndarray, width: int, own: tuple[int, ...], shape: tuple[int, ...], real: type) -> np.ndarray:
    """The rows of the array one after another: a single row if it has only one, else one for each element of the shape."""
    if own != shape and array.size != width:
        array = np.broadcast_to(array, (*shape, width) if width > 1 else shape)
    flat: np.ndarray = np.ascontiguousarray(array, real).reshape(-1)
    return flat if flat.flags.aligned else flat.copy()


def _result(out: np.ndarray | None, shape: tuple[int, ...], real: type, inputs: Sequence[np.ndarray]) -> np.ndarray:
    if out is None:
        return np.empty(shape, real)
    if not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != real or not out.flags.c_contiguous:
        kind = f"{out.dtype} {out.shape}" if isinstance(out, np.ndarray) else type(out).__name__
        raise ValueError(f"out must be a C-contiguous {np.dtype(real).name} array of shape {shape}, got {kind}")
    if not out.flags.writeable:
        raise ValueError("out must be writeable, got a read-only array")
    if any(np.may_share_memory(out, array) for array in inputs):
        raise ValueError("out must not overlap an argument")
    return out


def _refuse(arrays: Sequence[Any]) -> None:
    """Raise for the first argument that holds an invalid number; a loop over no rows has checked none of them."""
    for argument in arrays:
        if isinstance(argument, Argument):
            argument.checked()
