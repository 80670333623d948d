"""Seals: the digest of each file that the build made, put down when it was made and compared when the next build starts.

python workflow/seal.py build/gate build/report.pdf        seals these; every rule does so after its work
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

BUILD, SEALS = Path("build"), Path("build/seals")


def place(path: Path) -> Path:
    """Where the seal of a file of the build lies."""
    return SEALS / path.relative_to(BUILD)


def digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "blake2b").hexdigest()


def refuse_broken(paths: Iterable[Path]) -> None:
    """ValueError, in one sentence that names them, if any of the files is not what its job made."""
    if torn := broken(paths):
        names = ", ".join(map(str, torn))
        raise ValueError(f"{names}: torn or altered since it was made; start the build again, and it is made again")


def put(paths: Iterable[Path]) -> None:
    from microfacet.files import write

    for path in paths:
        write(place(path), digest(path) + "\n")


def read(path: Path) -> str | None:
    """The seal of a file, None where it has none."""
    try:
        return place(path).read_text("utf-8", errors="replace").strip()
    except OSError:
        return None


def sealed() -> list[Path]:
    """Every file that a build has made and sealed, whether it is still there or not."""
    paths = (Path(folder, name) for folder, _, names in os.walk(SEALS) for name in names if not name.startswith("."))
    return sorted(BUILD / path.relative_to(SEALS) for path in paths)


def whole(path: Path) -> bool:
    """Whether a file is what its job made; one that is not there is not torn either."""
    try:
        return digest(path) == read(path)
    except FileNotFoundError:
        return True


def broken(paths: Iterable[Path]) -> list[Path]:
    """Those of the files that are not what their jobs made: torn, altered, or never finished."""
    paths = list(paths)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return [path for path, good in zip(paths, pool.map(whole, paths), strict=True) if not good]


if __name__ == "__main__":
    put(map(Path, sys.argv[1:]))
