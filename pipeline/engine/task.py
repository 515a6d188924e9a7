"""What travels to a worker and what comes back: a call that never raises, and its outcome."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from pipeline.errors import EngineError, PipelineError

Task = TypeVar("Task")
Result = TypeVar("Result")
OURS = ("pipeline", "baselines", "robots")  # packages whose ValueErrors are sentences for the user


class TaskFault(RuntimeError):  # noqa: N818 - a fault of the code, with its own traceback
    """A task that raised what no user can correct, with the traceback of its worker."""


@dataclass(frozen=True)
class TaskResult(Generic[Result]):
    """How a task ended.

    Attributes:
        value: What it returned; None where it did not.
        problem: The sentence of its error, or how its worker died; "" if all is well.
        trace: Traceback of an error that is no sentence for the user.
        lost: Whether the worker died, so that nobody knows what the task would have said.
    """

    value: Result | None = None
    problem: str = ""
    trace: str = ""
    lost: bool = False

    def result(self) -> Result:
        """Return the value.

        Raises:
            EngineError: The worker died.
            PipelineError: The task refused what it was given.
            TaskFault: It raised anything else; the message has the traceback of the worker.
        """
        if self.lost:
            raise EngineError(self.problem)
        if self.trace:
            raise TaskFault(f"{self.problem}\n\nIn the worker:\n{self.trace}")
        if self.problem:
            raise PipelineError(self.problem)
        return self.value  # type: ignore[return-value]  # None only where a task returns None


def lost(reason: str) -> TaskResult[Any]:
    """Return the outcome of a task whose worker died."""
    return TaskResult(problem=reason, lost=True)


@dataclass(frozen=True)
class Call(Generic[Task, Result]):
    """A function as a worker runs it: on so many threads, and its errors brought home.

    Attributes:
        function: Found by its module and name, so that every machine can import it.
        cpus: Threads that it may use; 0 leaves them alone.
    """

    function: Callable[[Task], Result]
    cpus: int

    def __call__(self, task: Task) -> TaskResult[Result]:
        """Run the task; only what ends the process escapes."""
        hold_threads(self.cpus)
        try:
            return TaskResult(self.function(task))
        except Exception as error:
            sentence = f"{type(error).__name__}: {error}"
            home = type(error).__module__.split(".")[0]
            if isinstance(error, ValueError | ImportError) and home in OURS:
                return TaskResult(problem=str(error))
            return TaskResult(problem=sentence, trace=traceback.format_exc())


@dataclass(frozen=True)
class Batch(Generic[Task, Result]):
    """A call on several tasks, one after another."""

    call: Call[Task, Result]

    def __call__(self, tasks: list[Task]) -> list[TaskResult[Result]]:
        """Run the tasks in order."""
        return [self.call(task) for task in tasks]


@contextmanager
def threads_held(count: int) -> Iterator[None]:
    """Let the thread pools of this process have ``count`` threads for a while; 0 changes nothing.

    The sums of floats that a training is made of hang on the number of threads.
    """
    if not count:
        yield
        return
    import numba
    import torch

    before = torch.get_num_threads(), numba.get_num_threads()
    try:
        hold_threads(count)
        yield
    finally:
        torch.set_num_threads(before[0])
        numba.set_num_threads(before[1])


def hold_threads(count: int) -> None:
    """Let the thread pools of this process have ``count`` threads from now on; 0 changes nothing.

    Libraries that are not imported yet read their number from the environment when they are.
    """
    if not count:
        return
    for library, name in (("torch", "OMP_NUM_THREADS"), ("numba", "NUMBA_NUM_THREADS")):
        if library not in sys.modules:
            os.environ[name] = str(count)
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(count)
    if "numba" in sys.modules:
        numba = sys.modules["numba"]
        numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
