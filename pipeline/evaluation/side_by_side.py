"""Many evaluations unattended: each in a process and on a core of its own, wherever that is."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path

from pipeline.engine.config import EngineConfig
from pipeline.engine.cores import own_cores, usable_cores
from pipeline.engine.running import one_machine, try_tasks, workers_of
from pipeline.engine.task import TaskResult
from pipeline.progress import LOGGER, last_line


@dataclass(frozen=True)
class EvaluationJob:
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
) -> list[EvaluationJob]:
    """List all jobs, robot by robot, each robot beginning with another solver.

    So a machine that slows down over the hours slows all solvers alike, and no solver always has
    the same neighbour. Jobs that are not pinned come last: nothing may run beside them.
    """
    jobs = []
    for turn, robot in enumerate(robots):
        first = turn % max(len(solvers), 1)
        jobs += [EvaluationJob(robot, solver) for solver in (*solvers[first:], *solvers[:first])]
    return jobs + [EvaluationJob(robot, solver, False) for solver in unpinned for robot in robots]


def run_jobs(
    jobs: Sequence[EvaluationJob],
    command: Callable[[EvaluationJob, int], Sequence[str]],
    engine: EngineConfig,
    logs: Path,
) -> list[EvaluationJob]:
    """Run all jobs, pinned ones as many at a time as the engine takes, the others after them.

    Those that are not pinned run one at a time on one machine: nothing may run beside them. A job
    that fails is reported and does not stop the others. What a killed job had measured is kept by
    the stage itself.

    Args:
        jobs: In the order of work.
        command: Gives the arguments of `python -m pipeline` for a job and the number of those that
            run side by side on a machine.
        engine: Where they run.
        logs: Folder that receives the output of each job.

    Returns:
        The jobs that failed.
    """
    logs.mkdir(parents=True, exist_ok=True)
    failed: list[EvaluationJob] = []
    ended = 0
    for pinned in (True, False):
        chosen = [job for job in jobs if job.pinned is pinned]
        places = workers_of(engine) if pinned or not one_machine(engine) else 1
        beside = min(places, usable_cores()) if one_machine(engine) else 1
        runs = [
            EvaluationRun(tuple(command(job, beside)), logs / job.file_name, pinned)
            for job in chosen
        ]
        tasks = try_tasks(replace(engine, workers=places), run_apart, runs, "bench")
        with closing(tasks) as outcomes:
            for number, outcome in outcomes:
                ended += 1
                what = f"{ended} of {len(jobs)}: {chosen[number]}"
                if not _report(what, outcome, runs[number].log):
                    failed.append(chosen[number])
    return failed


@dataclass(frozen=True)
class EvaluationRun:
    """A command of the pipeline in a process of its own.

    Attributes:
        arguments: Of `python -m pipeline`.
        log: File that receives its output.
        pinned: Whether it is timed on one core; else on all that there are.
        folder: Where the user stands, which relative paths among the arguments start from.
    """

    arguments: tuple[str, ...]
    log: Path
    pinned: bool
    folder: Path = field(default_factory=Path.cwd)


def run_apart(run: EvaluationRun) -> tuple[int, float]:
    """Run a command on cores that nothing else is timed on; its exit status and seconds."""
    with own_cores(1 if run.pinned else usable_cores()) as first:
        began = time.monotonic()
        with run.log.open("w", encoding="utf-8") as stream:
            place = [f"evaluate.first_core={first}"] if run.pinned else []
            status = subprocess.run(
                [sys.executable, "-m", "pipeline", *run.arguments, *place],
                cwd=run.folder,
                stdout=stream,
                stderr=subprocess.STDOUT,
                check=False,
            ).returncode
        return status, time.monotonic() - began


def _report(what: str, outcome: TaskResult[tuple[int, float]], log: Path) -> bool:
    """Report how a job ended and return whether it succeeded."""
    status, seconds = outcome.value or (None, 0.0)
    if status == 0:
        LOGGER.info("%s done in %.0f s", what, seconds)
        return True
    LOGGER.info("%s failed (%s), see %s", what, outcome.problem or last_line(log) or status, log)
    return False
