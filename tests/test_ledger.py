"""Every statement of the library, found by itself: printed, computed and proved. The full checks are slow."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import microfacet as mf
import mpmath
import numpy as np
import pytest
from integrals import integral_differs, stands_for_integrals
from microfacet.__main__ import main
from microfacet.files import keep, recall
from microfacet.statements import checks
from microfacet.statements.notation import Direction
from microfacet.statements.registry import STAGES
from microfacet.statements.statement import Equation

ROOT = Path(__file__).parent.parent
LIBRARY = ROOT / "lib" / "microfacet"
KEYS = list(mf.equations)
COMPUTED = [key for key in KEYS if checks.is_computed(mf.equations[key])]
INTEGRALS = [key for key in KEYS if stands_for_integrals(mf.equations[key])]
EVERY = pytest.mark.parametrize("key", KEYS)


def test_every_statement_in_the_text_is_in_the_ledger() -> None:
    written = [key for path in LIBRARY.rglob("*.py") for key in re.findall(r'^\s+key="([\w.]+)"', path.read_text(), re.M)]
    assert sorted(written) == sorted(KEYS)
    assert len(KEYS) >= 60


def test_ledger_keeps_the_order_of_the_talk() -> None:
    stages = [STAGES.index(key.split(".")[0]) for key in KEYS]
    assert stages == sorted(stages)


@EVERY
def test_statement_is_complete(key: str) -> None:
    """It has a title, slides of the talk, a source in the bibliography, and prints."""
    equation = mf.equations[key]
    assert re.fullmatch(r"[a-z_]+(\.\w+){2}|anisotropy\.\w+", key)
    assert len(equation.title) > 10
    assert not equation.title.endswith(".")
    assert equation.slides
    assert all(17 <= slide <= 75 for slide in equation.slides)
    known = re.findall(r"^@\w+\{(\w+),", (ROOT / "chapters" / "references.bib").read_text(), re.M)
    cited = [source.split(",")[0].strip() for source in equation.cite.split(";")]
    assert set(cited) <= set(known)
    assert equation.latex.count("{") == equation.latex.count("}")
    assert re.search(r"=|<|>|\\le |\\ge |\\approx ", equation.latex)
    assert "Piecewise" not in equation.latex
    assert not re.search(r"[a-z]+_(packed|test)", equation.latex)
    module, line = equation.stated_at.split(", line ")
    path = LIBRARY.parent / (module.replace(".", "/") + ".py")
    assert 0 < int(line) <= len(path.read_text().splitlines())


def points(equation: Equation, count: int) -> list[list[float]]:
    """Arguments inside the domain: by magnitude, or crowding in the middle where there is none; directions anywhere."""
    random = np.random.default_rng(len(equation.key))
    found = []
    for _ in range(count):
        point: list[float] = []
        for argument, domain in equation.over.items():
            if isinstance(argument, Direction):
                theta, phi = np.arccos(random.random()), 2 * np.pi * random.random()
                point += [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
            else:
                low, high = map(float, domain)
                share = random.random()
                point.append(low * (high / low) ** share if low > 0 else low + (high - low) * (1 + (2 * share - 1) ** 5) / 2)
        found.append([float(v) for v in point])
    return found


def ulps(value: float, exact: mpmath.mpf) -> float:
    return float(abs(mpmath.mpf(value) - exact)) / math.ulp(abs(float(exact)))


@pytest.mark.parametrize("key", COMPUTED)
def test_kernel_keeps_its_promise(key: str) -> None:
    """As Python runs it, in double precision, at a few arguments: errors in ulps of the 50-digit value."""
    equation = mf.equations[key]
    for point in points(equation, 8):
        exact = equation.exact(*point)
        if 1e-300 < abs(exact) < 1e300:
            assert ulps(equation.scalar(*point), exact) <= equation.within[0] * 1.05 + 0.5, point


@pytest.mark.parametrize("key", COMPUTED)
def test_a_kernel_off_by_a_millionth_would_be_seen(key: str) -> None:
    """The test above can fail for this statement: not every value is 0."""
    equation = mf.equations[key]
    errors = []
    for point in points(equation, 8):
        exact = equation.exact(*point)
        if 1e-300 < abs(exact) < 1e300:
            errors.append(ulps(equation.scalar(*point) * (1 + 1e-6), exact))
    assert errors
    assert max(errors) > 1e6 > equation.within[0]


@pytest.mark.parametrize("key", INTEGRALS)
def test_closed_form_is_the_integral_it_stands_for(key: str) -> None:
    assert not integral_differs(mf.equations[key])


# --- command ------------------------------------------------------------------------------------------------------------


def test_command_lists_and_writes_one_record(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == KEYS
    out = tmp_path / "record.json"
    assert main(["check", "visibility.smith.heights", "--out", str(out)]) == 0
    record = json.loads(out.read_text())["visibility.smith.heights"]
    assert (record["key"], record["verdict"], record["message"]) == ("visibility.smith.heights", "pass", "")
    assert {mark["status"] for mark in record["marks"].values()} <= {"pass", "fail", "none"}


def test_a_kept_record_is_taken_until_the_statement_changes(tmp_path: Path) -> None:
    words = ["check", "visibility.smith.heights", "--kept", str(tmp_path / "kept"), "--out", str(tmp_path / "out.json")]
    assert main(words) == 0
    (kept,) = (tmp_path / "kept").iterdir()
    fresh, record = kept.read_text(), recall(kept)
    keep(kept, record | {"verdict": "kept"})
    assert main(words) == 0
    assert '"verdict": "kept"' in (tmp_path / "out.json").read_text()
    for altered in (fresh.replace('"pass"', '"fail"'), "{torn", "", fresh.replace(record["key"], "another")):
        kept.write_text(altered)
        assert main(words) == 0
        assert kept.read_text() == fresh
        assert json.loads((tmp_path / "out.json").read_text()) == {record["key"]: record}
    kept.rename(kept.with_name(f"visibility.smith.heights-{'0' * 20}.json"))
    assert main(words) == 0
    assert len(list((tmp_path / "kept").iterdir())) == 2


def test_command_names_an_unknown_key(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "visibility.smith.height"]) == 2
    assert "no equation 'visibility.smith.height'; near: visibility.smith.heights" in capsys.readouterr().err
