"""The tally of mutants over all workers: what each check killed, said at the end of the run."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import suite


def outcomes(reporter: pytest.TerminalReporter) -> Iterator[suite.Outcome]:
    for reports in (reporter.stats.get("passed", []), reporter.stats.get("failed", [])):
        for report in reports:
            for name, found in getattr(report, "user_properties", []):
                yield from (suite.Outcome(*each) for each in found if name == suite.TOLD)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    found = list(outcomes(terminalreporter))
    if not found:
        return
    report = suite.tally(found)
    killed = ", ".join(f"{count} by {name}" for name, count in sorted(report["killed by"].items()))
    said = (
        f"{report['mutants']} mutants: {killed}; {len(report['survived'])} survived; {report['equivalent']} proved equivalent"
    )
    terminalreporter.write_line(said)
