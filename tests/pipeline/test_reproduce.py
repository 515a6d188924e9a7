"""`reproduce` on small pipelines of DVC: side by side, recorded as DVC does, nothing lost."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.commands.reproduce import Reproduction
from pipeline.errors import PipelineError
from pipeline.stages.dvc_tasks import DvcTasks
from pipeline.stages.schedule import Estimates

STAGES = """\
stages:
  code:
    cmd: python write.py code.txt
    always_changed: true
    outs: [{code.txt: {cache: false, persist: true}}]
  dataset:
    matrix: {robot: [a, b]}
    cmd: python write.py data-${item.robot}.txt source.txt
    deps: [code.txt, source.txt]
    outs: ["data-${item.robot}.txt"]
  plan:
    cmd: python write.py plan.txt data-a.txt
    deps: [data-a.txt, data-b.txt]
    outs: [plan.txt]
"""
WRITE = """\
import sys, time, pathlib
path, *sources = sys.argv[1:]
begun = {"data-a.txt": "data-b.txt", "data-b.txt": "data-a.txt"}.get(path, path) + ".begun"
pathlib.Path(path + ".begun").touch()
text = "".join(pathlib.Path(source).read_text() for source in sources)
if "fail" in text and path == "data-a.txt":
    sys.exit("error: data of a cannot be made")
until = time.monotonic() + 60
while not pathlib.Path(begun).exists():  # only beside the other one can it end
    assert time.monotonic() < until
    time.sleep(0.01)
pathlib.Path(path).write_text(text + "x")
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:/usr/bin:/bin")
    monkeypatch.setenv("DVC_NO_ANALYTICS", "1")
    dvc("init", "--no-scm", "-q")
    Path("dvc.yaml").write_text(STAGES)
    Path("write.py").write_text(WRITE)
    Path("source.txt").write_text("one")
    return tmp_path


def dvc(*arguments: str) -> str:
    command = [sys.executable, "-m", "dvc", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def reproduced(project: Path) -> list[str]:
    """Run what is stale; returns the names of the tasks that ran."""
    with DvcTasks(project) as tasks:
        run = Reproduction(tasks, project / "results", Estimates({}, {}), 2)
        run.code()
        run.announce()
        run.everything([[0], [0]])
    return sorted(run.took)


def test_tasks_run_side_by_side_and_dvc_knows_of_them(project: Path) -> None:
    assert reproduced(project) == ["dataset@a", "dataset@b", "plan"]
    assert Path("plan.txt").read_text() == "onexx"
    assert dvc("status", "dataset", "plan").strip() == "Data and pipelines are up to date."
    assert reproduced(project) == []


def test_an_edit_reruns_what_reads_it_and_the_run_cache_knows_the_rest(project: Path) -> None:
    reproduced(project)
    Path("source.txt").write_text("two")
    assert reproduced(project) == ["dataset@a", "dataset@b", "plan"]
    Path("source.txt").write_text("one")
    assert reproduced(project) == [], "these results are in DVC's run cache"
    assert Path("plan.txt").read_text() == "onexx"
    Path("data-b.txt").unlink()
    assert reproduced(project) == []
    assert Path("data-b.txt").read_text() == "onex"


def test_a_failure_names_task_and_log_and_keeps_what_ran_beside_it(
    project: Path,
) -> None:
    Path("source.txt").write_text("fail")
    with pytest.raises(
        PipelineError, match=r"dataset@a failed \(error: data of a cannot be made\)"
    ):
        reproduced(project)
    assert not Path("plan.txt").exists()
    Path("write.py").write_text(Path("write.py").read_text().replace('"fail" in text', "False"))
    assert reproduced(project) == ["dataset@a", "plan"]


def test_it_says_what_is_to_be_done_and_what_it_took(
    project: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.commands.reproduce.LOGGER", logging.getLogger())
    with caplog.at_level(logging.INFO), DvcTasks(project) as tasks:
        run = Reproduction(tasks, project / "results", Estimates({}, {"dataset": 60}), 2)
        run.code()
        run.announce()
        run.everything([[0], [0]])
        run.report(3.0)
    said = caplog.messages
    assert said[0] == (
        "3 of 3 tasks to run, 2 at a time: about 60 s and 1 of unknown length, of which"
    )
    assert said[1].split() == ["dataset", "2", "2", "min", "of", "one", "core"]
    assert any(line.startswith("3 of 3: plan") for line in said)
    assert said[-1] == "3 s in all"
