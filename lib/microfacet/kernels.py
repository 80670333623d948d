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

import ast
import builtins
import dis
import hashlib
import inspect
import linecache
import math
import textwrap
from collections import namedtuple
from collections.abc import Callable, Sequence
from functools import cache
from math import exp, ldexp
from types import FunctionType
from typing import Any, NamedTuple, cast

import numpy as np

from microfacet.cache import key, load, require_compiler, store
from microfacet.directions import UNIT, Argument
from microfacet.processors import QUICK, Pace, in_own_thread, spread

Vector = tuple[float, float, float]
Pair = tuple[float, float]
Parameters = tuple[Any, ...]
Broadcast = tuple[bool, ...]
Checks = tuple[str, ...]
Loop = Callable[..., bool]
Varying = Any  # nested like the parameters: the index of each array in a list of them, None for everything else
Layout = Any  # nested like the parameters: the names of the fields, and the layouts of their values; see `layout`
QUICKEST = 1e-9  # lower bound of the seconds per element ...
LONG = 1e-6  # ... and the same for a kernel with an inner loop, whose time may vary from element to element
PARAMETER_SETS = 64  # how many sets of parameters a kernel caches with the loop prepared for each

_HEADER = """\
from math import *
import numpy as np
from microfacet.kernels import jit_once, named
from microfacet.widest import widest
from numba import float32, float64, njit, types

R, T = {real}, np.{real}
"""


class ByPrecision(float):
    """A constant of a kernel that differs between the precisions; in plain Python it is the double one."""

    single: float

    def __new__(cls, double: float, single: float) -> ByPrecision:
        made = super().__new__(cls, double)
        made.single = single
        return made


# --- an exponential that can be vectorized --------------------------------------------------------------------------

SMALLEST, GREATEST = ByPrecision(-750.0, -110.0), ByPrecision(720.0, 92.0)  # exp is 0 below, infinite above
ROUNDER = ByPrecision(6755399441055744.0, 12582912.0)  # 1.5 x 2^52, 1.5 x 2^23: adding it rounds to an integer
PER_LN2 = 1.4426950408889634
LN2_HIGH = ByPrecision(0.6931471803691238, 0.693359375)  # short enough for its product with an exponent to be exact
LN2_LOW = ByPrecision(1.9082149292705877e-10, -0.00021219444005469057)


def power_of_two(k: float) -> float:
    """2^k for an integer k within the exponents of normal numbers."""
    return ldexp(1.0, int(k))


_BITS = "def unnamed(k):\n    return np.int{0}((np.int{0}(k) + np.int{0}({1})) << np.int{0}({2})).view(np.float{0})"
power_of_two.__compiled__ = {np.float64: _BITS.format(64, 1023, 52), np.float32: _BITS.format(32, 127, 23)}  # type: ignore[attr-defined]


def exponential(x: float) -> float:
    """exp(x) to an ulp without a branch or a call: it replaces `exp` in a kernel without a loop of its own.

    x = k ln 2 + r with |r| below 0.35, where Taylor's series to r^13/13! suffices; 2^k in two factors, for subnormal results.
    """
    x = SMALLEST if x < SMALLEST else x
    x = GREATEST if x > GREATEST else x
    k = (x * PER_LN2 + ROUNDER) - ROUNDER
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    p = 1.0 / 6227020800.0
    p = p * r + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = (p * r) * r + r
    half = (0.5 * k + ROUNDER) - ROUNDER
    return ((1.0 + p) * power_of_two(half)) * power_of_two(k - half)


VECTORIZED: dict[Any, Any] = {exp: exponential}  # replacements of functions of `math` in a kernel without a loop


_REPLACING = tuple(f"{function.__name__}_" for function in VECTORIZED.values())

# --- from functions to one text -----------------------------------------------------------------------------------


def source(function: FunctionType) -> str:
    """The text of a kernel: generated functions carry it, for others it is looked up."""
    text = getattr(function, "__source__", None)
    if text is None:
        text = textwrap.dedent(inspect.getsource(function))
        if function.__name__ != "<lambda>" and f"def {function.__name__}(" not in text:
            raise RuntimeError(f"{inspect.getsourcefile(function)} has changed since it was imported: start again")
    return str(text)


def _bindings(function: FunctionType) -> dict[str, Any]:
    """The values of the free names of a function, without the names of attributes."""
    code = function.__code__
    free = [step.argval for step in dis.get_instructions(code) if step.opname == "LOAD_GLOBAL"]
    bindings = {name: function.__globals__[name] for name in free if name in function.__globals__}
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        bindings[name] = cell.cell_contents
    return bindings


class _Embed(ast.NodeTransformer):
    """Rename the functions that a function calls, inline its constants, and give float literals the loop's precision."""

    def __init__(self, name: str, names: dict[str, str], constants: dict[str, str]) -> None:
        self.name, self.names, self.constants = name, names, constants

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.name = self.name
        node.decorator_list, node.returns = [], None
        for argument in node.args.args:
            argument.annotation = None
        if ast.get_docstring(node) is not None:
            node.body = node.body[1:]
        self.generic_visit(node)
        return node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        assert node.value is not None
        return self.generic_visit(ast.copy_location(ast.Assign([node.target], node.value), node))

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        return _real(node) if isinstance(node.value, float) else node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """The arguments of a replacement of `math` are cast: its constants are those of the loop's precision."""
        replaced = isinstance(node.func, ast.Name) and self.names.get(node.func.id, "").startswith(_REPLACING)
        self.generic_visit(node)
        if replaced:
            node.args = [_real(argument) for argument in node.args]
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if node.id in self.names:
            return ast.copy_location(ast.Name(self.names[node.id], node.ctx), node)
        if node.id in self.constants:
            return ast.copy_location(ast.parse(self.constants[node.id], mode="eval").body, node)
        return node


def _real(node: ast.expr) -> ast.expr:
    return ast.Call(ast.Name("R", ast.Load()), [node], [])


def _literal(value: Any, real: type) -> str:
    """The text that stands for a constant."""
    if isinstance(value, int):
        return repr(value)
    if isinstance(value, ByPrecision) and real is np.float32:
        value = value.single
    return ast.unparse(_real(ast.Constant(float(value))))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


class _Program:
    """The functions a kernel needs, each once, callees first. A name ends in a digest of the text, which names the callees."""

    def __init__(self, real: type) -> None:
        self.real = real
        self.texts: list[str] = []
        self.names: dict[FunctionType, str] = {}
        self.known: set[str] = set()  # names of tables and of classes

    def table(self, values: tuple[float, ...]) -> str:
        """The name of an array that holds the values of a tuple: of integers if all are."""
        kind = "np.intp" if all(isinstance(value, int) for value in values) else "T"
        return self._define(f"table_{_digest(repr(values))}", f"np.array({values!r}, {kind})")

    def named_tuple(self, fields: tuple[str, ...]) -> str:
        """The name of the class of tuples with these fields."""
        return self._define(f"Named_{_digest(repr(fields))}", f"named{fields!r}")

    def _define(self, name: str, value: str) -> str:
        if name not in self.known:
            self.known.add(name)
            self.texts.append(f"{name} = {value}")
        return name

    def add(self, function: FunctionType) -> str:
        if function in self.names:
            return self.names[function]
        if hasattr(function, "__compiled__"):
            return self._keep(function, *_named(function.__name__, function.__compiled__[self.real]))
        names, constants = {}, {}
        replaced = {} if _has_loop(function) else VECTORIZED
        for name, value in _bindings(function).items():
            value = replaced.get(value, value) if callable(value) else value
            if (known := self._defined(value)) is not None:
                names[name] = known
            elif isinstance(value, int | float):
                constants[name] = _literal(value, self.real)
            elif not (value is getattr(math, name, None) or value is getattr(builtins, name, None)):
                raise TypeError(f"kernel {function.__qualname__} uses {name}, which is no kernel and no constant")
        return self._keep(function, *_embedded(function, tuple(names.items()), tuple(constants.items())))

    def _defined(self, value: Any) -> str | None:
        """The name of a kernel, of a tuple of numbers or of a class of named tuples; None for anything else."""
        if isinstance(value, FunctionType):
            return self.add(value)
        if isinstance(value, tuple):
            return self.table(value)
        fields = _fields(value)
        return None if fields is None else self.named_tuple(fields)

    def _keep(self, function: FunctionType, unique: str, text: str) -> str:
        if unique not in self.names.values():
            self.texts.append(text)
        self.names[function] = unique
        return unique


@cache
def _has_loop(function: FunctionType) -> bool:
    return _loops(ast.parse(source(function)))


@cache
def _embedded(
    function: FunctionType, names: tuple[tuple[str, str], ...], constants: tuple[tuple[str, str], ...]
) -> tuple[str, str]:
    """The name and text of a function in a program, given the names and constants that replace its free names."""
    tree = _Embed("unnamed", dict(names), dict(constants)).visit(ast.parse(source(function)))
    return _named(function.__name__, ast.unparse(ast.fix_missing_locations(tree)))


_VECTORIZABLE, _HAS_LOOP = "@jit_once(R, True)", "@jit_once(R, False)"


def _named(name: str, text: str) -> tuple[str, str]:
    unique = f"{name}_{_digest(text)}"
    return unique, f"{_VECTORIZABLE if _vectorizable(text) else _HAS_LOOP}\n{text.replace('def unnamed(', f'def {unique}(', 1)}"


def _vectorizable(text: str) -> bool:
    """Whether a function has no loop, or only loops of plain arithmetic, which the compiler can unroll."""
    nodes = list(ast.walk(ast.parse(text)))
    called = {node.func.id for node in nodes if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    return called <= {"R", "min", "max", "abs", "range"} or not _loops(ast.parse(text))


def _loops(tree: ast.AST) -> bool:
    return any(isinstance(node, ast.For | ast.While) for node in ast.walk(tree))


_jitted: dict[tuple[Any, str], Any] = {}


def jit_once(real: Any, vectorizable: bool) -> Callable[[FunctionType], Any]:
    """Decorator of the functions in the text: a function that stands in two texts is compiled once in a process.

    vectorizable: see `_vectorizable`; such a function is inlined, since a loop with calls is not vectorized.
    """

    def known(function: FunctionType) -> Any:
        import numba

        options = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "forceinline": vectorizable}
        compiler: Any = cast(Any, numba.njit)(**options)
        return _jitted.setdefault((real, function.__name__), compiler(function))

    return known


# --- named tuples of parameters -----------------------------------------------------------------------------------


@cache
def named(*fields: str) -> Any:
    """The class of named tuples with these fields, for compiled code.

    Code is compiled for plain tuples and names their fields itself. So the cached code does not refer to a class of the
    caller, which another process may not have: only the names of its fields matter.
    """
    return namedtuple("_".join(fields), fields)


def _fields(kind: Any) -> tuple[str, ...] | None:
    """The fields of a class of named tuples; None for anything else."""
    return getattr(kind, "_fields", None) if isinstance(kind, type) and issubclass(kind, tuple) else None


def layout(parameters: Any) -> Layout:
    """The structure of parameters: for each tuple the names of its fields, if it has any, and the layouts of its elements.

    None for a number or a table. Parameters of one layout are compiled alike if their numbers are of the same types.
    """
    if not isinstance(parameters, tuple) or isinstance(parameters, Table):
        return None
    return _fields(type(parameters)), tuple(map(layout, parameters))


# --- from one text to a compiled loop -----------------------------------------------------------------------------


def _loop(
    name: str,
    widths: Sequence[int],
    outputs: int,
    broadcast: Sequence[bool],
    checks: Sequence[str],
    parameters: str,
    varying: int,
) -> str:
    """The text of the loop over flat arrays, row after row. A `broadcast` argument has one row, which is used for all.

    parameters: the text of the kernel's parameters, see `_rebuilt`; the last `varying` arrays are parameters that vary. The
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
    unique = f"loop_{_digest(described)}"  # loops of all programs share one name space
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


def _count(varying: Varying) -> int:
    """How many arrays the parameters hold."""
    return max(map(_count, varying)) if isinstance(varying, tuple) else 0 if varying is None else varying + 1


def _rebuilt(shape: Layout, varying: Varying, program: _Program, path: str = "p") -> str:
    """The text of the parameters for one row, with fields: the k-th varying one is vk, the others are indexed from path."""
    if isinstance(varying, int):
        return f"v{varying}"
    if shape is None or not (varying or _names(shape)):
        return path
    fields, inner = shape
    places = varying or (None,) * len(inner)
    parts = [_rebuilt(*both, program, f"{path}[{k}]") for k, both in enumerate(zip(inner, places, strict=True))]
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
def _machine_code(text: str, kind: Any) -> Any:
    """The compiler's result for a program and the type of its parameters: from the cache, else compiled and stored there."""
    from microfacet import widest

    name = key(text, kind, inspect.getsource(jit_once), inspect.getsource(widest))
    code = load(name)
    if code is None:
        code = in_own_thread(lambda: _compile(text, kind))
        store(name, code)
    return code


def _compile(text: str, kind: Any) -> Any:
    require_compiler()
    file = f"<kernel {_digest(text)}>"
    linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file  # for the compiler's messages
    scope: dict[str, Any] = {"__name__": __name__}  # a later process looks for this module
    exec(compile(text, file, "exec"), scope)
    (result,) = scope["compiled"](kind).overloads.values()
    return result


def _separated(parameters: Any, arrays: list[np.ndarray]) -> tuple[Varying, Any]:
    """Where the parameters hold arrays, and the parameters with 0 in place of each array. The arrays are added to the list."""
    if isinstance(parameters, np.ndarray):
        known = [k for k, array in enumerate(arrays) if array is parameters]
        if not known:
            arrays.append(parameters)
        return known[0] if known else len(arrays) - 1, 0.0
    if not isinstance(parameters, tuple) or isinstance(parameters, Table):
        return None, parameters
    parts = [_separated(part, arrays) for part in parameters]
    places = tuple(place for place, _ in parts)
    make = getattr(parameters, "_make", tuple)
    return (places if any(place is not None for place in places) else None), make(rest for _, rest in parts)


class Table(tuple[float, ...]):
    """A parameter of a kernel that holds any number of values: compiled as an array, so that one loop serves all lengths."""


class Count(int):
    """A parameter of a kernel that stays an integer: a count or an index. Other integers become floats."""


def _cast(parameters: Any, real: type) -> Any:
    """The parameters as arguments of the loop: plain tuples of numbers, since the loop names their fields itself."""
    if isinstance(parameters, Table):
        return np.array(parameters, real)
    if isinstance(parameters, tuple):
        return tuple(_cast(p, real) for p in parameters)
    return int(parameters) if isinstance(parameters, Count) else real(parameters)


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
        program = _Program(real)
        name = program.add(self.function)  # type: ignore[arg-type]
        header = _HEADER.format(real=np.dtype(real).name)
        none = len(self.widths)
        parameters = _rebuilt(shape, self.varying, program)
        broadcast, checks = broadcast or (False,) * none, checks or ("",) * none
        loop = _loop(name, self.widths, self.outputs, broadcast, checks, parameters, _count(self.varying))
        return "\n\n".join([header, *program.texts, loop])

    def _compiled(self, real: type, kind: Any, shape: Layout, broadcast: Broadcast, checks: Checks) -> tuple[Loop, Pace]:
        """The compiled loop itself, without numba's dispatcher, which would inspect the types of all arguments at each call."""
        known = (real, kind, shape, broadcast, checks)
        if known not in self._loops:
            text = self.text(real, broadcast, checks, shape)
            pace = Pace(LONG if _HAS_LOOP in text else QUICKEST)
            self._loops[known] = _machine_code(text, kind).entry_point, pace
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
            cast_ = _cast(parameters, real)
            loop, pace = self._compiled(real, numba.typeof(cast_), shape, broadcast, checks)
            ready = self._ready[real, parameters, broadcast, checks] = _Ready(loop, pace, cast_, parameters, shape)
        return ready

    def _varied(
        self, arrays: Sequence[Any], shape: tuple[int, ...], parameters: Parameters, real: type, out: np.ndarray | None
    ) -> Any:
        """The call where some parameters are arrays, which are cast to the precision of the arguments."""
        if self._known is None or self._known[0] is not parameters:
            varying_arrays: list[np.ndarray] = []
            self._known = (parameters, *_separated(parameters, varying_arrays), varying_arrays)
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
