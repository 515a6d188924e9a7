"""`paper` with a command in place of each stage: failures, what goes on, the report at the end."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.data.files import read_json
from pipeline.engine.scheduler import Command
from pipeline.stages.whole_run import UnitTasks

SOLVERS = ["neural=[cycleik]", "numerical=[lm]", "seeded=[]"]
WITHOUT = ["tune_robots=[]", "detector_robots=[]", "grasp_robots=[]"]
ARGUMENTS = ["profile=smoke", "robots=[nico]", *SOLVERS, *WITHOUT]
MAKE = """
import pathlib, sys
folder, name, *paths = sys.argv[1:]
if pathlib.Path(folder, "fail-" + name).exists():
    sys.exit(f"error: {name} cannot be made")
for path in map(pathlib.Path, paths):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
with open(pathlib.Path(folder, "ran"), "a") as stream:
    print(name, file=stream)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    def command(tasks: UnitTasks, name: str) -> Command:
        outputs = map(str, tasks._units[name].outputs)
        return Command([sys.executable, "-c", MAKE, str(tmp_path), name, *outputs])

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # cores are held among these tasks
    monkeypatch.setattr(UnitTasks, "command", command)
    return tmp_path


def ran(folder: Path, status: int = 0) -> list[str]:
    """Call the command; returns the names of the units that were made."""
    (folder / "ran").unlink(missing_ok=True)
    assert main(["paper", *ARGUMENTS, f"results_dir={folder}"]) == status
    return (folder / "ran").read_text().split()


def test_a_failure_stops_what_needs_it_alone_and_the_next_call_goes_on(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "fail-train-nico").touch()
    names = ran(folder, status=1)
    assert names[:-1] == ["dataset-nico", "evaluate_numerical-nico-lm"]
    assert names[-1] == "report", "of what there is"
    said = capsys.readouterr()
    assert said.out.splitlines()[0].startswith("6 of 6 tasks to run, ")
    assert said.out.splitlines()[-1] == str(folder / "report.html")
    log = folder / "logs" / "train-nico.log"
    failures = [line for line in said.err.splitlines() if line.startswith("error: ")]
    assert failures[0] == f"error: train-nico failed (error: train-nico cannot be made), see {log}"
    assert len(failures) == 3
    assert read_json(folder / "whole_run" / "dataset-nico.json")["seconds"] > 0

    (folder / "fail-train-nico").unlink()
    names = ran(folder)
    assert names[0] == "train-nico"
    assert sorted(names[1:-1]) == ["evaluate_neural-nico-cycleik", "plan-nico"]
    assert names[-1] == "report"


@pytest.mark.parametrize("value", ["0", "0.5", "two"])
def test_a_number_of_processes_that_cannot_be_is_refused(
    value: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["paper", f"processes={value}"]) == 2
    assert "processes must be a whole number from 1" in capsys.readouterr().err


def test_a_plan_that_is_asked_for_in_capitals_runs_nothing(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["paper", *ARGUMENTS, f"results_dir={folder}", "plan=True"]) == 0
    assert "6 of 6 tasks to run" in capsys.readouterr().out
    assert not (folder / "ran").exists()
