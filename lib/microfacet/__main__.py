"""Commands: `python -m microfacet check KEY... --out FILE` checks statements; `list` names them, `trust` counts digits."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from microfacet.statement import Equation


def parser() -> argparse.ArgumentParser:
    main = argparse.ArgumentParser(prog="microfacet", description="Microfacet models: check the statements of the report.")
    commands = main.add_subparsers(dest="command", required=True)
    check = commands.add_parser("check", help="check statements and print what was found")
    check.add_argument("keys", nargs="*", metavar="KEY", help="keys of statements; none means all")
    check.add_argument(
        "--out", metavar="FILE", help="write the records here as JSON; the exit status is then 0 if they fail too"
    )
    check.add_argument(
        "--kept", metavar="FOLDER", help="keep each record here too, and take it from here while the statement is the same"
    )
    commands.add_parser("list", help="list the statements by key")
    commands.add_parser("trust", help="measure how many digits are right over the library's domain; takes some seconds")
    return main


def main(words: list[str] | None = None) -> int:
    from microfacet.statement import equations

    chosen = parser().parse_args(words)
    if chosen.command == "trust":
        from microfacet.validation.trust import table

        print(table())
        return 0
    if chosen.command == "list":
        print("\n".join(f"{key:40} {equations[key].title}" for key in equations))
        return 0
    try:
        found = [_record(equations[key], chosen.kept) for key in chosen.keys or equations]
    except KeyError as unknown:
        print(unknown.args[0], file=sys.stderr)
        return 2
    if chosen.out:
        _write(Path(chosen.out), found)
        return 0
    return _print(found)


def _record(equation: Equation, kept: str | None) -> dict[str, Any]:
    """What the checks find; a kept record of the very same statement says it already."""
    if kept is None:
        return equation.check().as_json()
    path = Path(kept) / f"{equation.key}-{equation.fingerprint}.json"
    try:
        return dict(json.loads(path.read_text())[equation.key])
    except (OSError, ValueError, KeyError):
        found = equation.check().as_json()
        _write(path, [found])
        return found


def _write(path: Path, records: list[dict[str, Any]]) -> None:
    """Records by key; the file is complete or not there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    scratch = path.with_suffix(f".{os.getpid()}.tmp")
    scratch.write_text(json.dumps({record["key"]: record for record in records}, indent=1) + "\n")
    os.replace(scratch, path)


def _print(records: list[dict[str, Any]]) -> int:
    for record in records:
        marks = "; ".join(f"{kind}: {mark['detail']}" for kind, mark in record["marks"].items() if mark["status"] != "none")
        print(record["message"] or f"{record['key']}: {marks or 'a definition'}")
    return 1 if any(record["verdict"] == "fail" for record in records) else 0


if __name__ == "__main__":
    sys.exit(main())
