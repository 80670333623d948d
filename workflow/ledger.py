"""The ledger gathers what became of every check; the gate lets a report pass only without a failure.

python workflow/ledger.py gather build/checks build/ledger.json
python workflow/ledger.py gate build/ledger.json build/gate build/report.pdf
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import inventory

KINDS = ("symbolic", "enclosed", "numeric", "measured")


def record_of(path: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(path.read_text("utf-8")))
    except (OSError, ValueError):
        inventory.stop(f"The record {path} is torn: remove it, and snakemake will make it again.")


def gather(folder: Path, out: Path) -> None:
    """One entry per statement: what it says, how it was checked, and how that went."""
    entries = []
    for key, statement in inventory.statements().items():
        record = record_of(folder / f"{key}.json")
        told = {name: statement[name] for name in ("title", "slides", "cite", "latex")}
        entries.append({"key": key, **told, **record})
    tally = {kind: sum(passed(e, kind) for e in entries) for kind in KINDS}
    ledger = {"count": len(entries), "tally": tally, "entries": entries}
    text = json.dumps(ledger, indent=1, ensure_ascii=False)
    inventory.write_atomically(out, text + "\n")


def passed(entry: dict[str, Any], kind: str) -> bool:
    return bool(entry["marks"].get(kind, {}).get("status") == "pass")


def complaint(entry: dict[str, Any]) -> str:
    """Key, error and where, for one failed statement."""
    lines = [f"  {entry['key']}  ({entry['title']})", f"      {entry.get('message', '')}"]
    for kind in KINDS:
        mark = entry["marks"].get(kind, {})
        if mark.get("status") == "fail":
            lines.append(f"      {kind}: {mark.get('detail', '')}")
    return "\n".join(line for line in lines if line.strip())


def gate(ledger: Path, out: Path, *reports: Path) -> None:
    """Pass, or name every failed statement and take away the reports that are no longer true."""
    entries = json.loads(ledger.read_text("utf-8"))["entries"]
    failed = [entry for entry in entries if entry["verdict"] != "pass"]
    if failed:
        for report in reports:
            report.unlink(missing_ok=True)
        head = f"No report: {len(failed)} of {len(entries)} statements failed their checks."
        inventory.stop("\n".join([head, *map(complaint, failed)]))
    inventory.write_atomically(out, f"{len(entries)} statements passed\n")


if __name__ == "__main__":
    task, *paths = sys.argv[1:]
    tasks: dict[str, Callable[..., None]] = {"gather": gather, "gate": gate}
    tasks[task](*map(Path, paths))
