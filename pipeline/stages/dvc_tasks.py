"""The stages of dvc.yaml as tasks that may run side by side, recorded by DVC as its own are.

`dvc repro` runs one stage after the other. A task here goes through the same steps as there (DVC
3.67, dvc/stage/__init__.py and run.py): is it stale, remove what it wrote, has the run cache its
result, run its command; then hash, cache and write down what came of it in dvc.lock. All of that is
done in one process that holds DVC's lock, only commands run beside each other.
"""

from __future__ import annotations

import logging
import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from dvc.exceptions import DvcException
from dvc.repo import Repo
from dvc.stage.cache import RunCacheNotFoundError
from dvc.stage.run import prepare_kwargs

from pipeline.data.files import read_json, write_json
from pipeline.engine.scheduler import Command
from pipeline.errors import PipelineError
from pipeline.stages.forecast import seconds_of_command
from pipeline.stages.graph import STAGES

DURATIONS = "durations.json"  # below the results: seconds of each task when it ran last


class DvcTasks:
    """The stages of a checkout's dvc.yaml by name, such as ``plan@nico``; a context manager.

    Attributes:
        needs: Names of the tasks that each task reads what they leave.
    """

    def __init__(self, folder: Path, results: Path) -> None:
        """Read dvc.yaml.

        Args:
            folder: Of the checkout.
            results: Folder of results, where it is remembered what each task took.
        """
        self._durations = results / DURATIONS
        self._took = dict(read_json(self._durations)) if self._durations.exists() else {}
        logging.getLogger("dvc").setLevel(logging.WARNING)  # a line for each task is said elsewhere
        self._repo = Repo(str(folder))
        graph = self._repo.index.graph
        self._stages = {stage.addressing: stage for stage in graph}
        self._upstream = {name: list(graph.successors(s)) for name, s in self._stages.items()}
        self.needs: Mapping[str, frozenset[str]] = {
            name: frozenset(stage.addressing for stage in upstream)
            for name, upstream in self._upstream.items()
        }
        self._held = [self._repo.lock, self._repo.scm_context()]

    def __enter__(self) -> DvcTasks:
        for each in self._held:
            each.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for each in reversed(self._held):
            each.__exit__(kind, error, trace)
        self._repo.close()

    def is_stale(self, name: str) -> bool:
        """Whether what a task reads, runs or wrote differs from what DVC wrote down."""
        return bool(self._stages[name].changed(False, self._upstream[name]))

    def begin(self, name: str) -> bool:
        """Prepare a stale task; whether its command must run, which it need not if it ever ran."""
        stage = self._stages[name]
        with _refused_in_words():
            stage.remove_outs(ignore_remove=False, force=False)
            try:
                self._repo.stage_cache.restore(stage)
            except RunCacheNotFoundError:
                stage.save_deps()
                return True
            self._record(name)
        return False

    def command(self, name: str) -> Command:
        """Return the command of a task, as DVC would run it."""
        stage = self._stages[name]
        given = prepare_kwargs(stage)
        return Command(shlex.split(stage.cmd), Path(given["cwd"]), given["env"])

    def finish(self, name: str, seconds: float) -> None:
        """Write down what a task left, and how long it took [s]."""
        with _refused_in_words():
            self._record(name)
        self._took[name] = round(seconds, 1)
        write_json(self._durations, self._took)

    def seconds(self, name: str) -> float:
        """Return what a task took here before, or else what rates say [s]."""
        if name in self._took:
            return float(self._took[name])
        _, *words = shlex.split(self._stages[name].cmd)
        ours = words[:2] == ["-m", "pipeline"] and words[2] in STAGES
        return seconds_of_command(words[2], words[3:]) if ours else 0.0

    def _record(self, name: str) -> None:
        stage = self._stages[name]
        uncached = any(not o.use_cache for o in stage.outs if not (o.is_metric or o.is_plot))
        stage.save(run_cache=not uncached)
        stage.commit()
        stage.dump(update_pipeline=False)


@contextmanager
def _refused_in_words() -> Iterator[None]:
    """Turn what DVC refuses, such as an output that a command did not leave, into a sentence.

    Raises:
        PipelineError: With that sentence.
    """
    try:
        yield
    except DvcException as error:
        raise PipelineError(str(error)) from error
