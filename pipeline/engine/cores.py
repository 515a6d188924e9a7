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
# Variable that says which cores whoever started this process holds for it: its tasks share those
# among themselves, and would wait for ever for what is held on their behalf.
HELD = "CYCLEIK_BENCH_CORES"


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
    with ExitStack() as held:
        while (first := take_cores(count, held)) is None:
            time.sleep(POLL_S)
        yield first


def take_cores(count: int, held: ExitStack) -> int | None:
    """Hold cores as `own_cores` does if so many are free, and return the place of the first one.

    Args:
        count: As there.
        held: Receives the hold.
    """
    usable = _usable()
    name = f"cycleik-bench-cores-{os.getuid()}{os.environ.get(HELD, '')}"
    folder = Path(tempfile.gettempdir()) / name
    folder.mkdir(exist_ok=True)
    width = min(count, len(usable))
    for first in range(0, len(usable) - width + 1, width):
        with ExitStack() as tried:
            if all(_hold(tried, folder / f"{core}") for core in usable[first : first + width]):
                held.enter_context(tried.pop_all())
                return first
    return None


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
