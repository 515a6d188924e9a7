"""Tasks side by side on cores of their own: order, failures, and what comes of an interruption."""

from __future__ import annotations

import logging
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from pipeline import progress
from pipeline.engine import scheduler as module
from pipeline.engine.cores import own_cores, usable_cores
from pipeline.engine.scheduler import Command, Scheduler, duration
from pipeline.errors import PipelineError
from pipeline.progress import log_file, set_up_logging

DEADLINE_S = 60.0
FINE = "print('fine')"
FAILS = "import sys; print('first'); sys.exit('error: the last line says why')"
SLEEP = time.sleep  # while that of the scheduler is another
LASTS = (
    "import os, pathlib, time; pathlib.Path('begun').write_text(str(os.getpid())); time.sleep(60)"
)


class Listed:
    """Tasks that are Python programs; those in ``fresh`` are done."""

    def __init__(self, folder: Path, programs: dict[str, str], **needs: str) -> None:
        self.folder = folder
        self.programs = programs
        self.needs = {name: frozenset(needs.get(name, "").split()) for name in programs}
        self.fresh = set[str]()
        self.known = set[str]()  # whose result needs no command
        self.refused = set[str]()  # whose result is not taken
        self.expected = dict.fromkeys(programs, 1.0)
        self.began: list[str] = []

    def is_stale(self, name: str) -> bool:
        return name not in self.fresh

    def begin(self, name: str) -> bool:
        self.began.append(name)
        return name not in self.known

    def command(self, name: str) -> Command:
        return Command([sys.executable, "-c", self.programs[name]], self.folder)

    def finish(self, name: str, seconds: float) -> None:
        if name in self.refused:
            raise PipelineError(f"{name} left nothing")
        self.fresh.add(name)

    def seconds(self, name: str) -> float:
        return self.expected[name]


@pytest.fixture(autouse=True)
def cores_of_the_test(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests beside this one hold cores too; none waits for another."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


def run(tasks: Listed, places: int = 1) -> Scheduler:
    scheduler = Scheduler(tasks, tasks.folder, places)
    scheduler.run(scheduler.stale([*tasks.needs]))
    return scheduler


def log(folder: Path, name: str) -> str:
    return (folder / "logs" / f"{name}.log").read_text(encoding="utf-8")


def test_a_task_waits_for_what_it_needs_and_has_a_log(tmp_path: Path) -> None:
    tasks = Listed(tmp_path, {"b": FINE, "a": FINE}, b="a")
    done = run(tasks, places=2)
    assert (tasks.began, [*done.took], done.failed) == (["a", "b"], ["a", "b"], {})
    assert log(tmp_path, "a") == "fine\n"


def test_the_longest_way_goes_first(tmp_path: Path) -> None:
    tasks = Listed(tmp_path, {"a": FINE, "b": FINE, "c": FINE, "d": FINE}, d="c")
    tasks.expected = {"a": 1.0, "b": 3.0, "c": 2.0, "d": 2.0}
    run(tasks)
    assert tasks.began == ["c", "b", "d", "a"]


def test_what_needs_a_failed_task_is_not_run_and_others_are(tmp_path: Path) -> None:
    programs = {"bad": FAILS, "after": FINE, "last": FINE, "c": FINE}
    done = run(Listed(tmp_path, programs, after="bad", last="after"))
    assert [*done.took] == ["c"]
    assert done.failed == {
        "bad": f"bad failed (error: the last line says why), see {tmp_path / 'logs' / 'bad.log'}",
        "after": "after was not run: it needs bad, which failed",
        "last": "last was not run: it needs after, which failed",
    }


def test_a_task_that_says_nothing_fails_with_its_status(tmp_path: Path) -> None:
    done = run(Listed(tmp_path, {"bad": "raise SystemExit(7)"}))
    assert done.failed["bad"].startswith("bad failed (status 7)")


def test_what_is_done_or_known_is_not_run(tmp_path: Path) -> None:
    tasks = Listed(tmp_path, {"a": FAILS, "b": FAILS, "c": FINE, "d": FINE}, c="a b", d="c")
    tasks.fresh, tasks.known = {"a", "d"}, {"b"}
    scheduler = Scheduler(tasks, tmp_path, 1)
    assert scheduler.stale([*tasks.needs]) == {"b", "c", "d"}, "what builds on b may be another"
    scheduler.run({"b", "c", "d"})
    assert ([*scheduler.took], scheduler.failed) == (["c"], {})
    assert tasks.began == ["b", "c"], "d came out as it was"


def test_a_result_that_is_not_taken_is_a_failure(tmp_path: Path) -> None:
    tasks = Listed(tmp_path, {"a": FINE, "b": FINE, "c": FINE}, b="a")
    tasks.refused = {"a"}
    done = run(tasks)
    assert [*done.took] == ["c"]
    assert done.failed["a"].startswith("a failed (a left nothing), see ")
    assert "b" in done.failed


@pytest.mark.skipif(usable_cores() < 2, reason="needs two cores")
def test_tasks_have_cores_and_threads_of_their_own(tmp_path: Path) -> None:
    say = (
        "import os, pathlib, time; me, other = {}; pathlib.Path(me).touch()\n"
        "while not pathlib.Path(other).exists(): time.sleep(0.01)\n"
        "print(*sorted(os.sched_getaffinity(0)), os.environ['OMP_NUM_THREADS'])"
    )
    programs = {"a": say.format(("one", "two")), "b": say.format(("two", "one"))}
    run(Listed(tmp_path, programs), places=2)
    first, second = (log(tmp_path, name).split() for name in programs)
    assert first[0] != second[0]
    assert [first[1], second[1]] == ["1", "1"]


def test_all_cores_are_shared_where_no_number_is_given(tmp_path: Path) -> None:
    tasks = Listed(tmp_path, {"a": "import os; print(len(os.sched_getaffinity(0)))"})
    Scheduler(tasks, tmp_path, 1, cores=0).run({"a"})
    assert int(log(tmp_path, "a")) == usable_cores()


def test_it_waits_for_cores_that_another_run_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    waited: list[float] = []
    holder = own_cores(usable_cores())
    sleep = time.sleep

    def noted(seconds: float) -> None:
        if not waited:
            assert tasks.began == []
            holder.__exit__(None, None, None)
        waited.append(seconds)
        sleep(seconds)

    tasks = Listed(tmp_path, {"a": FINE})
    holder.__enter__()
    monkeypatch.setattr(module.time, "sleep", noted)
    assert [*run(tasks).took] == ["a"]


def test_a_task_may_hold_the_cores_that_are_held_for_it(tmp_path: Path) -> None:
    """An evaluation that fans out asks for cores of its own, within those of its task."""
    inner = "from pipeline.engine.cores import own_cores\nwith own_cores(1) as core: print(core)"
    tasks = Listed(Path(__file__).parents[3], {"a": inner})
    Scheduler(tasks, tmp_path, 1).run({"a"})
    assert log(tmp_path, "a") == "0\n"


def test_it_says_what_it_will_do_what_is_left_and_what_it_took(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LOGGER", logging.getLogger())
    programs = {"data@a": FINE, "data@b": FINE, "plan@a": FINE, "plan@b": FAILS, "out": FINE}
    tasks = Listed(tmp_path, programs)
    tasks.needs |= {"plan@a": frozenset({"data@a"}), "out": frozenset({"plan@a", "plan@b"})}
    tasks.expected = dict.fromkeys(programs, 120.0)
    tasks.fresh = {"data@b"}
    scheduler = Scheduler(tasks, tmp_path, 1)
    stale = scheduler.stale([*programs])
    text = scheduler.plan([*programs, "tune@a"], stale, ["tune@a"]).splitlines()
    assert text[0] == "4 of 6 tasks to run, 1 at a time, each on a core of its own: about 8 min"
    assert [re.split(" {2,}", line) for line in text[2:]] == [
        ["data", "2", "0", "1", "2 min"],
        ["plan", "2", "0", "2", "4 min"],
        ["out", "1", "0", "1", "2 min"],
        ["tune", "1", "1", "0", "-"],
    ]
    with caplog.at_level(logging.DEBUG):
        scheduler.run(stale)
        scheduler.report()
    said = [each.message for each in caplog.records if each.name == "root"]
    assert re.fullmatch(r"data@a done in \d+ s", said[0])
    assert re.fullmatch(r"plan@a done in \d+ s", said[1])
    assert said[2].startswith("plan@b failed (error: the last line says why), see ")
    assert re.fullmatch(r"plan +1 +\d+ s, +\d+ of a core", said[4])
    assert said[-2] == f"error: {said[2]}"
    assert said[-1] == "error: out was not run: it needs plan@b, which failed"


def test_a_terminal_sees_one_bar_and_a_file_each_task(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    set_up_logging()
    tasks = Listed(tmp_path, {"a": "import time; time.sleep(0.4)", "b": FINE}, b="a")
    monkeypatch.setattr(module, "REDRAW_S", 0.0)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with log_file(tmp_path / "all.log"):
        run(tasks)
    assert not [line for line in capsys.readouterr().err.split("\r") if "done in" in line]
    lines = (tmp_path / "all.log").read_text().splitlines()
    assert [re.sub(r"^[-\d]+ [:\d]+ |\d+ s$", "", line) for line in lines] == [
        f"logs: {tmp_path}",
        "a done in ",
        "b done in ",
    ]


def test_elsewhere_a_line_comes_for_each_tenth(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(progress, "LOGGER", logging.getLogger())
    bar = progress.WholeBar()
    with caplog.at_level(logging.INFO):
        for share in (0.0, 0.05, 0.11, 0.12, 0.35, 0.2, 1.0):
            bar.show(share, f"at {share}")
    bar.close()
    assert caplog.messages == [" 10 %  at 0.11", " 30 %  at 0.35", "100 %  at 1.0"]


def test_times_are_read_easily() -> None:
    times = [0, 89.4, 120, 5300, 7200, 4e6]
    assert [*map(duration, times)] == ["0 s", "89 s", "2 min", "88 min", "2.0 h", "1,111.1 h"]


def test_an_interruption_ends_the_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_: float) -> None:
        begun(tmp_path)
        raise KeyboardInterrupt

    monkeypatch.setattr(module.time, "sleep", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(Listed(tmp_path, {"a": LASTS}))
    assert not alive(begun(tmp_path))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_commands_end_with_a_process_that_is_killed(tmp_path: Path, number: signal.Signals) -> None:
    program = (
        "from pathlib import Path; from tests.unit.engine import test_scheduler as t\n"
        f"t.run(t.Listed(Path({str(tmp_path)!r}), {{'a': t.LASTS}}))"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    folder = Path(__file__).parents[3]
    with subprocess.Popen([sys.executable, "-c", program], cwd=folder, env=environment) as parent:
        task = begun(tmp_path)
        parent.send_signal(number)
    until = time.monotonic() + DEADLINE_S
    while alive(task):
        assert time.monotonic() < until, "the task outlives what started it"
        time.sleep(0.01)


def begun(folder: Path) -> int:
    """Wait for the task that lasts; returns its process."""
    until = time.monotonic() + DEADLINE_S
    while not (folder / "begun").exists() or not (folder / "begun").read_text():
        assert time.monotonic() < until, "the task does not begin"
        SLEEP(0.01)
    return int((folder / "begun").read_text())


def alive(process: int) -> bool:
    """Whether a process runs; one that nobody has waited for does not."""
    state = Path(f"/proc/{process}/stat")
    try:
        return state.read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
