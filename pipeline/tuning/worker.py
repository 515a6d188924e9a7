"""A search as its workers see it: one process, or the requested number on one study."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from optuna import Study

from pipeline.data.dataset import read_split
from pipeline.engine.running import fans_out, try_tasks, workers_of
from pipeline.engine.task import threads_held
from pipeline.errors import EngineError
from pipeline.progress import LOGGER, bar
from pipeline.tuning.objective import TrialObjective
from pipeline.tuning.storage import STORAGE_ERRORS, Store, open_store, storage_errors_named
from pipeline.tuning.study import count, is_over, open_study, run_trials
from robots import load_robot

if TYPE_CHECKING:
    from pipeline.settings import Config

BAR_S = 1.0  # between looks at how far the workers are
ROUNDS = 5  # times that workers are started anew when none of them is left


@dataclass(frozen=True)
class SearchJob:
    """All that a worker needs to join a study, on whatever machine it runs.

    Attributes:
        config: The configuration of the search.
        data: Folder of the pose sets.
        digest: Of those sets.
        journal: The journal file, where that is the storage.
    """

    config: Config
    data: Path
    digest: str
    journal: Path

    def store(self) -> Store:
        """Open the storage, as one more worker."""
        tune = self.config.tune
        return open_store(tune.storage, self.journal, tune.heartbeat_s)


def work(job: SearchJob) -> int:
    """Join a study, run trials until it has the requested number, and return their number.

    Raises:
        PipelineError: Trial after trial failed, or the storage cannot be opened.
    """
    store = job.store()
    try:
        with storage_errors_named(store):
            study = open_study(store, job.config, job.digest)
            robot = load_robot(job.config.robot.name)
            parts = [read_split(job.data, part, robot) for part in ("train", "validation")]
            run_trials(store, study, TrialObjective(robot, job.config, *parts), job.config)
            return count(study).finished
    finally:
        store.close()


def search(job: SearchJob, study: Study) -> None:
    """Run a study to its end with ``tune.workers`` workers on the engine of the run.

    A worker that dies leaves the rest to the others; where none is left, all are started anew.

    Args:
        job: What each worker needs to know.
        study: The study, to see how far it is.

    Raises:
        PipelineError: Trial after trial failed.
        EngineError: Workers died as soon as they were there.
    """
    config = job.config
    engine = replace(config.engine, workers=config.tune.workers or config.engine.workers)
    with _shown(study, config):
        for _ in range(ROUNDS):
            if is_over(count(study), config):
                return
            if not fans_out(engine):
                with threads_held(engine.cpus):
                    work(job)
                continue
            # Closed when one of them gives up, so that none runs on beside what is written then.
            with closing(try_tasks(engine, work, [job] * workers_of(engine), "tune")) as outcomes:
                for number, outcome in outcomes:
                    if outcome.lost:
                        LOGGER.warning("worker %d of the study: %s", number, outcome.problem)
                    else:
                        outcome.result()
    if not is_over(count(study), config):
        raise EngineError(
            f"all workers died {ROUNDS} times: {count(study).finished} of {config.tune.trials} "
            "trials are done; with less memory for each (tune.workers, tune.space) the same "
            "command goes on from there"
        )


@contextmanager
def _shown(study: Study, config: Config) -> Iterator[None]:
    """Show how many trials are finished, whoever runs them."""
    over = threading.Event()
    first = count(study).finished
    with bar(config.tune.trials, "trial", f"tune {config.robot.name}", first) as shown:

        def watch() -> None:
            with suppress(*STORAGE_ERRORS):  # the search itself reports it
                while not over.wait(BAR_S):
                    shown.update(count(study).finished - shown.n)

        watcher = threading.Thread(target=watch, daemon=True)
        watcher.start()
        try:
            yield
        finally:
            over.set()
            watcher.join()
            with suppress(*STORAGE_ERRORS):
                shown.update(count(study).finished - shown.n)
