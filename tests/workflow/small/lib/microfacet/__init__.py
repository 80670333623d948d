"""A package with the public face that the build relies on, and three statements."""

import importlib
from typing import Any

__version__ = "0.0.1"

PUBLIC = {"GGX": "geometry.ggx", "equations": "statements.statement"}


def __getattr__(name: str) -> Any:
    if name not in PUBLIC:
        raise AttributeError(name)
    return getattr(importlib.import_module(f"microfacet.{PUBLIC[name]}"), name)
