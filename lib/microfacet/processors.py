"""How many threads to use, and those threads. A module of its own, so that what only counts does not load what compiles.

An interrupt (Ctrl-C) is seen when the main thread gets back from compiled code. So work is done in pieces of some
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

QUICK = 1e-4  # seconds: to give less than this to another thread would take longer than to do it
PIECE = 0.02  # seconds that a piece should take at most
STRIPS = 4  # parts of an array that are begun at once, for one may hold what takes much longer than the rest


def threads() -> int:
    """How many threads a large array is shared among: $MICROFACET_THREADS, else the processors this process may use.

    ValueError if that variable is no whole number.
    """
    chosen = os.environ.get("MICROFACET_THREADS")
    try:
        return max(1, int(chosen)) if chosen else _processors()
    except ValueError:
        raise ValueError(f"MICROFACET_THREADS must be a whole number, got {chosen!r}") from None


def _processors() -> int:
    """Those this process may use; all where the system does not tell."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share(work: Callable[..., Any], jobs: Sequence[Iterable[Any]]) -> list[Any]:
    """What work(*job) returns for each job; that many threads, this one among them, take the next job while there is one."""
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


def apart(work: Callable[[], Any]) -> Any:
    """What work() returns, from a thread of its own, so that an interrupt ends the wait for it though the work goes on.

    For what cannot be done in pieces, such as compiling.
    """
    found: list[Any] = []
    failed: list[BaseException] = []

    def go() -> None:
        try:
            found.append(work())
        except BaseException as error:
            failed.append(error)

    thread = Thread(target=go, daemon=True)
    thread.start()
    thread.join()
    if failed:
        raise failed[0]
    return found[0]


@cache
def _pool(count: int) -> ThreadPoolExecutor:
    """Threads that stay for the next array: starting them takes longer than many an array does."""
    return ThreadPoolExecutor(count)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # threads are not inherited


# --- arrays -----------------------------------------------------------------------------------------------------------


class Pace:
    """How long a loop takes for an element, in seconds: what its last call took, and at the beginning a whole piece.

    least: no element is taken for quicker, since the next one may take so long. certain: whether that call was long enough
    for its beginning and end not to count.
    """

    def __init__(self, least: float) -> None:
        self.least, self.seconds, self.certain = least, PIECE, False

    def update(self, count: int, seconds: float) -> None:
        self.seconds, self.certain = max(seconds / count, self.least), seconds > QUICK / 2


class _Strip:
    """A part of an array: what of it is not begun yet, and how fast it goes."""

    def __init__(self, start: int, stop: int, pace: float) -> None:
        self.start, self.stop, self.pace = start, stop, pace
        self.done, self.seconds = 0, 0.0


class _Strips:
    """An array, of which each thread takes a piece at a time, from one strip after another.

    The slowest of the strips that are under way says how many elements a piece may have.
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
        """Seconds that what is not begun yet should take."""
        return self.left * self.slowest()

    def finish(self) -> bool:
        """Remember how long it took; whether all went well."""
        slowest = max(self.strips, key=lambda strip: strip.seconds / strip.done)
        self.pace.update(slowest.done, slowest.seconds)
        return self.good


def spread(work: Callable[[int, int], bool], count: int, pace: Pace) -> bool:
    """Whether work(start, stop) went well all over range(count), count > 0, which threads share if it takes long enough.

    While it is not known how long it takes, this thread does a little alone.
    """
    strips = _Strips(work, count, pace)
    alone = perf_counter() + (0.0 if pace.certain else QUICK)
    while strips.rest() < 2 * QUICK or perf_counter() < alone:
        if not strips.step():
            return strips.finish()
    _together(strips.step, min(strips.threads - 1, int(strips.rest() / QUICK)))
    return strips.finish()
