"""Checkouts for the tests of the build."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import closure
import inventory
import pytest
from checkout import Checkout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Checkout:
    """A checkout whose report has been built. Tests that change it put things back."""
    checkout = Checkout(tmp_path_factory.mktemp("built"))
    done = checkout.snakemake()
    assert done.returncode == 0, done.stdout
    return checkout


@pytest.fixture
def within(built: Checkout, monkeypatch: pytest.MonkeyPatch) -> Iterator[Checkout]:
    """The built checkout as the current folder, with nothing remembered from another."""
    monkeypatch.chdir(built.root)
    forget()
    yield built
    forget()


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Checkout]:
    """A fresh checkout as the current folder, with nothing remembered from another."""
    checkout = Checkout(tmp_path / "small")
    monkeypatch.chdir(checkout.root)
    forget()
    yield checkout
    forget()


def forget() -> None:
    for module in (closure, inventory):
        for thing in vars(module).values():
            if hasattr(thing, "cache_clear"):
                thing.cache_clear()
