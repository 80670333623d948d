"""What a figure's data script computes, once for all tests."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

FIGURES = Path(__file__).parents[2] / "figures"
Compute = Callable[[str], dict[str, Any]]


@pytest.fixture(scope="session")
def compute() -> Compute:
    """From `stage/name` to the arrays of that figure."""

    @cache
    def compute(name: str) -> dict[str, Any]:
        values: dict[str, Any] = runpy.run_path(str(FIGURES / f"{name}_data.py"))["compute"]()
        return values

    return compute
