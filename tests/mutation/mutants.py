"""Mutants: an expression, or a kernel's text, broken in one place by rule. None of these rules knows what it breaks.

Of expressions: the sign of the whole and of each term, a factor 1 + 1e-6, each exponent raised and lowered by one, axes
swapped, each factor dropped, each number raised by one. Of kernels: signs, a factor 1 + 1e-6, exponents and repeated
factors, axes.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import FunctionType
from typing import Any

import sympy as sp
from microfacet.compiler.kernels import source
from microfacet.statements.notation import alpha_x, alpha_y, mu_i, mu_o, wi, wm, wo, x, y

SLIGHTLY = sp.Rational(1000001, 1000000)


@dataclass(frozen=True)
class Mutant:
    """What was done, and what came out."""

    rule: str
    made: Any


# --- of expressions -----------------------------------------------------------------------------------------------------

AXES = [(alpha_x, alpha_y), (x, y), (mu_o, mu_i), *((d.x, d.y) for d in (wm, wo, wi))]
Place = Callable[[Any], Any]  # puts a part in place of the one that stood there


def of_expression(expression: Any) -> Iterator[Mutant]:
    """Every mutant of an expression, each once."""
    whole = sp.sympify(expression)
    seen = {whole}
    for mutant in _of_expression(whole):
        if mutant.made not in seen:
            seen.add(mutant.made)
            yield mutant


def _of_expression(whole: Any) -> Iterator[Mutant]:
    yield Mutant("the sign", sp.Mul(-1, whole, evaluate=False))
    yield Mutant("a factor 1 + 1e-6", sp.Mul(SLIGHTLY, whole, evaluate=False))
    yield from _axes(whole)
    for part, put in _places(whole, lambda same: same):
        for rule, made in _broken(part):
            yield Mutant(rule, put(made))


def _axes(whole: Any) -> Iterator[Mutant]:
    for first, second in AXES:
        if {first, second} <= whole.free_symbols:
            yield Mutant(f"{first} and {second} swapped", _renamed(whole, {first: second, second: first}))
    for angle in sorted((f.args[0] for f in whole.atoms(sp.cos) if f.args[0].is_Symbol), key=str):
        if str(angle).startswith("phi") and sp.sin(angle) in whole.atoms(sp.sin):
            s, c = sp.sin(angle), sp.cos(angle)
            yield Mutant(f"sin and cos of {angle} swapped", _renamed(whole, {s: c, c: s}))


def _renamed(e: Any, names: dict[Any, Any]) -> Any:
    """Parts renamed, all at once, without evaluating anything."""
    if e in names:
        return names[e]
    return _rebuilt(e, [_renamed(part, names) for part in e.args]) if e.args else e


def _rebuilt(e: Any, args: list[Any]) -> Any:
    if isinstance(e, sp.Add | sp.Mul | sp.Pow):
        return e.func(*args, evaluate=False)
    return e.func(*args)


def _places(e: Any, put: Place) -> Iterator[tuple[Any, Place]]:
    """Every part of the expression with a way to put something else there."""
    yield e, put
    if isinstance(e, sp.Integral):
        yield from _places(e.function, lambda made: put(sp.Integral(made, *e.limits)))
        return
    for k, part in enumerate(e.args):
        if not (e.is_Pow and k == 1 and part.is_Number):
            yield from _places(part, _putter(e, k, put))


def _putter(e: Any, k: int, put: Place) -> Place:
    return lambda made: put(_rebuilt(e, [*e.args[:k], made, *e.args[k + 1 :]]))


def _broken(e: Any) -> Iterator[tuple[str, Any]]:
    """What each rule makes of this part alone."""
    for k, part in enumerate(e.args if e.is_Add or e.is_Mul else ()):
        if e.is_Add:
            yield f"the sign of {part}", _rebuilt(e, [*e.args[:k], sp.Mul(-1, part, evaluate=False), *e.args[k + 1 :]])
        elif part != 1:
            yield f"{part} dropped", _rebuilt(e, [*e.args[:k], *e.args[k + 1 :]])
    if e.is_Pow:
        for step, word in ((1, "raised"), (-1, "lowered")):
            exponent = e.exp + step if e.exp.is_Number else sp.Add(e.exp, step, evaluate=False)
            yield f"the exponent of {e} {word}", sp.Pow(e.base, exponent, evaluate=False)
    if e.is_Rational:
        yield f"{e} raised", e + sp.Rational(1, e.q)


# --- of kernels ---------------------------------------------------------------------------------------------------------

TWINS = [("alpha_x", "alpha_y"), ("x", "y"), ("ox", "oy"), ("ix", "iy"), ("mx", "my"), ("vx", "vy"), ("mu_o", "mu_i")]
TWINS += [(f"x_{name}", f"y_{name}") for name in "moi"]


def of_kernel(function: FunctionType) -> Iterator[Mutant]:
    """Every mutant of one kernel, as functions that can be called in its place."""
    for rule, text in _of_text(source(function)):
        yield Mutant(rule, _compiled(function, text))


def called(function: FunctionType) -> list[FunctionType]:
    """The kernel and all that it calls, directly or not; each once."""
    found = [function]
    for kernel in found:
        found += [inner for inner in _inner(kernel).values() if inner not in found]
    return found


def _inner(function: FunctionType) -> dict[str, FunctionType]:
    scope = function.__globals__
    return {name: scope[name] for name in function.__code__.co_names if isinstance(scope.get(name), FunctionType)}


def rebound(function: FunctionType, old: FunctionType, new: FunctionType) -> FunctionType:
    """The kernel with another one, wherever it is called, replaced."""
    if function is old:
        return new
    changed = {name: rebound(inner, old, new) for name, inner in _inner(function).items() if old in called(inner)}
    return FunctionType(function.__code__, {**function.__globals__, **changed}, function.__name__)


def _compiled(function: FunctionType, text: str) -> FunctionType:
    scope = dict(function.__globals__)
    exec(compile(text, f"<mutant of {function.__name__}>", "exec"), scope)
    made: FunctionType = scope[function.__name__]
    made.__source__ = text  # type: ignore[attr-defined]
    return made


def _of_text(text: str) -> Iterator[tuple[str, str]]:
    tree = ast.parse(text)
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    for first, second in TWINS:
        if {first, second} <= names:
            yield (
                f"{first} and {second} swapped",
                ast.unparse(ast.fix_missing_locations(_Swap(first, second).visit(copy.deepcopy(tree)))),
            )
    count = len(list(ast.walk(tree)))
    for k in range(count):
        for rule, change in _CHANGES:
            changed = copy.deepcopy(tree)
            node = list(ast.walk(changed))[k]
            before = ast.unparse(node) if isinstance(node, ast.expr) else ""
            if change(node):
                yield f"{rule} in {before or 'what is returned'}", ast.unparse(ast.fix_missing_locations(changed))


class _Swap(ast.NodeTransformer):
    """Two names exchanged wherever a function reads them."""

    def __init__(self, first: str, second: str) -> None:
        self.names = {first: second, second: first}

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return ast.Name(self.names.get(node.id, node.id), node.ctx) if isinstance(node.ctx, ast.Load) else node


def _sign(node: ast.AST) -> bool:
    """a + b becomes a - b and the other way round; -a becomes a."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        node.op = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
        return True
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        node.op = ast.UAdd()
        return True
    return False


def _slightly(node: ast.AST) -> bool:
    """A returned number times 1 + 1e-6; of several, the first."""
    if not isinstance(node, ast.Return) or node.value is None:
        return False
    value = node.value
    if isinstance(value, ast.Tuple):
        value.elts[0] = ast.BinOp(value.elts[0], ast.Mult(), ast.Constant(1.000001))
    else:
        node.value = ast.BinOp(value, ast.Mult(), ast.Constant(1.000001))
    return not (isinstance(value, ast.Constant) and value.value == 0)


def _exponent(node: ast.AST) -> bool:
    """a ** b becomes a ** (b + 1), a * a becomes a."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        node.right = ast.BinOp(node.right, ast.Add(), ast.Constant(1.0))
        return True
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and ast.dump(node.left) == ast.dump(node.right):
        node.right = ast.Constant(1.0)
        return True
    return False


_CHANGES = [("the sign", _sign), ("a factor 1 + 1e-6", _slightly), ("the exponent", _exponent)]
