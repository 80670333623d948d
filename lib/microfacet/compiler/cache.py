"""Compiled code in a folder of the user, for the next process; what is loaded is what was written.

A file holds one compiled function. Its name is a digest of everything that determines the code: the text, the types, the
version of the compiler and the processor. So no file is ever out of date, and two processes that write the same file write the
same code. A digest precedes the code in the file: a torn or altered file is compiled again.

To load compiled code is to run it, and a digest helps against accidents only. So a folder is used only if it belongs to the
user and nobody else may write in it, and a file under the same condition. Who can write in a parent of the folder could at most
put another folder of the user's own in its place; a parent that all may write in is refused nevertheless, unless each may
remove only what is his own (as in /tmp). Where there is no such folder, or no space, code is kept in memory, and a
`CacheWarning` says so.
"""

from __future__ import annotations

import errno
import hashlib
import os
import pickle
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, cast

SUFFIX = ".compiled"
DIGEST = hashlib.sha256().digest_size
ABANDONED = 3600.0  # seconds after which an unfinished file is removed

_ADVICE = "set MICROFACET_CACHE to a folder that only you can write, to compile but once"


class CacheWarning(UserWarning):
    """Compiled code cannot be kept, or what was kept cannot be used. Results are the same; it is compiled again."""


def cache_directory() -> Path:
    """The folder of compiled code: $MICROFACET_CACHE, else `microfacet` in $XDG_CACHE_HOME, else in ~/.cache.

    An empty variable counts as unset, and so does a relative $XDG_CACHE_HOME, as its specification says.
    """
    if chosen := os.environ.get("MICROFACET_CACHE"):
        return Path(chosen).absolute()
    common = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (common if common.is_absolute() else Path.home() / ".cache") / "microfacet"


def key(*parts: object) -> str:
    """The name of the code compiled from these parts by this compiler for this processor."""
    import llvmlite
    import numba
    from numba.core.registry import cpu_target

    processor = cpu_target.target_context.codegen().magic_tuple()
    versions = (numba.__version__, llvmlite.__version__, sys.implementation.cache_tag, sys.maxsize)
    return hashlib.sha256(repr((versions, processor, *map(str, parts))).encode()).hexdigest()[:40]


def load(name: str) -> Any:
    """The compiler's result stored under this name; None if there is none that can be trusted."""
    from numba.core.compiler import CompileResult
    from numba.core.registry import cpu_target
    from numba.core.runtime.nrt import rtsys

    context = cpu_target.target_context
    rtsys.initialize(context)
    folder = _folder()
    path = folder / f"{name}{SUFFIX}" if folder else None
    if path is None or (code := _read(path)) is None:
        return None
    try:
        return CompileResult._rebuild(context, *pickle.loads(code))
    except Exception as error:  # whatever a compiler of the same version, but built otherwise, makes of it
        _warn(f"{path} cannot be loaded ({error!r}): it is made again")
        return None


def store(name: str, compiled: Any) -> None:
    """Store the compiler's result for the next process, if there is a folder for it."""
    from numba.core.serialize import dumps

    folder = _folder()
    if folder is None or compiled.lifted or compiled.library.has_dynamic_globals:  # addresses are of no use to another process
        return
    path = folder / f"{name}{SUFFIX}"
    try:
        _write(path, dumps(compiled._reduce()))
    except OSError as error:
        _warn(f"cannot write to the kernel cache {folder} ({error.strerror}): kernels are compiled in memory; {_ADVICE}")


def compiled(**options: Any) -> Callable[[Any], Any]:
    """A decorator: numba's njit with these options, for functions of a module, cached here and not in numba's folder.

    They are compiled again when anything in the file of their module changes. They may not call functions of other modules.
    """
    import numba

    def known(function: Any) -> Any:
        require_compiler()
        dispatcher: Any = cast(Any, numba.njit)(**options)(function)
        dispatcher._cache = _NumbaCache((_content(function.__code__.co_filename), function.__qualname__))
        return dispatcher

    return known


@cache
def _content(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


def require_compiler() -> None:
    """RuntimeError if numba has been told not to compile: in plain Python a kernel would fail where a loop gives infinity."""
    import numba

    if cast(Any, numba.config).DISABLE_JIT:
        raise RuntimeError("NUMBA_DISABLE_JIT is set, and microfacet's kernels have to be compiled: unset it")


class _NumbaCache:
    """The cache of one function, with the interface that numba expects."""

    cache_path = None

    def __init__(self, function: tuple[str, str]) -> None:
        self.function = function

    def load_overload(self, signature: Any, context: Any) -> Any:
        return load(key(*self.function, signature))

    def save_overload(self, signature: Any, result: Any) -> None:
        store(key(*self.function, signature), result)


# --- folders and files ----------------------------------------------------------------------------------------------


def _folder() -> Path | None:
    """The folder, if there is one that only this user can write."""
    try:
        folder = cache_directory()
        _make(folder)
        wrong = _open_to_others(folder)
    except OSError as error:
        wrong = f"{error.filename}: {error.strerror}"
    except RuntimeError as error:  # the user has no home
        wrong = str(error)
    if not wrong:
        return folder
    _warn(f"the kernel cache cannot be used ({wrong}): kernels are compiled in memory; {_ADVICE}")
    return None


def _make(folder: Path) -> None:
    """Make a folder and its parents, for the user alone whatever the umask says."""
    if not folder.is_dir():
        if folder.exists():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
        _make(folder.parent)
        folder.mkdir(mode=0o700, exist_ok=True)


def _open_to_others(folder: Path) -> str:
    """In what way others could write in a folder, or nothing."""
    if not hasattr(os, "geteuid"):  # folders have no such owners and modes here
        return ""
    if others := _others(folder.stat()):
        return f"{folder} {others}"
    for parent in folder.resolve().parents:
        mode = parent.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"{parent}, which it is in, can be written by others"
    return ""


def _others(status: os.stat_result) -> str:
    if status.st_uid != os.geteuid():
        return "belongs to another user"
    return "can be written by others" if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


def _read(path: Path) -> bytes | None:
    """The code in a file, if it is there, is the user's and is as it was written."""
    try:
        with path.open("rb") as file:
            others = _others(os.fstat(file.fileno())) if hasattr(os, "geteuid") else ""
            content = file.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        others = f"cannot be read ({error.strerror})"
    if not others and content[:DIGEST] == _digest(path, code := content[DIGEST:]):
        return code
    _warn(f"{path} {others or 'is not as it was written'}: it is made again")
    return None


def _write(path: Path, code: bytes) -> None:
    """Put a whole file in its place at once. OSError, and no trace of it, if that cannot be done."""
    _tidy(path.parent)
    handle, scratch = tempfile.mkstemp(".tmp", dir=path.parent)
    try:
        with open(handle, "wb") as file:
            file.write(_digest(path, code) + code)
        os.replace(scratch, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(scratch)
        raise


def _digest(path: Path, code: bytes) -> bytes:
    """The digest of the code and of its name, so that a file under another's name is detected."""
    return hashlib.sha256(path.name.encode() + code).digest()


@cache
def _tidy(folder: Path) -> None:
    """Remove, once in a process, the unfinished files of processes that were killed."""
    for scratch in folder.glob("*.tmp"):
        with suppress(OSError):
            if time.time() - scratch.stat().st_mtime > ABANDONED:
                scratch.unlink()


@cache
def _warn(sentence: str) -> None:
    """Say it, once in a process."""
    warnings.warn(sentence, CacheWarning, stacklevel=2)
