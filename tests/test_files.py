"""Output files replace plain files only, and are whole or as they were."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from microfacet.files import writable, write


def make_folder(path: Path) -> None:
    path.mkdir()


def make_link(path: Path) -> None:
    path.with_name("target").write_text("kept")
    path.symlink_to("target")


def make_dangling_link(path: Path) -> None:
    path.symlink_to("nowhere")


def make_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(path))


KINDS: dict[str, list[Callable[[Path], None]]] = {
    "a folder": [make_folder],
    "a symbolic link": [make_link, make_dangling_link],
    "a pipe": [os.mkfifo],
    "a socket": [make_socket],
}


@pytest.mark.parametrize(("kind", "make"), [(kind, make) for kind, makers in KINDS.items() for make in makers])
def test_what_is_no_plain_file_is_refused_by_name_and_stays(
    kind: str, make: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path("out")
    make(path)
    before = path.lstat()
    for refuse in (writable, lambda path: write(path, "new")):
        with pytest.raises(ValueError, match=f"^out is {kind}: an output file replaces plain files only$"):
            refuse(path)
    assert (path.lstat().st_mode, path.lstat().st_ino) == (before.st_mode, before.st_ino)
    assert not Path("target").exists() or Path("target").read_text() == "kept"


@pytest.mark.parametrize("device", ["/dev/null", "/dev/full"])
def test_a_device_is_refused(device: str) -> None:
    with pytest.raises(ValueError, match="is a device"):
        write(device, "")


@pytest.mark.parametrize("name", ["file/out", "file/folder/out"])
def test_a_folder_that_is_none_is_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match=r"cannot be written: .*file is no folder$"):
        writable(tmp_path / name)


def test_a_folder_that_is_locked_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)  # root may write everywhere
    with pytest.raises(ValueError, match=r"new/out cannot be written: this is not permitted in \S+$"):
        writable(tmp_path / "new" / "out")


@pytest.mark.parametrize("name", ["", ".", "/", ".."])
def test_a_name_that_is_none_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"must have a name|is a folder"):
        writable(name)


def test_a_file_is_made_with_its_folders_and_replaced_whole(tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / f"{'λ' * 100}.txt"
    write(path, "ά")
    assert path.read_bytes() == "ά".encode()
    write(path, b"2")
    assert path.read_bytes() == b"2"
    assert list(path.parent.iterdir()) == [path]


def test_a_file_is_readable_as_the_umask_says(tmp_path: Path) -> None:
    write(tmp_path / "out", "")
    (tmp_path / "plain").touch()
    assert (tmp_path / "out").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("step", ["write_bytes", "replace"])
def test_a_full_disk_leaves_the_old_file_and_says_so(step: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "scratch")

    path = tmp_path / "out"
    write(path, "old")
    monkeypatch.setattr(*((Path, step) if step == "write_bytes" else (os, step)), full)
    with pytest.raises(OSError, match=r"^\S+out cannot be written: No space left on device$"):
        write(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
