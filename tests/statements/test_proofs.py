"""Every statement's checks, run once: passed, and as good as what is on record, domain and promised error included.

The build runs them too, and the gate compares; here a proof that lost a step or a sign is found without building a report.
"""

from __future__ import annotations

import json
from pathlib import Path

import ledger
import microfacet as mf
import pytest
from microfacet.statements import checks

KEPT = json.loads((Path(__file__).parents[2] / "records/ledger.json").read_text("utf-8"))


@pytest.mark.parametrize("key", mf.equations)
def test_a_statement_is_proved_enclosed_and_computed_as_on_record(key: str) -> None:
    record = checks.check(mf.equations[key])
    assert record.failures == []
    kept = {kind: found for kind, found in KEPT[key].items() if kind != "measured"}
    assert list(ledger.losses(ledger.reached(record.as_json()), kept)) == []


def test_most_statements_are_proved_or_enclosed() -> None:
    """The test above compares with something."""
    kept = [found for key, found in KEPT.items() if key in mf.equations and {"symbolic", "enclosed"} & found.keys()]
    assert len(kept) > 0.9 * len(KEPT)
