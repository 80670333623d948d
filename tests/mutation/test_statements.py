"""A check counts only if it can fail: every statement and kernel, broken in every way of mutants.py, goes red."""

from __future__ import annotations

import json
from pathlib import Path
from types import FunctionType

import pytest
import suite

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parent.parent.parent
FOUND: dict[str, list[suite.Outcome]] = {}


def survivors(name: str, outcomes: list[suite.Outcome]) -> list[str]:
    FOUND[name] = outcomes
    return [f"{o.part}: {o.rule}" for o in outcomes if not o.killed_by]


@pytest.mark.parametrize("key", suite.ORIGINAL)
def test_every_mutant_of_a_statement_is_red(key: str) -> None:
    outcomes = list(suite.outcomes_of_statement(key))
    assert {"the sign", "a factor 1 + 1e-6"} <= {outcome.rule for outcome in outcomes}
    assert survivors(key, outcomes) == []


@pytest.mark.parametrize("function", suite.users(), ids=lambda function: function.__name__)
def test_every_mutant_of_a_kernel_is_red(function: FunctionType) -> None:
    """In double precision, as Python runs it; the kernel itself is as good as promised at the same arguments."""
    assert not any(suite.wrong_kernel(key, suite.ORIGINAL[key].scalar) for key in suite.users()[function])
    assert survivors(f"{function.__module__}.{function.__name__}", list(suite.outcomes_of_kernel(function))) == []


def test_tally(capsys: pytest.CaptureFixture[str]) -> None:
    """How many mutants each check killed: printed, and left in build/mutation.json for the ledger."""
    if len(FOUND) < len(suite.ORIGINAL) + len(suite.users()):
        pytest.skip("some statements or kernels were not looked at")
    report = suite.tally([outcome for outcomes in FOUND.values() for outcome in outcomes])
    (ROOT / "build").mkdir(exist_ok=True)
    (ROOT / "build" / "mutation.json").write_text(json.dumps(report, indent=1) + "\n")
    with capsys.disabled():
        killed = ", ".join(f"{count} by {name}" for name, count in report["killed by"].items())
        print(f"\n{report['mutants']} mutants: {killed}; {len(report['survived'])} survived")
    assert report["survived"] == []
    assert {"numeric", "enclosed", "symbolic"} <= set(report["killed by"])
