"""Jobs are shared among threads: each is done once, results keep their order, and an error is not lost."""

from __future__ import annotations

import threading
import time

import pytest
from microfacet.processors import share, threads


@pytest.mark.parametrize("count", ["1", "2", "5"])
@pytest.mark.parametrize("jobs", [0, 1, 2, 40])
def test_results_come_in_the_order_of_the_jobs(count: str, jobs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", count)
    done: list[int] = []
    assert share(lambda k: done.append(k) or 2 * k, [(k,) for k in range(jobs)]) == [2 * k for k in range(jobs)]
    assert sorted(done) == list(range(jobs))


def test_jobs_run_beside_one_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "3")
    meeting = threading.Barrier(3, timeout=20)
    share(lambda: meeting.wait(), [()] * 3)


@pytest.mark.parametrize("bad", [0, 7])
def test_an_error_reaches_the_caller(bad: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "2")

    def work(k: int) -> None:
        time.sleep(0.001)
        if k == bad:
            raise ValueError(f"job {k}")

    with pytest.raises(ValueError, match=f"job {bad}"):
        share(work, [(k,) for k in range(8)])


def test_jobs_may_share_jobs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "2")
    sums = share(lambda k: sum(share(lambda j: j, [(k + j,) for j in range(4)])), [(k,) for k in range(6)])
    assert sums == [4 * k + 6 for k in range(6)]


def test_the_number_of_threads_can_be_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "7")
    assert threads() == 7
    monkeypatch.delenv("MICROFACET_THREADS")
    assert threads() >= 1


def test_a_number_of_threads_that_is_none_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MICROFACET_THREADS", "abc")
    with pytest.raises(ValueError, match="MICROFACET_THREADS must be a whole number, got 'abc'"):
        threads()
