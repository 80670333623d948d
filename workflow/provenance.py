"""Which version of which commit is being built, and whether its tree was clean."""

from __future__ import annotations

import subprocess
import tomllib
from pathlib import Path

import inventory


def git(*arguments: str) -> str | None:
    """What git answers, or None where there is no git or no repository."""
    try:
        done = subprocess.run(["git", *arguments], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()


def version() -> str:
    path = Path("pyproject.toml")
    try:
        return str(tomllib.loads(inventory.text_of(path))["project"]["version"])
    except (ValueError, LookupError, TypeError) as error:
        inventory.fault(f"{path} does not state the project's version: {error}.")


def provenance() -> dict[str, str]:
    """Strings for the footer: version, commit, and the state of the tree (clean, changed, unknown)."""
    top = git("rev-parse", "--show-toplevel")
    ours = top is not None and Path(top).resolve() == Path.cwd().resolve()
    commit = git("rev-parse", "--short=10", "HEAD") if ours else None
    changes = git("status", "--porcelain") if commit else None
    state = "unknown" if changes is None else "changed" if changes else "clean"
    return {"version": version(), "commit": commit or "unknown commit", "tree": state}
