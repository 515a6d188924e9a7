"""Functions that the tests of engines run; a module that every worker can import."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from pipeline.engine.cores import own_cores
from pipeline.errors import ConfigError


def square(number: int) -> int:
    """The sooner a task comes, the later it ends."""
    time.sleep(0.05 * (3 - number % 4))
    return number * number


def process(number: int) -> int:
    return os.getpid()


def threads(number: int) -> str:
    return os.environ.get("OMP_NUM_THREADS", "any")


def fail_at_two(number: int) -> int:
    if number == 2:
        raise ConfigError("number 2 cannot be")
    return number


def divide(number: int) -> float:
    return 1 / number


def die_at_one(number: int) -> int:
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.2)
    return number


def unpicklable(number: int) -> object:
    return lambda: number


def say_and_sleep(path: str) -> None:
    """Write the process number and sleep, or fail as soon as another has written."""
    if path.startswith("after "):
        while not Path(path.removeprefix("after ")).exists():
            time.sleep(0.05)
        raise ConfigError("no path")
    Path(path).write_text(str(os.getpid()), encoding="utf-8")
    time.sleep(60)


def hold_core(path: str) -> int:
    """The place of a core, written down while it is held."""
    with own_cores(1) as place:
        mark = Path(path).with_suffix(f".{place}")
        assert not mark.exists(), "another task holds this core"
        mark.write_text("")
        time.sleep(0.3)
        mark.unlink()
    return place
