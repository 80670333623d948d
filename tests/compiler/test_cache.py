"""The kernel cache: what is loaded is what was written, from a folder of the user's alone; else code is kept in memory."""

from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from microfacet.compiler import cache, loop
from microfacet.compiler.batch import Batch
from microfacet.compiler.cache import SUFFIX, CacheWarning, cache_directory

LIBRARY = Path(__file__).parents[2] / "lib"
NOBODY = 65534
as_root = pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="takes another user's rights")


def cubic(x: float, p: Any) -> float:
    return x * x * x + p[0]


def forget() -> None:
    """What a new process would not know."""
    loop.machine_code.cache_clear()
    cache._warn.cache_clear()
    cache._tidy.cache_clear()


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty cache."""
    tmp_path.chmod(0o700)
    monkeypatch.setenv("MICROFACET_CACHE", str(tmp_path / "kernels"))
    forget()
    yield tmp_path / "kernels"
    forget()


def value() -> float:
    """From a kernel that was compiled or loaded just now."""
    forget()
    return float(Batch(cubic, [1])([2.0], (0.5,)))


def warned(call: Callable[[], Any] = value) -> list[str]:
    """What the cache has to say of a call that is right nevertheless."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert call() == 8.5
    assert all(issubclass(warning.category, CacheWarning) for warning in caught)
    return [str(warning.message) for warning in caught]


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The programs that were compiled so far."""
    done: list[str] = []

    def compile_(text: str, kind: Any) -> Any:
        done.append(text)
        return genuine(text, kind)

    genuine = loop._compile
    monkeypatch.setattr(loop, "_compile", compile_)
    return done


def only(folder: Path) -> Path:
    (file,) = folder.iterdir()
    return file


# --- where --------------------------------------------------------------------------------------------------------


def test_the_folder_is_the_one_named_or_the_users(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert cache_directory() == tmp_path / "kernels"
    monkeypatch.setenv("MICROFACET_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_directory() == tmp_path / "microfacet"
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    for unset in ("", "relative", "./here"):
        monkeypatch.setenv("XDG_CACHE_HOME", unset)
        assert cache_directory() == tmp_path / "home/.cache/microfacet"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_directory() == tmp_path / "home/.cache/microfacet"


def test_nothing_is_written_where_one_stands(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("MICROFACET_CACHE")
    for unset in ("", "relative"):
        monkeypatch.setenv("XDG_CACHE_HOME", unset)
        assert not warned()
    assert not list((tmp_path / "here").iterdir())
    assert only(tmp_path / ".cache/microfacet").suffix == SUFFIX


@pytest.mark.parametrize("umask", [0o000, 0o002, 0o077])
def test_folders_and_files_are_the_users_alone_whatever_the_umask(
    umask: int, folder: Path, compilations: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MICROFACET_CACHE", str(folder / "deep" / "below"))
    before = os.umask(umask)
    try:
        assert not warned()
    finally:
        os.umask(before)
    for made in (folder, folder / "deep", folder / "deep/below", only(folder / "deep/below")):
        assert not made.stat().st_mode & 0o077
    assert not warned()
    assert len(compilations) == 1


# --- what is loaded is what was written -------------------------------------------------------------------------------


def test_a_file_that_is_whole_is_loaded_without_a_word(folder: Path, compilations: list[str]) -> None:
    assert not warned()
    content = only(folder).read_bytes()
    assert not warned()
    assert len(compilations) == 1
    assert only(folder).read_bytes() == content


def flipped(content: bytes, place: int) -> bytes:
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


ALTERATIONS: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda content: b"",
    "shorter than its digest": lambda content: content[:20],
    "torn": lambda content: content[: len(content) // 2],
    "without its last byte": lambda content: content[:-1],
    "with one byte more": lambda content: content + b"\0",
    "zeros": lambda content: bytes(len(content)),
    "no code": lambda content: cache._digest(Path("other"), b"") + b"",
    **{
        f"flipped at {share}": lambda content, share=share: flipped(content, int(share * (len(content) - 1)))
        for share in (0, 1e-3, 0.1, 0.3, 0.5, 0.7, 0.9, 1)
    },
}


@pytest.mark.parametrize("alteration", ALTERATIONS.values(), ids=ALTERATIONS)
def test_a_file_that_is_not_as_it_was_written_is_made_again(
    alteration: Callable[[bytes], bytes], folder: Path, compilations: list[str]
) -> None:
    value()
    file = only(folder)
    file.write_bytes(alteration(file.read_bytes()))
    assert warned() == [f"{file} is not as it was written: it is made again"]
    assert len(compilations) == 2
    assert not warned()
    assert len(compilations) == 2


def test_a_file_that_takes_anothers_place_is_found_out(folder: Path, compilations: list[str]) -> None:
    """Whole and right, but for another program."""

    def square(x: float, p: Any) -> float:
        return x * x + p[0]

    value()
    wanted = only(folder)
    assert Batch(square, [1])([2.0], (0.5,)) == 4.5
    (other,) = set(folder.iterdir()) - {wanted}
    shutil.copy(other, wanted)
    assert warned() == [f"{wanted} is not as it was written: it is made again"]
    assert len(compilations) == 3


def test_code_that_cannot_be_loaded_is_made_again(folder: Path, compilations: list[str]) -> None:
    """As it was written, but by what gives itself out for the same compiler."""
    value()
    file = only(folder)
    cache._write(file, b"no pickle")
    (sentence,) = warned()
    assert sentence.startswith(f"{file} cannot be loaded (")
    assert not warned()
    assert len(compilations) == 2


def test_a_folder_in_the_place_of_a_file(folder: Path) -> None:
    value()
    file = only(folder)
    file.unlink()
    file.mkdir()
    unread, unwritten = warned()
    assert unread == f"{file} cannot be read (Is a directory): it is made again"
    assert unwritten.startswith(f"cannot write to the kernel cache {folder} (Is a directory)")
    assert only(folder) == file


def test_another_text_compiler_or_processor_is_another_file(monkeypatch: pytest.MonkeyPatch) -> None:
    import numba
    from numba.core.codegen import JITCPUCodegen

    names = {cache.key("text", "kind"), cache.key("text", "other"), cache.key("textkind"), cache.key("tex", "tkind")}
    monkeypatch.setattr(numba, "__version__", "0")
    names.add(cache.key("text", "kind"))
    monkeypatch.setattr(JITCPUCodegen, "magic_tuple", lambda self: ("another", "processor", ""))
    names.add(cache.key("text", "kind"))
    assert len(names) == 6


# --- only from a folder of the user's alone ---------------------------------------------------------------------------


@pytest.mark.parametrize("mode", [0o720, 0o702, 0o777, 0o1777, 0o775])
def test_a_folder_that_others_can_write_is_neither_read_nor_written(mode: int, folder: Path, compilations: list[str]) -> None:
    value()
    content = only(folder).read_bytes()
    folder.chmod(mode)
    (sentence,) = warned()
    assert sentence.startswith(
        f"the kernel cache cannot be used ({folder} can be written by others): kernels are compiled in memory;"
    )
    assert "MICROFACET_CACHE" in sentence
    assert only(folder).read_bytes() == content
    assert len(compilations) == 2


def test_a_link_to_such_a_folder_neither(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = folder.parent / "target"
    target.mkdir()
    folder.symlink_to(target)
    assert not warned()
    target.chmod(0o777)
    assert len(warned()) == 1


def test_nor_one_in_a_folder_that_all_can_write(folder: Path) -> None:
    folder.parent.chmod(0o777)
    (sentence,) = warned()
    assert f"{folder.parent}, which it is in, can be written by others" in sentence
    folder.parent.chmod(0o1777)  # as /tmp: each may remove only what is his own
    assert not warned()


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_others_can_write_is_made_again(mode: int, folder: Path, compilations: list[str]) -> None:
    value()
    file = only(folder)
    file.chmod(mode)
    assert warned() == [f"{file} can be written by others: it is made again"]
    assert len(compilations) == 2
    assert file.stat().st_mode & 0o777 == 0o600
    assert not warned()


@as_root
def test_a_folder_of_another_user_is_neither_read_nor_written(folder: Path, compilations: list[str]) -> None:
    value()
    os.chown(folder, NOBODY, NOBODY)
    (sentence,) = warned()
    assert f"{folder} belongs to another user" in sentence
    assert len(compilations) == 2


@as_root
def test_a_file_of_another_user_is_made_again(folder: Path, compilations: list[str]) -> None:
    value()
    file = only(folder)
    os.chown(file, NOBODY, NOBODY)
    assert warned() == [f"{file} belongs to another user: it is made again"]
    assert len(compilations) == 2
    assert file.stat().st_uid == os.geteuid()


# --- no place, no space -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("home", ["/dev/null", "/proc/nothing/here"])
def test_without_a_home_code_is_kept_in_memory(home: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MICROFACET_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", home)
    (sentence,) = warned()
    assert "the kernel cache cannot be used (/" in sentence
    assert "kernels are compiled in memory; set MICROFACET_CACHE to a folder that only you can write" in sentence


def test_a_user_without_a_home(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("MICROFACET_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", none)
    (sentence,) = warned()
    assert "(Could not determine home directory.)" in sentence


def test_a_file_in_the_place_of_the_folder(folder: Path) -> None:
    folder.write_text("")
    assert len(warned()) == 1
    assert folder.read_text() == ""


def test_what_is_compiled_in_memory_is_compiled_once_and_said_once(folder: Path, compilations: list[str]) -> None:
    folder.write_text("")

    def many() -> float:
        forget()
        for _ in range(3):
            single = Batch(cubic, [1])([np.float32(2.0)], (0.5,))
            double = Batch(cubic, [1])([2.0], (0.5,))
        assert single == double
        return float(double)

    assert len(warned(many)) == 1
    assert len(compilations) == 2


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO])
@pytest.mark.parametrize("name", ["mkstemp", "write", "replace"])
def test_a_full_disk_loses_nothing(name: str, code: int, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*args: Any, **options: Any) -> Any:
        raise OSError(code, os.strerror(code))

    value()
    only(folder).unlink()
    with monkeypatch.context() as broken:
        if name == "write":
            genuine = open
            broken.setattr(cache, "open", lambda *args: Full(genuine(*args), full), raising=False)
        else:
            broken.setattr({"mkstemp": cache.tempfile, "replace": cache.os}[name], name, full)
        (sentence,) = warned()
    assert sentence.startswith(
        f"cannot write to the kernel cache {folder} ({os.strerror(code)}): kernels are compiled in memory;"
    )
    assert not list(folder.iterdir())
    assert not warned()
    assert only(folder).suffix == SUFFIX


class Full:
    """A file that takes half of what is written to it."""

    def __init__(self, file: Any, full: Callable[[], Any]) -> None:
        self.file, self.full = file, full

    def __enter__(self) -> Full:
        return self

    def __exit__(self, *reason: object) -> None:
        self.file.close()

    def write(self, content: bytes) -> None:
        self.file.write(content[: len(content) // 2])
        self.full()


def test_an_interrupt_while_it_writes_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*args: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as broken:
        broken.setattr(cache.os, "replace", interrupted)
        with pytest.raises(KeyboardInterrupt):
            value()
    assert not list(folder.iterdir())


def test_what_a_killed_process_left_is_removed_by_a_later_one(folder: Path) -> None:
    folder.mkdir(mode=0o700)
    old, young = folder / "old.tmp", folder / "young.tmp"
    for scratch in (old, young):
        scratch.write_bytes(b"half")
    os.utime(old, (time.time() - 2 * cache.ABANDONED,) * 2)
    assert not warned()
    assert not old.exists()
    assert young.exists()  # another process may be at it


# --- other processes, other users -------------------------------------------------------------------------------------

FIRST = """
import json, os, sys, warnings
import microfacet as mf
model = mf.GGX(0.3)
if user := int(sys.argv[1]):  # who may not be able to read the compiler's files
    from numba.core.registry import cpu_target
    cpu_target.target_context.refresh()
    os.setgroups([]); os.setgid(user); os.setuid(user)
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    values = [float(model.D([0.6, 0.0, 0.8]))]
    if "trace" in sys.argv:
        import numpy as np
        from microfacet.surface.height_field import HeightField
        values.append(float(HeightField(np.zeros((8, 8))).trace([0.3, 0.4, 2.0], [0.0, 0.0, -1.0]).distance[0]))
print(json.dumps([values, [str(w.message) for w in caught if w.category.__name__ == "CacheWarning"]]))
"""
D = 0.3**2 / np.pi / (0.36 + 0.3**2 * 0.64) ** 2


def started(*arguments: str, library: Path = LIBRARY, user: int = 0, **environment: str) -> Any:
    command = [sys.executable, "-c", FIRST, str(user), *arguments]
    kept = {name: value for name, value in os.environ.items() if name not in ("MICROFACET_CACHE", "XDG_CACHE_HOME")}
    return subprocess.Popen(
        command, env=kept | {"PYTHONPATH": str(library)} | environment, cwd="/", stdout=-1, stderr=-1, text=True
    )


def ended(process: Any) -> tuple[list[float], list[str]]:
    output, errors = process.communicate()
    assert process.returncode == 0, errors
    values, sentences = json.loads(output)
    np.testing.assert_allclose(values, [D, 2.0][: len(values)], rtol=1e-14)
    return values, sentences


@pytest.mark.slow
def test_processes_that_write_the_same_at_once_lose_nothing(folder: Path) -> None:
    def all_at_once() -> list[Any]:
        return [ended(process) for process in [started(MICROFACET_CACHE=str(folder)) for _ in range(4)]]

    assert all(not sentences for _, sentences in all_at_once())
    content = only(folder).read_bytes()
    assert all(not sentences for _, sentences in all_at_once())
    assert only(folder).read_bytes() == content
    only(folder).write_bytes(content[:-100])
    assert any(sentences for _, sentences in all_at_once())
    assert not ended(started(MICROFACET_CACHE=str(folder)))[1]


@pytest.mark.slow
def test_a_process_that_is_killed_at_any_time_loses_nothing(folder: Path) -> None:
    process = started("trace", MICROFACET_CACHE=str(folder))
    while not folder.exists() or not list(folder.iterdir()):
        time.sleep(0.001)
    process.kill()
    process.communicate()
    assert not ended(started("trace", MICROFACET_CACHE=str(folder)))[1]
    assert not ended(started("trace", MICROFACET_CACHE=str(folder)))[1]


@pytest.mark.slow
def test_a_read_only_installation_without_a_home(tmp_path: Path) -> None:
    """Neither the kernels nor what the surfaces compile needs a place, and nothing is written beside them."""
    installed = tmp_path / "site"
    shutil.copytree(LIBRARY, installed, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (installed, *installed.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    files = set(installed.rglob("*"))
    (sentence,) = ended(started("trace", library=installed, HOME="/dev/null", PYTHONDONTWRITEBYTECODE="1"))[1]
    assert "(/dev/null: Not a directory): kernels are compiled in memory; set MICROFACET_CACHE" in sentence
    assert set(installed.rglob("*")) == files  # root could


@as_root
@pytest.mark.slow
def test_a_cache_that_root_made_hurts_nobody_else(folder: Path) -> None:
    with tempfile.TemporaryDirectory() as place:
        os.chmod(place, 0o755)
        folder, own = Path(place) / "root", Path(place) / "own"
        assert not ended(started(MICROFACET_CACHE=str(folder)))[1]
        (sentence,) = ended(started(user=NOBODY, MICROFACET_CACHE=str(folder)))[1]
        assert f"{folder} belongs to another user" in sentence
        (sentence,) = ended(started(user=NOBODY, MICROFACET_CACHE=str(Path(place) / "new")))[1]
        assert f"({place}/new: Permission denied)" in sentence
        own.mkdir(mode=0o700)
        os.chown(own, NOBODY, NOBODY)
        assert not ended(started(user=NOBODY, MICROFACET_CACHE=str(own)))[1]
        content = only(own).read_bytes()
        own.chmod(0o500)
        assert not ended(started(user=NOBODY, MICROFACET_CACHE=str(own)))[1]
        only(own).write_bytes(content[:-1])
        torn, unwritten = ended(started(user=NOBODY, MICROFACET_CACHE=str(own)))[1]
        assert "is not as it was written" in torn
        assert f"cannot write to the kernel cache {own} (Permission denied)" in unwritten


EVENTS = """
from numba.core import event
with event.install_recorder("numba:compile") as seen:
    import numpy as np
    from microfacet.surface.height_field import HeightField
    HeightField(np.zeros((8, 8))).trace([0.3, 0.4, 2.0], [0.0, 0.0, -1.0])
print(len(seen.buffer))
"""


@pytest.mark.slow
def test_surfaces_keep_what_they_compile_in_the_same_folder(folder: Path) -> None:
    def events() -> int:
        environment = os.environ | {"PYTHONPATH": str(LIBRARY), "MICROFACET_CACHE": str(folder)}
        done = subprocess.run([sys.executable, "-c", EVENTS], env=environment, capture_output=True, text=True, check=True)
        return int(done.stdout)

    assert events() > 0
    assert events() == 0
    assert {file.suffix for file in folder.iterdir()} == {SUFFIX}


@pytest.mark.parametrize("code", ["import microfacet as mf; mf.GGX(0.3).D([0.0, 0.0, 1.0])", "import microfacet.surface.lanes"])
def test_without_a_compiler_one_sentence_says_so(code: str) -> None:
    """In plain Python a division by zero is an error, and no infinity."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "MICROFACET_CACHE": "/dev/null", "PYTHONPATH": str(LIBRARY)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert done.stderr.strip().splitlines()[-1] == (
        "RuntimeError: NUMBA_DISABLE_JIT is set, and microfacet's kernels have to be compiled: unset it"
    )
