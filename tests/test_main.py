"""The commands end in an answer or in one sentence."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import microfacet as mf
import pytest
from microfacet.__main__ import main

KEY = "visibility.smith.heights"


def command(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "microfacet", *words], capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": "lib"} | environment, cwd=Path(__file__).parents[1],
    )  # fmt: skip


def is_one_sentence(text: str) -> bool:
    return text.count("\n") == 1 and len(text) > 10 and "Traceback" not in text


def test_the_version_is_told() -> None:
    assert command("--version").stdout == f"microfacet {mf.__version__}\n"


@pytest.mark.parametrize("option", ["--out", "--kept"])
@pytest.mark.parametrize("place", ["folder", "link", "file/inside", ""])
def test_an_output_that_cannot_be_is_refused_before_the_work(
    option: str, place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(type(mf.equations[KEY]), "check", lambda self: pytest.fail("worked first"))
    Path("folder").mkdir()
    Path("file").write_text("kept")
    Path("link").symlink_to("file")
    if option == "--kept" and place in ("folder", ""):
        pytest.skip("records are kept in a folder")
    if option == "--kept" and place == "link":
        place = "file"
    assert main(["check", KEY, option, place]) == 2
    assert is_one_sentence(capsys.readouterr().err)
    assert Path("file").read_text() == "kept"
    assert Path("link").is_symlink()


def test_a_reader_that_goes_away_is_no_fault() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "microfacet", "list"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": "lib"}, cwd=Path(__file__).parents[1],
    )  # fmt: skip
    assert process.stdout
    process.stdout.close()
    assert process.stderr
    assert process.stderr.read() == ""
    assert process.wait() == 141


def test_a_full_disk_is_one_sentence() -> None:
    done = subprocess.run(
        f"{sys.executable} -m microfacet list > /dev/full", shell=True, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": "lib"}, cwd=Path(__file__).parents[1],
    )  # fmt: skip
    assert done.stderr == "The output cannot be read or written: No space left on device\n"
    assert done.returncode == 2


def test_a_terminal_that_knows_ascii_only_gets_ascii() -> None:
    script = """if True:
        import sys
        from microfacet import __main__ as command
        command._statements = lambda chosen: print("1 \u00b1 2 \u2264 \u03b1 \u2192 \u00e9 \u2713 \u4e00") or 0
        sys.exit(command.main(["list"]))"""
    environment = os.environ | {"PYTHONPATH": "lib", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, env=environment,
                          cwd=Path(__file__).parents[1])  # fmt: skip
    assert (done.stdout, done.stderr, done.returncode) == ("1 +- 2 <= alpha -> e yes \\u4e00\n", "", 0)


def test_all_that_is_told_can_be_told_in_ascii() -> None:
    done = command("list", PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()


def test_without_a_compiler_there_is_a_sentence(tmp_path: Path) -> None:
    done = command("check", "geometry.ggx.Lambda", NUMBA_DISABLE_JIT="1", MICROFACET_CACHE=str(tmp_path))
    assert done.stderr == "NUMBA_DISABLE_JIT is set, and microfacet's kernels have to be compiled: unset it\n"
    assert done.returncode == 2


def test_what_is_left_out_without_python_flint_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    enclosed = next(key for key in mf.equations if mf.equations[key].enclosed)
    other = next(key for key in mf.equations if not mf.equations[key].enclosed)
    monkeypatch.setattr("microfacet.statements.balls.available", lambda: False)
    monkeypatch.setattr("microfacet.__main__._record", lambda equation, kept: {"verdict": "pass", "message": "m", "marks": {}})
    assert main(["check", enclosed]) == 0
    assert capsys.readouterr().err == "python-flint is not installed: what 1 statements enclose was not checked.\n"
    assert main(["check", other]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("--alpha 0.3 --theta -5:10", "theta must"),
        ("--alpha -0.3:.2", "alpha must"),
        ("--alpha -.3", "alpha must"),
        ("--alpha 0.3 --ratio -1:2", "ratio must"),
        ("--alpha 0.3 --light -1:2", "light must"),
        ("--alpha 0.3 --fresnel 1", "fresnel must reflect light, which an index of 1 does not, got dielectric 1"),
        ("--alpha 0.3 --fresnel 1,0", "fresnel must reflect light, which an index of 1 does not, got conductor 1 + 0i"),
        ("--alpha 0.3 --fresnel 1,-1", "k must"),
        ("--alpha 0.3 --fresnel -1.5,2", "eta must"),
        ("--alpha 0.3 --chart x.gif", "chart must end in .svg, .pdf or .png, got 'x.gif'"),
        ("--alpha 0.3 --chart .", "chart must end in"),
        ("--alpha 0.3 --costs none.json", "costs must be a record of benchmarks, and there is no file none.json"),
        ("--alpha 0.3 --chart folder.svg", "folder.svg is a folder"),
    ],
)
def test_a_question_that_is_none_is_refused_at_once(
    words: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("microfacet.enough.choice.costs_now", lambda *_: pytest.fail("worked first"))
    Path("folder.svg").mkdir()
    assert main(["choose", *words.split()]) == 2
    said = capsys.readouterr().err
    assert is_one_sentence(said)
    assert sentence in said
