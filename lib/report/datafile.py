"""Data files of the figures: written whole or not at all, read with one clear sentence when something is wrong."""

from __future__ import annotations

import hashlib
import io
import sys
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from microfacet.files import writable, write
from numpy.typing import ArrayLike, NDArray

TORN = (OSError, EOFError, ValueError, KeyError, AttributeError, RuntimeError, zlib.error, zipfile.BadZipFile)
SEAL = "seal"  # the name of the digest of all other arrays in a file


def seal(arrays: dict[str, NDArray[Any]]) -> str:
    """A digest of names, kinds, shapes and numbers."""
    digest = hashlib.sha256()
    for name, values in sorted(arrays.items()):
        digest.update(f"{name} {values.dtype.str} {values.shape} ".encode() + np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def store(path: str, **arrays: ArrayLike) -> None:
    """Write ``arrays`` to the .npz file ``path``, making its folder; an interrupted run leaves no torn file."""
    given = {name: np.asarray(values) for name, values in arrays.items()}
    file = io.BytesIO()
    np.savez(file, allow_pickle=False, **given, **{SEAL: np.array(seal(given))})
    put(path, file.getvalue())


def put(path: str | Path, content: bytes | str) -> None:
    """Write a file, whole or not at all; where none can be, one sentence ends the program."""
    try:
        write(path, content)
    except (ValueError, OSError) as fault:
        sys.exit(str(fault))


def refuse(path: str | Path) -> None:
    """End the program with one sentence, before its work, if ``put`` would afterwards."""
    try:
        writable(path)
    except ValueError as fault:
        sys.exit(str(fault))


def load(path: str, made_in: str = "build/data") -> dict[str, NDArray[Any]]:
    """Read the arrays that ``store`` wrote; a file missing, torn, or changed since ends the program with one sentence."""
    remedy = f"run `snakemake {made_in}/{Path(path).stem}.npz` to make it"
    try:
        arrays = _read(path)
    except FileNotFoundError:
        sys.exit(f"The data file {path} is missing: {remedy}.")
    except TORN:
        sys.exit(f"The data file {path} is torn or not a data file: delete it and {remedy}.")
    if SEAL in arrays and str(arrays.pop(SEAL)) != seal(arrays):
        sys.exit(f"The data file {path} has been changed since it was made: delete it and {remedy}.")
    return arrays


def intact(path: str | Path) -> bool:
    """Whether a file is one that ``store`` wrote, whole and unchanged."""
    try:
        arrays = _read(path)
    except TORN:
        return False
    return SEAL in arrays and str(arrays.pop(SEAL)) == seal(arrays)


def _read(path: str | Path) -> dict[str, NDArray[Any]]:
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def rounded(arrays: dict[str, ArrayLike], digits: int = 7) -> dict[str, NDArray[Any]]:
    """The arrays rounded to `digits` significant digits: last bits differ between processors, a figure's bytes must not."""
    return {name: _rounded(np.asarray(values), digits) for name, values in arrays.items()}


def _rounded(values: NDArray[Any], digits: int) -> NDArray[Any]:
    if values.dtype.kind != "f":
        return values
    flat = [float(f"{v:.{digits - 1}e}") for v in values.ravel()]
    return np.array(flat).reshape(values.shape)
