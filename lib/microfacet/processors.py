"""How many threads to use, and those threads. A module of its own, so that what only counts does not load what compiles."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any


def threads() -> int:
    """How many threads a large array is shared among: $MICROFACET_THREADS, else the processors this process may use."""
    chosen = os.environ.get("MICROFACET_THREADS")
    return max(1, int(chosen)) if chosen else len(os.sched_getaffinity(0))


def share(work: Callable[..., Any], jobs: Sequence[Iterable[Any]]) -> list[Any]:
    """What work(*job) returns for each job, by that many threads; one job alone is not handed to another thread."""
    if len(jobs) == 1 or threads() == 1:
        return [work(*job) for job in jobs]
    return [done.result() for done in [_pool(threads()).submit(work, *job) for job in jobs]]


@cache
def _pool(count: int) -> ThreadPoolExecutor:
    """Threads that stay for the next array: starting them takes longer than many an array does."""
    return ThreadPoolExecutor(count)


os.register_at_fork(after_in_child=_pool.cache_clear)  # threads are not inherited
