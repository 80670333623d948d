"""Families of models: every class that gives itself a `label`, in the library or outside, is in every list.

The tables, the domain of trust, `choose` and the tests go through these. A file with a class is enough to be among them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, TypeVar

from microfacet.model import Model, labelled, signature
from microfacet.statements.registry import load

Kind = TypeVar("Kind", bound=Model)


def families(base: type[Kind], first: Sequence[str] = ()) -> list[type[Kind]]:
    """The labelled classes below `base`: those named, then the library's by their files, then others as they were made."""
    load()
    found = [kind for kind in labelled.values() if issubclass(kind, base)]
    return sorted(found, key=lambda kind: (_place(kind.__name__, first), not _ours(kind), kind.__module__ * _ours(kind)))


def _place(name: str, first: Sequence[str]) -> int:
    return first.index(name) if name in first else len(first)


def _ours(kind: type[Model]) -> bool:
    return kind.__module__.split(".")[0] == __name__.split(".")[0]


def key_of(kind: type[Model]) -> str:
    """The name of a class in keys of statements: `normalized_blinn_phong` for NormalizedBlinnPhong."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", kind.__name__).lower()


def alphas_of(kind: type[Model]) -> int:
    """How many arguments of a class are alphas: two, one, or none."""
    made_of: Any = kind
    return sum(name in ("alpha", "alpha_x", "alpha_y") for name in signature(made_of).parameters)


def of_alpha(kind: type[Kind], alpha_x: float, alpha_y: float) -> Kind:
    """The model of these alphas; a ValueError for two different ones where the class has one."""
    count = alphas_of(kind)
    if count < 2 and alpha_x != alpha_y:
        raise ValueError(f"{kind.__name__} has one roughness, got {alpha_x:g} and {alpha_y:g}")
    make: Any = kind
    return make(*(alpha_x, alpha_y)[:count])
