"""A check counts only if it can fail: every statement and kernel, broken in every way of mutants.py, goes red."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple
from types import FunctionType

import pytest
import suite

pytestmark = pytest.mark.slow
Record = Callable[[str, object], None]


def survivors(outcomes: list[suite.Outcome], record_property: Record) -> list[str]:
    record_property(suite.TOLD, [astuple(outcome) for outcome in outcomes])
    return [f"{o.part}: {o.rule}" for o in outcomes if not o.killed_by]


@pytest.mark.parametrize("key", suite.ORIGINAL)
def test_every_mutant_of_a_statement_is_red(key: str, record_property: Record) -> None:
    outcomes = list(suite.outcomes_of_statement(key))
    assert {"the sign", "a factor 1 + 1e-6"} <= {outcome.rule for outcome in outcomes}
    assert survivors(outcomes, record_property) == []


@pytest.mark.parametrize("function", suite.users(), ids=lambda function: function.__name__)
def test_every_mutant_of_a_kernel_is_red(function: FunctionType, record_property: Record) -> None:
    """In double precision, as Python runs it; the kernel itself is as good as promised at the same arguments."""
    assert not any(suite.wrong_kernel(key, suite.ORIGINAL[key].scalar) for key in suite.users()[function])
    assert survivors(list(suite.outcomes_of_kernel(function)), record_property) == []
