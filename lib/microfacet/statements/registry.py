"""Where statements stand, and which there are: `registry` holds every statement that was made, under its key.

A statement whose left-hand side is a function defines an abbreviation, which other statements may use.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

import sympy as sp
from sympy.core.function import AppliedUndef

from microfacet.model import Model, labelled

if TYPE_CHECKING:
    from microfacet.statements.statement import Equation

STAGES = ("geometry", "visibility", "material", "brdf", "validation")  # folders of the library that hold statements
Definition = tuple[tuple[Any, ...], Any]  # what an abbreviation takes, and what it stands for


class Registry:
    """Statements by key, and by the function that they define."""

    def __init__(self) -> None:
        self.statements: dict[str, Equation] = {}
        self.defining: dict[Any, Equation] = {}

    def add(self, equation: Equation) -> None:
        """ValueError for a key that is taken."""
        if equation.key in self.statements:
            raise ValueError(f"equation {equation.key} is stated twice")
        self.statements[equation.key] = equation
        if isinstance(equation.symbol, AppliedUndef):
            self.defining[equation.symbol.func] = equation

    def definition(self, function: Any) -> Definition | None:
        """What the function stands for, if a statement defines it."""
        if function not in self.defining:
            return None
        stated = self.defining[function]
        return stated.symbol.args, stated.equals if stated.equals is not None else stated.means

    def expand(self, expression: Any) -> Any:
        """The expression with every abbreviation replaced by what it stands for."""
        while found := self.used_in(sp.sympify(expression)):
            for f in found:
                symbols, form = self.definition(f.func) or ((), f)
                expression = expression.subs(f, form.subs(dict(zip(symbols, f.args, strict=True)), simultaneous=True))
        return expression

    def used_in(self, expression: Any) -> list[Any]:
        """The abbreviations in an expression."""
        return [f for f in expression.atoms(AppliedUndef) if f.func in self.defining]

    @contextmanager
    def without(self, *keys: str) -> Iterator[None]:
        """Without these statements, whose keys may be used anew; afterwards all is as it was."""
        statements, defining = self.statements, self.defining
        self.statements = {key: equation for key, equation in statements.items() if key not in keys}
        self.defining = dict(defining)
        try:
            yield
        finally:
            self.statements, self.defining = statements, defining


registry = Registry()


KERNELS = {"D": "kernel", "F": "kernel", "Lambda": "closed_Lambda"}  # of a family, for what it names among its statements


def stating(equation: Equation) -> list[tuple[type[Model], str]]:
    """The families that name the statement as that of their D, F or Lambda."""
    named = [(kind, role) for kind in labelled.values() for role in KERNELS]
    return [(kind, role) for kind, role in named if getattr(kind, "statements", {}).get(role) is equation]


@cache
def load() -> None:
    """Import every module that may hold statements."""
    for stage in STAGES:
        package = importlib.import_module(f"microfacet.{stage}")
        for module in pkgutil.iter_modules(package.__path__):
            importlib.import_module(f"{package.__name__}.{module.name}")


def refuse_misplaced(module: str, key: str) -> None:
    """ValueError for a statement of the library in a folder that `load` passes over, or whose key names another folder."""
    library, folder, *rest = [*module.split("."), "", ""]
    if library != "microfacet" or not rest[0]:
        return
    if folder not in STAGES:
        raise ValueError(f"equation {key} stands in {folder}/, where none is looked for, but in {', '.join(STAGES)}")
    if not key.startswith(f"{folder}."):
        raise ValueError(f"equation {key} stands in {folder}/: its key must begin with {folder}.")
