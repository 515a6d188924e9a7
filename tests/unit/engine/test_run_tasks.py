"""The seam of the engines: results in order, failures as a sentence, deaths that spare others."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from pipeline.config import compose
from pipeline.engine.config import EngineConfig
from pipeline.engine.cores import usable_cores
from pipeline.engine.running import fans_out, one_machine, run_tasks, threads_of, try_tasks
from pipeline.engine.task import TaskFault
from pipeline.errors import ConfigError, EngineError, PipelineError
from tests import engine_tasks

PROCESSES = ["engine=local", "engine.workers=2", "engine.cpus=1"]
DEBUG = ["engine=slurm", "engine.cluster=debug", "engine.workers=2"]
needs_submitit = pytest.mark.skipif(
    importlib.util.find_spec("submitit") is None, reason="submitit is not installed (extra cluster)"
)
ENGINES = [
    pytest.param(["engine=local"], id="here"),
    pytest.param(PROCESSES, id="processes"),
    pytest.param(DEBUG, id="submitit", marks=needs_submitit),
]
APART = ENGINES[1:2]


@cache
def composed(*arguments: str) -> EngineConfig:
    return compose(arguments).engine


def engine(arguments: list[str], folder: Path) -> EngineConfig:
    return replace(composed(*arguments), folder=str(folder))


@pytest.mark.parametrize("arguments", ENGINES)
def test_results_stand_in_the_order_of_the_tasks(arguments: list[str], tmp_path: Path) -> None:
    finished: dict[int, int] = {}
    where = engine(arguments, tmp_path)
    results = run_tasks(where, engine_tasks.square, range(5), finished.__setitem__)
    assert results == [0, 1, 4, 9, 16]
    assert finished == dict(enumerate(results))
    assert run_tasks(where, engine_tasks.square, []) == []
    assert not list(tmp_path.rglob("*")), "what travelled is left behind"


@pytest.mark.parametrize("arguments", APART)
def test_tasks_leave_this_process_and_get_the_threads_that_were_requested(
    arguments: list[str], tmp_path: Path
) -> None:
    where = engine(arguments, tmp_path)
    assert os.getpid() not in run_tasks(where, engine_tasks.process, range(3))
    assert run_tasks(where, engine_tasks.threads, range(2)) == ["1", "1"]


@pytest.mark.parametrize("arguments", ENGINES)
def test_what_a_task_refuses_is_a_sentence_and_what_ended_before_is_kept(
    arguments: list[str], tmp_path: Path
) -> None:
    kept: dict[int, int] = {}
    with pytest.raises(PipelineError, match="number 2 cannot be"):
        run_tasks(engine(arguments, tmp_path), engine_tasks.fail_at_two, range(6), kept.__setitem__)
    assert {0, 1} & set(kept)
    assert 2 not in kept


@pytest.mark.parametrize("arguments", APART)
def test_a_fault_of_the_code_brings_its_traceback_home(
    arguments: list[str], tmp_path: Path
) -> None:
    with pytest.raises(TaskFault, match=r"(?s)ZeroDivisionError.*engine_tasks\.py"):
        run_tasks(engine(arguments, tmp_path), engine_tasks.divide, [0, 1])


def test_a_killed_process_loses_its_own_task_only(tmp_path: Path) -> None:
    where = engine(PROCESSES, tmp_path)
    endings = dict(try_tasks(where, engine_tasks.die_at_one, range(5)))
    assert [number for number, outcome in endings.items() if outcome.lost] == [1]
    assert sorted(outcome.value for n, outcome in endings.items() if n != 1) == [0, 2, 3, 4]
    kept: dict[int, int] = {}
    with pytest.raises(EngineError, match=r"1 of 5 tasks .* \(number 1\): .*killed.* is kept"):
        run_tasks(where, engine_tasks.die_at_one, range(5), kept.__setitem__)
    assert sorted(kept) == [0, 2, 3, 4]


def test_a_worker_that_is_killed_while_it_waits_is_replaced(tmp_path: Path) -> None:
    where = replace(engine(PROCESSES, tmp_path), workers=2)
    processes: list[int] = []

    def kill(_: int, process: int) -> None:
        if not processes:
            os.kill(process, signal.SIGKILL)
            time.sleep(0.5)  # until its pool has noticed
        processes.append(process)

    run_tasks(where, engine_tasks.process, range(4), kill)
    assert len(processes) == 4
    assert processes.count(processes[0]) == 1


def test_what_cannot_travel_is_reported_and_not_waited_for(tmp_path: Path) -> None:
    with pytest.raises(TaskFault, match="pickle"):
        run_tasks(engine(PROCESSES, tmp_path), engine_tasks.unpicklable, range(2))


def test_workers_end_with_a_failed_run_and_with_a_killed_parent(tmp_path: Path) -> None:
    where, path = engine(PROCESSES, tmp_path), tmp_path / "first"
    with pytest.raises(PipelineError, match="no path"):
        run_tasks(where, engine_tasks.say_and_sleep, [str(path), f"after {path}"])
    _all_gone([path])

    names = [str(tmp_path / name) for name in ("second", "third")]
    code = (
        "from pipeline.config import compose\nfrom pipeline.engine.running import run_tasks\n"
        "from tests.engine_tasks import say_and_sleep\n"
        f"run_tasks(compose({PROCESSES!r}).engine, say_and_sleep, {names!r})"
    )
    with subprocess.Popen([sys.executable, "-c", code]) as parent:
        _wait_for([Path(name) for name in names])
        parent.kill()
    _all_gone([Path(name) for name in names])


def test_tasks_side_by_side_hold_cores_of_their_own(tmp_path: Path) -> None:
    where = replace(engine(PROCESSES, tmp_path), workers=3)
    places = run_tasks(where, engine_tasks.hold_core, [str(tmp_path / "core")] * 6)
    assert set(places) <= set(range(usable_cores()))


def test_where_tasks_run_and_on_how_many_threads() -> None:
    local, slurm, ray = (composed(f"engine={name}") for name in ("local", "slurm", "ray"))
    assert not fans_out(local)
    assert fans_out(replace(local, workers=2))
    assert fans_out(slurm)
    assert one_machine(local)
    assert one_machine(replace(slurm, cluster="local"))
    assert not one_machine(slurm)
    assert one_machine(ray)
    assert not one_machine(replace(ray, address="auto"))
    assert threads_of(replace(local, workers=1000)) == 1
    assert threads_of(replace(local, cpus=3)) == 3


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["engine=slum"], "did you mean 'slurm'"),
        (["engine.partition=short"], "no key in engine: 'partition'"),
        (["engine=slurm", "engine.workers=0"], "engine.workers must be at least 1"),
        (["engine=slurm", "engine.cluster=lokal"], "engine.cluster must be one of slurm, local"),
        (["engine=slurm", "engine.minutes=0"], "engine.minutes must be greater than 0"),
        (["engine=ray", "engine.address=''"], "engine.address must be local"),
        (["engine.name=dask"], "local, slurm, ray"),
    ],
)
def test_settings_that_cannot_be_are_refused(overrides: list[str], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        compose(overrides)


@needs_submitit
def test_a_cluster_that_is_not_there_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(EngineError, match=r"srun.*set engine\.cluster=local"):
        run_tasks(engine(["engine=slurm"], tmp_path), engine_tasks.square, range(2))


@pytest.mark.parametrize(("arguments", "name"), [(DEBUG, "submitit"), (["engine=ray"], "ray")])
def test_a_missing_extra_is_a_sentence(
    arguments: list[str], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(EngineError, match=rf"package {name}.*pip install 'cycleik-bench\["):
        run_tasks(engine(arguments, tmp_path), engine_tasks.square, range(2))


def _wait_for(paths: list[Path]) -> None:
    deadline = time.monotonic() + 60
    while not all(path.exists() and path.read_text() for path in paths):
        assert time.monotonic() < deadline, "the workers do not start"
        time.sleep(0.02)


def _all_gone(paths: list[Path]) -> None:
    numbers = [int(path.read_text()) for path in paths]
    deadline = time.monotonic() + 20
    while any(_alive(number) for number in numbers):
        assert time.monotonic() < deadline, "a worker outlives its parent"
        time.sleep(0.05)


def _alive(number: int) -> bool:
    try:
        status = Path(f"/proc/{number}/stat").read_text()
    except OSError:
        return False
    return status.rsplit(")", 1)[1].split()[0] != "Z"
