"""The gate's own rules: how much worse is worse, on both sides of each limit, and what becomes of a report that is not true."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import inventory
import ledger
import pytest
from checkout import Checkout

BARELY = 1e-9


def fell(name: str, now: Any, before: Any) -> bool:
    return list(ledger.figures_lost({name: now}, {name: before})) != []


@pytest.mark.parametrize("ulps", [0.0, 0.5, 2.0, 40.0])
def test_ulps_may_grow_by_a_quarter_and_half_a_unit(ulps: float) -> None:
    """Whatever the precision is called."""
    limit = ulps + ulps / 4 + 0.5
    for name in ("float64", "float32"):
        assert not fell(name, limit - BARELY, ulps)
        assert fell(name, limit + BARELY, ulps)


@pytest.mark.parametrize("error", [1e-6, 1e-3, 2.0])
def test_a_standard_error_may_grow_by_a_quarter(error: float) -> None:
    assert not fell("error", error * 1.25 * (1 - BARELY), error)
    assert fell("error", error * 1.25 * (1 + BARELY), error)


def test_a_cross_may_lose_a_tenth_of_its_distance() -> None:
    assert not fell("margin", 0.9 * 0.3 * (1 + BARELY), 0.3)
    assert fell("margin", 0.9 * 0.3 * (1 - BARELY), 0.3)


@pytest.mark.parametrize("name", ["claims", "count", "digits"])
def test_of_what_is_counted_none_may_be_lost(name: str) -> None:
    assert [fell(name, new, 7) for new in (6, 7, 8)] == [True, False, False]


def test_a_cross_stays_where_it_was_found() -> None:
    assert [fell("at", new, "a in [0, 1]") for new in ("a in [0, 1]", "a in [0, 2]")] == [False, True]


@pytest.mark.parametrize(("radius", "digits"), [(1.1e-40, 39), (0.9e-40, 40), (3e-7, 6), (0.05, 1), (0.0, None), (None, None)])
def test_digits_proved_are_those_before_the_radius(radius: float | None, digits: int | None) -> None:
    """|error| < 10^-digits; a radius of 0 or none at all has no digits to compare."""
    assert ledger.enclosure_figures({"radius": radius, "count": 3}) == {"count": 3, "digits": digits}
    if radius and digits:
        assert 10.0 ** -(digits + 1) < radius < 10.0**-digits


@pytest.mark.parametrize(("low", "high", "margin"), [(-0.5, -0.3, 0.3), (0.2, 0.7, 0.2), (1 / 3, 2.0, 0.333)])
def test_the_margin_of_a_cross_is_its_nearer_end(low: float, high: float, margin: float) -> None:
    found = ledger.enclosure_figures({"low": low, "high": high, "at": "here", "radius": 0.1, "count": 2})
    assert found == {"count": 2, "at": "here", "margin": margin}


def test_what_is_not_said_counts_as_one_or_as_exact() -> None:
    assert ledger.proof_figures({}) == {"claims": 1}
    assert ledger.enclosure_figures({})["count"] == 1
    assert ledger.significance_figures({}) == {"count": 1, "error": 0.0}
    assert ledger.significance_figures({"count": 7, "error": 0.25}) == {"count": 7, "error": 0.25}
    assert ledger.kernel_figures({"float64": {"ulps": 1.23456, "promised": 4}}) == {"float64": 1.23, "promised float64": 4.0}


def test_what_was_gained_is_no_loss_and_what_was_unknown_can_not_be_lost() -> None:
    assert list(ledger.losses({"over": "", "symbolic": {"claims": 1}}, {"over": ""})) == []
    assert list(ledger.figures_lost({"digits": None}, {"digits": None})) == []
    assert list(ledger.figures_lost({"digits": 0}, {"digits": None})) == ["digits was None, it is 0"]
    assert list(ledger.figures_lost({}, {"digits": 5})) == ["digits was 5, it is gone"]
    assert list(ledger.losses({"over": "a"}, {"over": ""})) == ["the domain was empty, it is a"]
    assert list(ledger.losses({"over": ""}, {"over": "a"})) == ["the domain was a, it is empty"]


# --- whole files ----------------------------------------------------------------------------------------------------------


def entry(key: str, verdict: str = "pass", **marks: dict[str, Any]) -> dict[str, Any]:
    message = "" if verdict == "pass" else f"{key} is off by 3"
    return {"key": key, "title": f"On {key}", "verdict": verdict, "message": message, "over": "", "marks": marks}


PROVED = {"status": "pass", "measured": {"claims": 2}}


class Gate:
    """A ledger, a record and two reports in a folder."""

    def __init__(self, folder: Path) -> None:
        self.ledger, self.record, self.out = folder / "ledger.json", folder / "record.json", folder / "gate"
        self.reports = [folder / "report.pdf", folder / "report.html"]
        for report in self.reports:
            report.write_text("what was true")

    def built(self, *entries: dict[str, Any]) -> Gate:
        self.ledger.write_text(json.dumps({"entries": entries}))
        return self

    def passed(self) -> str:
        ledger.gate(self.ledger, self.record, self.out, *self.reports)
        assert all(report.exists() for report in self.reports)
        return self.out.read_text()

    def refused(self) -> str:
        with pytest.raises(SystemExit) as stop:
            ledger.gate(self.ledger, self.record, self.out, *self.reports)
        assert not any(report.exists() for report in self.reports)
        assert not self.out.exists()
        return str(stop.value)


@pytest.fixture
def gate(tmp_path: Path) -> Gate:
    gate = Gate(tmp_path).built(entry("a.b", symbolic=PROVED), entry("a.c", symbolic=PROVED))
    ledger.renew(gate.ledger, gate.record)
    return gate


def test_what_is_as_it_was_passes_and_keeps_its_reports(gate: Gate) -> None:
    assert gate.passed() == "2 statements passed\n"


def test_a_new_statement_needs_a_record(gate: Gate) -> None:
    said = gate.built(entry("a.b", symbolic=PROVED), entry("a.c", symbolic=PROVED), entry("a.d")).refused()
    assert said.strip() == f"No report: {gate.record} does not say what was reached by a.d. If that is new: make record."


def test_a_failure_takes_the_reports_away_and_is_named(gate: Gate) -> None:
    said = gate.built(entry("a.b", symbolic=PROVED), entry("a.c", "fail", symbolic=PROVED)).refused()
    assert said.strip() == "No report: 1 of 2 statements failed their checks.\n  On a.c\n      a.c is off by 3"


def test_what_was_never_checked_is_a_failure_too(gate: Gate) -> None:
    assert "1 of 2" in gate.built(entry("a.b", symbolic=PROVED), entry("a.c", "unchecked", symbolic=PROVED)).refused()


def test_what_got_worse_or_went_is_named_and_nothing_else(gate: Gate) -> None:
    said = gate.built(entry("a.b")).refused()
    head, *rest = said.strip().splitlines()
    assert head == f"No report: 2 statements are worse than {gate.record} says. If that is meant: make record."
    assert rest == [
        "  a.c", "      on record, but stated no more", "  a.b", "      symbolic: passed on record, not any more",
    ]  # fmt: skip


def test_a_record_is_only_renewed_by_who_passed(gate: Gate) -> None:
    before = gate.record.read_text()
    gate.built(entry("a.b", "fail"))
    with pytest.raises(SystemExit):
        ledger.renew(gate.ledger, gate.record)
    assert gate.record.read_text() == before
    assert json.loads(before)["a.b"] == {"over": "", "symbolic": {"claims": 2}}


def test_a_record_can_be_read_by_people(gate: Gate) -> None:
    """Greek letters as such, statements by the alphabet, a line for each figure: a change shows as what it is."""
    gate.built(entry("b.b", symbolic=PROVED) | {"over": "α in [1, 2]"}, entry("a.c", symbolic=PROVED))
    ledger.renew(gate.ledger, gate.record)
    text = gate.record.read_text("utf-8")
    assert "α in [1, 2]" in text
    assert list(json.loads(text)) == ["a.c", "b.b"]
    assert len(text.splitlines()) > 8
    assert text.endswith("}\n")


@pytest.mark.parametrize("text", [None, "{", ""])
def test_a_torn_record_ends_with_its_remedy(tmp_path: Path, text: str | None) -> None:
    path = tmp_path / "record.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SystemExit, match="is missing, torn or empty: start the build again"):
        ledger.record_of(path)
    with pytest.raises(SystemExit, match=r"torn or empty: `git checkout records/none\.json` or `make record` brings it back"):
        ledger.record_of(Path("records/none.json"))


# --- from checks to the ledger ----------------------------------------------------------------------------------------


@pytest.fixture
def stated(small: Checkout, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Two statements of one stage and one of another, and records of what became of them."""
    facts = {"title": "T", "slides": [1], "cite": "c", "latex": "x"}
    monkeypatch.setattr(inventory, "statements", lambda: dict.fromkeys(("a.b", "a.c", "b.a"), facts))

    def write(**changes: dict[str, Any]) -> Path:
        records = {key: entry(key, symbolic=PROVED) for key in ("a.b", "a.c", "b.a")}
        records |= {key.replace("_", "."): made for key, made in changes.items()}
        folder = Path("checks")
        folder.mkdir(exist_ok=True)
        for stage in "ab":
            (folder / f"{stage}.json").write_text(json.dumps({k: v for k, v in records.items() if k.startswith(f"{stage}.")}))
        return folder

    return write


def gathered(folder: Path, trials: dict[str, Any]) -> dict[str, Any]:
    Path("measured.json").write_text(json.dumps(trials))
    ledger.gather(folder, Path("measured.json"), Path("ledger.json"))
    found: dict[str, Any] = json.loads(Path("ledger.json").read_text())
    return found


def test_the_ledger_counts_what_passed_by_kind(stated: Callable[..., Path]) -> None:
    folder = stated(a_c=entry("a.c", numeric={"status": "pass"}, enclosed={"status": "fail"}))
    found = gathered(folder, {"b.a": {"status": "pass", "detail": "seen"}})
    assert found["count"] == 3
    assert found["tally"] == {"symbolic": 2, "enclosed": 0, "numeric": 1, "measured": 1}
    assert [one["key"] for one in found["entries"]] == ["a.b", "a.c", "b.a"]
    assert found["entries"][2]["marks"] == {"symbolic": PROVED, "measured": {"status": "pass", "detail": "seen"}}
    assert found["entries"][0]["latex"] == "x"


@pytest.mark.parametrize(("before", "message"), [("pass", "a.b"), ("fail", "a.b is off by 3")])
def test_a_trial_that_refutes_fails_its_statement(stated: Callable[..., Path], before: str, message: str) -> None:
    found = gathered(stated(a_b=entry("a.b", before)), {"a.b": {"status": "fail", "detail": "refuted"}})
    assert found["entries"][0]["verdict"] == "fail"
    assert found["entries"][0]["message"] == f"{message}; measured: refuted"


def test_a_trial_that_passes_does_not_save_a_statement(stated: Callable[..., Path]) -> None:
    found = gathered(stated(a_b=entry("a.b", "fail")), {"a.b": {"status": "pass", "detail": "seen"}})
    assert (found["entries"][0]["verdict"], found["entries"][0]["message"]) == ("fail", "a.b is off by 3")


def test_a_trial_of_what_is_not_stated_is_refused(stated: Callable[..., Path]) -> None:
    with pytest.raises(SystemExit, match=r"measured.json measures what is not stated: a.z, c.a"):
        gathered(stated(), {"c.a": {"status": "pass"}, "a.z": {"status": "pass"}})


def test_failures_are_said_before_anything_is_measured(stated: Callable[..., Path]) -> None:
    report = Path("report.pdf")
    report.write_text("what was true")
    ledger.checked(stated(), Path("checked"), report)
    assert Path("checked").read_text() == "3 statements passed their checks\n"
    assert report.exists()
    Path("checked").unlink()
    with pytest.raises(SystemExit, match="1 of 3 statements failed"):
        ledger.checked(stated(b_a=entry("b.a", "fail")), Path("checked"), report)
    assert not report.exists()
    assert not Path("checked").exists()
