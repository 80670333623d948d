"""The ledger gathers what became of every check; the gate lets a report pass only if none failed and none got worse.

What every statement once reached is on record, in git; a build reads the record and never writes it.

python workflow/ledger.py checked build/checks build/checked build/report.pdf
python workflow/ledger.py gather build/checks build/measured.json build/ledger.json
python workflow/ledger.py gate build/ledger.json records/ledger.json build/gate build/report.pdf
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from math import isfinite, log10
from pathlib import Path
from typing import Any

import inventory

RECORDS = Path("records")  # kept in git; all other records are made by the build
KINDS = ("symbolic", "enclosed", "numeric", "measured")


def record_of(path: Path) -> dict[str, Any]:
    """The contents of a record by name; one that is missing, torn or empty stops the build."""
    try:
        record = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        record = None
    if not (isinstance(record, dict) and record):
        remedy = f"`git checkout {path}` or `make record` brings it back" if path.parent == RECORDS else "start the build again"
        inventory.stop(f"The record {path} is missing, torn or empty: {remedy}.")
    return record


def checked(folder: Path, out: Path, *reports: Path) -> None:
    """Report failures at once: the ledger waits for the significance tests on surfaces, which take minutes."""
    entries = entries_of(folder, {})
    refuse_failures(entries, reports)
    inventory.write_atomically(out, f"{len(entries)} statements passed their checks\n")


def entries_of(folder: Path, significance_tests: dict[str, Any]) -> list[dict[str, Any]]:
    """One entry per statement: its text, its checks, and their results."""
    checked_now: dict[str, Any] = {}
    for stage in dict.fromkeys(map(inventory.stage, inventory.statements())):
        checked_now |= record_of(folder / f"{stage}.json")
    fields = ("title", "slides", "cite", "latex")
    return [
        {
            "key": key,
            **{name: statement[name] for name in fields},
            **with_significance_test(checked_now[key], significance_tests.get(key)),
        }
        for key, statement in inventory.statements().items()
    ]


def gather(folder: Path, measured: Path, out: Path) -> None:
    """The ledger: the entries of all statements, and how many of each kind of check passed."""
    significance_tests = record_of(measured)
    if unknown := sorted(significance_tests.keys() - inventory.statements().keys()):
        inventory.stop(f"{measured} measures what is not stated: {', '.join(unknown)}.")
    entries = entries_of(folder, significance_tests)
    tally = {kind: sum(passed(e, kind) for e in entries) for kind in KINDS}
    ledger = {"count": len(entries), "tally": tally, "entries": entries}
    text = json.dumps(ledger, indent=1, ensure_ascii=False)
    inventory.write_atomically(out, text + "\n")


def with_significance_test(record: dict[str, Any], test: dict[str, Any] | None) -> dict[str, Any]:
    """The record with the mark of its significance test."""
    if test is None:
        return record
    failed = test["status"] == "fail"
    message = f"{record['message'] or record['key']}; measured: {test['detail']}" if failed else record["message"]
    verdict = "fail" if failed else record["verdict"]
    return {**record, "verdict": verdict, "message": message, "marks": {**record["marks"], "measured": test}}


def passed(entry: dict[str, Any], kind: str) -> bool:
    return bool(entry["marks"].get(kind, {}).get("status") == "pass")


def complaint(entry: dict[str, Any]) -> str:
    """Title, key, error and where, for one failed statement."""
    return f"  {entry['title']}\n      {entry['message']}"


# Figures of the checks, compared with the record -----------------------------------------------

SLACK = 1.25  # factor by which ulps may grow, and half a unit: processors differ in the last place of exp and its like
FEWER = 0.9  # of the distance from 0 that a cross is proved to keep


def reached(entry: dict[str, Any]) -> dict[str, Any]:
    """The part of an entry that goes on record: figures by kind of check that passed."""
    figures = {kind: FIGURES[kind](entry["marks"][kind].get("measured", {})) for kind in KINDS if passed(entry, kind)}
    return {"over": entry.get("over", ""), **figures}


def proof_figures(measured: dict[str, Any]) -> dict[str, Any]:
    return {"claims": measured.get("claims", 1)}


def enclosure_figures(measured: dict[str, Any]) -> dict[str, Any]:
    """Points or boxes; for equalities the digits proved, for crosses the box and the distance from 0."""
    points = {"count": measured.get("count", 1)}
    if "low" not in measured:
        return points | {"digits": int(-log10(measured["radius"])) if measured.get("radius") else None}
    margin = min(abs(measured["low"]), abs(measured["high"]))
    return points | {"at": measured["at"], "margin": float(f"{margin:.3g}")}


def kernel_figures(measured: dict[str, Any]) -> dict[str, Any]:
    """In units of the last place: the largest error, and the one that is promised."""
    errors = {precision: round(mark["ulps"], 2) for precision, mark in measured.items()}
    return errors | {f"promised {precision}": float(mark["promised"]) for precision, mark in measured.items()}


def significance_figures(measured: dict[str, Any]) -> dict[str, Any]:
    """Number of tests and standard error; the p-value is random and not recorded."""
    return {"count": measured.get("count", 1), "error": measured.get("error", 0.0)}


FIGURES: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
    "symbolic": proof_figures,
    "enclosed": enclosure_figures,
    "numeric": kernel_figures,
    "measured": significance_figures,
}


def losses(now: dict[str, Any], before: dict[str, Any]) -> Iterator[str]:
    """One sentence for each way in which a statement fell behind its record."""
    if now["over"] != before["over"]:
        yield f"the domain was {before['over'] or 'empty'}, it is {now['over'] or 'empty'}"
    for kind in KINDS:
        if kind in before and kind not in now:
            yield f"{kind}: passed on record, not any more"
        elif kind in before:
            yield from (f"{kind}: {loss}" for loss in figures_lost(now[kind], before[kind]))


def figures_lost(now: dict[str, Any], before: dict[str, Any]) -> Iterator[str]:
    for name, old in before.items():
        new = now.get(name)
        if new != old and (new is None or not still(name, new, old)):
            yield f"{name} was {old}, it is {'gone' if new is None else new}"


def still(name: str, new: Any, old: Any) -> bool:
    """Whether a figure is as good as the one on record, which must be a number, and finite, to compare with."""
    if name == "at" or not (isinstance(old, int | float) and isfinite(old)):
        return False
    if name == "margin":
        return bool(new >= FEWER * old)
    if name == "error":
        return bool(new <= SLACK * old)
    if name in ("claims", "count", "digits"):
        return bool(new >= old)
    if name.startswith("promised"):
        return bool(new <= old)
    return bool(new <= SLACK * old + 0.5)


def unrecorded(now: Any, before: Any, name: str = "") -> Iterator[str]:
    """Figures that are not on record: a loss there would go unnoticed."""
    if not isinstance(now, dict):
        return
    for inner, values in now.items():
        full = f"{name}, {inner}" if name else inner
        if not isinstance(before, dict) or inner not in before:
            yield full
        else:
            yield from unrecorded(values, before[inner], full)


def behind(now: dict[str, Any], recorded: dict[str, Any]) -> list[str]:
    """The gate's sentences about statements that are worse than the record, or gone."""
    gone = [f"  {key}\n      on record, but stated no more" for key in recorded if key not in now]
    worse = {key: list(losses(now[key], recorded[key])) for key in recorded if key in now}
    return gone + ["\n      ".join([f"  {key}", *message]) for key, message in worse.items() if message]


def renew(ledger: Path, record: Path) -> None:
    """Put on record what the last build reached. Asked for by people only."""
    entries = record_of(ledger)["entries"]
    refuse_failures(entries, [])
    text = json.dumps({entry["key"]: reached(entry) for entry in entries}, indent=1, sort_keys=True, ensure_ascii=False)
    inventory.write_atomically(record, text + "\n")


def gate(ledger: Path, record: Path, out: Path, *reports: Path) -> None:
    """Pass, or name every statement that failed or got worse, and delete the report, which is no longer true."""
    entries = record_of(ledger)["entries"]
    refuse_failures(entries, reports)
    now = {entry["key"]: reached(entry) for entry in entries}
    recorded = record_of(record)
    if lacking := list(unrecorded(now, recorded)):
        withdraw(reports)
        inventory.stop(f"No report: {record} does not say what was reached by {listed(lacking)}. If that is new: make record.")
    if worse := behind(now, recorded):
        withdraw(reports)
        head = f"No report: {len(worse)} statements are worse than {record} says. If that is meant: make record."
        inventory.stop("\n".join([head, *worse]))
    inventory.write_atomically(out, f"{len(entries)} statements passed\n")


def listed(names: list[str], most: int = 5) -> str:
    return "; ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def refuse_failures(entries: list[dict[str, Any]], reports: Sequence[Path]) -> None:
    failed = [entry for entry in entries if entry["verdict"] != "pass"]
    if failed:
        withdraw(reports)
        head = f"No report: {len(failed)} of {len(entries)} statements failed their checks."
        inventory.stop("\n".join([head, *map(complaint, failed)]))


def withdraw(reports: Sequence[Path]) -> None:
    for report in reports:
        report.unlink(missing_ok=True)


if __name__ == "__main__":
    task, *paths = sys.argv[1:]
    tasks: dict[str, Callable[..., None]] = {"checked": checked, "gather": gather, "gate": gate, "renew": renew}
    tasks[task](*map(Path, paths))
