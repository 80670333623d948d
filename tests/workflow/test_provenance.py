"""The report says which commit it is made from, and whether that is all it is made from."""

from __future__ import annotations

import subprocess

import pytest
from checkout import Checkout
from provenance import provenance, version

IDENTITY = ("-c", "user.name=Test", "-c", "user.email=test@example.org")


def git(*arguments: str) -> None:
    subprocess.run(["git", *IDENTITY, *arguments], check=True, capture_output=True)


def test_clean_and_changed_trees(small: Checkout) -> None:
    git("init", "--quiet")
    git("add", ".")
    git("commit", "--quiet", "-m", "all")
    clean = provenance()
    assert clean["tree"] == "clean"
    assert len(clean["commit"]) == 10
    small.path("chapters/3_more.md").write_text("# More\n")
    assert provenance() == {**clean, "tree": "changed"}


def test_a_folder_that_is_no_repository(small: Checkout) -> None:
    assert provenance()["commit"] == "unknown commit"
    assert provenance()["tree"] == "unknown"


def test_a_folder_inside_another_repository(small: Checkout, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(small.root.parent)
    git("init", "--quiet")
    git("commit", "--quiet", "--allow-empty", "-m", "another")
    monkeypatch.chdir(small.root)
    assert provenance()["commit"] == "unknown commit"


def test_a_machine_without_git(small: Checkout, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    assert provenance()["tree"] == "unknown"


def test_the_version_is_the_librarys(small: Checkout) -> None:
    assert provenance()["version"] == "0.0.1"
    small.path("lib/microfacet/__init__.py").write_text("PUBLIC = {}\n")
    with pytest.raises(SystemExit, match=r"lib/microfacet/__init__.py does not state the project's version\."):
        version()
