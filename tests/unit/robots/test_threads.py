"""Work on threads: all of it is done, failures come back, and nothing waits for nothing."""

import multiprocessing
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from robots import threads
from robots.threads import on_threads, shares

WAIT_S = 30.0


def test_every_part_is_done_once() -> None:
    for count in (1, 2, 3, 40):
        done: list[int] = []
        on_threads(count, done.append)
        assert sorted(done) == list(range(count))


def test_shares_cover_a_batch_once_and_are_worth_a_thread() -> None:
    assert shares(0, 2, 250) == [slice(0, 0)]
    assert shares(499, 2, 250) == [slice(0, 499)]
    assert shares(501, 2, 250) == [slice(0, 250), slice(250, 501)]
    parts = shares(5000, 3, 250)
    assert np.array_equal(np.concatenate([np.arange(5000)[part] for part in parts]), range(5000))
    assert len(shares(700, 64, 250)) == 2


def test_the_first_part_runs_on_the_callers_thread_and_others_beside_it() -> None:
    begun, names = threading.Event(), {}

    def work(index: int) -> None:
        names[index] = threading.current_thread()
        if index:
            begun.set()
        else:
            assert begun.wait(WAIT_S)

    on_threads(2, work)
    assert names[0] is threading.current_thread()
    assert names[1] is not names[0]


@pytest.mark.parametrize("failing", [0, 1])
def test_a_failure_is_raised_when_all_have_ended(failing: int) -> None:
    begun, ended = threading.Event(), []

    def work(index: int) -> None:
        if index:
            begun.set()
        else:
            assert begun.wait(WAIT_S)
        if index == failing:
            raise MemoryError("no room")
        ended.append(index)

    with pytest.raises(MemoryError, match="no room"):
        on_threads(2, work)
    assert ended == [1 - failing]


def test_a_pool_that_is_busy_holds_nobody_up(monkeypatch: pytest.MonkeyPatch) -> None:
    free = threading.Event()
    with ThreadPoolExecutor(1) as pool:
        monkeypatch.setattr(threads, "_pool", lambda: pool)
        busy = pool.submit(free.wait, WAIT_S)
        done: list[threading.Thread] = []
        on_threads(3, lambda index: done.append(threading.current_thread()))
        assert done == [threading.current_thread()] * 3
        free.set()
        assert busy.result()


def _fork_and_work(answers: "multiprocessing.Queue[int]") -> None:
    on_threads(3, answers.put)


def test_a_fork_has_a_pool_of_its_own() -> None:
    on_threads(2, lambda index: None)
    context = multiprocessing.get_context("fork")
    answers: multiprocessing.Queue[int] = context.Queue()
    child = context.Process(target=_fork_and_work, args=(answers,))
    child.start()
    assert sorted(answers.get(timeout=WAIT_S) for _ in range(3)) == [0, 1, 2]
    child.join(WAIT_S)
    assert child.exitcode == 0
