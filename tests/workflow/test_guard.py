"""What a build made and somebody or something changed since is named and made again; what cannot be is named and stops it."""

from __future__ import annotations

import base64
import fcntl
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import build
import guard
import inventory
import pytest
import seal
from checkout import Checkout

PRODUCTS = (
    "build/report.pdf",
    "build/report.html",
    "build/gate",
    "build/checked",
    "build/ledger.json",
    "build/measured.json",
    "build/checks/geometry.json",
    "build/data/masking.npz",
    "build/figures/masking.svg",
    "build/figures/masking.pdf",
    "build/figures/masking.png",
    "build/figures/masking.moving.svg",
    "build/chapters/1_visibility.md",
    "build/chapters/1_visibility.typ",
)


def tear(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def alter(path: Path) -> None:
    """One bit of one byte; size and date stay."""
    kept, content = path.stat(), bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    os.utime(path, ns=(kept.st_atime_ns, kept.st_mtime_ns))


def empty(path: Path) -> None:
    path.write_bytes(b"")


def lengthen(path: Path) -> None:
    path.write_bytes(path.read_bytes() + b"\n")


def unseal(path: Path) -> None:
    seal.place(path).unlink()


def forge(path: Path) -> None:
    seal.place(path).write_bytes(b"\xff\x00")


FAULTS = (tear, alter, empty, lengthen, unseal, forge)


@pytest.fixture
def made(small: Checkout) -> Checkout:
    """A checkout with something in the place of everything that a build makes, sealed."""
    for name in PRODUCTS:
        small.path(name).parent.mkdir(parents=True, exist_ok=True)
        small.path(name).write_text(f"what became of {name}")
    seal.put(map(Path, PRODUCTS))
    return small


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("name", PRODUCTS)
def test_each_file_that_was_changed_is_named_and_marked(
    made: Checkout, name: str, fault: Callable[[Path], None], capsys: pytest.CaptureFixture[str]
) -> None:
    fault(Path(name))
    guard.compare(PRODUCTS, building=False)
    assert capsys.readouterr().err == f"{name}: is not what its job made (torn, altered or unfinished), to be made again.\n"
    assert marked() == [name]
    assert Path(name).exists()
    guard.compare(PRODUCTS, building=True)
    assert [other for other in PRODUCTS if not Path(other).exists()] == ([name] if "report" in name else [])


def marked() -> list[str]:
    """The files that snakemake will take for unfinished."""
    folder = Path(".snakemake/incomplete")
    return sorted(base64.urlsafe_b64decode(path.name).decode() for path in folder.iterdir()) if folder.exists() else []


def test_what_is_whole_or_gone_is_left_alone(made: Checkout, capsys: pytest.CaptureFixture[str]) -> None:
    Path("build/gate").unlink()
    Path("build/mine.txt").write_text("not the build's")
    Path("build/figures/mine.svg").write_text("not the build's")
    guard.compare(PRODUCTS, building=True)
    assert capsys.readouterr().err == ""
    assert marked() == []
    assert Path("build/mine.txt").exists()
    assert Path("build/figures/mine.svg").exists()


def folder(path: Path) -> None:
    path.mkdir()
    (path / "mine").touch()


KINDS = {
    "a symbolic link": lambda path: path.symlink_to("elsewhere"),
    "a folder": folder,
    "a pipe": os.mkfifo,
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PRODUCTS)
def test_what_is_no_file_in_the_place_of_one_stops_the_build(made: Checkout, name: str, kind: str) -> None:
    Path("build/elsewhere").write_text("kept")
    Path(name).unlink()
    KINDS[kind](Path(name))
    with pytest.raises(SystemExit, match=f"{name} is {kind}: an output file replaces plain files only. Move it away."):
        guard.compare(PRODUCTS, building=True)
    assert os.path.lexists(name)


def test_a_range_of_surfaces_without_a_seal_counts_if_it_is_whole(small: Checkout) -> None:
    from report.datafile import store

    good, bad = (Path(f"build/campaign/gabor_07/{span}.npz") for span in ("0-16", "16-32"))
    for path in (good, bad):
        store(str(path), heights=[1.0, 2.0])
    tear(bad)
    guard.compare([str(good), str(bad)], building=True)
    assert marked() == [str(bad)]
    assert seal.read(good) == seal.digest(good)
    alter(good)
    guard.compare([str(good)], building=True)
    assert marked() == [str(good), str(bad)]
    assert good.exists()


@pytest.mark.parametrize(
    ("words", "building"),
    [
        ([], True),
        (["masking", "slide_39"], True),
        (["--cores", "4", "--config", "surfaces=400"], True),
        (["-n"], False),
        (["--dry-run", "masking"], False),
        (["-np"], False),
        (["--cores", "2", "-n"], False),
        (["--lint"], False),
        (["--report", "archive.html"], False),
        (["--summary"], False),
        (["--list"], False),
        (["--unlock"], False),
        (["--touch"], False),
        (["--dag"], False),
    ],
)
def test_a_look_is_no_build(words: list[str], building: bool) -> None:
    assert guard.builds(words) is building


def test_what_is_kept_between_builds_is_not_believed_once_it_is_changed(small: Checkout) -> None:
    from microfacet.files import keep, recall

    path = Path("build/kept.json")
    assert recall(path) is None
    keep(path, {"λ": [1, 2.5, None]})
    whole = path.read_bytes()
    assert recall(path) == {"λ": [1, 2.5, None]}
    for place in range(len(whole)):
        path.write_bytes(whole[:place])
        assert recall(path) is None
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        assert recall(path) is None


def test_a_fault_of_the_sources_takes_the_old_report_away(made: Checkout, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("figures/visibility/plain.py").write_text("def")
    with pytest.raises(SystemExit, match=r"plain\.py, line 1: "):
        inventory.figures()
    assert Path("build/report.pdf").exists()
    monkeypatch.setattr(inventory, "withdrawn", list(guard.REPORTS))
    with pytest.raises(SystemExit, match=r"plain\.py, line 1: "):
        inventory.figures()
    assert not Path("build/report.pdf").exists()
    assert not Path("build/report.html").exists()


# Whole builds ----------------------------------------------------------------------------------


def remembered(checkout: Checkout) -> dict[str, bytes]:
    return {name: checkout.path(name).read_bytes() for name in PRODUCTS}


@pytest.mark.slow
@pytest.mark.usefixtures("within")
def test_every_product_of_a_build_is_sealed() -> None:
    assert set(map(str, seal.sealed())) == set(build.products())
    assert seal.broken(map(Path, build.products())) == []


@pytest.mark.slow
@pytest.mark.parametrize("fault", [alter, unseal])
def test_a_build_ends_in_the_same_bytes_whatever_was_done_to_the_last_one(
    within: Checkout, fault: Callable[[Path], None]
) -> None:
    before = remembered(within)
    for name in PRODUCTS:
        fault(Path(name))
    assert "are not what their jobs made (torn, altered or unfinished), to be made again" in within.snakemake("-n").stdout
    done = within.snakemake()
    assert done.returncode == 0, done.stdout
    assert "Traceback" not in done.stdout
    assert remembered(within) == before
    assert "Nothing to be done" in within.snakemake().stdout


@pytest.mark.slow
def test_a_torn_report_is_set_again_and_nothing_else_is_done(built: Checkout) -> None:
    before = remembered(built)
    tear(built.path("build/report.pdf"))
    assert built.jobs() == {"report build/report.pdf"}
    assert remembered(built) == before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["build/data/masking.npz", "build/measured.json", "build/chapters/1_visibility.md"])
def test_what_is_torn_before_the_end_is_made_again_though_the_report_stands(built: Checkout, name: str) -> None:
    before = remembered(built)
    tear(built.path(name))
    done = built.snakemake()
    assert f"{name}: is not what its job made" in done.stdout
    assert done.returncode == 0, done.stdout
    assert remembered(built) == before


@pytest.mark.slow
def test_what_one_figure_needs_is_looked_at_too(built: Checkout) -> None:
    before = remembered(built)
    tear(built.path("build/data/masking.npz"))
    tear(built.path("build/gate"))
    assert built.jobs("masking") == {"data masking", "figure masking", "motion masking"}
    done = built.snakemake()
    assert "build/gate: is not what its job made" in done.stdout
    assert done.returncode == 0, done.stdout
    assert remembered(built) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("records/ledger.json", None, "records/ledger.json is missing: `git checkout records/ledger.json` brings it back."),
        ("records/ledger.json", "", "records/ledger.json is missing, torn or empty"),
        ("records/ledger.json", "[]", "records/ledger.json is missing, torn or empty"),
        ("chapters/references.bib", None, "chapters/references.bib is missing: `git checkout"),
        ("requirements.lock", None, "requirements.lock is missing: `git checkout"),
        ("chapters/1_visibility.md", "\udcff", "chapters/1_visibility.md is no text in UTF-8"),
        ("figures/visibility/plain.py", "\udcff", "figures/visibility/plain.py is no text in UTF-8"),
        ("lib/microfacet/geometry/ggx.py", "\udcff", "The library in lib/ cannot state its equations: "),
        ("lib/microfacet/geometry/ggx.py", "def", "lib/microfacet/geometry/ggx.py, line 1: "),
        ("lib/microfacet/__init__.py", "def", "lib/microfacet/__init__.py, line 1: "),
        ("figures/visibility/plain.py", "def", "figures/visibility/plain.py, line 1: "),
    ],
)
def test_a_source_that_is_gone_or_broken_takes_the_report_away(
    built: Checkout, name: str, text: str | None, sentence: str
) -> None:
    kept, dates = built.path(name).read_text("utf-8"), built.path(name).stat()
    if text is None:
        built.path(name).unlink()
    else:
        built.path(name).write_text(text, "utf-8", errors="surrogateescape")
        os.utime(built.path(name), ns=(0, 0))  # older than all that was made of it
    done = built.snakemake()
    built.path(name).write_text(kept)
    os.utime(built.path(name), ns=(dates.st_atime_ns, dates.st_mtime_ns))
    assert done.returncode != 0
    assert sentence in done.stdout
    assert "Traceback" not in done.stdout
    assert not built.path("build/report.pdf").exists()
    assert not built.path("build/report.html").exists()
    assert built.snakemake().returncode == 0


@pytest.mark.slow
def test_jobs_that_are_killed_or_break_are_named_without_a_traceback(built: Checkout) -> None:
    broken = {"plain": "import os\nos.kill(os.getpid(), 9)\n", "masking": "1 / 0\n"}
    kept = {name: built.path(f"figures/visibility/{name}.py").read_text() for name in broken}
    for name, code in broken.items():
        built.path(f"figures/visibility/{name}.py").write_text(kept[name] + code)
    done = built.snakemake()
    for name, text in kept.items():
        built.path(f"figures/visibility/{name}.py").write_text(text)
    assert done.returncode != 0
    assert "Traceback" not in done.stdout
    end = done.stdout[done.stdout.rindex("Exiting because a job execution failed") :]
    assert "build/logs/figure/plain.log: the job was killed (SIGKILL); start the build again\n" in end
    assert "build/logs/figure/masking.log: ZeroDivisionError: division by zero (the log says where)\n" in end
    assert not built.path("build/report.pdf").exists()
    assert built.snakemake().returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["build/chapters/1_visibility.typ", "build/figures/masking.svg", "build/ledger.json"])
def test_what_is_torn_while_the_report_is_set_is_named_itself(built: Checkout, name: str) -> None:
    whole = built.path(name).read_bytes()
    tear(built.path(name))
    words = ["build/other.pdf", "--version=1", "--commit=a", "--tree=clean"]
    done = subprocess.run(
        [sys.executable, "workflow/typeset.py", *words], cwd=built.root, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": "lib"},
    )  # fmt: skip
    built.path(name).write_bytes(whole)
    assert done.returncode == 1
    sentence = f"{name}: torn or altered since it was made; start the build again, and it is made again"
    assert done.stderr.strip() == sentence


@pytest.mark.slow
def test_a_misspelt_setting_is_refused(built: Checkout) -> None:
    done = built.snakemake("--config", "rnage=4")
    assert done.returncode != 0
    assert "There is no setting called 'rnage'. Did you mean range?" in done.stdout
    assert built.path("build/report.pdf").exists()


@pytest.mark.slow
def test_a_build_beside_another_is_one_sentence(built: Checkout) -> None:
    with built.path(".snakemake/turn").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        for words in ([], ["-n"], ["masking"]):
            done = built.snakemake(*words)
            assert done.returncode != 0
            assert "Another build is running in this checkout: wait for it to end." in done.stdout
            assert "Building DAG" not in done.stdout
        assert "good condition" in built.snakemake("--lint").stdout


def test_drawings_are_the_stills_of_all_and_the_moving_ones_of_those_that_move(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(__file__).resolve().parents[2])
    figures = inventory.figures()
    moving = {f"build/figures/{name}.moving.svg" for name, one in figures.items() if one.moves}
    assert 0 < len(moving) < len(figures)
    drawn = build.drawings(list(figures))
    assert {path for path in drawn if path.endswith(".moving.svg")} == moving
    assert len(drawn) == len(set(drawn)) == len(moving) + len(build.ENDINGS) * len(figures)
