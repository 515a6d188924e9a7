"""Commands on cores of their own: order, failures, and what comes after an interruption."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pipeline.engine import unattended
from pipeline.engine.unattended import CoreTask, run_on_cores

QUICK = ("robots", "--help")


def run(
    tasks: list[CoreTask], folder: Path, processes: int = 2
) -> tuple[list[str], dict[str, str]]:
    ended: list[str] = []
    failed = run_on_cores(tasks, processes, folder, lambda task, status, _: ended.append(task.name))
    return ended, failed


def test_a_task_waits_for_what_it_needs_and_has_a_log(tmp_path: Path) -> None:
    tasks = [CoreTask("b", QUICK, ("a",)), CoreTask("a", QUICK)]
    ended, failed = run(tasks, tmp_path)
    assert (ended, failed) == (["a", "b"], {})
    assert (tmp_path / "a.log").read_text(encoding="utf-8")


def test_what_needs_a_failed_task_is_not_run_and_others_are(tmp_path: Path) -> None:
    bad = CoreTask("bad", ("evalute",))
    ended, failed = run([bad, CoreTask("after", QUICK, ("bad",)), CoreTask("c", QUICK)], tmp_path)
    assert sorted(ended) == ["bad", "c"]
    assert "did you mean 'evaluate'" in failed["bad"]
    assert failed["after"] == "needs bad, which failed"


def test_an_interruption_ends_the_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[int] = []
    start = unattended._start

    def noted(task: CoreTask, logs: Path) -> unattended._Running:
        running = start(task, logs)
        started.append(running.process.pid)
        return running

    def interrupted(_: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(unattended, "_start", noted)
    monkeypatch.setattr(unattended.time, "sleep", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run([CoreTask("a", QUICK)], tmp_path)
    with pytest.raises(ProcessLookupError):
        os.kill(started[0], 0)
