"""What a person is told of a job that failed is one sentence, and where the log is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import build
import pytest

ROOT = Path(__file__).resolve().parents[2]
TRACE = 'Traceback (most recent call last):\n  File "x.py", line 1\nZeroDivisionError: division by zero\n'
SAID = {
    "\nNo report: 1 failed.\n  a\n": (1, "{log}: No report: 1 failed.\n  a"),
    TRACE: (1, "{log}: ZeroDivisionError: division by zero (the log says where)"),
    "a warning\n" + TRACE: (1, "{log}: ZeroDivisionError: division by zero (the log says where)"),
    "": (3, "{log}: the job ended with status 3 and without a word"),
    "no signal": (128, "{log}: no signal"),
    "half of": (137, "{log}: the job was killed (SIGKILL); start the build again"),
}


@pytest.mark.parametrize("text", SAID)
def test_what_a_failed_job_said_is_told_at_once_and_at_the_end(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, (status, sentence) = tmp_path / "job.log", SAID[text]
    log.write_text(text)
    command = [sys.executable, str(ROOT / "workflow/failed.py"), str(log), str(status)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (status, sentence.format(log=log) + "\n")
    told = tmp_path / "snakemake.log"
    told.write_text(
        f"Command 'set -euo pipefail;  python x.py {log.with_name('other')} 2> {log} || python' "
        f"returned non-zero exit status {status}.\nError in rule x:\n    log: {log} (check log file(s) for error details)\n"
    )
    build.repeat_failures([str(told)])
    assert capsys.readouterr().err == sentence.format(log=log).splitlines()[0] + "\n"


def test_every_rule_seals_what_it_made_and_says_why_it_failed() -> None:
    texts = [(ROOT / name).read_text() for name in ("Snakefile", "workflow/campaign.smk")]
    shells = [part.split("\n\n")[0] for text in texts for part in text.split("    shell:\n")[1:]]
    ending = '" && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"'
    assert len(shells) == 12
    assert [shell for shell in shells if not shell.rstrip().endswith(ending)] == []
