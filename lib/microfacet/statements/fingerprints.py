"""Digests of statements: a build redoes the checks of those whose digest has changed."""

from __future__ import annotations

import functools
import hashlib
import inspect
import sys
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import sympy as sp

from microfacet.compiler.kernels import source
from microfacet.statements.registry import KERNELS, registry, stating
from microfacet.statements.statement import Equation, equations


def fingerprint(equation: Equation) -> str:
    """A digest that changes when, and only when, the outcome of the checks may change."""
    return hashlib.sha256("\n".join([_checker(), *content(equation, set())]).encode()).hexdigest()[:20]


def fingerprints() -> dict[str, str]:
    """The digests of all statements by key."""
    return {key: fingerprint(equations[key]) for key in equations}


@cache
def _checker() -> str:
    """The text of what carries out the checks, and the versions of what it relies on."""
    folder = Path(__file__).parents[1]
    texts = [path.read_text("utf-8") for name in ("statements", "compiler") for path in sorted((folder / name).glob("*.py"))]
    return "\n".join([*texts, sys.version, *map(_version, ("numpy", "numba", "sympy", "mpmath", "python-flint"))])


def _version(name: str) -> str:
    try:
        return f"{name} {version(name)}"
    except PackageNotFoundError:
        return f"no {name}"


def content(thing: Any, seen: set[int]) -> list[str]:
    """Everything that the outcome of a check depends on, as text."""
    if id(thing) in seen:
        return []
    seen.add(id(thing))
    if isinstance(thing, Equation):
        return _equation_content(thing, seen)
    if isinstance(thing, functools._lru_cache_wrapper):
        thing = thing.__wrapped__
        return [_text(thing, inspect.getsource), *_all_content(_uses(thing), seen)]
    if isinstance(thing, FunctionType):
        return [_text(thing, source), *_all_content(_uses(thing), seen)]
    if is_dataclass(thing) and not isinstance(thing, type):
        return [line for part in fields(thing) for line in content(getattr(thing, part.name), seen)]
    if isinstance(thing, list | tuple | dict):
        parts = [*thing.values()] if isinstance(thing, dict) else [*thing]
        return [repr(thing) if all(isinstance(p, str | float | int) for p in parts) else "", *_all_content(parts, seen)]
    if isinstance(thing, sp.Basic):
        called = [registry.defining[f.func] for f in registry.used_in(thing)]
        return [_representation(thing), *(line for e in sorted(called, key=lambda e: e.key) for line in content(e, seen))]
    return [repr(thing) if isinstance(thing, int | float | str) else repr(getattr(thing, "_fields", ""))]  # of a named tuple


@cache
def _text(function: FunctionType, look_up: Callable[[FunctionType], str]) -> str:
    return look_up(function)


@cache
def _representation(expression: Any) -> str:
    return str(sp.srepr(expression))


def _all_content(things: Sequence[Any], seen: set[int]) -> list[str]:
    return [line for thing in things for line in content(thing, seen)]


def _uses(function: FunctionType) -> list[Any]:
    """What a function of ours names: globals, what it closes over, and attributes of our modules."""
    root = function.__module__.split(".")[0] if isinstance(function.__module__, str) else ""
    if root in sys.stdlib_module_names or root in ("numpy", "scipy", "sympy", "mpmath", "numba", "flint"):
        return []
    names = sorted(_names(function.__code__))
    found = [function.__globals__[name] for name in names if name in function.__globals__]
    found += [cell.cell_contents for cell in function.__closure__ or ()]
    modules = [m for m in found if isinstance(m, ModuleType) and m.__name__.startswith("microfacet.")]
    return [*found, *(getattr(m, name) for m in modules for name in names if name in vars(m))]


def _names(code: CodeType) -> set[str]:
    """The names in a function's code and in the functions inside it."""
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return set(code.co_names).union(*inner)


def _equation_content(e: Equation, seen: set[int]) -> list[str]:
    lines = [e.key, repr(e.within), e.relation]
    for form in (e.symbol, e.means, e.equals, e.computed_as, *e.where.values(), *e.over.values()):
        lines += content(form if isinstance(form, tuple | str) else sp.sympify(form), seen)
    for function in (e.proof, e.rewrite_proof, e.computed_by, e.enclosed if callable(e.enclosed) else None):
        lines += content(function, seen) if function is not None else []
    for kind, role in stating(e):
        lines += [kind.__name__, *content(getattr(kind, KERNELS[role]), seen)]
    for key in () if callable(e.enclosed) else e.enclosed:
        lines += content(registry.statements[key], seen)
    return [*lines, repr(e.over)]
