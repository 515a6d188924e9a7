"""`reproduce`: what `dvc repro` does, several tasks at a time, with what it will take and took."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.commands.arguments import command_parser
from pipeline.config import bench_lists
from pipeline.data.files import read_json, read_yaml, write_json
from pipeline.errors import PipelineError
from pipeline.locations import CONF_DIR, need_checkout
from pipeline.progress import LOGGER, last_line
from pipeline.stages.dvc_file import CODE
from pipeline.stages.dvc_tasks import DvcTasks
from pipeline.stages.schedule import (
    Estimates,
    makespan,
    priorities,
    ready,
    stale_tasks,
    step_of,
)

DESCRIPTION = """\
reproduce [processes=2]

Brings every stage of dvc.yaml up to date as `dvc repro` does, as many tasks at a time as
`processes` of conf/bench.yaml says, each on cores of its own. Says at the start what that will take
and at the end what each stage took. Each task writes its log below the results folder.
"""
LOGS, DURATIONS = "logs", "durations.json"  # below the results folder of the profile


def reproduce(arguments: list[str]) -> int:
    """Bring all stages up to date; status 2 where a task fails."""
    given = command_parser("reproduce", DESCRIPTION).takes_overrides().parse(arguments).overrides
    bench = bench_lists()
    cores = sorted(os.sched_getaffinity(0))
    places = min(_processes(given, int(bench["processes"])), len(cores))
    folder = need_checkout("reproduce")
    results = folder / "results" / str(bench["profile"])
    began = time.monotonic()
    with DvcTasks(folder) as tasks:
        run = Reproduction(tasks, results, _estimates(results, bench), places)
        run.code()
        run.announce()
        run.everything([cores[place::places] for place in range(places)])
    run.report(time.monotonic() - began)
    return 0


def _processes(given: list[str], usual: int) -> int:
    for argument in given:
        key, _, value = argument.partition("=")
        if key != "processes" or not value.isdigit() or int(value) < 1:
            raise PipelineError(f"reproduce takes processes=N with N from 1, got {argument}")
        usual = int(value)
    return usual


def _estimates(results: Path, bench: dict[str, Any]) -> Estimates:
    path = results / DURATIONS
    given = read_yaml(CONF_DIR / "durations.yaml").get(bench["profile"]) or {}
    return Estimates(read_json(path) if path.exists() else {}, given)


@dataclass
class Running:
    """A task that runs: its process, its place, its log, and when it began."""

    task: str
    process: subprocess.Popen[bytes]
    place: int
    log: Path
    began: float


@dataclass
class Reproduction:
    """Stale tasks, side by side.

    Attributes:
        tasks: As DVC knows them.
        results: Folder of the profile's results.
        estimates: What each task takes.
        places: How many run at a time.
        left: Stale tasks that have not begun.
        took: Wall and processor time of those that ended [s].
    """

    tasks: DvcTasks
    results: Path
    estimates: Estimates
    places: int
    left: set[str] = field(default_factory=set)
    took: dict[str, tuple[float, float]] = field(default_factory=dict)

    def code(self) -> None:
        """Write down what code the tasks depend on, which decides what is stale."""
        self.tasks.begin(CODE)
        command, given = self.tasks.command(CODE)
        subprocess.run(command, check=True, **given)
        self.tasks.finish(CODE)

    def announce(self) -> None:
        """Say what is to be done and how long that takes."""
        others = [task for task in self.tasks.needs if task != CODE]
        changed = {task for task in others if self.tasks.is_stale(task)}
        self.left = stale_tasks(self.tasks.needs, changed) - {CODE}
        if not self.left:
            LOGGER.info("all %d tasks are up to date", len(others))
            return
        LOGGER.info(
            "%d of %d tasks to run, %d at a time: %s, of which",
            len(self.left), len(others), self.places, self._remaining(self.left),
        )  # fmt: skip
        for step, tasks in _by_step(self.left).items():
            seconds = sum(self.estimates.seconds(task) for task in tasks)
            LOGGER.info("  %-20s %3d  %s of one core", step, len(tasks), _minutes(seconds))

    def everything(self, cores: list[list[int]]) -> None:
        """Run what is stale, the longest way to go first.

        Args:
            cores: Those of each place.

        Raises:
            PipelineError: A task failed; what ran beside it was finished and is kept.
        """
        order = priorities(self.tasks.needs, self.estimates)
        done = set(self.tasks.needs) - self.left
        running: dict[int, Running] = {}
        failed: list[Running] = []
        total = len(self.left)
        with _ended_with_us(running):
            while running or (self.left and not failed):
                free = [place for place in range(self.places) if place not in _places(running)]
                able = [] if failed else ready(self.tasks.needs, self.left, done, order)
                if free and able:
                    task = able[0]
                    self.left.remove(task)
                    if not self.tasks.is_stale(task) or not self.tasks.begin(task):
                        done.add(task)  # its inputs came out as they were, or the run is known
                        continue
                    started = self._start(task, free[0], cores[free[0]])
                    running[started.process.pid] = started
                    continue
                ended, used = _wait(running)
                if ended.process.returncode:
                    failed.append(ended)
                    continue
                self.tasks.finish(ended.task)
                done.add(ended.task)
                self._note(ended, used)
                waiting = self.left | {each.task for each in running.values()}
                LOGGER.info(
                    "%d of %d: %s, %.0f s; %s left",
                    total - len(waiting), total, ended.task, self.took[ended.task][0],
                    self._remaining(waiting),
                )  # fmt: skip
        if failed:
            raise PipelineError("; ".join(map(_problem, failed)))

    def report(self, seconds: float) -> None:
        """Say what each stage took.

        Args:
            seconds: What the run took.
        """
        for step, tasks in _by_step(self.took).items():
            wall = sum(self.took[task][0] for task in tasks)
            core = sum(self.took[task][1] for task in tasks)
            LOGGER.info("  %-20s %3d  %6.0f s, %6.0f of a core", step, len(tasks), wall, core)
        LOGGER.info("%s in all", _minutes(seconds))

    def _start(self, task: str, place: int, cores: list[int]) -> Running:
        log = self.results / LOGS / f"{task}.log"
        log.parent.mkdir(parents=True, exist_ok=True)
        command, given = self.tasks.command(task)
        ours = os.sched_getaffinity(0)
        os.sched_setaffinity(0, cores)  # a child begins with the cores of its parent
        try:
            with log.open("wb") as stream:
                process = subprocess.Popen(command, stdout=stream, stderr=stream, **given)
        finally:
            os.sched_setaffinity(0, ours)
        return Running(task, process, place, log, time.monotonic())

    def _note(self, ended: Running, used: float) -> None:
        self.took[ended.task] = (time.monotonic() - ended.began, used)
        seconds = {task: round(wall, 1) for task, (wall, _) in self.took.items()}
        write_json(self.results / DURATIONS, {**self.estimates.own, **seconds})

    def _remaining(self, tasks: set[str]) -> str:
        seconds = makespan(self.tasks.needs, tasks, self.estimates, self.places)
        unknown = [task for task in tasks if self.estimates.seconds(task) == 0]
        known = [f"about {_minutes(seconds)}"] if seconds or not unknown else []
        return " and ".join([*known, *([f"{len(unknown)} of unknown length"] if unknown else [])])


def _by_step(tasks: Iterator[str] | set[str] | dict[str, Any]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for task in sorted(tasks):
        found.setdefault(step_of(task), []).append(task)
    return found


def _places(running: dict[int, Running]) -> set[int]:
    return {each.place for each in running.values()}


def _wait(running: dict[int, Running]) -> tuple[Running, float]:
    """Wait for the next process that ends; returns it and its processor time [s]."""
    while True:
        number, status, used = os.wait4(-1, 0)
        if (ended := running.pop(number, None)) is not None:
            ended.process.returncode = os.waitstatus_to_exitcode(status)
            return ended, used.ru_utime + used.ru_stime


@contextmanager
def _ended_with_us(running: dict[int, Running]) -> Iterator[None]:
    """Let no task outlive this process: Ctrl-C and SIGTERM end them, and what they kept stays."""
    try:
        yield
    except BaseException:
        for each in running.values():
            each.process.terminate()
        for each in running.values():
            each.process.wait()
        raise


def _problem(failed: Running) -> str:
    reason = last_line(failed.log) or failed.process.returncode
    return f"{failed.task} failed ({reason}), see {failed.log}"


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
