"""The one seam of everything that fans out: tasks in, outcomes out, wherever they run.

A task must hold all that its result depends on, its seed included: then the rows are the same
whatever the engine, and in whatever order the tasks end.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterator, Sequence
from contextlib import closing
from typing import Any, Protocol, TypeVar

from pipeline.engine.config import LOCAL, RAY, SLURM, EngineConfig
from pipeline.engine.cores import usable_cores
from pipeline.engine.task import Call, TaskResult, threads_held
from pipeline.errors import EngineError

Task = TypeVar("Task")
Result = TypeVar("Result")
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


def run_tasks(
    engine: EngineConfig,
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    finished: Callable[[int, Result], object] | None = None,
    title: str = "tasks",
) -> list[Result]:
    """Run a function on every task and return the results in the order of the tasks.

    The first task that raises ends the others. A worker that dies does not: lost tasks are reported
    when all others have ended.

    Args:
        engine: Where and how many at a time.
        function: A function of a module that workers can import.
        tasks: Whatever can be pickled.
        finished: Called in this process with number and result of each task as it ends, in any
            order: the place to keep what must outlive a failure.
        title: What a scheduler calls the jobs.

    Raises:
        EngineError: The engine cannot start, or workers died.
        PipelineError: A task refused what it was given.
        TaskFault: A task raised anything else.
    """
    if not fans_out(engine) or (engine.name == LOCAL and len(tasks) == 1):
        with threads_held(engine.cpus):
            return [_here(function, number, task, finished) for number, task in enumerate(tasks)]
    results: dict[int, Result] = {}
    deaths: dict[int, str] = {}
    with closing(try_tasks(engine, function, tasks, title)) as endings:
        for number, outcome in endings:
            if outcome.lost:
                deaths[number] = outcome.problem
                continue
            results[number] = outcome.result()
            if finished is not None:
                finished(number, results[number])
    if deaths:
        raise EngineError(
            f"{len(deaths)} of {len(tasks)} tasks were lost with their workers, the first one "
            f"(number {min(deaths)}): {deaths[min(deaths)]}. What the others finished is kept; the "
            "same command goes on from there"
        )
    return [results[number] for number in range(len(tasks))]


def try_tasks(
    engine: EngineConfig,
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    title: str = "tasks",
) -> Generator[tuple[int, TaskResult[Result]], None, None]:
    """Run a function on every task and yield the number and outcome of each as it ends.

    Nothing that happens to a task is raised here: see `TaskResult`. Closing the generator ends the
    tasks that still run.

    Args:
        engine: Where and how many at a time.
        function: A function of a module that workers can import.
        tasks: Whatever can be pickled.
        title: What a scheduler calls the jobs.

    Raises:
        EngineError: The engine cannot start.
    """
    call = Call(function, threads_of(engine))
    if not tasks:
        return
    if not fans_out(engine):
        plain = Call(function, 0)
        with threads_held(engine.cpus):
            for number, task in enumerate(tasks):
                yield number, plain(task)
        return
    yield from in_flight(_jobs(engine, title, len(tasks)), call, tasks)


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


def fans_out(engine: EngineConfig) -> bool:
    """Whether tasks leave this process; those of a single local worker do not."""
    return engine.name != LOCAL or workers_of(engine) > 1


def one_machine(engine: EngineConfig) -> bool:
    """Whether all tasks run on this very machine."""
    if engine.name == SLURM:
        return engine.cluster != SLURM
    return engine.name != RAY or engine.address == LOCAL


def workers_of(engine: EngineConfig) -> int:
    """Return how many tasks run at a time."""
    return engine.workers or usable_cores()


def threads_of(engine: EngineConfig) -> int:
    """Return how many threads a task that left this process may use."""
    return engine.cpus or max(usable_cores() // workers_of(engine), 1)


def _here(
    function: Callable[[Task], Result],
    number: int,
    task: Task,
    finished: Callable[[int, Result], object] | None,
) -> Result:
    result = function(task)
    if finished is not None:
        finished(number, result)
    return result


def _jobs(engine: EngineConfig, title: str, count: int) -> Jobs:
    if engine.name == SLURM:
        from pipeline.engine.submitit_jobs import SubmititJobs

        return SubmititJobs(engine, title)
    if engine.name == RAY:
        from pipeline.engine.ray_tasks import RayTasks

        return RayTasks(engine)
    from pipeline.engine.processes import Processes

    return Processes(min(workers_of(engine), count))
