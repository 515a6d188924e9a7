"""Threads of compiled kernels: a pool of Python's, and whether there may be others.

The threads of numba and of OpenMP, which torch stands on, do not survive a fork: a child that
starts a parallel kernel waits for workers that its parent has. So a forked process stays on one
thread of theirs, with the same results. A pool of Python's threads is made anew in a child, and a
kernel that is compiled with `nogil=True` lets them run side by side.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

_state = {"forked": False}


def forked() -> bool:
    """Whether this process is a fork of one that had loaded this package."""
    return _state["forked"]


def on_threads(count: int, work: Callable[[int], None]) -> None:
    """Call `work` with 0 to ``count - 1``: 0 on the caller's thread, others on the pool's.

    What no thread of the pool has begun when the caller is done with its own, the caller does too,
    so that calls from many threads at once never wait for one another.

    Raises:
        BaseException: The first that a call raised, when all have ended.
    """
    others = [_pool().submit(work, index) for index in range(1, count)]
    failures: list[BaseException] = []
    for index, other in enumerate([None, *others]):
        try:
            if other is None or other.cancel():
                work(index)
            else:
                other.result()
        except BaseException as failure:
            failures.append(failure)
    if failures:
        raise failures[0]


def shares(count: int, threads: int, least: int) -> list[slice]:
    """Rows of a batch for each of so many threads.

    Args:
        count: Rows.
        threads: Threads, 1 at least.
        least: Rows that are worth a thread.

    Returns:
        One slice at least, of about as many rows each.
    """
    used = max(1, min(threads, count // least))
    edges = [index * count // used for index in range(used + 1)]
    return [slice(*pair) for pair in pairwise(edges)]


@cache
def _pool() -> ThreadPoolExecutor:
    """Threads that are kept from call to call: a start takes as long as a hundred poses."""
    return ThreadPoolExecutor(max(1, (os.cpu_count() or 1) - 1), "cycleik")


def _note_fork() -> None:
    _state["forked"] = True
    _pool.cache_clear()  # its threads are the parent's
    torch = sys.modules.get("torch")
    if torch is not None and hasattr(torch, "set_num_threads"):
        torch.set_num_threads(1)  # as torch does in the workers of its own data loaders


os.register_at_fork(after_in_child=_note_fork)
