"""The engine slurm: jobs that submitit hands to the scheduler, or runs on this machine."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Collection, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pipeline.engine.config import SLURM, EngineConfig
from pipeline.engine.task import Batch, Call, TaskResult, lost
from pipeline.errors import EngineError
from pipeline.packages import optional_package
from pipeline.progress import hide_bars

# s between looks at the jobs. On a cluster each look is a query to the file server for each job;
# submitit queries the scheduler itself far less often.
POLL_S, CLUSTER_POLL_S = 0.5, 5.0


class SubmititJobs:
    """Jobs of submitit: one array on a cluster, a few at a time on this machine.

    Args:
        engine: Resources of a job, where its logs go, and which cluster it is.
        title: Name of the jobs in the scheduler's list.

    Raises:
        EngineError: submitit is not installed, or there is no such cluster here.
    """

    def __init__(self, engine: EngineConfig, title: str) -> None:
        submitit = optional_package("engine=slurm", EngineError)
        self._lost = submitit.core.utils.UncompletedJobError
        self.batch = engine.tasks_per_job
        # The scheduler holds an array back by itself; processes of this machine start at once.
        self.room = None if engine.cluster == SLURM else engine.workers
        self._logs = Path(engine.folder).absolute() / f"{title}-{os.getpid()}"
        try:
            self._executor = submitit.AutoExecutor(self._logs / "%j", cluster=engine.cluster)
            self._executor.update_parameters(**parameters(engine, title))
        except (RuntimeError, ValueError, NameError, AssertionError) as error:
            sentence = " ".join(str(error).split())
            raise EngineError(
                f"submitit cannot submit to engine.cluster={engine.cluster}: {sentence}; on one "
                "machine set engine.cluster=local"
            ) from error

    def submit(self, call: Call[Any, Any], batches: Sequence[list[Any]]) -> list[Any]:
        """Submit a job for each batch, all of them as one array where there are arrays."""
        try:
            jobs: list[Any] = self._executor.map_array(_Quiet(Batch(call)), batches)
        except Exception as error:  # sbatch refused: partition, account, limits
            sentence = " ".join(str(error).split())
            raise EngineError(f"the scheduler took no jobs: {sentence}") from error
        return jobs

    def ended(self, handles: Collection[Any]) -> Collection[Any]:
        """Wait for the first jobs that end."""
        while True:
            if done := [job for job in handles if job.done()]:
                return done
            time.sleep(CLUSTER_POLL_S if self.room is None else POLL_S)

    def outcomes(self, handle: Any, count: int) -> list[TaskResult[Any]]:
        """Return the results of the tasks of a job; its log stays if it died."""
        try:
            outcomes: list[TaskResult[Any]] = handle.result()
        except self._lost:
            folder = handle.paths.folder
            return [lost(f"job {handle.job_id} died; its log is in {folder}")] * count
        shutil.rmtree(handle.paths.folder, ignore_errors=True)
        return outcomes

    def close(self, handles: Collection[Any]) -> None:
        """Cancel the jobs still in flight; what stays on disk are the logs of those that failed."""
        for job in handles:
            job.cancel(check=False)
        for path in (*self._logs.rglob("*.sh"), *self._logs.rglob("*.pkl")):
            path.unlink(missing_ok=True)
        for folder in (*self._logs.glob("*"), self._logs, self._logs.parent):
            with suppress(OSError):  # not empty
                folder.rmdir()


class _Quiet:
    """A batch of tasks without progress bars: a job's log is for what went wrong."""

    def __init__(self, batch: Batch[Any, Any]) -> None:
        self.batch = batch

    def __call__(self, tasks: list[Any]) -> list[TaskResult[Any]]:
        hide_bars()
        return self.batch(tasks)


def parameters(engine: EngineConfig, title: str) -> dict[str, Any]:
    """Return the parameters of submitit for an engine; those of SLURM are ignored elsewhere."""
    given: dict[str, Any] = {
        "name": title,
        "timeout_min": engine.minutes,
        "cpus_per_task": engine.cpus,
        "slurm_array_parallelism": engine.workers,
    }
    if engine.memory_gb:
        given["mem_gb"] = engine.memory_gb
    if engine.partition:
        given["slurm_partition"] = engine.partition
    if engine.options:
        given["slurm_additional_parameters"] = dict(engine.options)
    if engine.setup:
        given["slurm_setup"] = list(engine.setup)
    return given
