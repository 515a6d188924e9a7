"""The engine local: a spawned process for each worker; one that dies takes no other along."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Collection, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing import connection, get_context, parent_process
from typing import Any

from pipeline.engine.task import Call, TaskResult, lost
from pipeline.progress import hide_bars


class Processes:
    """Worker processes of this machine, each a pool of its own.

    One pool of many workers is broken as a whole when one of them is killed; a pool of one is
    broken alone, and the next task gets a new one.

    Args:
        workers: How many.
    """

    batch = 1

    def __init__(self, workers: int) -> None:
        self.room: int | None = workers
        self._idle: list[_Worker] = []
        self._busy: dict[Future[Any], _Worker] = {}

    def submit(self, call: Call[Any, Any], batches: Sequence[list[Any]]) -> list[Future[Any]]:
        """Hand each task to a worker that waits, or to a new one."""
        return [self._begin(call, task) for (task,) in batches]

    def ended(self, handles: Collection[Future[Any]]) -> Collection[Future[Any]]:
        """Wait for the first tasks that end."""
        return wait(handles, return_when=FIRST_COMPLETED).done

    def outcomes(self, handle: Future[Any], count: int) -> list[TaskResult[Any]]:
        """Return the result of a task; a worker that died is not used again."""
        worker = self._busy.pop(handle)
        try:
            outcome = handle.result()
        except BrokenProcessPool:
            worker.stop()
            return [lost("its worker process died (killed, or out of memory?)")]
        except Exception as error:  # what could not travel: the task, or what it returned
            outcome = TaskResult(problem=f"{type(error).__name__}: {error}", trace=str(error))
        self._idle.append(worker)
        return [outcome]

    def close(self, handles: Collection[Future[Any]]) -> None:
        """Stop all workers; those that still work are ended."""
        for future in handles:
            self._busy.pop(future).end()
        for worker in self._idle:
            worker.stop()

    def _begin(self, call: Call[Any, Any], task: Any) -> Future[Any]:
        while self._idle:
            with suppress(BrokenProcessPool):  # killed while it waited: nothing is lost with it
                return self._hand(self._idle.pop(), call, task)
        return self._hand(_Worker(), call, task)

    def _hand(self, worker: _Worker, call: Call[Any, Any], task: Any) -> Future[Any]:
        future = worker.pool.submit(call, task)
        self._busy[future] = worker
        return future


class _Worker:
    """A pool of one process."""

    def __init__(self) -> None:
        self.pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_begin)
        self._number = self.pool.submit(os.getpid)

    def stop(self) -> None:
        self.pool.shutdown(wait=False, cancel_futures=True)

    def end(self) -> None:
        with suppress(BrokenProcessPool, ProcessLookupError):
            os.kill(self._number.result(), signal.SIGTERM)
        self.stop()


def _begin() -> None:
    """Set a worker up: no bars, no traceback on Ctrl-C, and no life after its parent's."""
    hide_bars()
    # Ctrl-C reaches the parent as well, which ends its workers. A handler, not SIG_IGN: commands
    # that a task starts would inherit that one and run on.
    signal.signal(signal.SIGINT, lambda number, frame: None)
    threading.Thread(target=_outlive_nobody, daemon=True).start()


def _outlive_nobody() -> None:
    parent = parent_process()
    assert parent is not None
    connection.wait([parent.sentinel])
    os._exit(1)
