"""One set of versions, with hashes, that names no host; and clear words where there is no Python."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import microfacet
import provenance
import pytest
import yaml
from hatchling.metadata.core import ProjectMetadata
from hatchling.plugin.manager import PluginManager
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
LOCKED = (PROJECT["dependencies"], *(PROJECT["optional-dependencies"][extra] for extra in ("report", "docs")))
DIRECT = [Requirement(text) for extra in LOCKED for text in extra]
PYTHONS = ("3.11", "3.12", "3.13")
HOST = re.compile(r"\w://|index-url|find-links|trusted-host|pythonhosted", re.I)


def locked() -> dict[str, list[Requirement]]:
    text = (ROOT / "requirements.lock").read_text("utf-8")
    found: dict[str, list[Requirement]] = {}
    for entry in re.sub(r" \\\n\s+", " ", text).splitlines():
        requirement, *hashes = entry.split(" --hash=")
        assert hashes, f"no hash for {requirement}"
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", one.strip()) for one in hashes)
        parsed = Requirement(requirement)
        found.setdefault(canonicalize_name(parsed.name), []).append(parsed)
    return found


def version_for(name: str, python: str) -> str:
    """The one version of a package that the lock gives a Python."""
    here = {**default_environment(), "python_version": python, "python_full_version": f"{python}.0"}
    fits = [r for r in locked()[canonicalize_name(name)] if r.marker is None or r.marker.evaluate(here)]
    assert len(fits) == 1, f"{name} for Python {python}: {fits}"
    return str(fits[0].specifier).removeprefix("==")


@pytest.mark.parametrize("python", PYTHONS)
def test_the_lock_answers_what_the_project_asks(python: str) -> None:
    for requirement in DIRECT:
        assert requirement.specifier.contains(version_for(requirement.name, python)), requirement


@pytest.mark.parametrize("name", ["requirements.lock", "environment.yml", "pyproject.toml", "Makefile"])
def test_no_file_names_a_package_host(name: str) -> None:
    assert not HOST.search((ROOT / name).read_text("utf-8"))


def test_conda_has_the_same_names_and_versions() -> None:
    conda = yaml.safe_load((ROOT / "environment.yml").read_text("utf-8"))["dependencies"]
    pinned = [line for line in conda if isinstance(line, str) and "==" in line]
    pinned += next(line["pip"] for line in conda if isinstance(line, dict))
    ours = {canonicalize_name(r.name): str(r.specifier) for r in map(Requirement, pinned)}
    assert ours == {canonicalize_name(r.name): "==" + version_for(r.name, "3.11") for r in DIRECT}


def test_the_version_is_stated_in_one_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """The library says it; what builds and installs it, and the report, read it there."""
    monkeypatch.chdir(ROOT)
    assert "version" not in PROJECT
    assert PROJECT["dynamic"] == ["version"]
    assert "version" not in yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    built = ProjectMetadata(str(ROOT), PluginManager()).hatch.version.source.get_version_data()["version"]
    assert provenance.version() == built == microfacet.__version__


def test_the_citation_names_the_licence() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert citation["license"] == PROJECT["license"]


def environment(python: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = ["sh", str(ROOT / "workflow/environment.sh"), python]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_a_missing_python_is_one_sentence(tmp_path: Path) -> None:
    done = environment("python-of-nowhere", tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith("There is no working Python called 'python-of-nowhere'")
    assert done.stderr.count("\n") == 1


def test_an_old_python_is_one_sentence(tmp_path: Path) -> None:
    old = tmp_path / "python"
    old.write_text('#!/bin/sh\ncase "$2" in *print*) echo 3.10;; *) exit 1;; esac\n')
    old.chmod(0o755)
    done = environment(str(old), tmp_path)
    assert done.returncode == 1
    assert "is Python 3.10, but this needs 3.11 or newer" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / ".venv").exists()


def test_a_checkout_whose_name_the_locale_does_not_know_finds_its_library(tmp_path: Path) -> None:
    checkout = tmp_path / "ünï"
    (checkout / "lib").mkdir(parents=True)
    (checkout / "lib" / "there.py").write_text("print('here')")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", ".venv"], cwd=checkout, check=True)
    (packages,) = checkout.glob(".venv/lib/python*/site-packages")
    (packages / "microfacet.pth").write_text(f"{checkout}/lib\n", "utf-8")
    (line,) = [line for line in (ROOT / "workflow/environment.sh").read_text().splitlines() if line.startswith("for path")]
    subprocess.run(["sh", "-c", line], cwd=checkout, check=True)
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "LC_", "LANG"))}
    command = [".venv/bin/python", "-c", "import there"]
    done = subprocess.run(command, cwd=checkout, env=plain | {"LC_ALL": "C"}, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("here\n", "")
