"""What a statement reached is compared with what is on record: every way of getting worse is named."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ledger
import microfacet as mf
import pytest

ROOT = Path(__file__).resolve().parents[2]
ENTRY = {
    "key": "a.b",
    "title": "a statement",
    "verdict": "pass",
    "message": "",
    "over": "a in [1, 2]",
    "marks": {
        "symbolic": {"status": "pass", "measured": {"claims": 3}},
        "enclosed": {"status": "pass", "measured": {"radius": 3e-41, "count": 5, "at": "a = 1"}},
        "numeric": {
            "status": "pass",
            "measured": {
                "float64": {"ulps": 2.0, "at": "a=1", "promised": 8.0},
                "float32": {"ulps": 1.5, "at": "a=1", "promised": 8.0},
            },
        },
        "measured": {"status": "pass", "measured": {"count": 7, "error": 1e-3, "odds": 0.4}},
    },
}
BOX = {"radius": 0.1, "low": -0.5, "high": -0.3, "count": 1, "at": "a in [0, 1]"}


def changed(path: str, value: Any, entry: dict[str, Any] = ENTRY) -> dict[str, Any]:
    """The entry with one of its leaves replaced."""
    made = copy.deepcopy(entry)
    *folders, leaf = path.split(".")
    inner = made
    for folder in folders:
        inner = inner[folder]
    inner[leaf] = value
    return made


def lost(now: dict[str, Any], before: dict[str, Any] = ENTRY) -> list[str]:
    return list(ledger.losses(ledger.reached(now), ledger.reached(before)))


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        ("over", "a in [1, 1.5]", "the domain was a in [1, 2], it is a in [1, 1.5]"),
        ("marks.symbolic.status", "none", "symbolic: passed on record, not any more"),
        ("marks.symbolic.measured.claims", 2, "symbolic: claims was 3, it is 2"),
        ("marks.enclosed.status", "none", "enclosed: passed on record, not any more"),
        ("marks.enclosed.measured.radius", 1e-30, "enclosed: digits was 40, it is 30"),
        ("marks.enclosed.measured.count", 4, "enclosed: count was 5, it is 4"),
        ("marks.numeric.measured.float64.ulps", 4.0, "numeric: float64 was 2.0, it is 4.0"),
        ("marks.numeric.measured.float64.promised", 8.5, "numeric: promised float64 was 8.0, it is 8.5"),
        ("marks.measured.status", "none", "measured: passed on record, not any more"),
        ("marks.measured.measured.count", 6, "measured: count was 7, it is 6"),
        ("marks.measured.measured.error", 2e-3, "measured: error was 0.001, it is 0.002"),
        ("marks.numeric.measured.float32.ulps", 3.0, "numeric: float32 was 1.5, it is 3.0"),
    ],
)
def test_each_way_of_getting_worse_is_named(path: str, value: Any, sentence: str) -> None:
    assert lost(changed(path, value)) == [sentence]


def test_a_precision_that_is_not_looked_at_any_more_is_named() -> None:
    said = lost(changed("marks.numeric.measured", {"float64": {"ulps": 2.0, "promised": 8.0}}))
    assert said == ["numeric: float32 was 1.5, it is gone", "numeric: promised float32 was 8.0, it is gone"]


def test_as_good_or_better_passes() -> None:
    assert lost(ENTRY) == []
    assert lost(changed("marks.numeric.measured.float64.ulps", 2.4)) == []  # another processor's exp
    assert lost(changed("marks.numeric.measured.float64.promised", 7.5)) == []
    assert lost(changed("marks.enclosed.measured.radius", 1e-60)) == []


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        ("at", "a in [0, 0.5]", "enclosed: at was a in [0, 1], it is a in [0, 0.5]"),
        ("high", -0.2, "enclosed: margin was 0.3, it is 0.2"),
    ],
)
def test_a_cross_keeps_its_box_and_its_distance(path: str, value: Any, sentence: str) -> None:
    cross = changed("marks.enclosed.measured", BOX)
    assert lost(cross, cross) == []
    assert lost(changed(f"marks.enclosed.measured.{path}", value, cross), cross) == [sentence]


def test_a_statement_that_is_gone_is_named() -> None:
    both = {"a.b": ledger.reached(ENTRY), "a.c": ledger.reached(ENTRY)}
    assert ledger.behind({"a.b": ledger.reached(ENTRY)}, both) == ["  a.c\n      on record, but stated no more"]
    assert ledger.behind(both, both) == []


def leaves(record: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The paths of all that a record says, folders first."""
    if isinstance(record, dict):
        for name, inner in record.items():
            yield (*path, name)
            yield from leaves(inner, (*path, name))


REACHED = {"a.b": ledger.reached(ENTRY), "a.c": ledger.reached(changed("marks.enclosed.measured", BOX))}


@pytest.mark.parametrize("path", list(leaves(REACHED)), ids=".".join)
@pytest.mark.parametrize("value", ["gone", None, {}, [], "", float("nan"), float("inf"), -float("inf")], ids=repr)
def test_a_record_that_says_less_than_was_reached_is_noticed(path: tuple[str, ...], value: Any) -> None:
    record = copy.deepcopy(REACHED)
    inner = record
    for name in path[:-1]:
        inner = inner[name]
    if value == "gone":
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    assert [*ledger.unrecorded(REACHED, record)] or ledger.behind(REACHED, record)


@pytest.mark.parametrize("text", ["", "{}", "[]", "null", "3", '{"a.b": ', "{}}", "[" * 100_000, "\x00", "\ud800"])
def test_a_record_that_is_none_stops_the_gate(text: str, tmp_path: Path) -> None:
    built, record, passed = tmp_path / "built.json", tmp_path / "ledger.json", tmp_path / "gate"
    built.write_text(json.dumps({"entries": [ENTRY]}))
    record.write_bytes(text.encode("utf-8", "surrogatepass"))
    for _ in range(2):
        with pytest.raises(SystemExit, match=r"The record \S+ is missing, torn or empty: .+\.\n$"):
            ledger.gate(built, record, passed)
        record.unlink(missing_ok=True)
    assert not passed.exists()


def test_a_statement_that_is_not_on_record_stops_the_gate(tmp_path: Path) -> None:
    built, record, passed = tmp_path / "built.json", tmp_path / "ledger.json", tmp_path / "gate"
    report = tmp_path / "report.pdf"
    report.touch()
    built.write_text(json.dumps({"entries": [ENTRY, ENTRY | {"key": "a.new"}]}))
    record.write_text(json.dumps({"a.b": ledger.reached(ENTRY)}))
    with pytest.raises(SystemExit, match=r"does not say what was reached by a\.new\. If that is new: make record\."):
        ledger.gate(built, record, passed, report)
    assert not passed.exists()
    assert not report.exists()
    ledger.renew(built, record)
    ledger.gate(built, record, passed)
    assert passed.exists()


def test_only_a_green_ledger_goes_on_record(tmp_path: Path) -> None:
    built, record = tmp_path / "built.json", tmp_path / "record.json"
    built.write_text(json.dumps({"entries": [ENTRY | {"verdict": "fail"}]}))
    with pytest.raises(SystemExit, match="1 of 1 statements failed"):
        ledger.renew(built, record)
    assert not record.exists()
    built.write_text(json.dumps({"entries": [ENTRY]}))
    ledger.renew(built, record)
    assert ledger.behind({"a.b": ledger.reached(ENTRY)}, ledger.record_of(record)) == []


def test_every_statement_is_on_record() -> None:
    assert set(json.loads((ROOT / "records/ledger.json").read_text())) == set(mf.equations)
