"""Commands: `python -m microfacet check KEY... --out FILE` checks statements; `list` names them, `trust` counts digits, and
`choose --alpha 0.05:0.3 --tolerance 1e-3` finds the cheapest model that is enough.

Exit status: 0 for yes (no statement failed, a model is enough), 1 for no, 2 if the question cannot be answered, which one
sentence then explains; as is customary, 130 after an interrupt and 141 where nobody reads on (`| head`).
"""

from __future__ import annotations

import argparse
import codecs
import io
import json
import os
import re
import sys
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from microfacet import __version__
from microfacet.files import keep, recall, writable, write

if TYPE_CHECKING:
    from microfacet.statements.statement import Equation


def parser() -> argparse.ArgumentParser:
    main = argparse.ArgumentParser(prog="microfacet", description="Microfacet models: check the statements of the report.")
    main.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
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
    for name, description in ranges.items():
        choose.add_argument(f"--{name}", metavar="LOW:HIGH", required=name == "alpha", help=description)
    choose.add_argument("--tolerance", type=float, default=1e-3, help="on what --measure names (default 1e-3)")
    choose.add_argument("--measure", default="albedo", help="albedo, lobe or picture (default albedo)")
    choose.add_argument("--normals", help="the surface's distribution: ggx (default) or beckmann")
    choose.add_argument(
        "--fresnel", metavar="ETA[,K]", help="index of a dielectric, or of a conductor (default: perfect mirrors)"
    )
    choose.add_argument("--bounces", help="all (default), or one if light that bounces again does not matter")
    choose.add_argument("--precision", help="single, double or either (default)")
    choose.add_argument("--chart", metavar="FILE", help="draw cost against error here, as .svg, .pdf or .png")
    choose.add_argument("--costs", metavar="FILE", help="take costs from this record of benchmarks (default: time them now)")


def _choose(asked: argparse.Namespace) -> int:
    """Print the choice, its table, and where its chart is."""
    from microfacet.enough.chart import refuse
    from microfacet.enough.choice import choose

    if asked.chart is not None:
        refuse(Path(asked.chart))

    scene = {name: _range(name, getattr(asked, name)) for name in ("alpha", "theta", "ratio", "light")}
    more = {name: getattr(asked, name) for name in ("normals", "bounces", "precision")}
    given = {name: value for name, value in (scene | more | {"fresnel": _fresnel(asked.fresnel)}).items() if value is not None}
    choice = choose(**given, tolerance=asked.tolerance, measure=asked.measure, costs=_costs(asked.costs))
    print(f"{choice.summary()}\n\n{choice.table()}")
    if asked.chart is not None:
        choice.chart(asked.chart)
        print(f"\nThe chart is in {asked.chart}.")
    return 0 if choice.chosen else 1


def _range(name: str, text: str | None) -> Any:
    """`0.05:0.3` as two numbers."""
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(":")] if ":" in text else float(text)
    except ValueError:
        raise ValueError(f"{name} must be a number or low:high, such as 0.05:0.3, got {text!r}") from None


def _fresnel(text: str | None) -> Any:
    from microfacet.material.fresnel import Conductor, Dielectric

    if text is None:
        return None
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2):
        raise ValueError(f"fresnel must be an index such as 1.5, or 0.2,3.9 for a conductor, got {text!r}")
    return Dielectric(*numbers) if len(numbers) == 1 else Conductor(*numbers)


def _costs(file: str | None) -> Any:
    """Of a record, or none."""
    from microfacet.enough.cost import recorded

    if file is not None and not Path(file).is_file():
        raise ValueError(f"costs must be a record of benchmarks, and there is no file {file}")
    return None if file is None else recorded(Path(file))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; what a person can mend is said in one sentence on the error stream."""
    _degrade(sys.stdout, sys.stderr)
    try:
        chosen = parser().parse_args(_joined(sys.argv[1:] if arguments is None else arguments))
        status = _choose(chosen) if chosen.command == "choose" else _statements(chosen)
        sys.stdout.flush()
    except BrokenPipeError:
        _abandon(sys.stdout)
        return 141
    except KeyboardInterrupt:
        return 130
    except (ValueError, OSError, RuntimeError) as fault:
        _abandon(sys.stdout)
        print(_sentence(fault), file=sys.stderr)
        return 2
    return status


def _sentence(fault: Exception) -> str:
    if isinstance(fault, OSError) and fault.errno is not None:
        return f"{fault.filename or 'The output'} cannot be read or written: {fault.strerror}"
    return str(fault)


def _abandon(stream: Any) -> None:
    """Write what can still be written; what cannot must not be tried again at exit."""
    try:
        stream.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _joined(arguments: Sequence[str]) -> list[str]:
    """`--theta -5:10` as `--theta=-5:10`: argparse takes what begins with a dash and is no plain number for an option."""
    joined: list[str] = []
    for argument in arguments:
        if re.match(r"-[\d.]", argument) and joined and re.fullmatch(r"--\w+", joined[-1]):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


SPELLED = {"±": "+-", "→": "->", "×": "x", "≤": "<=", "≥": ">=", "✓": "yes", "✗": "no", "·": "*", "°": " degrees", "–": "-"}


def _degrade(*streams: Any) -> None:
    """Let a terminal that knows fewer characters show others in their place."""
    codecs.register_error("spelled", _spelled)
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="spelled")


def _spelled(error: UnicodeError) -> tuple[str, int]:
    """What stands for characters that an encoding lacks: a sign in ASCII, a letter's name, or its number."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_in_ascii, error.object[error.start : error.end])), error.end


def _in_ascii(character: str) -> str:
    name = unicodedata.name(character, "").removeprefix("GREEK SMALL LETTER ").removeprefix("GREEK CAPITAL LETTER ")
    letter = name.lower() if name.isalpha() else f"\\u{ord(character):04x}"
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return SPELLED.get(character) or plain or letter


def _statements(chosen: argparse.Namespace) -> int:
    if chosen.command == "check":
        return _check(chosen)
    from microfacet.statements.statement import equations

    if chosen.command == "trust":
        from microfacet.validation.accuracy_table import table

        print(table())
    else:
        print("\n".join(f"{key:40} {equations[key].title}" for key in equations))
    return 0


def _check(chosen: argparse.Namespace) -> int:
    """Check, and print what was found or write it; what could not be written is refused before the work."""
    if chosen.out is not None:
        writable(chosen.out)
    if chosen.kept is not None:
        writable(Path(chosen.kept) / "kept.json")
    from microfacet.statements.statement import equations

    try:
        asked = [equations[key] for key in chosen.keys or equations]
    except KeyError as unknown:
        raise ValueError(unknown.args[0]) from None
    _warn_of_what_is_left_out(asked)
    found = [_record(equation, chosen.kept) for equation in asked]
    if chosen.out is None:
        return _print(found)
    write(chosen.out, json.dumps({record["key"]: record for record in found}, indent=1) + "\n")
    return 0


def _warn_of_what_is_left_out(asked: Sequence[Equation]) -> None:
    from microfacet.statements.balls import available

    count = sum(bool(equation.enclosed) for equation in asked)
    if count and not available():
        print(f"python-flint is not installed: what {count} statements enclose was not checked.", file=sys.stderr)


def _record(equation: Equation, kept: str | None) -> dict[str, Any]:
    """What the checks find; a kept record of the very same statement says it already, unless it was altered."""
    if kept is None:
        return equation.check().as_json()
    from microfacet.statements.fingerprints import fingerprint

    path = Path(kept) / f"{equation.key}-{fingerprint(equation)}.json"
    record = recall(path)
    if record is None or record["key"] != equation.key:
        record = equation.check().as_json()
        keep(path, record)
    return dict(record)


def _print(records: list[dict[str, Any]]) -> int:
    for record in records:
        marks = "; ".join(f"{kind}: {mark['detail']}" for kind, mark in record["marks"].items() if mark["status"] != "none")
        print(record["message"] or f"{record['key']}: {marks or 'a definition'}")
    return 1 if any(record["verdict"] == "fail" for record in records) else 0


if __name__ == "__main__":
    sys.exit(main())
