"""What a figure's data script computes, once for all tests."""

from __future__ import annotations

import runpy
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from microfacet.surface.measure import shard
from report.campaign import CAMPAIGN
from report.datafile import store

FIGURES = Path(__file__).parents[2] / "figures"
Compute = Callable[[str], dict[str, Any]]


@pytest.fixture(scope="session", autouse=True)
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A campaign of four small surfaces a family, in place of the build's."""
    folder = tmp_path_factory.mktemp("campaign")
    for name, entry in CAMPAIGN.items():
        family = replace(entry.family, size=128, correlation=7)
        store(str(folder / f"{name}.npz"), **shard(family, replace(entry.plan, side=40), 0, 4))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MICROFACET_CAMPAIGN", str(folder))
        yield folder


@pytest.fixture(scope="session")
def compute() -> Compute:
    """From `stage/name` to the arrays of that figure."""

    @cache
    def compute(name: str) -> dict[str, Any]:
        values: dict[str, Any] = runpy.run_path(str(FIGURES / f"{name}_data.py"))["compute"]()
        return values

    return compute
