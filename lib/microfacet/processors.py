"""How many threads to use, and those threads. A module of its own, so that what only counts does not load what compiles."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import Any


def threads() -> int:
    """How many threads a large array is shared among: $MICROFACET_THREADS, else the processors this process may use.

    ValueError if that variable is no whole number.
    """
    chosen = os.environ.get("MICROFACET_THREADS")
    try:
        return max(1, int(chosen)) if chosen else len(os.sched_getaffinity(0))
    except ValueError:
        raise ValueError(f"MICROFACET_THREADS must be a whole number, got {chosen!r}") from None


def share(work: Callable[..., Any], jobs: Sequence[Iterable[Any]]) -> list[Any]:
    """What work(*job) returns for each job; that many threads, this one among them, take the next job while there is one."""
    results: list[Any] = [None] * len(jobs)
    waiting = iter(enumerate(jobs))

    def take() -> None:
        for place, job in waiting:
            results[place] = work(*job)

    helpers = min(threads(), len(jobs)) - 1
    others = [_pool(threads() - 1).submit(take) for _ in range(helpers)]
    try:
        take()
    finally:
        begun = [other for other in others if not other.cancel()]
        wait(begun)
    for other in begun:
        other.result()
    return results


@cache
def _pool(count: int) -> ThreadPoolExecutor:
    """Threads that stay for the next array: starting them takes longer than many an array does."""
    return ThreadPoolExecutor(count)


os.register_at_fork(after_in_child=_pool.cache_clear)  # threads are not inherited
