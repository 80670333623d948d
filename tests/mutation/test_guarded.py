"""The run of mutants itself: a tiny checkout with a mistake that a test finds, one that none finds, and one that never ends."""

from __future__ import annotations

import ast
from datetime import UTC, datetime
from pathlib import Path
from random import Random

import guarded
import places
import pytest

LIBRARY = '''\
"""Tiny."""


def scaled(x: float) -> float:
    """Twice 2 is 4."""
    if x > 7.5:
        raise ValueError(f"{x} is more than {7 + 1}")
    return 2.5 * x


def untested(x: int) -> int:
    return x + 3


def counted(n: int) -> int:
    while n < 5:
        n += 1
    return n
'''
TEST = """\
from microfacet.tiny import counted, scaled, untested


def test_of_one_function():
    assert scaled(2.0) == 5.0
    assert counted(0) == 5


def test_that_looks_at_nothing():
    untested(2)
"""


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    root = tmp_path / "tiny"
    for name, text in {
        "lib/microfacet/__init__.py": "",
        "lib/microfacet/tiny.py": LIBRARY,
        "lib/microfacet/compiler/__init__.py": "",
        "lib/microfacet/compiler/program.py": "class Program:\n    def add(self, function): ...\n",
        "tests/test_tiny.py": TEST,
        "tests/test_other.py": "def test_of_something_else():\n    assert True\n",
        "pyproject.toml": '[tool.pytest.ini_options]\npythonpath = ["lib"]\nmarkers = ["slow: "]\n',
    }.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, "utf-8")
    return root


@pytest.mark.slow
def test_what_is_tested_is_killed_and_what_is_not_survives(tiny: Path) -> None:
    outcomes = guarded.run(tiny, 1000, 1, ["lib/microfacet/tiny"], ["not slow"], patience=8)
    assert len(outcomes) == len(places.of_file(tiny, "lib/microfacet/tiny.py"))
    states = {name: {one.state for one in outcomes if one.place.function == name} for name in ("scaled", "untested")}
    assert states == {"scaled": {"killed", "survived"}, "untested": {"survived"}}  # nobody tries 7.5
    survived = {one.place.rule for one in outcomes if one.place.function == "scaled" and one.state == "survived"}
    assert survived == {"a number"}
    assert (tiny / "lib/microfacet/tiny.py").read_text("utf-8") == LIBRARY


def test_a_test_file_that_does_not_call_a_function_is_not_asked(tiny: Path, tmp_path: Path) -> None:
    copy = guarded.Copy(tiny, tmp_path / "copy", tmp_path)
    known = [guarded.watch(copy, file, "not slow") for file in guarded.test_files(tiny)]
    place = next(place for place in places.of_file(tiny, "lib/microfacet/tiny.py") if place.function == "untested")
    assert [one.file for one in guarded.chosen(place, known, "not slow")] == ["tests/test_tiny.py"]


@pytest.mark.slow
def test_what_never_ends_is_killed(tiny: Path, tmp_path: Path) -> None:
    (tmp_path / "kernels").mkdir()
    copy = guarded.Copy(tiny, tmp_path / "copy", tmp_path / "kernels", patience=5)
    place = next(place for place in places.of_file(tiny, "lib/microfacet/tiny.py") if place.function == "counted")
    endless = guarded.Watched("tests/test_tiny.py", "not slow", seconds=0.0)
    assert copy.judged(place, LIBRARY.replace("n += 1", "pass"), [endless], "not slow") == "time"
    assert (tmp_path / "copy/lib/microfacet/tiny.py").read_text("utf-8") == LIBRARY


def test_reasons_are_asked_of_survivors_only_and_count() -> None:
    place = places.Place("lib/a.py", 1, 0, 1, ("2",), "a number", "")
    killed, survived = guarded.Outcome(place, "1", "2", by="a test"), guarded.Outcome(place, "1", "2")
    excused = guarded.Outcome(place, "1", "2", why="it is multiplied by 0")
    assert (killed.state, survived.state, excused.state) == ("killed", "survived", "equivalent")
    assert guarded.rate([killed] * 19 + [survived, excused]) == 0.95
    assert "95.0% killed" in guarded.summary([killed] * 19 + [survived, excused])


def test_every_reviewed_mutant_is_still_there_with_its_reason() -> None:
    why = guarded.equivalents()
    assert guarded.stale(guarded.ROOT, why) == []
    assert all(len(reason.split()) > 3 for reason in why.values())


def test_a_reason_whose_line_is_gone_is_named(tiny: Path) -> None:
    there, gone = ("lib/microfacet/tiny.py", "n += 1", "n -= 1"), ("lib/microfacet/tiny.py", "n += 7", "n -= 7")
    assert guarded.stale(tiny, [there, gone]) == [gone]


def test_every_mutant_is_another_program() -> None:
    """In each file of the library, of the figures' data and of the workflow."""
    random = Random(1)
    files = places.files(guarded.ROOT)
    assert len(files) > 100
    for file in files:
        text = (guarded.ROOT / file).read_text("utf-8")
        found, whole = places.of_file(guarded.ROOT, file), ast.dump(ast.parse(text))
        for place in random.sample(found, min(2, len(found))):
            assert ast.dump(ast.parse(place.mutant(text, random))) != whole, place


def test_what_is_said_and_what_is_asserted_is_no_place(tiny: Path) -> None:
    found = places.of_file(tiny, "lib/microfacet/tiny.py")
    assert {place.line for place in found} == {6, 8, 12, 16, 17}


def test_the_same_seed_draws_the_same_mutants() -> None:
    draw = [[(o.place, o.new) for o, _ in guarded.mutants(guarded.ROOT, 30, seed, ["lib"])] for seed in (1, 1, 2)]
    assert draw[0] == draw[1] != draw[2]


QUICK = ("lib/microfacet/surface/profile.py", "lib/microfacet/surface/measure.py", "workflow/ledger.py", "figures/material/")
ASKED = (
    "tests/surface/test_profile.py",
    "tests/surface/test_measure.py",
    "tests/surface/test_ramps.py",
    "tests/workflow/test_gate.py",
    "tests/workflow/test_ledger.py",
    "tests/figures/test_rays_of_polylines.py",
    "tests/figures/test_curves.py",
)


@pytest.mark.slow
def test_todays_mistakes_are_found() -> None:
    """A small part of the nightly run: other places each day. That half of them survive by chance, where one in twenty does,
    has odds of a few in a million; a run in which nothing is mutated, or nothing noticed, kills none."""
    seed = int(f"{datetime.now(UTC):%Y%m%d}")
    outcomes = guarded.run(guarded.ROOT, 10, seed, QUICK, ["not slow"], why=guarded.equivalents(), tests=ASKED)
    assert sum(outcome.state == "killed" for outcome in outcomes) >= 5, guarded.summary(outcomes)


def test_a_reason_may_be_given_for_whatever_a_line_becomes() -> None:
    outcome = guarded.Outcome(places.Place("lib/a.py", 1, 0, 1, ("2",), "a number", ""), "CHUNK = 1", "CHUNK = 2")
    assert guarded.reason(outcome, {("lib/a.py", "CHUNK = 1", "*"): "how much a thread takes at once"}).startswith("how much")
    assert guarded.reason(outcome, {("lib/a.py", "CHUNK = 1", "CHUNK = 3"): "another"}) == ""


def test_arguments_at_which_a_statement_is_enclosed_are_no_places(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(
        "one = Equation(\n    enclosed=lambda it: at(it, [(1.5,), (2.5,)], bits=3),\n    over=[(4, 5)],\n)\n"
    )
    found = [place for place in places.of_file(tmp_path, "a.py") if place.rule == "a number"]
    assert [place.others for place in found] == [("4", "(2)"), ("5", "(3)"), ("6", "(4)")]


def test_what_a_run_took_down_is_taken_until_what_decides_it_changes(tiny: Path, tmp_path: Path) -> None:
    """Another test is run again, and one whose functions changed; a file of which nothing is called does not count."""
    copy = guarded.Copy(tiny, tmp_path / "copy", tmp_path)
    (tiny / "build/mutants").mkdir(parents=True)
    tests = guarded.test_files(tiny)
    first = guarded.record(tiny, [copy], ["not slow", "slow"], tests)
    assert {(one.file, one.suite) for one in first} == {(file, "not slow") for file in tests}  # none has a slow test
    for one in first:
        one.seconds = -1.0
    kept = tiny / "build/mutants/watched.jsonl"
    kept.write_text("".join(map(guarded._line, first)))

    def again() -> set[str]:
        return {one.file for one in guarded.record(tiny, [copy], ["not slow"], tests) if one.seconds >= 0}

    assert again() == set()
    program = copy.root / "lib/microfacet/compiler/program.py"
    program.write_text("class Program:\n    def add(self, function): return function\n")
    assert again() == set()
    library = copy.root / "lib/microfacet/tiny.py"
    library.write_text(library.read_text() + "\n")
    assert again() == {"tests/test_tiny.py"}
    other = copy.root / "tests/test_other.py"
    other.write_text(other.read_text() + "\n")
    assert "tests/test_other.py" in again()


def test_a_run_that_was_stopped_goes_on(tiny: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was judged is not judged again, until anything of the checkout changes."""
    judged: list[str] = []

    def judge(copy: guarded.Copy, outcome: guarded.Outcome, *_: object) -> None:
        judged.append(outcome.new)
        if len(judged) == 4:
            raise KeyboardInterrupt
        outcome.by = "a test"

    def run() -> list[str]:
        return [one.by for one in guarded.run(tiny, 6, 3, ["lib/microfacet/tiny"], ["not slow"], workers=1)]

    monkeypatch.setattr(guarded, "judge", judge)
    monkeypatch.setattr(guarded, "record", lambda *_: [])
    with pytest.raises(KeyboardInterrupt):
        run()
    assert run() == ["a test"] * 6
    assert len(judged) == 4 + 3
    (tiny / "tests/test_other.py").write_text("def test_of_another_thing():\n    assert True\n")
    run()
    assert len(judged) == 4 + 3 + 6
