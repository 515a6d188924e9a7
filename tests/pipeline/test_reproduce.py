"""`reproduce` on small pipelines of DVC: side by side, recorded as DVC does, nothing lost."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from pipeline.commands import reproduce as module
from pipeline.commands.reproduce import reproduce
from pipeline.engine.cores import usable_cores
from pipeline.progress import set_up_logging
from pipeline.stages.dvc_file import CODE
from pipeline.stages.dvc_tasks import DvcTasks

pytestmark = pytest.mark.skipif(usable_cores() < 2, reason="the tasks wait for each other")
ROOT = Path(__file__).parents[2]

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
  other:
    cmd: python write.py other.txt data-b.txt
    deps: [data-b.txt]
    outs: [other.txt]
"""
WRITE = """\
import sys, time, pathlib
path, *sources = sys.argv[1:]
begun = {"data-a.txt": "data-b.txt", "data-b.txt": "data-a.txt"}.get(path, path) + ".begun"
pathlib.Path(path + ".begun").touch()
text = "".join(pathlib.Path(source).read_text() for source in sources)
if "fail" in text and path == "data-a.txt":
    sys.exit("error: data of a cannot be made")
if "hang" in text and path == "plan.txt":
    pathlib.Path("hangs").touch()
    time.sleep(60)
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
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # cores are held among these tasks
    monkeypatch.setattr(module, "need_checkout", lambda _: tmp_path)
    set_up_logging()
    dvc("init", "--no-scm", "-q")
    Path("dvc.yaml").write_text(STAGES)
    Path("write.py").write_text(WRITE)
    Path("source.txt").write_text("one")
    return tmp_path


def dvc(*arguments: str) -> str:
    command = [sys.executable, "-m", "dvc", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def reproduced(project: Path, status: int = 0) -> list[str]:
    """Run what is stale; returns the names of the tasks whose commands ran to their end."""
    path = project / "results" / "quick" / "durations.json"
    path.unlink(missing_ok=True)
    assert reproduce(["processes=2"]) == status
    return sorted({*json.loads(path.read_text())} - {CODE})


def test_tasks_run_side_by_side_and_dvc_knows_of_them(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert reproduced(project) == ["dataset@a", "dataset@b", "other", "plan"]
    assert Path("plan.txt").read_text() == "onexx"
    assert dvc("status", "dataset", "plan").strip() == "Data and pipelines are up to date."
    assert reproduced(project) == []
    assert "all 4 tasks are up to date" in capsys.readouterr().err


def test_an_edit_reruns_what_reads_it_and_the_run_cache_knows_the_rest(project: Path) -> None:
    reproduced(project)
    Path("source.txt").write_text("two")
    assert reproduced(project) == ["dataset@a", "dataset@b", "other", "plan"]
    Path("source.txt").write_text("one")
    assert reproduced(project) == [], "these results are in DVC's run cache"
    assert Path("plan.txt").read_text() == "onexx"
    Path("data-b.txt").unlink()
    assert reproduced(project) == []
    assert Path("data-b.txt").read_text() == "onex"


def test_a_failure_is_listed_with_its_log_and_what_does_not_need_it_goes_on(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("source.txt").write_text("fail")
    assert reproduced(project, status=2) == ["dataset@b", "other"]
    log = project / "results" / "quick" / "logs" / "dataset@a.log"
    assert capsys.readouterr().err.splitlines()[-2:] == [
        f"error: dataset@a failed (error: data of a cannot be made), see {log}",
        "error: plan was not run: it needs dataset@a, which failed",
    ]
    assert not Path("plan.txt").exists()
    Path("write.py").write_text(Path("write.py").read_text().replace('"fail" in text', "False"))
    assert reproduced(project) == ["dataset@a", "plan"]


def test_a_command_that_leaves_nothing_fails(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("write.py").write_text(WRITE + "if path == 'other.txt': pathlib.Path(path).unlink()\n")
    assert reproduced(project, status=2) == ["dataset@a", "dataset@b", "plan"]
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith("error: other failed (") and "other.txt" in said


def test_without_the_code_of_the_tasks_nothing_is_run(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("dvc.yaml").write_text(STAGES.replace("write.py code.txt", "missing.py"))
    assert reproduce([]) == 2
    assert "error: code failed (" in capsys.readouterr().err
    assert not Path("data-a.txt").exists()


def test_it_says_what_is_to_be_done_and_what_it_took(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = project / "results" / "quick"
    folder.mkdir(parents=True)
    took = {"dataset@a": 60, "dataset@b": 60, "plan": 30, "other": 100}
    (folder / "durations.json").write_text(json.dumps(took))
    assert reproduce(["processes=2"]) == 0
    said = capsys.readouterr().err.splitlines()
    assert said[1].startswith("4 of 4 tasks to run, 2 at a time, each on")
    assert said[1].endswith("of its own: about 3 min")
    assert "dataset 2 0 2 2 min" in [" ".join(line.split()) for line in said]
    listed = (folder / "logs" / "reproduce.log").read_text()
    assert all(f" {name} done in " in listed for name in ("code", *took))
    assert not any(" done in " in line for line in said), "a terminal sees one bar"
    assert said[-1].endswith(" s in all")
    now = json.loads((folder / "durations.json").read_text())
    assert all(now[name] < seconds for name, seconds in took.items()), "measured anew"
    with DvcTasks(project, folder) as tasks:
        assert tasks.seconds("plan") == now["plan"]


def test_killed_in_the_middle_it_goes_on(project: Path) -> None:
    Path("source.txt").write_text("hang")
    program = (
        "from pathlib import Path; from pipeline.commands import reproduce as module\n"
        f"module.need_checkout = lambda _: Path({str(project)!r})\n"
        "module.reproduce(['processes=2'])"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(project)}
    with subprocess.Popen([sys.executable, "-c", program], env=environment) as child:
        until = time.monotonic() + 60
        while not Path("hangs").exists() or not Path("other.txt").exists():
            assert child.poll() is None and time.monotonic() < until
            time.sleep(0.01)
        time.sleep(1.0)  # until `other` is written down
        child.send_signal(signal.SIGKILL)
    assert not Path("plan.txt").exists()
    Path("hangs").unlink()
    Path("write.py").write_text(WRITE.replace('"hang" in text', "False"))
    assert reproduced(project) == ["plan"]
    assert Path("plan.txt").read_text() == "hangxx"


@pytest.mark.parametrize("argument", ["processes=0", "processes=two", "robots=[nico]"])
def test_what_it_does_not_take_is_refused(project: Path, argument: str) -> None:
    with pytest.raises(module.PipelineError, match=r"reproduce takes|whole number from 1"):
        reproduce([argument])
