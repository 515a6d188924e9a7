"""Cores of this machine: how many there are to use, and some for a timed task alone."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

POLL_S = 0.2  # between tries for a core that another task holds


def usable_cores() -> int:
    """Return how many cores this process may use."""
    return len(_usable())


@contextmanager
def own_cores(count: int) -> Iterator[int]:
    """Hold cores that no other task of this user on this machine holds; wait for them if need be.

    Tasks that are timed side by side are pinned to different cores this way, whatever engine put
    them on the machine. The operating system drops the hold with the process.

    Args:
        count: Neighbouring cores of those that this process may use; all of them at most.

    Yields:
        The place of the first one, counted from 0, as `evaluate.first_core` has it.
    """
    usable = _usable()
    folder = Path(tempfile.gettempdir()) / f"cycleik-bench-cores-{os.getuid()}"
    folder.mkdir(exist_ok=True)
    width = min(count, len(usable))
    while True:
        for first in range(0, len(usable) - width + 1, width):
            with ExitStack() as held:
                if all(_hold(held, folder / str(core)) for core in usable[first : first + width]):
                    yield first
                    return
        time.sleep(POLL_S)


def _hold(held: ExitStack, path: Path) -> bool:
    lock = FileLock(path, blocking=False)
    try:
        held.enter_context(lock)
    except Timeout:
        return False
    return True


def _usable() -> list[int]:
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))
