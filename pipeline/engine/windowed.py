"""Tasks in flight: as many at a time as an engine has room for, told as they end."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any, Protocol

from pipeline.engine.task import Call, TaskResult

Numbered = tuple[int, TaskResult[Any]]


class Jobs(Protocol):
    """What an engine that takes single jobs must offer; a job is one task or several."""

    room: int | None  # jobs in flight; None leaves the number to the engine
    batch: int  # tasks of a job

    def submit(self, call: Call[Any, Any], batches: Sequence[list[Any]]) -> list[Any]:
        """Start a job for each batch of tasks and return their handles."""
        ...

    def ended(self, handles: Collection[Any]) -> Collection[Any]:
        """Wait until at least one job has ended and return those that have."""
        ...

    def outcomes(self, handle: Any, count: int) -> list[TaskResult[Any]]:
        """Return the outcomes of a job's tasks; a job that died gives ``count`` lost ones."""
        ...

    def close(self, handles: Collection[Any]) -> None:
        """End the jobs still in flight, if there are any, and let everything go."""
        ...


def in_flight(jobs: Jobs, call: Call[Any, Any], tasks: Sequence[Any]) -> Iterator[Numbered]:
    """Run tasks and yield the number and outcome of each as it ends.

    Args:
        jobs: The engine.
        call: What is done to each task.
        tasks: In the order in which they are to begin.

    Yields:
        The task's place in ``tasks`` and its outcome. Closing the generator ends what still runs.
    """
    numbers = list(range(len(tasks)))
    batches = [numbers[i : i + jobs.batch] for i in range(0, len(numbers), jobs.batch)]
    running: dict[Any, list[int]] = {}
    try:
        while batches or running:
            free = len(batches) if jobs.room is None else max(jobs.room - len(running), 0)
            now, batches = batches[:free], batches[free:]
            if now:
                handles = jobs.submit(call, [[tasks[number] for number in one] for one in now])
                running.update(zip(handles, now, strict=True))
            for handle in jobs.ended(running):
                batch = running.pop(handle)
                yield from zip(batch, jobs.outcomes(handle, len(batch)), strict=True)
    finally:
        jobs.close(running)
