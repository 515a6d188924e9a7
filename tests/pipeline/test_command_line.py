"""The command line as a newcomer meets it: help, bad input, sweeps, comparison."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.commands import COMMANDS
from pipeline.commands.run import run_name
from pipeline.config import compose, to_yaml
from pipeline.stages.graph import STAGES

TOY = ["profile=smoke", "dataset.train=400", "dataset.validation=50", "dataset.test=50"]


def run_main(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    status = main(list(arguments))
    captured = capsys.readouterr()
    return status, captured.out, captured.err


@pytest.mark.parametrize("arguments", [(), ("--help",), ("-h",), ("help",)])
def test_help_names_every_stage(capsys: pytest.CaptureFixture[str], arguments: tuple) -> None:
    status, out, _ = run_main(capsys, *arguments)
    assert status == 0
    assert all(stage in out for stage in STAGES)


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_explains_itself(capsys: pytest.CaptureFixture[str], stage: str) -> None:
    status, out, _ = run_main(capsys, stage, "--help")
    assert status == 0
    assert f"python -m pipeline {stage}" in out


@pytest.mark.parametrize(
    ("old", "new"), [("contest", "compare-tuned"), ("ship", "export-weights"), ("where", "paths")]
)
def test_old_command_names_still_act(
    capsys: pytest.CaptureFixture[str], old: str, new: str
) -> None:
    arguments = () if new == "paths" else ("--help",)
    assert run_main(capsys, old, *arguments) == run_main(capsys, new, *arguments)


def test_robots_solvers_and_doctor(capsys: pytest.CaptureFixture[str]) -> None:
    assert "panda_joint1" in run_main(capsys, "robots")[1]
    solvers = run_main(capsys, "solvers")[1]
    assert re.search(r"cycleik +neural", solvers)
    assert re.search(r"placo +numerical +ready", solvers)
    status, out, _ = run_main(capsys, "doctor")
    assert status == 0
    assert "pytorch-kinematics" in out
    assert "accelerator" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["trian"], "did you mean 'train'"),
        (["train", "robot=pandaa"], "did you mean 'panda'"),
        (["train", "train.learning_rat=1"], "did you mean 'learning_rate'"),
        (["train", "train.batch_size=-1"], "greater than 0"),
        (["train", "--fast"], "no option '--fast'"),
        (["evaluate", "evaluate.solvers=[placco]", "profile=smoke"], "did you mean 'placo'"),
        (["grasp", "robot=valkyrie", "profile=smoke"], "no grasp scene"),
        (["grasp", "robot=panda", "profile=paper"], "perception=perfect agent=none"),
        (["paper", "hours=soon"], "hours must be a number greater than 0"),
        (["paper", "hours=nan"], "hours must be a number greater than 0"),
        (["paper", "plan=yes"], "plan takes true or false, got yes"),
        (["compare", "tests"], "required: B"),
        (["compare", "nowhere", "nowhere"], "there is no folder nowhere"),
        (["robot", "add", "x.urdf"], "x.urdf: no such file"),
        (["robots", "all"], "unexpected argument 'all'"),
        (["robot", "ad"], "did you mean 'add'"),
        (["table", "tabel2"], "did you mean 'table2'"),
        (["chat", "--robto=nico"], "no option '--robto=nico'"),
        (["train", "robot=panda", "profile=smoke", "train.from=best"], "pipeline tune"),
        (["all", "robots=[pandaa]"], "did you mean 'panda'"),
    ],
)
def test_bad_input_gives_one_sentence_status_2_and_no_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: list[str], words: str
) -> None:
    is_stage = arguments[0] in STAGES and "--fast" not in arguments
    extra = [f"results_dir={tmp_path}"] if is_stage else []
    status, out, err = run_main(capsys, *arguments, *extra)
    assert status == 2
    assert words in err
    assert err.startswith("error: ")
    assert err.count("\n") <= 2
    assert "Traceback" not in err + out
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_a_sweep_runs_each_combination_in_a_folder_of_its_own_and_compare_tells_them_apart(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    sweep = ["train.loss=former,smooth", "robot=nico", "train.epochs=1", *TOY]
    status, _, _ = run_main(capsys, "train", "-m", *sweep, f"results_dir={tmp_path}")
    assert status == 0
    folders = sorted((tmp_path / "sweep").iterdir())
    assert [folder.name.split(",")[0] for folder in folders] == [
        "train.loss=former",
        "train.loss=smooth",
    ]
    assert all((f / "train" / "nico" / "tiny" / "weights.safetensors").exists() for f in folders)
    status, out, _ = run_main(capsys, "compare", *map(str, folders))
    assert status == 0
    assert re.search(r"train/nico/tiny: train\.loss +former +smooth", out)
    assert "position_error_mm" in out
    assert "B - A" in out


def test_a_typo_in_a_sweep_stops_before_the_first_run(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    status, _, err = run_main(
        capsys, "train", "-m", "train.loss=smooth,smoth", f"results_dir={tmp_path}"
    )
    assert (status, "smoth" in err) == (2, True)
    assert not list(tmp_path.iterdir())


def test_a_run_is_named_after_what_was_overridden() -> None:
    overrides = ["robot=nico", "profile=smoke", "model.hidden=[64,64]", "results_dir=x"]
    assert run_name(overrides) == "robot=nico,model.hidden=_64,64_"
    assert run_name(["profile=smoke"]) == "default"


def test_a_run_is_named_after_its_profile_where_profiles_are_swept() -> None:
    overrides = ["profile=smoke", "seed=1", "results_dir=x"]
    assert run_name(overrides, with_profile=True) == "profile=smoke,seed=1"


def test_a_password_of_a_storage_is_in_neither_name_nor_configuration_of_a_run() -> None:
    storage = "tune.storage='postgresql://me:p@ss:w/rd@host:5432/studies?password=word2'"
    name = run_name([storage])
    assert "studies" in name
    written = to_yaml(compose([storage]))
    assert "storage: postgresql://me:***@host:5432/studies?password=***" in written
    assert not re.search("p@ss|w/rd|word2|w_rd", name + written)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(capsys: pytest.CaptureFixture[str], command: str) -> None:
    status, out, _ = run_main(capsys, command, "--help")
    assert status == 0
    assert f"python -m pipeline {command}" in out
    assert command in run_main(capsys)[1]


@pytest.mark.parametrize("command", ["robots", "solvers", "doctor", "paths"])
def test_a_command_without_arguments_explains_itself_and_does_not_run(
    capsys: pytest.CaptureFixture[str], command: str
) -> None:
    status, out, _ = run_main(capsys, command, "--help")
    assert status == 0
    assert out.startswith(f"usage: python -m pipeline {command} ")
    assert "key=value" not in out
    assert len(out.splitlines()) == 6


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["plan", "plan.solvers=[cycleik,placco]"], "placco"),
        (["plan", "plan.solvers=[cycleik]", "plan.repair=nobody"], "nobody"),
        (["grasp", "robot=panda", "grasp.solver=cycleik", "grasp.repair=nobody"], "nobody"),
    ],
)
def test_unknown_solvers_are_found_before_anything_is_made(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: list[str], words: str
) -> None:
    status, _, err = run_main(capsys, *arguments, "profile=smoke", f"results_dir={tmp_path}")
    assert status == 2
    assert words in err
    assert not list(tmp_path.rglob("*"))
