"""A user's program is checked as the user's editor does it: names, arguments and results have types."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import microfacet as mf
import pytest

LIB = Path(mf.__file__).resolve().parents[1]
RIGHT = """
import microfacet as mf
import numpy as np
from numpy.typing import NDArray

class Flat(mf.Fresnel):
    parameters = (0.5,)

texture: NDArray[np.float32] = np.full((4, 4), 0.3, np.float32)
model: mf.Masking = mf.Smith(mf.GGX(texture, 0.1))
ndf: mf.Distribution = model.ndf
brdf = mf.Microfacet(model, mf.Conductor([0.2, 0.9, 1.4], [3.9, 2.4, 1.6]))
values: NDArray[np.float64] = brdf.evaluate([0, 0, 1], np.zeros((5, 3))) + ndf.D([0, 0, 1]) * mf.Smith(ndf).Lambda([0, 0, 1])
value, error = brdf.albedo_with_error([0, 0, 1])
reveal_type(mf.GGX)
reveal_type(brdf.evaluate)
reveal_type(mf.validate(model).holds)
reveal_type(mf.reflect([0, 0, 1], [0, 0, 1]))
"""
REVEALED = (
    "def (alpha_x:",
    "-> numpy.ndarray[",
    "bool",
    "numpy.ndarray[",
)
WRONG = {
    "mf.Smith(0.3)": "incompatible type",
    "mf.GGX()": "Missing positional argument",
    "mf.Microfacet(mf.GGX(0.3))": "incompatible type",
    "mf.Smith(mf.GGX(0.3)).evaluate": "has no attribute",
    "mf.Nothing": 'Module has no attribute "Nothing"',
}


def checked(text: str, folder: Path) -> str:
    """What mypy says of a program outside of this project."""
    (folder / "program.py").write_text(text, "utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", f"--cache-dir={folder}/cache", "program.py"]
    return subprocess.run(command, cwd=folder, env={"MYPYPATH": str(LIB)}, capture_output=True, text=True, check=False).stdout


def test_names_and_their_modules_are_those_that_are_loaded() -> None:
    """What is written for editors, in __init__.pyi, is what happens."""
    stub = ast.parse((LIB / "microfacet/__init__.pyi").read_text("utf-8"))
    names = {name.name: node.module for node in stub.body if isinstance(node, ast.ImportFrom) for name in node.names}
    assert names == {name: f"microfacet.{module}" for name, module in mf.PUBLIC.items()}
    assert (LIB / "microfacet/py.typed").is_file()


@pytest.mark.slow
def test_a_users_program_has_types(tmp_path: Path) -> None:
    told = checked(RIGHT, tmp_path)
    assert "error" not in told, told
    revealed = [line.partition("Revealed type is ")[2] for line in told.splitlines() if "Revealed" in line]
    for line, part in zip(revealed, REVEALED, strict=True):
        assert part in line
        assert line != '"Any"'


@pytest.mark.slow
def test_wrong_programs_are_told(tmp_path: Path) -> None:
    lines = checked("import microfacet as mf\n" + "\n".join(WRONG), tmp_path).splitlines()
    for k, (line, told) in enumerate(WRONG.items()):
        assert any(f"program.py:{k + 2}: error" in one and told in one for one in lines), (line, lines)
