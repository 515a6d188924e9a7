"""Commands side by side, each on one core that it holds alone; those that wait for others wait."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.engine.cores import own_cores, usable_cores
from pipeline.progress import last_line

POLL_S = 0.2
DEATH_OF_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


@dataclass(frozen=True)
class CoreTask:
    """A command of the pipeline that keeps one core busy.

    Attributes:
        name: Unique; also of its log.
        arguments: Of `python -m pipeline`.
        needs: Names of the tasks that must have succeeded before.
    """

    name: str
    arguments: tuple[str, ...]
    needs: tuple[str, ...] = ()


@dataclass
class _Running:
    task: CoreTask
    process: subprocess.Popen[bytes]
    began: float
    core: ExitStack = field(default_factory=ExitStack)


def run_on_cores(
    tasks: Sequence[CoreTask],
    processes: int,
    logs: Path,
    ended: Callable[[CoreTask, int, float], None],
) -> dict[str, str]:
    """Run commands, a number of them at a time, each pinned to a core of its own.

    Where this process is interrupted or dies, its commands end with it; what they keep is theirs.

    Args:
        tasks: In the order of work; the needs of one come before it, or are done already.
        processes: How many at a time; no more than there are cores.
        logs: Folder that receives the output of each.
        ended: Called with each that has ended, its exit status and its seconds.

    Returns:
        Why tasks did not succeed, by name; empty where all did.
    """
    logs.mkdir(parents=True, exist_ok=True)
    waiting, running = list(tasks), list[_Running]()
    failed: dict[str, str] = {}
    pending = {task.name for task in tasks}
    room = min(processes, usable_cores())
    try:
        while waiting or running:
            for task in [each for each in waiting if failed.keys() & {*each.needs}]:
                waiting.remove(task)
                first = next(name for name in task.needs if name in failed)
                failed[task.name] = f"needs {first}, which failed"
                pending.discard(task.name)
            ready = [task for task in waiting if not pending & {*task.needs}]
            for task in ready[: room - len(running)]:
                waiting.remove(task)
                running.append(_start(task, logs))
            time.sleep(POLL_S)
            for each in [each for each in running if each.process.poll() is not None]:
                running.remove(each)
                each.core.close()
                status = each.process.returncode
                if status:
                    reason = last_line(logs / f"{each.task.name}.log")
                    failed[each.task.name] = reason or f"status {status}"
                pending.discard(each.task.name)
                ended(each.task, status, time.monotonic() - each.began)
    finally:
        for each in running:
            each.process.terminate()
        for each in running:
            each.process.wait()
            each.core.close()
    return failed


def _start(task: CoreTask, logs: Path) -> _Running:
    with ExitStack() as core:
        place = core.enter_context(own_cores(1))
        number = sorted(os.sched_getaffinity(0))[place]
        stream = core.enter_context((logs / f"{task.name}.log").open("wb"))
        process = subprocess.Popen(
            [sys.executable, "-m", "pipeline", *task.arguments],
            stdout=stream,
            stderr=subprocess.STDOUT,
            env={**os.environ, **ONE_THREAD},
            preexec_fn=lambda: _on_core(number),
        )
        return _Running(task, process, time.monotonic(), core.pop_all())


def _on_core(number: int) -> None:
    """In the new process: keep to one core, and end with the parent, whatever ends that."""
    os.sched_setaffinity(0, {number})
    ctypes.CDLL(None).prctl(DEATH_OF_PARENT, signal.SIGTERM)
