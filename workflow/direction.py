"""Imports run one way: geometry -> visibility -> material -> brdf -> validation -> surface -> enough, never back.

A module may import its own stage and those before it; the modules at the top of the package serve
all stages, so at import time they reach into none. Nothing in the library imports `report`.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import closure

LIB = closure.PACKAGES[closure.PACKAGE]
STAGES = ("geometry", "visibility", "material", "brdf", "validation", "surface", "enough")


def stage(module: str) -> str:
    """`microfacet.geometry.ggx` -> `geometry`; `microfacet.statement` -> `statement`."""
    return [*module.split("."), ""][1]


def imports_at_load(path: Path) -> Iterator[tuple[int, str]]:
    """Line and module of every import that runs when the file is loaded."""
    module = ".".join(path.relative_to(LIB).with_suffix("").parts)
    reader = closure.Imports(module.removesuffix(".__init__"), path.name == "__init__.py")
    for node in statements_at_load(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = reader.base(node)
            yield from ((node.lineno, f"{base}.{alias.name}") for alias in node.names)


def statements_at_load(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.iter_child_nodes(tree):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            yield node
            yield from statements_at_load(node)


def faults() -> Iterator[str]:
    for path in sorted(closure.whole_package()):
        home = stage(".".join(path.relative_to(LIB).with_suffix("").parts))
        for line, module in imports_at_load(path):
            if closure.is_ours(module) and not allowed(home, module):
                yield f"{path}:{line}: {home} must not import {stage(module) or module}"


def allowed(home: str, module: str) -> bool:
    package, target = module.split(".")[0], stage(module)
    if package != closure.PACKAGE or target not in STAGES:
        return package == closure.PACKAGE
    return home in STAGES and STAGES.index(target) <= STAGES.index(home)


if __name__ == "__main__":
    found = list(faults())
    print("\n".join(found) or "Imports run one way.")
    sys.exit(bool(found))
