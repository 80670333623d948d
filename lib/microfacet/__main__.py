"""Commands: `python -m microfacet check KEY... --out FILE` checks statements; `list` names them, `trust` counts digits, and
`choose --alpha 0.05:0.3 --tolerance 1e-3` finds the cheapest model that is enough."""

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
    _add_choose(commands)
    return main


def _add_choose(commands: Any) -> None:
    choose = commands.add_parser(
        "choose",
        help="find the cheapest model that is near enough to the most complete one",
        description="The cheapest model that stays within a tolerance of the most complete one, for all of a scene. "
        "A range is written low:high; one number will do.",
    )
    ranges = {
        "alpha": "roughness, the larger one if there are two",
        "theta": "polar angle of the view in degrees (default 0:80)",
        "ratio": "of the larger roughness to the smaller (default 1)",
        "light": "polar angle of the light in degrees (default 0:90)",
    }
    for name, told in ranges.items():
        choose.add_argument(f"--{name}", metavar="LOW:HIGH", required=name == "alpha", help=told)
    choose.add_argument("--tolerance", type=float, default=1e-3, help="on what --measure names (default 1e-3)")
    choose.add_argument("--measure", default="albedo", help="albedo, lobe or picture (default albedo)")
    choose.add_argument("--normals", help="the surface's distribution: ggx (default) or beckmann")
    choose.add_argument(
        "--fresnel", metavar="ETA[,K]", help="index of a dielectric, or of a conductor (default: perfect mirrors)"
    )
    choose.add_argument("--bounces", help="all (default), or one if light that bounces again does not matter")
    choose.add_argument("--precision", help="single, double or either (default)")
    choose.add_argument("--chart", metavar="FILE", help="draw cost against error here, as .svg, .pdf or .png")
    choose.add_argument("--time", action="store_true", help="time the candidates now, whatever is on record")


def _choose(asked: argparse.Namespace) -> int:
    """Print the choice, its table, and where its chart is; one sentence if the scene is none."""
    from microfacet.enough.choice import choose

    try:
        scene = {name: _range(name, getattr(asked, name)) for name in ("alpha", "theta", "ratio", "light")}
        more = {name: getattr(asked, name) for name in ("normals", "bounces", "precision")} | {
            "fresnel": _fresnel(asked.fresnel)
        }
        given = {name: value for name, value in (scene | more).items() if value is not None}
        choice = choose(**given, tolerance=asked.tolerance, measure=asked.measure, costs="now" if asked.time else None)
        print(f"{choice.told()}\n\n{choice.table()}")
        if asked.chart:
            choice.chart(asked.chart)
            print(f"\nThe chart is in {asked.chart}.")
    except ValueError as fault:
        print(fault, file=sys.stderr)
        return 2
    return 0 if choice.chosen else 1


def _range(name: str, words: str | None) -> Any:
    """`0.05:0.3` as two numbers."""
    if words is None:
        return None
    try:
        return [float(word) for word in words.split(":")] if ":" in words else float(words)
    except ValueError:
        raise ValueError(f"{name} must be a number or low:high, such as 0.05:0.3, got {words!r}") from None


def _fresnel(words: str | None) -> Any:
    from microfacet.material.fresnel import Conductor, Dielectric

    if words is None:
        return None
    try:
        numbers = [float(word) for word in words.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2):
        raise ValueError(f"fresnel must be an index such as 1.5, or 0.2,3.9 for a conductor, got {words!r}")
    return Dielectric(*numbers) if len(numbers) == 1 else Conductor(*numbers)


def main(words: list[str] | None = None) -> int:
    chosen = parser().parse_args(words)
    if chosen.command == "choose":
        return _choose(chosen)
    return _statements(chosen)


def _statements(chosen: argparse.Namespace) -> int:
    from microfacet.statement import equations

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
