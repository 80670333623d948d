"""How many threads to use. A module of its own, so that what only counts threads does not depend on what compiles."""

from __future__ import annotations

import os


def threads() -> int:
    """How many threads a large array is shared among: $MICROFACET_THREADS, else the processors this process may use."""
    chosen = os.environ.get("MICROFACET_THREADS")
    return max(1, int(chosen)) if chosen else len(os.sched_getaffinity(0))
