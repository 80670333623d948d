"""How many threads to use, and a pool of them. A module of its own, so that a caller who only counts threads loads no compiler.

Python handles an interrupt (Ctrl-C) when the main thread returns from compiled code. So work is done in pieces of some
hundredths of a second, and when one thread stops, for whatever reason, the others take no further piece.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache
from itertools import pairwise
from threading import Lock, Thread
from time import perf_counter
from typing import Any

QUICK = 1e-4  # seconds: to hand less work than this to another thread takes longer than to do it
PIECE = 0.02  # seconds that a piece should take at most
STRIPS = 4  # parts of an array that are processed in turn, since one may take much longer per element than the others


def threads() -> int:
    """How many threads work on a large array: $MICROFACET_THREADS, else the number of processors this process may use.

    ValueError if that variable is not a whole number.
    """
    chosen = os.environ.get("MICROFACET_THREADS")
    try:
        return max(1, int(chosen)) if chosen else _processors()
    except ValueError:
        raise ValueError(f"MICROFACET_THREADS must be a whole number, got {chosen!r}") from None


def _processors() -> int:
    """The number that this process may use; that of the machine where the system does not report it."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def parallel_map(work: Callable[..., Any], jobs: Sequence[Iterable[Any]]) -> list[Any]:
    """The results of work(*job) for all jobs, in their order; the jobs run on several threads, this one among them."""
    results: list[Any] = [None] * len(jobs)
    waiting = iter(range(len(jobs)))

    def step() -> bool:
        if (place := next(waiting, None)) is None:
            return False
        results[place] = work(*jobs[place])
        return True

    _together(step, min(threads(), len(jobs)) - 1)
    return results


def _together(step: Callable[[], bool], helpers: int) -> None:
    """Call step() again and again, in this thread and in helpers, until it returns False or any of them fails."""
    stopped: list[bool] = []
    others: list[Future[None]] = []

    def go() -> None:
        try:
            while not stopped and step():
                pass
        finally:
            stopped.append(True)

    try:
        others.extend(_pool(threads() - 1).submit(go) for _ in range(helpers))
        go()
    finally:
        stopped.append(True)  # an interrupt may come at any place
        begun = [other for other in others if not other.cancel()]
        wait(begun)
    for other in begun:
        other.result()


def in_own_thread(work: Callable[[], Any]) -> Any:
    """The result of work(), run in a thread of its own, so that an interrupt ends the wait for it, though not the work.

    For work that cannot be split into pieces, such as compiling.
    """
    result: list[Any] = []
    failed: list[BaseException] = []

    def go() -> None:
        try:
            result.append(work())
        except BaseException as error:
            failed.append(error)

    thread = Thread(target=go, daemon=True)
    thread.start()
    thread.join()
    if failed:
        raise failed[0]
    return result[0]


@cache
def _pool(count: int) -> ThreadPoolExecutor:
    """Threads that stay alive for the next array: to start them takes longer than to process a small array."""
    return ThreadPoolExecutor(count)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # threads are not inherited


# --- arrays -----------------------------------------------------------------------------------------------------------


class Pace:
    """How many seconds a loop takes per element: measured in its last call; before the first call, the time of a whole piece.

    least: a lower bound of the estimate, since the next element may be slower. certain: whether the last call was so long that
    its overhead does not matter.
    """

    def __init__(self, least: float) -> None:
        self.least, self.seconds, self.certain = least, PIECE, False

    def update(self, count: int, seconds: float) -> None:
        self.seconds, self.certain = max(seconds / count, self.least), seconds > QUICK / 2


class _Strip:
    """A part of an array: the range that is not begun yet, and its pace."""

    def __init__(self, start: int, stop: int, pace: float) -> None:
        self.start, self.stop, self.pace = start, stop, pace
        self.done, self.seconds = 0, 0.0


class _Strips:
    """An array in strips; each thread takes one piece after another, from the strips in turn.

    The pace of the slowest unfinished strip limits how many elements a piece may have.
    """

    def __init__(self, work: Callable[[int, int], bool], count: int, pace: Pace) -> None:
        self.work, self.left, self.pace, self.good, self.lock = work, count, pace, True, Lock()
        self.threads = threads()
        number = 1 if pace.certain and count * pace.seconds < PIECE else min(STRIPS, count)
        edges = (count * k // number for k in range(number + 1))
        self.strips = [_Strip(start, stop, pace.seconds) for start, stop in pairwise(edges)]
        self.waiting = deque(self.strips)

    def step(self) -> bool:
        """Do a piece; False if there is none left."""
        with self.lock:
            if not self.waiting:
                return False
            size = self._size()
            strip = self.waiting.popleft()
            start = strip.start
            stop = strip.start = min(strip.stop, start + size)
            self.left -= stop - start
            if stop < strip.stop:
                self.waiting.append(strip)
        began = perf_counter()
        good = self.work(start, stop)
        took = perf_counter() - began
        with self.lock:
            self.good &= good
            strip.done, strip.seconds = strip.done + stop - start, strip.seconds + took
            strip.pace = max(took / (stop - start), strip.seconds / strip.done, self.pace.least)
        return True

    def _size(self) -> int:
        pace = self.slowest()
        fair = max(QUICK / 2 / pace, self.left / (4 * self.threads)) if self.threads > 1 else self.left
        return max(1, int(min(PIECE / pace, fair)))

    def slowest(self) -> float:
        return max((strip.pace for strip in self.waiting), default=self.pace.least)

    def rest(self) -> float:
        """Estimated seconds for the elements that are not begun yet."""
        return self.left * self.slowest()

    def finish(self) -> bool:
        """Record the pace of the slowest strip; return whether all pieces succeeded."""
        slowest = max(self.strips, key=lambda strip: strip.seconds / strip.done)
        self.pace.update(slowest.done, slowest.seconds)
        return self.good


def spread(work: Callable[[int, int], bool], count: int, pace: Pace) -> bool:
    """Whether work(start, stop) succeeded all over range(count), count > 0; several threads take part if it takes long enough.

    While the pace is not known, this thread works alone for a moment.
    """
    strips = _Strips(work, count, pace)
    alone = perf_counter() + (0.0 if pace.certain else QUICK)
    while strips.rest() < 2 * QUICK or perf_counter() < alone:
        if not strips.step():
            return strips.finish()
    _together(strips.step, min(strips.threads - 1, int(strips.rest() / QUICK)))
    return strips.finish()
