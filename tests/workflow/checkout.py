"""A small checkout: the project's own toolchain round a library of three statements."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SMALL = Path(__file__).resolve().parent / "small"
TOOLCHAIN = (
    "Snakefile",
    "workflow",
    "profiles",
    "environment.yml",
    "pyproject.toml",
    "requirements.lock",
    "CITATION.cff",
    "lib/microfacet/files.py",
)
SKIPPED = shutil.ignore_patterns("__pycache__")


class Checkout:
    """A folder with a small project in it, and the commands one gives there."""

    def __init__(self, root: Path) -> None:
        self.root = root
        shutil.copytree(SMALL, root, dirs_exist_ok=True, ignore=SKIPPED)
        for name in TOOLCHAIN:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, root / name, ignore=SKIPPED)
            else:
                shutil.copy(source, root / name)

    def path(self, name: str) -> Path:
        return self.root / name

    def edit(self, name: str, old: str, new: str) -> None:
        text = self.path(name).read_text("utf-8")
        assert old in text
        self.path(name).write_text(text.replace(old, new), "utf-8")

    def snakemake(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "snakemake", "--cores", "2", *arguments]
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "COV_", "PYTHON"))}
        environment["XDG_CACHE_HOME"] = str(self.root / ".cache")
        return subprocess.run(
            command, cwd=self.root, env=environment, text=True, check=False,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    def jobs(self, *arguments: str) -> set[str]:
        """The messages of the jobs that a build did, but for the target itself."""
        done = self.snakemake(*arguments)
        messages = re.findall(r"^Job [1-9]\d*: (.*)$", done.stdout, re.M)
        return {" ".join(message.split()) for message in messages}
