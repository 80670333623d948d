"""What all tests share: kernels are kept under build/, hypothesis tries the same examples every time, mutants are counted."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

os.environ.setdefault("MICROFACET_CACHE", str(Path(__file__).parent.parent / "build" / "kernels"))

settings.register_profile("repeatable", deadline=None, derandomize=True, database=None, max_examples=60)
settings.load_profile("repeatable")

LONG = ("workflow/test_build.py", "workflow/test_web.py", "figures/", "stability/", "brdf/", "validation/")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files that take long come first, so that no worker is left with one of them at the end."""
    items.sort(key=lambda item: not any(name in item.nodeid for name in LONG))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """The tally of mutants over all workers. It stands here because a run of several workers reads no folder's own conftest."""
    reports = [*terminalreporter.stats.get("passed", []), *terminalreporter.stats.get("failed", [])]
    told = [found for report in reports for name, found in getattr(report, "user_properties", []) if name == "mutants"]
    if told:
        import suite

        terminalreporter.write_line(suite.said(suite.Outcome(*each) for found in told for each in found))
