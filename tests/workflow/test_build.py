"""The build does what it must, once, and says clearly why it cannot."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time

import pytest
from checkout import Checkout

pytestmark = pytest.mark.slow  # each starts whole builds

PDF, HTML = "build/report.pdf", "build/report.html"
PAGES = {f"report {PDF}", f"report {HTML}"}
STATEMENTS = "lib/microfacet/statements/statement.py"


def change_kernel(checkout: Checkout, kernel: str) -> None:
    """Give the statement visibility.G1, whose closed form is a, another kernel."""
    text = checkout.path(STATEMENTS).read_text("utf-8")
    checkout.path(STATEMENTS).write_text(re.sub(r'"a", "[^"]*"\)', f'"a", "{kernel}")', text), "utf-8")


def test_the_report_is_there_and_nothing_is_left_to_do(built: Checkout) -> None:
    assert built.path(PDF).read_bytes().startswith(b"%PDF")
    assert built.path(HTML).read_bytes().startswith(b"<!DOCTYPE html>")
    assert "Nothing to be done" in built.snakemake("-n").stdout


def test_lint_is_clean(built: Checkout) -> None:
    assert "good condition" in built.snakemake("--lint").stdout


def test_an_edited_drawing_redoes_itself_and_the_pages_only(built: Checkout) -> None:
    built.edit("figures/visibility/masking.py", "figsize=(6, 2.5)", "figsize=(6, 2.6)")
    assert built.jobs() == {"figure masking", "motion masking"} | PAGES


def test_an_edited_look_of_the_web_page_leaves_the_paper_alone(built: Checkout) -> None:
    built.edit("workflow/web.css", "color-scheme: light dark;", "color-scheme: light dark; /* both */")
    assert built.jobs() == {f"report {HTML}"}
    built.edit("workflow/web.css", " /* both */", "")
    assert built.jobs() == {f"report {HTML}"}


def test_an_edited_caption_redoes_its_chapter_too(built: Checkout) -> None:
    built.edit("figures/visibility/masking.py", "over the angle", "against the angle")
    assert built.jobs() == {"figure masking", "motion masking", "chapter 1_visibility"} | PAGES


def test_an_edited_kernel_redoes_its_own_check_only(built: Checkout) -> None:
    change_kernel(built, "a * 1")
    gate = {
        "check visibility: 2 statements",
        "checked no statement failed",
        "ledger build/ledger.json",
        "gate no statement failed or got worse",
    }
    assert built.jobs() == gate | PAGES


def test_an_edit_in_the_library_redoes_what_imports_it(built: Checkout) -> None:
    built.edit("lib/microfacet/geometry/ggx.py", "alpha * alpha", "alpha**2")
    assert built.jobs() == {"figure masking", "motion masking"} | PAGES


def test_a_failing_check_stops_the_report_but_not_the_figures(built: Checkout) -> None:
    change_kernel(built, "a + 1")
    built.path("build/figures/plain.svg").unlink()
    done = built.snakemake()
    assert done.returncode != 0
    assert "1 of 3 statements failed" in done.stdout
    assert "visibility.G1" in done.stdout
    assert "off by 1.0e+00" in done.stdout
    assert "build/logs/checked.log: No report: 1 of 3 statements failed" in done.stdout[-400:]
    assert not built.path(PDF).exists()
    assert not built.path(HTML).exists()
    assert built.path("build/figures/plain.svg").exists()
    change_kernel(built, "a")
    assert built.snakemake().returncode == 0


def test_a_statement_that_measurements_refute_stops_the_report(built: Checkout) -> None:
    tests = "lib/report/significance_tests.py"
    built.edit(tests, '"status": "pass", "detail": "1000 samples', '"status": "fail", "detail": "refuted: 1000 samples')
    done = built.snakemake()
    assert done.returncode != 0
    assert "1 of 3 statements failed" in done.stdout
    assert "visibility.G1; measured: refuted: 1000 samples" in done.stdout
    assert not built.path(PDF).exists()
    built.edit(tests, '"status": "fail", "detail": "refuted: 1000', '"status": "pass", "detail": "1000')
    assert built.snakemake().returncode == 0


def test_a_statement_worse_than_its_record_stops_the_report(built: Checkout) -> None:
    built.edit("records/ledger.json", '"claims": 1', '"claims": 2')
    done = built.snakemake()
    assert done.returncode != 0
    assert "2 statements are worse than records/ledger.json says" in done.stdout
    assert "symbolic: claims was 2, it is 1" in done.stdout
    assert not built.path(PDF).exists()
    built.edit("records/ledger.json", '"claims": 2', '"claims": 1')
    assert built.snakemake().returncode == 0


def test_a_moving_figure_moves_on_the_web_only(built: Checkout) -> None:
    built.edit("figures/visibility/masking.py", "80px", "70px")
    assert built.jobs("slide_38") == {"figure masking", "motion masking"}
    assert b"70px" in built.path("build/figures/masking.moving.svg").read_bytes()
    assert built.jobs() <= PAGES


def test_a_figure_is_drawn_by_name_and_by_slide(built: Checkout) -> None:
    for target, name in (("masking", "masking"), ("slide_42", "plain")):
        built.path(f"build/figures/{name}.png").unlink()
        assert f"figure {name}" in built.jobs(target)
        assert built.path(f"build/figures/{name}.png").exists()


@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ("maskin", "There is no figure or other target called 'maskin'. Did you mean masking"),
        ("slide_40", "There is no drawn slide called 'slide_40'. Did you mean"),
        ("build/figures/plan.svg", "There is no figure called 'plan'. Did you mean plain?"),
    ],
)
def test_an_unknown_target_is_one_sentence(built: Checkout, target: str, sentence: str) -> None:
    done = built.snakemake("-n", target)
    assert done.returncode != 0
    assert sentence in done.stdout
    assert "Traceback" not in done.stdout


def test_a_broken_chapter_names_its_place(built: Checkout) -> None:
    text = built.path("chapters/A_ledger.md").read_text("utf-8")
    built.edit("chapters/A_ledger.md", "ledger_table()", 'figure("maskin")')
    built.edit("chapters/A_ledger.md", "import ledger_table", "import figure")
    done = built.snakemake()
    built.path("chapters/A_ledger.md").write_text(text, "utf-8")
    assert "chapters/A_ledger.md, line 4" in done.stdout
    assert "There is no figure called 'maskin'. Did you mean masking?" in done.stdout
    assert not built.path(PDF).exists()
    assert built.snakemake().returncode == 0


@pytest.mark.parametrize("config", ["surfaces=1", "range=0", "surfaces=many"])
def test_a_campaign_that_cannot_be_is_one_sentence(built: Checkout, config: str) -> None:
    done = built.snakemake("--config", config)
    assert done.returncode != 0
    assert "--config takes surfaces=N, at least 2, and range=N, at least 1; got" in done.stdout
    assert "Traceback" not in done.stdout


def test_another_gate_is_another_verdict(built: Checkout) -> None:
    built.edit("workflow/ledger.py", "SLACK = 1.25", "SLACK = 1.26")
    gate = {"checked no statement failed", "ledger build/ledger.json", "gate no statement failed or got worse"}
    assert gate <= built.jobs()


def test_other_versions_of_what_is_installed_redo_what_was_computed_with_it(built: Checkout) -> None:
    built.edit("requirements.lock", "numba==", "numba === ")
    assert {"data masking", "figure masking", "chapter 1_visibility"} <= built.jobs("-n")
    built.edit("requirements.lock", "numba === ", "numba==")


def same_bytes(one: Checkout, other: Checkout) -> bool:
    drawn = [f"build/figures/masking.{ending}" for ending in ("svg", "pdf", "png")]
    return all(one.path(name).read_bytes() == other.path(name).read_bytes() for name in (PDF, HTML, *drawn))


def take_over(built: Checkout, small: Checkout) -> None:
    """What the tests before this one have made of the sources."""
    for name in ("lib", "figures", "chapters", "workflow"):
        subprocess.run(["cp", "-R", str(built.path(name)), str(small.root)], check=True)


def test_two_checkouts_give_the_same_bytes(built: Checkout, small: Checkout) -> None:
    assert built.snakemake().returncode == 0
    take_over(built, small)
    assert small.snakemake().returncode == 0
    assert same_bytes(small, built)


@pytest.mark.parametrize("orphans", [False, True], ids=["with its jobs", "alone"])
@pytest.mark.parametrize("moment", ["build/checks/geometry.json", "build/ledger.json"])
def test_a_killed_build_resumes_and_ends_in_the_same_report(
    built: Checkout, small: Checkout, moment: str, orphans: bool
) -> None:
    assert built.snakemake().returncode == 0
    take_over(built, small)
    command = [sys.executable, "-m", "snakemake", "--cores", "2"]
    process = subprocess.Popen(command, cwd=small.root, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               start_new_session=True)  # fmt: skip
    while not small.path(moment).exists():
        time.sleep(0.05)
    (os.kill if orphans else os.killpg)(process.pid, signal.SIGKILL)
    process.wait()
    done = small.snakemake()
    assert done.returncode == 0, done.stdout
    assert same_bytes(small, built)
