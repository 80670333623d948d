"""The direction of imports, as `make lint` checks it: kept by the library, and a wrong one is named."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def lint(root: Path) -> subprocess.CompletedProcess[str]:
    command = [str(Path(sys.executable).with_name("lint-imports")), "--no-cache", "--no-logo"]
    paths = os.pathsep.join([str(root / "lib"), str(root)])
    return subprocess.run(
        command, cwd=root, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True, check=False
    )


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    for folder in ("lib", "benchmarks"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_imports_run_one_way(copy: Path) -> None:
    done = lint(copy)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("file", "line", "named"),
    [
        ("geometry/slopes.py", "from microfacet.visibility import smith", "geometry.slopes -> microfacet.visibility"),
        ("statements/notation.py", "from microfacet.geometry import ggx", "statements.notation -> microfacet.geometry.ggx"),
        ("frame.py", "def late():\n    from report import datafile", "microfacet.frame -> report.datafile"),
        ("more.py", "", "microfacet.more"),
    ],
)
def test_an_import_the_other_way_is_named(copy: Path, file: str, line: str, named: str) -> None:
    """At the top and within functions; and a new module at the top of the package has to be given its place."""
    path = copy / "lib/microfacet" / file
    before = path.read_text("utf-8") if path.exists() else ""
    path.write_text(f"{before}\n{line}\n", "utf-8")
    done = lint(copy)
    assert done.returncode == 1
    assert named in done.stdout
