"""Tasks side by side, each a command on cores that it holds alone; what they took, what failed."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from pipeline.engine.cores import HELD, take_cores, usable_cores
from pipeline.engine.order import Needs, among, makespan, priorities, ready, stale_tasks, step_of
from pipeline.errors import PipelineError
from pipeline.progress import LOGGER, WholeBar, last_line

LOGS = "logs"  # folder below the results: what each task said
POLL_S = 0.2
REDRAW_S = 1.0
DEATH_OF_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
IN_ORDER = {
    "PYTHONUNBUFFERED": "1"
}  # else what is printed stands in the log behind what went wrong
LIBC = ctypes.CDLL(None)  # here, since a new process had better load nothing before its command


@dataclass(frozen=True)
class Command:
    """What a task runs.

    Attributes:
        words: Program and arguments.
        folder: Where it runs.
        environment: Its variables.
    """

    words: Sequence[str]
    folder: Path = field(default_factory=Path.cwd)
    environment: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))


class Tasks(Protocol):
    """Where tasks come from, by their names, and who knows which of them are done."""

    @property
    def needs(self) -> Needs:
        """Names of the tasks that each task reads what they leave."""
        ...

    def is_stale(self, name: str) -> bool:
        """Whether a task must run, as far as one can say before those that it needs have run."""
        ...

    def begin(self, name: str) -> bool:
        """Prepare a stale task; whether its command must run."""
        ...

    def command(self, name: str) -> Command:
        """Return what a task runs."""
        ...

    def finish(self, name: str, seconds: float) -> None:
        """Write down that a task has succeeded, and how long it took [s]."""
        ...

    def seconds(self, name: str) -> float:
        """Return what a task is expected to take [s]."""
        ...


@dataclass
class _Running:
    name: str
    process: subprocess.Popen[bytes]
    began: float
    cores: ExitStack


@dataclass
class _Work:
    """Tasks of one call: what they need of each other, and how far each is."""

    needs: Needs
    seconds: dict[str, float]
    left: set[str]
    order: dict[str, float]
    done: set[str] = field(default_factory=set)
    running: list[_Running] = field(default_factory=list)


class Scheduler:
    """Runs tasks as many at a time as there are places, those with the longest way to go first.

    Attributes:
        took: Wall and processor time of those that succeeded [s], by name.
        failed: A sentence for each that failed or was not run since it needs one that did.
    """

    def __init__(self, tasks: Tasks, results: Path, places: int, cores: int = 1) -> None:
        """Run nothing yet.

        Args:
            tasks: Of which `run` is given some.
            results: Folder of results, below which logs lie.
            places: How many run at a time; no more than there are cores.
            cores: That each holds; 0 shares all that there are evenly.
        """
        self.places = min(places, usable_cores())
        self.took: dict[str, tuple[float, float]] = {}
        self.failed: dict[str, str] = {}
        self._tasks = tasks
        self._logs = results / LOGS
        self._cores = cores or usable_cores() // self.places
        self._began = time.monotonic()
        self._waits = False

    def stale(self, names: Collection[str]) -> set[str]:
        """Return those of some tasks that must run, and those that build on them."""
        changed = {name for name in names if self._tasks.is_stale(name)}
        return stale_tasks(among(self._tasks.needs, names), changed)

    def plan(
        self, names: Collection[str], stale: Collection[str], left_out: Collection[str] = ()
    ) -> str:
        """Return what will be done, step by step, and how long that takes.

        Args:
            names: Of all tasks.
            stale: Those that will run.
            left_out: Those that will not, though they are not done.
        """
        if not stale:
            return f"all {len(names)} tasks are up to date"
        seconds = {name: self._tasks.seconds(name) for name in stale}
        whole = makespan(self._tasks.needs, stale, seconds, self.places)
        cores = "a core" if self._cores == 1 else f"{self._cores} cores"
        lines = [
            f"{len(stale)} of {len(names)} tasks to run, {self.places} at a time, each on {cores} "
            f"of its own: about {duration(whole)}",
            f"{'step':<20} {'tasks':>5} {'left out':>9} {'to run':>7} {'of one core':>12}",
        ]
        for step, mine in by_step(names).items():
            times = [seconds[name] for name in mine if name in stale]
            left = len({*mine} & {*left_out})
            time_of = duration(sum(times)) if times else "-"
            lines.append(f"{step:<20} {len(mine):>5} {left:>9} {len(times):>7} {time_of:>12}")
        return "\n".join(lines)

    def run(self, stale: Collection[str]) -> None:
        """Run stale tasks; what another one leaves fresh in the meantime is passed over.

        Where a task fails, what does not need it goes on. Where this process is interrupted or
        dies, commands end with it; what they keep is theirs.

        Args:
            stale: Their names; what they need besides is there.
        """
        needs = among(self._tasks.needs, stale)
        seconds = {name: self._tasks.seconds(name) for name in stale}
        work = _Work(needs, seconds, {*stale}, priorities(needs, seconds))
        whole, drawn = self._seconds_left(work), -REDRAW_S
        with _ended_with_us(work.running), closing(WholeBar()) as bar:
            while work.left or work.running:
                while self._settle_one(work):
                    pass
                if whole and time.monotonic() - drawn > REDRAW_S:
                    left, drawn = self._seconds_left(work), time.monotonic()
                    bar.show(1.0 - left / whole, self._so_far(work, left))
                time.sleep(POLL_S)
                for each in [*work.running]:
                    self._collect(each, work)

    def report(self) -> None:
        """Say what each step took, and what did not succeed."""
        for step, names in by_step(self.took).items():
            wall = sum(self.took[name][0] for name in names)
            core = sum(self.took[name][1] for name in names)
            LOGGER.info("%-20s %5d  %6.0f s, %6.0f of a core", step, len(names), wall, core)
        LOGGER.info("%s in all", duration(time.monotonic() - self._began))
        for sentence in self.failed.values():
            LOGGER.error("error: %s", sentence)

    def _settle_one(self, work: _Work) -> bool:
        """Begin one task, or find that it need not or cannot run; False where all must wait."""
        for name in sorted(work.left):
            if bad := sorted(work.needs[name] & self.failed.keys()):
                work.left.remove(name)
                self.failed[name] = f"{name} was not run: it needs {bad[0]}, which failed"
                return True
        able = ready(work.needs, work.left, work.done, work.order)
        if not able or len(work.running) >= self.places:
            return False
        with ExitStack() as cores:
            first = take_cores(self._cores, cores)
            if first is None:
                self._say_waiting(work)
                return False
            work.left.remove(able[0])
            try:
                if self._tasks.is_stale(able[0]) and self._tasks.begin(able[0]):
                    work.running.append(self._start(able[0], first, cores.pop_all()))
                else:
                    work.done.add(able[0])
            except PipelineError as error:
                self.failed[able[0]] = f"{able[0]} failed ({error})"
        return True

    def _start(self, name: str, first: int, cores: ExitStack) -> _Running:
        command = self._tasks.command(name)
        numbers = sorted(os.sched_getaffinity(0))[first : first + self._cores]
        threads = dict.fromkeys(THREADS, str(len(numbers)))
        held = {HELD: "-".join(["-within", *map(str, numbers)])}
        log = self._log(name)
        log.parent.mkdir(parents=True, exist_ok=True)
        with log.open("wb") as stream:
            process = subprocess.Popen(
                command.words,
                cwd=command.folder,
                env={**command.environment, **threads, **held, **IN_ORDER},
                stdout=stream,
                stderr=subprocess.STDOUT,
                preexec_fn=_on_cores(numbers),
            )
        return _Running(name, process, time.monotonic(), cores)

    def _collect(self, each: _Running, work: _Work) -> None:
        """Note how a task ended, if it has."""
        number, status, used = os.wait4(each.process.pid, os.WNOHANG)
        if not number:
            return
        seconds = time.monotonic() - each.began
        each.process.returncode = os.waitstatus_to_exitcode(status)
        each.cores.close()
        work.running.remove(each)
        name, log = each.name, self._log(each.name)
        why = (last_line(log) or f"status {each.process.returncode}") if status else ""
        try:
            if not status:
                self._tasks.finish(name, seconds)
        except PipelineError as error:
            why = str(error)
        if why:
            self.failed[name] = f"{name} failed ({why}), see {log}"
            LOGGER.info("%s", self.failed[name])
        else:
            work.done.add(name)
            self.took[name] = seconds, used.ru_utime + used.ru_stime
            LOGGER.debug("%s done in %.0f s", name, seconds)

    def _so_far(self, work: _Work, left: float) -> str:
        """Say how many tasks have ended, what is left, and what runs."""
        ended = len(work.needs) - len(work.left) - len(work.running)
        now = ", ".join(each.name for each in work.running)
        return f"{ended} of {len(work.needs)} tasks; about {duration(left)} left; now {now or '-'}"

    def _seconds_left(self, work: _Work) -> float:
        """Return what tasks will take that run or wait and can succeed [s]."""
        gone = {each.name: time.monotonic() - each.began for each in work.running}
        bad = {name for name in work.needs if name in self.failed}
        able = {*work.left, *gone} - stale_tasks(work.needs, bad)
        seconds = {n: max(work.seconds[n] - gone.get(n, 0.0), 0.0) for n in able}
        return makespan(work.needs, able, seconds, self.places)

    def _say_waiting(self, work: _Work) -> None:
        if not work.running and not self._waits:
            LOGGER.info("waiting for cores: other runs on this machine hold them")
            self._waits = True

    def _log(self, name: str) -> Path:
        return self._logs / f"{name}.log"


def by_step(names: Iterable[str]) -> dict[str, list[str]]:
    """Return names of tasks by the names of their steps, both in the order in which they come."""
    found: dict[str, list[str]] = {}
    for name in names:
        found.setdefault(step_of(name), []).append(name)
    return found


def duration(seconds: float) -> str:
    """Return a time as one reads it: seconds, minutes or hours."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 90 * 60 else f"{seconds / 3600:,.1f} h"


def _on_cores(numbers: Sequence[int]) -> Callable[[], None]:
    """What a new process does first: keep to its cores, and let it end when its parent does."""
    parent = os.getpid()

    def begin() -> None:
        os.sched_setaffinity(0, numbers)
        LIBC.prctl(DEATH_OF_PARENT, signal.SIGTERM)
        if os.getppid() != parent:  # it died before it could be said
            os._exit(1)

    return begin


@contextmanager
def _ended_with_us(running: Sequence[_Running]) -> Iterator[None]:
    """Let no task outlive what is done here."""
    try:
        yield
    finally:
        for each in running:
            each.process.terminate()
        for each in running:
            each.process.wait()
            each.cores.close()
