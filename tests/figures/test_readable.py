"""Every figure that has a ``draw``: its texts do not touch, it fits the page, and its bytes repeat."""

from __future__ import annotations

import ast
import os
import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import inventory
import pytest
from report import datafile, plotting

pytestmark = pytest.mark.slow  # the data of all figures are computed here

ROOT = Path(__file__).parents[2]
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT / "lib")}
SCRIPTS = [p for p in sorted((ROOT / "figures").glob("*/*.py")) if inventory.read_figure(p)]
DRAWN = [p for p in SCRIPTS if "\ndef draw(" in p.read_text()]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory, compute: Callable[[str], dict[str, Any]]) -> dict[Path, Path]:
    """Data files of all figures, made by their own scripts."""
    folder, made = tmp_path_factory.mktemp("data"), {}
    for script in DRAWN:
        maker = script.with_name(f"{script.stem}_data.py")
        if maker.exists():
            made[script] = folder / f"{script.stem}.npz"
            datafile.store(str(made[script]), **compute(f"{script.parent.name}/{script.stem}"))
    return made


@pytest.mark.parametrize("script", DRAWN, ids=lambda p: p.stem)
def test_labels_do_not_touch(script: Path, data: dict[Path, Path]) -> None:
    draw = runpy.run_path(str(script))["draw"]
    figure = draw(plotting.load(str(data[script]))) if script in data else draw()
    width = figure.get_size_inches()[0]
    faults = plotting.overlaps(figure)
    plotting.plt.close(figure)
    assert faults == []
    assert width <= plotting.WIDTH


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda p: p.stem)
def test_the_caption_begins_with_a_sentence(script: Path) -> None:
    caption = ast.get_docstring(ast.parse(script.read_text()))
    assert caption is not None
    assert caption.splitlines()[0].endswith(".")


def test_bytes_repeat(tmp_path: Path, data: dict[Path, Path]) -> None:
    script = ROOT / "figures/visibility/visible_normals.py"
    for run, zone in (("a", "UTC"), ("b", "Asia/Tokyo")):
        outputs = [tmp_path / run / f"visible_normals.{end}" for end in ("svg", "pdf", "png")]
        subprocess.run([sys.executable, script, data[script], *outputs], check=True, env=ENVIRONMENT | {"TZ": zone})
    for end in ("svg", "pdf", "png"):
        first, second = ((tmp_path / run / f"visible_normals.{end}").read_bytes() for run in ("a", "b"))
        assert first == second


@pytest.mark.parametrize(("content", "says"), [(None, "missing"), (b"", "torn"), (b"PK\x03\x04 torn", "torn")])
def test_bad_data_file_gives_one_sentence(tmp_path: Path, content: bytes | None, says: str) -> None:
    path = tmp_path / "masking.npz"
    if content is not None:
        path.write_bytes(content)
    script = ROOT / "figures/visibility/masking.py"
    run = subprocess.run([sys.executable, script, path, tmp_path / "a.svg"], capture_output=True, text=True, env=ENVIRONMENT)
    assert run.returncode == 1
    assert run.stderr.count("\n") == 1
    for words in (str(path), says, "snakemake build/data/masking.npz"):
        assert words in run.stderr
