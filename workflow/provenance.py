"""Which version of which commit is being built, and whether its tree was clean."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import inventory


def git(*arguments: str) -> str | None:
    """The output of git, or None without git or a repository."""
    try:
        done = subprocess.run(["git", *arguments], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()


def version() -> str:
    """The library's version, read from its source without importing it: its other faults are reported elsewhere."""
    path = Path("lib/microfacet/__init__.py")
    stated = re.search(r'^__version__ = "(.+)"$', inventory.text_of(path), re.M)
    return stated[1] if stated else inventory.fault(f"{path} does not state the project's version.")


def provenance() -> dict[str, str]:
    """Strings for the footer: version, commit, and the state of the tree (clean, changed, unknown)."""
    top = git("rev-parse", "--show-toplevel")
    ours = top is not None and Path(top).resolve() == Path.cwd().resolve()
    commit = git("rev-parse", "--short=10", "HEAD") if ours else None
    changes = git("status", "--porcelain") if commit else None
    state = "unknown" if changes is None else "changed" if changes else "clean"
    return {"version": version(), "commit": commit or "unknown commit", "tree": state}
