"""A pytest plugin that writes down which functions of this checkout a run of tests called or compiled.

`python -m pytest -p watch FILE`; $MICROFACET_WATCH names the file to write. It looks at calls and not at lines, which costs
little; what a kernel consists of is not called when it is compiled, so that is asked of `Batch`. A module that is imported
counts as a function without a name, and a class that is defined as its name with a dot. It also writes down which tests failed.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

ROOT = Path.cwd()
PLACES = ("lib", "figures", "workflow")
seen: set[CodeType] = set()
failed: set[str] = set()


def look(frame: FrameType, event: str, argument: Any) -> None:
    """Called for each call of a Python function; without a result, its lines are not traced."""
    seen.add(frame.f_code)


threading.settrace(look)
sys.settrace(look)


def pytest_sessionstart() -> None:
    from microfacet.compiler.program import Program

    def add(program: Any, function: Any, added: Any = Program.add) -> str:
        seen.add(function.__code__)
        return added(program, function)

    Program.add = add  # type: ignore[method-assign]


def pytest_runtest_logreport(report: Any) -> None:
    if report.failed:
        failed.add(report.nodeid)


def touched() -> dict[str, list[str]]:
    """File -> names of its functions."""
    found: dict[str, set[str]] = {}
    for code in seen:
        path = ROOT / code.co_filename  # which may be relative already, of a script that was run by its name
        if path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0] in PLACES:
            found.setdefault(str(path.relative_to(ROOT)), set()).add(named(code))
    return {file: sorted(names) for file, names in sorted(found.items())}


def named(code: CodeType) -> str:
    """As places.py has it: "Class.method.inner", and "" for the module; lambdas belong to what is around them."""
    parts = [part for part in code.co_qualname.replace(".<locals>", "").split(".") if not part.startswith("<")]
    defined = parts and not code.co_flags & CO_OPTIMIZED  # the body of a class
    return ".".join(parts) + ("." if defined else "")


def pytest_sessionfinish() -> None:
    sys.settrace(None)
    threading.settrace(None)  # type: ignore[arg-type]
    Path(os.environ["MICROFACET_WATCH"]).write_text(json.dumps({"touched": touched(), "failed": sorted(failed)}), "utf-8")
