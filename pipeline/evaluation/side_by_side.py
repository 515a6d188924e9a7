"""Many evaluations unattended: a few at a time, each in a process and on a core of its own."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, Queue

from pipeline.progress import LOGGER
from pipeline.provenance import ROOT


@dataclass(frozen=True)
class Job:
    """One solver on the test poses of one robot.

    Attributes:
        robot: Name of the robot.
        solver: Name of the solver.
        pinned: False for a solver whose threads may use every core: it runs alone.
    """

    robot: str
    solver: str
    pinned: bool = True

    def __str__(self) -> str:
        return f"{self.robot} {self.solver}" + ("" if self.pinned else " unpinned")

    @property
    def file_name(self) -> str:
        """Name of the job's log."""
        return f"evaluate-{str(self).replace(' ', '-')}.log"


def jobs_in_turns(
    robots: Sequence[str], solvers: Sequence[str], unpinned: Iterable[str]
) -> list[Job]:
    """List all jobs, robot by robot, each robot beginning with another solver.

    So a machine that slows down over the hours slows all solvers alike, and no solver always has
    the same neighbour. Jobs that are not pinned come last: nothing may run beside them.
    """
    jobs = []
    for turn, robot in enumerate(robots):
        first = turn % max(len(solvers), 1)
        jobs += [Job(robot, solver) for solver in (*solvers[first:], *solvers[:first])]
    return jobs + [Job(robot, solver, False) for solver in unpinned for robot in robots]


def run_jobs(
    jobs: Sequence[Job],
    command: Callable[[Job, int, int], Sequence[str]],
    processes: int,
    logs: Path,
) -> list[Job]:
    """Run all jobs, pinned ones ``processes`` at a time, the others alone after them.

    A job that fails is told and does not stop the others. What a killed job had measured is kept by
    the stage itself.

    Args:
        jobs: In the order of work.
        command: Gives the arguments of `python -m pipeline` for a job, the place of its process
            (from 0) and how many run side by side.
        processes: How many pinned jobs run at a time.
        logs: Folder that receives the output of each job.

    Returns:
        The jobs that failed.
    """
    logs.mkdir(parents=True, exist_ok=True)
    failed: list[Job] = []
    count = _Count(len(jobs))
    for pinned, places in ((True, processes), (False, 1)):
        queue: Queue[Job] = Queue()
        for job in jobs:
            if job.pinned is pinned:
                queue.put(job)

        def work(place: int, queue: Queue[Job] = queue, places: int = places) -> None:
            while (job := _next(queue)) is not None:
                if not _run(command(job, place, places), logs / job.file_name, job, count):
                    failed.append(job)

        with ThreadPoolExecutor(places) as pool:
            try:
                for future in [pool.submit(work, place) for place in range(places)]:
                    future.result()
            finally:  # interrupted: the running jobs were too, and no other may begin
                while _next(queue) is not None:
                    pass
    return failed


def _next(queue: Queue[Job]) -> Job | None:
    try:
        return queue.get_nowait()
    except Empty:
        return None


@dataclass
class _Count:
    """How many of all jobs have ended."""

    total: int
    ended: int = 0


def _run(arguments: Sequence[str], log: Path, job: Job, count: _Count) -> bool:
    began = time.monotonic()
    with log.open("w", encoding="utf-8") as stream:
        status = subprocess.run(
            [sys.executable, "-m", "pipeline", *arguments],
            cwd=ROOT,
            stdout=stream,
            stderr=subprocess.STDOUT,
            check=False,
        ).returncode
    count.ended += 1
    place, seconds = f"{count.ended} of {count.total}", time.monotonic() - began
    if status == 0:
        LOGGER.info("%s: %s done in %.0f s", place, job, seconds)
        return True
    last = [line for line in log.read_text(encoding="utf-8").splitlines() if line.strip()][-1:]
    LOGGER.info("%s: %s failed (%s), see %s", place, job, "".join(last) or status, log)
    return False
