"""Data files come back as they were stored; one that is missing, torn or changed ends the program with a sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from report import datafile

ARRAYS = {"x": np.linspace(0, 1, 5), "words": np.array(["one", "two"]), "count": np.array(3), "turned": np.eye(3)[:, ::-1]}


def test_what_is_stored_comes_back(tmp_path: Path) -> None:
    datafile.store(str(tmp_path / "a.npz"), **ARRAYS)
    found = datafile.load(str(tmp_path / "a.npz"))
    assert found.keys() == ARRAYS.keys()
    for name, values in ARRAYS.items():
        np.testing.assert_array_equal(found[name], values)


def test_the_same_arrays_make_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        datafile.store(str(tmp_path / f"{name}.npz"), **ARRAYS)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize("name", ["x", "words", "count"])
def test_one_number_changed_is_noticed(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.npz"
    datafile.store(str(path), **ARRAYS)
    with np.load(path) as file:
        arrays = dict(file)
    arrays[name] = np.where(arrays[name] == arrays[name].flat[0], arrays[name].flat[-1], arrays[name]) if name != "count" else 4
    np.savez(path, **arrays)
    with pytest.raises(SystemExit, match=r"a\.npz has been changed since it was made: delete it"):
        datafile.load(str(path))


def test_missing_and_torn_files_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    with pytest.raises(SystemExit, match=r"is missing: run `snakemake build/data/a\.npz`"):
        datafile.load(str(path))
    datafile.store(str(path), **ARRAYS)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(SystemExit, match="is torn or not a data file"):
        datafile.load(str(path))
