"""Output files: written whole or not at all, and never over anything but a plain file.

Also values that are stored from one run to the next, each with a digest, so that torn or altered files are detected.
Needs the standard library only.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
from contextlib import suppress
from pathlib import Path
from typing import Any

KINDS = {
    stat.S_IFLNK: "a symbolic link",
    stat.S_IFDIR: "a folder",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
}


def writable(path: str | Path) -> Path:
    """``path``, if a file can be written there: if it is free, or a plain file. To be called before the work starts.

    ValueError, in one sentence, if the path is a link, a folder, a device, a pipe or a socket, or its folder is not writable.
    """
    path = Path(path)
    if not path.name:
        raise ValueError(f"an output file must have a name, got {str(path)!r}")
    _refuse_what_is_no_file(path)
    folder = next(parent for parent in path.absolute().parents if os.path.lexists(parent))
    if not folder.is_dir():
        raise ValueError(f"{path} cannot be written: {folder} is no folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ValueError(f"{path} cannot be written: this is not permitted in {folder}")
    return path


def _refuse_what_is_no_file(path: Path) -> None:
    try:
        kind = stat.S_IFMT(path.lstat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return
    if kind != stat.S_IFREG:
        raise ValueError(f"{path} is {KINDS.get(kind, 'no plain file')}: an output file replaces plain files only")


def write(path: str | Path, content: bytes | str) -> None:
    """Put ``content`` (text as UTF-8) into the file ``path``, making its folder: all of it, or the old file stays.

    ValueError where `writable` raises one; OSError, in one sentence, if the system refuses (a full disk, no permission).
    """
    path = writable(path)
    scratch = path.with_name(f".{path.name[:60]}.{os.urandom(4).hex()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
        os.replace(scratch, path)
    except OSError as fault:
        raise OSError(f"{path} cannot be written: {fault.strerror}") from fault
    finally:
        with suppress(OSError):
            scratch.unlink()


def keep(path: str | Path, value: Any) -> None:
    """Store ``value``, made of JSON types, for another run."""
    text = json.dumps(value, indent=1, ensure_ascii=False)
    write(path, f"{_digest(text)}\n{text}\n")


def recall(path: str | Path) -> Any:
    """The value stored by `keep`; None if the file is missing, torn or altered."""
    try:
        digest, _, text = Path(path).read_text("utf-8").partition("\n")
    except (OSError, ValueError):
        return None
    return json.loads(text) if text.endswith("\n") and digest == _digest(text[:-1]) else None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()
