"""One small mistake at a time in the code around the statements: which ones does a test find?

    make mutants                                  300 places, drawn with today's date as the seed
    make mutants NUMBER=20 SEED=20260101          fewer, or another day's

places.py says where a mistake can be made and which. A sample of these places is drawn over lib/, the scripts of figures' data
and workflow/. Each mutant lives in a copy of the checkout, and meets the test files that call the function it is in (watch.py
writes down which, in a first run without mistakes), the file that mirrors it first, until a test fails. Quick tests come
first; slow ones see only what these let through and nobody has reviewed. A run that does not end in time counts as killed.
What the first run wrote down, and the kernels that it compiled, are kept in build/mutants: the next one runs only those test
files again that changed, or of which a function that they call is in a file that changed. What became of each mutant is kept
too, so that a run that was stopped goes on.

What changes nothing stands in equivalents.toml, with the reason; fewer than 95 % of the others killed is a failure.

Why not a tool from the package index: mutmut 3 puts trampolines round functions, so that `inspect.getsource`, of which kernels
are compiled, finds another text, and leaves what is outside of functions alone; cosmic-ray runs one command for all mutants and
has no sample; mutatest has one, but has not been kept since 2022. None of them knows that a kernel is run by machine code.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from random import Random
from typing import Any

import places
from places import Place

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
EQUIVALENTS = HERE / "equivalents.toml"
ENOUGH = 0.95
ANY = "*"
LEFT = shutil.ignore_patterns(
    "build", "dist", ".git", ".venv", ".snakemake", "__pycache__", ".pytest_cache", ".mypy_cache", ".ruff_cache", "*.egg-info"
)
SUITES = ("not slow", "slow")
PATIENCE = 90.0  # seconds that a run may take beyond four times what it takes without a mistake
MEMORY = 24 << 30  # bytes that the tests of one mutant may ask for: a range that is doubled may ask for all there are
UNSEEN = {  # who starts what as a process of its own, or reads its text
    "workflow/": ("tests/workflow/", "tests/test_chapters.py", "tests/test_ledger.py"),
    "figures/": ("tests/test_prose.py",),
}


@dataclass
class Outcome:
    """What became of one mutant: killed by a test, by the clock (by = "time"), or by nothing (by = "")."""

    place: Place
    old: str
    new: str
    by: str = ""
    why: str = ""
    seconds: float = 0.0

    @property
    def state(self) -> str:
        return "killed" if self.by else "equivalent" if self.why else "survived"


@dataclass
class Watched:
    """What a test file calls, how long it takes and what of it fails without any mistake."""

    file: str
    suite: str
    seconds: float
    touched: dict[str, list[str]] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)
    digest: str = ""


# --- a copy of the checkout -------------------------------------------------------------------------------------------


class Copy:
    """A copy of a checkout in which tests are run. Kernels that it compiles are forgotten after each run."""

    def __init__(self, root: Path, folder: Path, kernels: Path, patience: float = PATIENCE) -> None:
        self.root, self.kernels, self.patience = folder, kernels, patience
        shutil.copytree(root, folder, ignore=LEFT)
        (folder / "build").mkdir()
        if (root / ".venv").exists():
            (folder / ".venv").symlink_to(root / ".venv")

    def pytest(self, arguments: Sequence[str], limit: float, cache: Path, **variables: str) -> tuple[int | None, str]:
        """Exit status (None if time was up) and what was printed."""
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--no-header", *arguments]
        paths = os.pathsep.join((str(self.root / "tests/mutation"), str(HERE)))
        settings = {"MICROFACET_CACHE": str(cache), "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
        process = subprocess.Popen(
            command, cwd=self.root, env=os.environ | settings | variables, text=True, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, preexec_fn=_frugal,
        )  # fmt: skip
        try:
            said, _ = process.communicate(timeout=limit)
            return process.returncode, said
        except subprocess.TimeoutExpired:
            return None, ""
        finally:
            _end(process)

    def judged(self, place: Place, text: str, watched: Sequence[Watched], suite: str) -> str:
        """The test that kills the mutant, or nothing. What is compiled of it is forgotten, and what was before is kept."""
        path, cache = self.root / place.file, self.root / "build" / "cache"
        top = self.root / Path(place.file).parts[0]
        kept = self.root / "build" / "kept"
        for folder, source, copied in ((cache, self.kernels, shutil.copy2), (kept, top, os.link)):
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(source, folder, copy_function=copied)
        path.unlink()  # and not written over: `kept` has the same file
        path.write_text(text, "utf-8")
        try:
            skipped = [f"--deselect={test}" for one in watched for test in one.failed]
            arguments = ["-x", "-m", suite, "-p", "in_order", *skipped, *(one.file for one in watched)]
            status, said = self.pytest(arguments, self.patience + 4 * sum(one.seconds for one in watched), cache)
        finally:
            shutil.rmtree(top)
            kept.rename(top)
        return "time" if status is None else "" if status in (0, 5) else _first_failure(said)


def _frugal() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def _end(process: subprocess.Popen[str]) -> None:
    """The process and whatever it has started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _first_failure(said: str) -> str:
    lines = [line for line in said.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return lines[0].split(" - ")[0] if lines else (said.strip().splitlines() or ["crash"])[-1]


# --- what each test file calls ------------------------------------------------------------------------------------------


def test_files(root: Path) -> list[str]:
    return sorted(str(path.relative_to(root)) for path in root.glob("tests/**/test_*.py") if "mutation" not in path.parts)


def watch(copy: Copy, file: str, suite: str) -> Watched:
    told = copy.root / "build" / "watched.json"
    told.unlink(missing_ok=True)
    start = time.perf_counter()
    copy.pytest(["-m", suite, "-p", "watch", file], 3600, copy.kernels, MICROFACET_WATCH=str(told))
    found = json.loads(told.read_text("utf-8")) if told.exists() else {"touched": {}, "failed": []}
    return Watched(file, suite, time.perf_counter() - start, found["touched"], found["failed"])


def digest(root: Path, one: Watched) -> str:
    """Of all that decides what a test file calls: itself, what tests share, and the files of which it calls a function."""
    tests = set(test_files(root))
    shared = [str(path.relative_to(root)) for path in root.glob("tests/**/*.py") if "mutation" not in path.parts]
    called = [file for file, names in one.touched.items() if any(name and not name.endswith(".") for name in names)]
    found = hashlib.sha256()
    for file in sorted({one.file, *called, *(file for file in shared if file not in tests)}):
        found.update(file.encode() + b"\0" + ((root / file).read_bytes() if (root / file).exists() else b""))
    return found.hexdigest()[:16]


def record(root: Path, copies: Sequence[Copy], suites: Sequence[str], tests: Sequence[str]) -> list[Watched]:
    """By file and suite, a line each, kept under build/ for as long as nothing changes that decides it."""
    kept, checkout = root / "build" / "mutants" / "watched.jsonl", copies[0].root
    lines = kept.read_text("utf-8").splitlines() if kept.exists() else []
    known = [one for line in lines if digest(checkout, one := Watched(**json.loads(line))) == one.digest]
    kept.write_text("".join(map(_line, known)), "utf-8")
    have = {(one.file, one.suite) for one in known}
    jobs = [(file, suite) for suite in suites for file in tests if _has(checkout / file, suite)]

    def one(copy: Copy, job: tuple[str, str]) -> Watched:
        found = watch(copy, *job)
        found.digest = digest(checkout, found)
        with kept.open("a", encoding="utf-8") as file:
            file.write(_line(found))
        return found

    known += shared_out(copies, [job for job in jobs if job not in have], one)
    return [one for one in known if one.file in tests]


def _line(one: Watched) -> str:
    return json.dumps(asdict(one)) + "\n"


def _has(test: Path, suite: str) -> bool:
    """Whether the file may have a test of this suite."""
    return suite != "slow" or "mark.slow" in test.read_text("utf-8")


def shared_out(copies: Sequence[Copy], jobs: Sequence[Any], work: Any) -> list[Any]:
    """work(copy, job) for every job, with each copy in use by one at a time."""
    free: SimpleQueue[Copy] = SimpleQueue()
    for copy in copies:
        free.put(copy)

    def one(job: Any) -> Any:
        copy = free.get()
        try:
            return work(copy, job)
        finally:
            free.put(copy)

    with ThreadPoolExecutor(len(copies)) as pool:
        return list(pool.map(one, jobs))


def chosen(place: Place, known: Iterable[Watched], suite: str) -> list[Watched]:
    """The test files that may find a mistake there: the mirror first, then the quickest.

    They call the function. What is compiled as a whole is called by nobody who could be watched: then, those that call another
    function of the file, if only to import it.
    """
    asked = [one for one in known if one.suite == suite]
    names = {place.function, f"{place.function}."}
    calls = [one for one in asked if _starts(one, place) or names & set(one.touched.get(place.file, ()))]
    others = [one for one in asked if set(one.touched.get(place.file, ())) - {""}]
    able = calls or others or [one for one in asked if place.file in one.touched]
    return sorted(able, key=lambda one: (not _mirrors(one.file, place.file), one.seconds))


def _starts(one: Watched, place: Place) -> bool:
    """Whether it runs the file in another process, or reads its text: neither can be watched."""
    return any(place.file.startswith(folder) and one.file.startswith(tests) for folder, tests in UNSEEN.items())


def _mirrors(test: str, file: str) -> bool:
    return Path(test).stem == f"test_{Path(file).stem}" and Path(test).parent.name in (*Path(file).parts, "tests")


def checkout_digest(root: Path, tests: Sequence[str]) -> str:
    """Of all that decides what becomes of a mutant."""
    found = hashlib.sha256(repr(tests).encode())
    for top in ("lib", "figures", "workflow", "tests", "chapters", "records", "Snakefile"):
        for path in sorted([root / top, *(root / top).rglob("*")]):
            if path.is_file() and not {"mutation", "__pycache__"} & set(path.relative_to(root).parts):
                found.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:16]


class Judged:
    """What a suite made of mutants of this checkout, a line each, kept under build/."""

    def __init__(self, path: Path, digest: str) -> None:
        self.path, self.digest = path, digest
        lines = map(json.loads, path.read_text("utf-8").splitlines() if path.exists() else [])
        self.known = {(line["place"], line["new"], line["suite"]): line for line in lines if line["digest"] == digest}

    def recall(self, outcome: Outcome, suite: str) -> bool:
        """Put down what became of it, if that is known."""
        line = self.known.get((repr(outcome.place), outcome.new, suite))
        if line:
            outcome.by, outcome.seconds = line["by"], line["seconds"]
        return line is not None

    def keep(self, outcome: Outcome, suite: str) -> None:
        line = {"digest": self.digest, "place": repr(outcome.place), "new": outcome.new, "suite": suite, "by": outcome.by}
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line | {"seconds": outcome.seconds}) + "\n")


# --- the run --------------------------------------------------------------------------------------------------------------


def mutants(root: Path, number: int, seed: int, among: Sequence[str]) -> Iterator[tuple[Outcome, str]]:
    """So many places, each as likely as any other, with one mistake made in each."""
    random = Random(seed)
    found = list(places.all_places(root, [file for file in places.files(root) if file.startswith(tuple(among))]))
    for place in random.sample(found, min(number, len(found))):
        text = (root / place.file).read_text("utf-8")
        mutant = place.mutant(text, random)
        yield Outcome(place, *_change(text, mutant)), mutant


def _change(old: str, new: str) -> tuple[str, str]:
    """The lines that differ."""
    lines = list(difflib.unified_diff(old.splitlines(), new.splitlines(), n=0, lineterm=""))[3:]
    sides = (" ".join(line[1:].strip() for line in lines if line[0] == sign) for sign in "-+")
    return next(sides), next(sides)


def reason(outcome: Outcome, why: dict[tuple[str, str, str], str]) -> str:
    """Why a mutant changes nothing, if that was reviewed."""
    file, old = outcome.place.file, outcome.old
    return why.get((file, old, outcome.new)) or why.get((file, old, ANY)) or ""


def equivalents(path: Path = EQUIVALENTS) -> dict[tuple[str, str, str], str]:
    """(file, line, what it becomes) -> why that changes nothing; "*" stands for whatever it becomes."""
    found = tomllib.loads(path.read_text("utf-8")).get("equivalent", []) if path.exists() else []
    return {(one["file"], one["old"], one["new"]): one["why"] for one in found}


def stale(root: Path, known: Iterable[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
    """Entries whose line is no longer there."""
    return [one for one in known if not (root / one[0]).exists() or one[1] not in _lines(root / one[0])]


def _lines(path: Path) -> str:
    return " ".join(line.strip() for line in path.read_text("utf-8").splitlines())


def judge(copy: Copy, outcome: Outcome, text: str, known: Sequence[Watched], suite: str) -> None:
    """Let the tests of a suite meet a mutant."""
    start = time.perf_counter()
    if able := chosen(outcome.place, known, suite):
        outcome.by = copy.judged(outcome.place, text, able, suite)
    outcome.seconds += time.perf_counter() - start


def run(
    root: Path, number: int, seed: int, among: Sequence[str] = ("",), suites: Sequence[str] = SUITES, workers: int = 2,
    why: dict[tuple[str, str, str], str] | None = None, patience: float = PATIENCE, tests: Sequence[str] = (),
) -> list[Outcome]:  # fmt: skip
    """Draw, judge and return; each outcome is printed as it comes.

    All mutants meet one suite before any meets the next, which sees those that are left and were not reviewed.
    """
    kernels = root / "build" / "mutants" / "kernels"  # named by what they are compiled of, so that another run can take them
    kernels.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="mutants", ignore_cleanup_errors=True) as folder:
        copies = [Copy(root, Path(folder) / f"copy{k}" / "checkout", kernels, patience) for k in range(workers)]
        known = record(root, copies, suites, tests or test_files(root))
        for test in sorted(test for one in known for test in one.failed):
            print(f"fails without any mistake, and is left out: {test}")

        judged = Judged(kernels.with_name("judged.jsonl"), checkout_digest(root, tests))
        jobs = list(mutants(copies[0].root, number, seed, among))
        for outcome, _ in jobs:
            outcome.why = reason(outcome, why or {})

        def one(copy: Copy, job: tuple[Outcome, str], suite: str) -> None:
            outcome = job[0]
            if not judged.recall(outcome, suite):
                judge(copy, *job, known, suite)
                judged.keep(outcome, suite)
            if outcome.state != "survived" or suite == suites[-1]:
                print(told(outcome), flush=True)

        for suite in suites:
            left = [job for job in jobs if job[0].state == "survived" or suite == suites[0]]
            shared_out(copies, left, partial(one, suite=suite))
    return [outcome for outcome, _ in jobs]


def told(outcome: Outcome) -> str:
    place = outcome.place
    first = f"{outcome.state} in {outcome.seconds:.0f} s  {place.file}:{place.line}  {place.rule}  {outcome.by or outcome.why}"
    return first if outcome.by else f"{first}\n    - {outcome.old}\n    + {outcome.new}"


def area(file: str) -> str:
    parts = Path(file).parts
    return "/".join(parts[:3] if parts[0] == "lib" and len(parts) > 3 else parts[: 2 if parts[0] == "lib" else 1])


def rate(outcomes: Sequence[Outcome]) -> float:
    """The part killed of those that change anything."""
    real = [outcome for outcome in outcomes if outcome.state != "equivalent"]
    return sum(outcome.state == "killed" for outcome in real) / len(real) if real else 1.0


def summary(outcomes: Sequence[Outcome]) -> str:
    tally = Counter((area(outcome.place.file), outcome.state) for outcome in outcomes)
    names = sorted({name for name, _ in tally})
    states = ("killed", "survived", "equivalent")
    lines = [f"{name:26}" + "".join(f"{tally[name, state]:12}" for state in states) for name in names]
    return "\n".join([f"{'':26}" + "".join(f"{state:>12}" for state in states), *lines, f"{rate(outcomes):.1%} killed"])


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="make one small mistake at a time and see whether a test finds it")
    parser.add_argument("--number", type=int, default=300)
    parser.add_argument("--seed", type=int, default=int(f"{datetime.now(UTC):%Y%m%d}"))
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--quick", action="store_true", help="the quick tests only")
    parser.add_argument("--among", nargs="*", default=[""], help="beginnings of names of files")
    given = parser.parse_args(arguments)
    print(f"{given.number} places, seed {given.seed}", flush=True)
    why = equivalents()
    outcomes = run(ROOT, given.number, given.seed, given.among, SUITES[: 1 if given.quick else 2], given.workers, why)
    out = ROOT / "build" / "mutants" / f"{given.seed}.json"
    out.write_text(json.dumps([asdict(outcome) | {"state": outcome.state} for outcome in outcomes], indent=1), "utf-8")
    print(summary(outcomes))
    for file, old, _ in stale(ROOT, why):
        print(f"no longer there, so take it out of {EQUIVALENTS.name}: {file}: {old}")
    return int(rate(outcomes) < ENOUGH)


if __name__ == "__main__":
    sys.exit(main())
