"""Inputs, parameters and targets for the Snakefile, from the inventory."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shlex
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import campaign
import closure
import failed
import inventory
import provenance
import typeset

ENDINGS = (".svg", ".pdf", ".png")
SIGNIFICANCE_TESTS = Path("lib/report/significance_tests.py")
VERSIONS = "requirements.lock"
ONE_OF_EACH = (
    "build/checked",
    "build/gate",
    "build/ledger.json",
    "build/measured.json",
    "build/report.pdf",
    "build/report.html",
)


def settle_environment() -> None:
    """Jobs run this interpreter, one thread each, and keep their byte code."""
    here = str(Path(sys.executable).parent)
    os.environ["PATH"] = here + os.pathsep + os.environ.get("PATH", "")
    os.environ["PYTHONPATH"] = os.pathsep.join(str(Path(folder).resolve()) for folder in ("lib", "."))
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    threads = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    os.environ.setdefault("MICROFACET_CACHE", str(Path("build/kernels").resolve()))
    os.environ["PYTHONUTF8"] = "1"
    os.environ |= dict.fromkeys(threads, "1") | {"MPLBACKEND": "agg", "PYTHONHASHSEED": "0"}


def repeat_failures(logs: Iterable[str]) -> None:
    """Repeat at the end which jobs failed, each with the sentence that says why."""
    output = "".join(Path(log).read_text("utf-8", errors="replace") for log in logs)
    statuses = dict(re.findall(r"^Command '.*? 2> (\S+) .*' returned non-zero exit status (\d+)\.$", output, re.M))
    for name in dict.fromkeys(re.findall(r"^    log: (\S+)", output, re.M)):
        print(failed.message(Path(name), int(statuses.get(name, 1))).splitlines()[0], file=sys.stderr)


def digest(value: object) -> str:
    text = json.dumps(value, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def digest_of(name: str) -> str:
    return hashlib.sha256(Path(inventory.source(name)).read_bytes()).hexdigest()[:16]


def products() -> list[str]:
    """Every file that the rules make, whatever is asked for."""
    figures = inventory.figures()
    data = [path for one in figures.values() for path in one.data]
    checks = [f"build/checks/{stem}.json" for stem in groups()]
    chapters = [f"build/chapters/{stem}.{ending}" for stem in texts() for ending in ("md", "typ")]
    ranges = [str(path) for path in Path(campaign.FOLDER).glob("**/*.npz")]
    return [*ONE_OF_EACH, *checks, *data, *drawings(list(figures)), *chapters, *ranges]


# Statements and figures ------------------------------------------------------------------------


def groups() -> dict[str, list[str]]:
    """Statements that are checked by one process, those of a stage: starting takes longer than most checks.

    Statements that have not changed are not checked again: their results are cached.
    """
    keys_by_stage: dict[str, list[str]] = {}
    for key in inventory.statements():
        keys_by_stage.setdefault(inventory.stage(key), []).append(key)
    return keys_by_stage


def group(stem: str) -> list[str]:
    return groups().get(stem) or inventory.stop(inventory.unknown("group of equations", stem, groups()))


def fingerprints(stem: str) -> list[str]:
    return [inventory.statements()[key]["fingerprint"] for key in group(stem)]


def figure(name: str) -> inventory.Figure:
    one = inventory.figures().get(name)
    return one or inventory.stop(inventory.unknown("figure", name, inventory.figures()))


@cache
def imports(script: Path) -> list[str]:
    """What a script imports, the versions of all else, and the records that any of it names and that there are."""
    texts = closure.of_script(script)
    named = {
        record
        for text in map(str, [script, *texts])
        for record in re.findall(r"records/\w+\.json", Path(text).read_text("utf-8"))
    }
    return [*texts, VERSIONS, *sorted(record for record in named if Path(record).exists())]


def tools(*names: str) -> list[str]:
    """Scripts of the workflow and what they import of it, as inputs: another gate is another verdict."""
    scripts = [Path("workflow", name) for name in names]
    read = {path for script in scripts for path in closure.of_script(script) if path.startswith("workflow/")}
    return sorted({*map(str, scripts), *read})


def surfaces_asked_for(config: Mapping[str, Any]) -> tuple[int, int]:
    """How many surfaces, and how many in a range; refused before anything is built."""
    known = {"surfaces": campaign.SURFACES, "range": campaign.RANGE}
    for name in config.keys() - known.keys():
        inventory.stop(f"{inventory.unknown('setting', name, known)} --config takes surfaces=N and range=N.")
    count, size = {**known, **config}.values()
    if not (isinstance(count, int) and isinstance(size, int) and count >= 2 and size >= 1):
        inventory.stop(f"--config takes surfaces=N, at least 2, and range=N, at least 1; got {count!r} and {size!r}.")
    return count, size


def targets() -> dict[str, list[str]]:
    """Target -> the figures it redraws."""
    by_slide = {f"slide_{n}": inventory.figures_of_slide(n) for n in inventory.drawn_slides()}
    return {name: [name] for name in inventory.figures()} | by_slide


def drawings(names: list[str]) -> list[str]:
    """All files that the figures of these names are drawn into."""
    still = [f"build/figures/{name}{ending}" for name in names for ending in ENDINGS]
    return still + [inventory.figures()[name].moving for name in names if inventory.figures()[name].moves]


def refuse_unknown(arguments: list[str], rules: Iterable[str]) -> None:
    """One sentence for a target that is neither a rule, a figure, a slide nor a file."""
    known = sorted(rules)
    for target in asked_for([word for word in arguments if word not in known]):
        path = Path(target)
        if path.parent == Path("build/figures") and path.suffix in ENDINGS:
            figure(path.name.split(".")[0])
        elif "/" not in target and not path.is_file():
            kind = "drawn slide" if target.startswith("slide") else "figure or other target"
            inventory.stop(inventory.unknown(kind, target, known))


def asked_for(arguments: list[str]) -> list[str]:
    """The targets among the words of a snakemake command line; none in a cluster's job, which names them in another way."""
    if "--target-jobs" in arguments or all(word.startswith("-") for word in arguments):
        return []
    from snakemake.cli import get_argument_parser

    return list(get_argument_parser().parse_known_args(arguments)[0].targets or [])


# Chapters --------------------------------------------------------------------------------------


def texts() -> list[str]:
    """Chapters, and the abstract if there is one."""
    abstract = [typeset.ABSTRACT] if Path(f"chapters/{typeset.ABSTRACT}.md").is_file() else []
    return [*abstract, *inventory.chapters()]


@cache
def text(stem: str) -> inventory.Chapter:
    return inventory.chapters().get(stem) or inventory.read_chapter(Path(f"chapters/{stem}.md"))


def figures_in_chapters() -> list[str]:
    """The figures the report shows; a name that does not exist is reported by its chapter."""
    named = {name for stem in texts() for name in text(stem).named("figure")}
    return sorted(named & set(inventory.figures()))


def moving_in_chapters() -> list[str]:
    return [figure(name).moving for name in figures_in_chapters() if figure(name).moves]


def chapter_data(stem: str) -> list[str]:
    known = inventory.figures()
    return [path for name in text(stem).named("data") if name in known for path in known[name].data]


def chapter_imports(stem: str) -> list[str]:
    return [*sorted(str(path) for path in closure.of_source(text(stem).code)), VERSIONS]


def chapter_names(stem: str) -> str:
    """Changes with the text of the named statements and captions, not with the drawing of a figure."""
    statements, figures = inventory.statements(), inventory.figures()
    stated = [statements.get(key) for helper in ("equation", "computed") for key in text(stem).named(helper)]
    forms = [facts and [facts["latex"], facts["computed_latex"]] for facts in stated]
    captions = {name: figures[name].printed_text for name in text(stem).named("figure") if name in figures}
    models = [figure.model for figure in figures.values()] if "models_of_light" in text(stem).calls else []
    return digest([forms, captions, models])


def report_tools(form: str) -> list[str]:
    """The sources of typesetting: the script, and the templates for this form."""
    templates = ["template.typ", "shared.typ", "page.typ", "web.typ"]
    return tools("typeset.py") + [f"workflow/{name}" for name in templates + (["web.css", "web.js"] if form == "html" else [])]


def source_options() -> str:
    return " ".join(f"--{name}={shlex.quote(value)}" for name, value in provenance.provenance().items())
