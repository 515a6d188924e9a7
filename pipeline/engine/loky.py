"""The engine joblib: warm worker processes of loky."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from typing import Any

from pipeline.engine.packages import package
from pipeline.engine.task import Call, lost
from pipeline.engine.windowed import Numbered
from pipeline.progress import hide_bars


def loky_tasks(workers: int, call: Call[Any, Any], tasks: Sequence[Any]) -> Iterator[Numbered]:
    """Run tasks in loky's workers and yield the number and outcome of each as it ends.

    loky ends all its workers when one dies, so every task that had not ended counts as lost.

    Args:
        workers: Processes at a time.
        call: What is done to each task.
        tasks: In the order in which they are to begin.

    Yields:
        The task's place in ``tasks`` and its outcome.

    Raises:
        EngineError: joblib is not installed.
    """
    joblib = package("joblib", "cluster")
    terminated = package("joblib.externals.loky.process_executor", "cluster").BrokenProcessPool
    parallel = joblib.Parallel(
        n_jobs=workers,
        backend="loky",
        return_as="generator_unordered",
        batch_size=1,
        pre_dispatch=2 * workers,
    )
    waiting = set(range(len(tasks)))
    numbered = joblib.delayed(_numbered)
    endings = parallel(numbered(call, number, task) for number, task in enumerate(tasks))
    try:
        for number, outcome in endings:
            waiting.remove(number)
            yield number, outcome
    except terminated:
        for number in sorted(waiting):
            yield number, lost("a worker process died, and joblib ends all of them then")
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that tasks were cancelled is what we ask for
            endings.close()


def _numbered(call: Call[Any, Any], number: int, task: Any) -> Numbered:
    hide_bars()
    return number, call(task)
