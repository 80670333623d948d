"""Every statement's proof and enclosure, run once: passed, and as good as what is on record.

The build runs them too, and the gate compares; here a proof that lost a step or a sign is found without building a report.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import ledger
import microfacet as mf
import pytest
from microfacet import checks

KEPT = json.loads((Path(__file__).parents[1] / "records/ledger.json").read_text("utf-8"))


@pytest.mark.parametrize("key", mf.equations)
def test_a_statement_is_proved_and_enclosed_as_on_record(key: str) -> None:
    equation = mf.equations[key]
    record = checks.Record(key, {"symbolic": checks.symbolic(equation), "enclosed": checks.enclosed(equation)})
    assert record.failures == []
    kept = {kind: found for kind, found in KEPT.get(key, {}).items() if kind in record.marks}
    assert list(ledger.losses(ledger.reached(asdict(record)), {"over": "", **kept})) == []


def test_most_statements_are_proved_or_enclosed() -> None:
    """The test above compares with something."""
    kept = [found for key, found in KEPT.items() if key in mf.equations and {"symbolic", "enclosed"} & found.keys()]
    assert len(kept) > 0.9 * len(KEPT)
