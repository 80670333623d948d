"""From a kernel and all that it calls to the text of one program, in which every function stands once, callees first."""

from __future__ import annotations

import ast
import builtins
import dis
import hashlib
import math
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from math import exp
from types import FunctionType
from typing import Any, cast

import numpy as np

from microfacet.compiler.exponential import exponential
from microfacet.compiler.kernels import ByPrecision, source

VECTORIZED: dict[Any, Any] = {exp: exponential}  # replacements of functions of `math` in a kernel without a loop


_REPLACING = tuple(f"{function.__name__}_" for function in VECTORIZED.values())


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


def digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


class Program:
    """The functions a kernel needs, each once, callees first. A name ends in a digest of the text, which names the callees."""

    def __init__(self, real: type) -> None:
        self.real = real
        self.texts: list[str] = []
        self.names: dict[FunctionType, str] = {}
        self.known: set[str] = set()  # names of tables and of classes

    def table(self, values: tuple[float, ...]) -> str:
        """The name of an array that holds the values of a tuple: of integers if all are."""
        kind = "np.intp" if all(isinstance(value, int) for value in values) else "T"
        return self._define(f"table_{digest(repr(values))}", f"np.array({values!r}, {kind})")

    def named_tuple(self, fields: tuple[str, ...]) -> str:
        """The name of the class of tuples with these fields."""
        return self._define(f"Named_{digest(repr(fields))}", f"named{fields!r}")

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
        fields = fields_of(value)
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


_VECTORIZABLE, HAS_LOOP = "@jit_once(R, True)", "@jit_once(R, False)"


def _named(name: str, text: str) -> tuple[str, str]:
    unique = f"{name}_{digest(text)}"
    return unique, f"{_VECTORIZABLE if _vectorizable(text) else HAS_LOOP}\n{text.replace('def unnamed(', f'def {unique}(', 1)}"


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


@cache
def named(*fields: str) -> Any:
    """The class of named tuples with these fields, for compiled code.

    Code is compiled for plain tuples and names their fields itself. So the cached code does not refer to a class of the
    caller, which another process may not have: only the names of its fields matter.
    """
    return namedtuple("_".join(fields), fields)


def fields_of(kind: Any) -> tuple[str, ...] | None:
    """The fields of a class of named tuples; None for anything else."""
    return getattr(kind, "_fields", None) if isinstance(kind, type) and issubclass(kind, tuple) else None
