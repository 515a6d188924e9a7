"""The engine ray: tasks of a Ray runtime, on this machine or of a cluster."""

from __future__ import annotations

import logging
import os
from collections.abc import Collection, Sequence
from typing import Any

from pipeline.engine.config import LOCAL, EngineConfig
from pipeline.engine.task import Call, TaskResult, lost
from pipeline.errors import EngineError
from pipeline.packages import optional_package
from pipeline.progress import hide_bars

GIB = 1 << 30


class RayTasks:
    """Tasks in flight on Ray; a runtime that was started here is stopped with the process.

    Args:
        engine: Address, tasks in flight, and resources of a task.

    Raises:
        EngineError: Ray is not installed, or there is no runtime at the address.
    """

    batch = 1

    def __init__(self, engine: EngineConfig) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # a benchmark calls nobody
        self._ray = optional_package("engine=ray", EngineError)
        if not self._ray.is_initialized():
            _connect(self._ray, engine)
        self.room: int | None = engine.workers
        self._lost = self._ray.exceptions.RayError
        resources: dict[str, Any] = {"num_cpus": engine.cpus, "max_retries": 0}
        if engine.memory_gb:
            resources["memory"] = int(engine.memory_gb * GIB)
        self._run = self._ray.remote(**resources)(_run)
        self._call: Any = None

    def submit(self, call: Call[Any, Any], batches: Sequence[list[Any]]) -> list[Any]:
        """Hand the tasks over; what is done to them is stored once."""
        if self._call is None:
            self._call = self._ray.put(call)
        return [self._run.remote(self._call, task) for (task,) in batches]

    def ended(self, handles: Collection[Any]) -> Collection[Any]:
        """Wait for the first tasks that end."""
        done, _ = self._ray.wait(list(handles), num_returns=1)
        return list(done)

    def outcomes(self, handle: Any, count: int) -> list[TaskResult[Any]]:
        """Return the result of a task."""
        try:
            outcome: TaskResult[Any] = self._ray.get(handle)
        except self._lost as error:
            reason = next(iter(str(error).strip().splitlines()), "")
            return [lost(f"its worker died ({type(error).__name__}: {reason})")]
        return [outcome]

    def close(self, handles: Collection[Any]) -> None:
        """Cancel the tasks still in flight."""
        for handle in handles:
            self._ray.cancel(handle, force=True)


def _run(call: Call[Any, Any], task: Any) -> TaskResult[Any]:
    hide_bars()
    return call(task)


def _connect(ray: Any, engine: EngineConfig) -> None:
    """Start a runtime on this machine or join the one at the address."""
    own = engine.address == LOCAL
    try:
        ray.init(
            address=engine.address,
            num_cpus=engine.workers * engine.cpus if own else None,
            include_dashboard=False if own else None,
            log_to_driver=False,
            logging_level=logging.ERROR,
        )
    except (ConnectionError, RuntimeError, ValueError, OSError) as error:
        sentence = " ".join(str(error).split())
        raise EngineError(
            f"Ray cannot be reached at engine.address={engine.address}: {sentence}; start it with "
            "`ray start --head`, or set engine.address=local"
        ) from error
