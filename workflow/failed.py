"""The message about a failed job: its output, or the last line of a traceback, or the signal that ended it.

python workflow/failed.py build/logs/gate.log 1        the log, and the exit status, which is passed on
"""

from __future__ import annotations

import signal
import sys
from pathlib import Path


def message(log: Path, status: int) -> str:
    text = log.read_text("utf-8", errors="replace").strip() if log.exists() else ""
    if status > 128:
        return f"{log}: the job was killed ({signal.Signals(status - 128).name}); start the build again"
    if "Traceback (most recent call last):" in text:
        return f"{log}: {text.splitlines()[-1]} (the log says where)"
    return f"{log}: {text or f'the job ended with status {status} and without a word'}"


if __name__ == "__main__":
    log, status = Path(sys.argv[1]), int(sys.argv[2])
    print(message(log, status), file=sys.stderr)
    sys.exit(status)
