"""Work is shared among threads: each job is done once, results keep their order, no error is lost, interrupts are seen soon."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from microfacet.compiler import processors
from microfacet.compiler.batch import LONG, QUICKEST, Batch
from microfacet.compiler.processors import PIECE, QUICK, Pace, in_own_thread, parallel_map, spread, threads


@pytest.mark.parametrize("count", ["1", "2", "5"])
@pytest.mark.parametrize("jobs", [0, 1, 2, 40])
def test_results_come_in_the_order_of_the_jobs(count: str, jobs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", count)
    done: list[int] = []
    assert parallel_map(lambda k: done.append(k) or 2 * k, [(k,) for k in range(jobs)]) == [2 * k for k in range(jobs)]
    assert sorted(done) == list(range(jobs))


def test_jobs_run_beside_one_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "3")
    meeting = threading.Barrier(3, timeout=20)
    parallel_map(lambda: meeting.wait(), [()] * 3)


@pytest.mark.parametrize("bad", [0, 7])
def test_an_error_reaches_the_caller(bad: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "2")

    def work(k: int) -> None:
        time.sleep(0.001)
        if k == bad:
            raise ValueError(f"job {k}")

    with pytest.raises(ValueError, match=f"job {bad}"):
        parallel_map(work, [(k,) for k in range(8)])


@pytest.mark.parametrize("count", ["1", "3"])
def test_after_an_error_no_further_job_is_begun(count: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", count)
    begun: list[int] = []

    def work(k: int) -> None:
        begun.append(k)
        time.sleep(0.01)
        if k == 3:
            raise ValueError

    with pytest.raises(ValueError, match=r"^$"):
        parallel_map(work, [(k,) for k in range(100)])
    assert 3 < len(begun) + 1 <= 4 + 2 * int(count)


def test_jobs_may_share_jobs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "2")
    sums = parallel_map(lambda k: sum(parallel_map(lambda j: j, [(k + j,) for j in range(4)])), [(k,) for k in range(6)])
    assert sums == [4 * k + 6 for k in range(6)]


def test_the_number_of_threads_can_be_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "7")
    assert threads() == 7
    monkeypatch.delenv("MICROFACET_THREADS")
    assert threads() >= 1


def test_where_the_system_does_not_tell_all_processors_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MICROFACET_THREADS", raising=False)
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 5)
    assert threads() == 5
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert threads() == 1


def test_a_number_of_threads_that_is_none_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "abc")
    with pytest.raises(ValueError, match="MICROFACET_THREADS must be a whole number, got 'abc'"):
        threads()


# --- arrays -----------------------------------------------------------------------------------------------------------


@given(count=st.integers(1, 3000), number=st.sampled_from(["1", "2", "5"]), known=st.sampled_from([1e-9, 1e-6, 1e-4, PIECE]))
@example(count=8, number="1", known=PIECE)
def test_every_element_is_done_once(count: int, number: str, known: float) -> None:
    done = np.zeros(count, int)
    pace = Pace(QUICKEST)

    def work(start: int, stop: int) -> bool:
        done[start:stop] += 1
        return not start <= bad < stop

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MICROFACET_THREADS", number)
        for bad in (-1, 0, count - 1):
            done[:], pace.seconds = 0, known
            assert spread(work, count, pace) is (bad < 0)
            assert (done == 1).all()


class Clock:
    """Time that passes only while elements are worked on, and CALL for each piece."""

    CALL = 1e-6

    def __init__(self, cost: np.ndarray) -> None:
        self.sums, self.now, self.pieces = np.append(0.0, np.cumsum(cost)), 0.0, list[float]()

    def __call__(self) -> float:
        return self.now

    def work(self, start: int, stop: int) -> bool:
        took = self.CALL + float(self.sums[stop] - self.sums[start])
        self.pieces.append(took)
        self.now += took
        return True


def mixed(count: int, low: float, high: float, order: str) -> np.ndarray:
    """What each element costs: half of them `low`, half `high`."""
    share = {
        "cheap first": np.arange(count) >= count // 2,
        "dear first": np.arange(count) < count // 2,
        "in turn": np.arange(count) % 2 == 0,
        "in blocks": np.arange(count) // 100 % 2 == 0,
    }[order]
    return np.where(share, high, low)


@pytest.mark.parametrize("order", ["cheap first", "dear first", "in turn", "in blocks"])
@pytest.mark.parametrize(
    ("count", "high"),
    [(10, 1e-2), (1000, 1e-2), (1000, 1e-5), (1000, 1e-7), (20000, 1e-3), (10**6, 1e-5), (10**6, 1e-7), (3 * 10**6, 1e-9)],
)
def test_no_piece_is_long_and_few_are_short(count: int, high: float, order: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever an element takes, whatever the call before has seen, and wherever those stand that take long."""
    least = LONG if high > LONG else QUICKEST
    pace = Pace(least)
    monkeypatch.setenv("MICROFACET_THREADS", "1")
    for low in (high, max(high / 1e6, 1e-9), high):
        clock = Clock(mixed(count, low, high, order))
        monkeypatch.setattr(processors, "perf_counter", clock)
        known = pace.seconds
        assert spread(clock.work, count, pace)
        assert max(clock.pieces) < 10 * PIECE
        total = clock.now - Clock.CALL * len(clock.pieces)
        longest = total if known == PIECE else max(total, known * count)
        assert len(clock.pieces) < 100 + min(count, 20 * longest / PIECE + longest / QUICK / 10)


def test_few_long_elements_are_shared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "3")
    seen: set[int] = set()

    def work(start: int, stop: int) -> bool:
        time.sleep(0.003 * (stop - start))
        seen.add(threading.get_ident())
        return True

    assert spread(work, 60, Pace(LONG))
    assert len(seen) == 3


def test_little_is_not_shared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another thread would take longer to begin."""
    monkeypatch.setattr(processors, "_together", None)
    monkeypatch.setenv("MICROFACET_THREADS", "3")
    pace = Pace(QUICKEST)
    for _ in range(3):
        clock = Clock(np.full(1000, 2e-8))
        monkeypatch.setattr(processors, "perf_counter", clock)
        assert spread(clock.work, 1000, pace)


def tripled(x: float, p: Any) -> float:
    return 3.0 * x


def test_a_short_call_is_one_call_of_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    batch, x = Batch(tripled, [1]), np.arange(1000.0)
    for _ in range(20):  # until a quiet moment shows how quick it is
        batch([x])
    monkeypatch.setattr("microfacet.compiler.batch.spread", None)
    np.testing.assert_array_equal(batch([x]), 3 * x)


# --- interrupts -------------------------------------------------------------------------------------------------------


def test_what_is_done_apart_comes_back() -> None:
    assert in_own_thread(lambda: 3) == 3
    with pytest.raises(ValueError, match="wrong"):
        in_own_thread(lambda: int("wrong"))


WAITING = """
import os, signal, threading, time
from microfacet.compiler.processors import in_own_thread

signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background of a shell ignores it

def interrupt():
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGINT)

threading.Thread(target=interrupt).start()
begin = time.perf_counter()
try:
    in_own_thread(lambda: time.sleep(60))
except KeyboardInterrupt:
    print(time.perf_counter() - begin)
"""


def test_the_wait_for_what_is_done_apart_ends_at_an_interrupt() -> None:
    """And so does the process: compiling that is under way does not keep it."""
    begin = time.perf_counter()
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2] / "lib")}
    done = subprocess.run([sys.executable, "-c", WAITING], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert 0.4 < float(done.stdout) < 1.5
    assert time.perf_counter() - begin < 30


INTERRUPTED = """
import json, os, signal, sys, threading, time
import numpy as np
import microfacet as mf
from microfacet.surface.height_field import HeightField

signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background of a shell ignores it

def directions(n):
    z, phi = np.random.default_rng(n).random((2, n)) * [[1.0], [7.0]]
    return np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], -1)

def rising(n):
    theta = np.linspace(np.pi, 0, n)
    return np.stack([np.sin(theta), 0 * theta, np.cos(theta)], -1)

brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3)))
steps = mf.RandomWalk(brdf.model)
w, many = directions(4), directions(1000000)
rough = HeightField(np.random.default_rng(0).normal(size=(1024, 1024)))
places = np.random.default_rng(1).random((2000000, 3)) * [1024, 1024, 0] + [0, 0, 6]
rays = places, many.repeat(2, 0) * [1, 1, -1]

def without_end(call, *arguments):
    while True:
        call(*arguments)

CALLS = {
    "albedo": (lambda: brdf.albedo(many), lambda: brdf.albedo(w)),
    "albedo from below": (lambda: brdf.albedo(rising(1000000)), lambda: brdf.albedo(w)),
    "walks": (lambda: steps.connections(many, many[::-1]), lambda: np.array(steps.connections(w, w))),
    "walks of one pair": (lambda: steps.evaluate(w[0], w[1], walks=10**9), lambda: np.array(steps.evaluate(w[0], w[1]))),
    "albedo of walks": (lambda: steps.albedo(many[:1000]), lambda: np.array(steps.albedo(w, 100))),
    "evaluate": (lambda: without_end(brdf.evaluate, many, many[::-1]), lambda: brdf.evaluate(w, w)),
    "sample": (lambda: without_end(brdf.sample, many, many[:, :2] % 1), lambda: brdf.sample(w, np.full((4, 2), 0.5))),
    "trace": (lambda: without_end(rough.trace, *rays), lambda: rough.trace(*(r[:4] for r in rays)).distance),
    "validate": (lambda: without_end(mf.validate, brdf.model), lambda: float(mf.validate(brdf.model)["visible_area"].residual)),
}
took = {}
for name, (long, short) in CALLS.items():
    expected = short()

    def interrupt():
        time.sleep(0.5)
        took[name] = time.perf_counter()
        os.kill(os.getpid(), signal.SIGINT)

    sender = threading.Thread(target=interrupt)
    sender.start()
    try:
        long()
        took[name] = None
    except KeyboardInterrupt:
        took[name] = time.perf_counter() - took[name]
    sender.join()
    np.testing.assert_array_equal(short(), expected)
print(json.dumps(took))
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", ["1", "2"])
def test_long_calls_end_soon_after_an_interrupt_and_the_next_is_right(number: str) -> None:
    environment = os.environ | {"MICROFACET_THREADS": number, "PYTHONPATH": str(Path(__file__).parents[2] / "lib")}
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for name, seconds in json.loads(done.stdout).items():
        assert seconds is not None, name
        assert seconds < 1, (name, seconds)
