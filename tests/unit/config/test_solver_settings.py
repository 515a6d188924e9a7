"""`solver.<name>.<key>`: composed, typed, swept, refused when unknown, and part of rows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import SettingError
from baselines.lm import LevenbergMarquardt
from baselines.registry import check_setting, file_settings, setting_types, using
from pipeline.commands.run import run_name
from pipeline.config import compose, sweep, to_yaml
from pipeline.errors import ConfigError
from pipeline.evaluation.runner import cache_key
from pipeline.evaluation.task import EvaluationTask
from pipeline.learning.card import shipped_weights
from pipeline.solvers import check_budgets
from pipeline.stages.solvers import solver_of
from robots import Robot, load_robot


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("panda")


def test_a_run_has_the_settings_of_every_solver_file() -> None:
    config = compose()
    assert set(config.solver) == set(baselines.names())
    for name, settings in config.solver.items():
        assert settings == {k: v for k, v in file_settings(name).items() if k != "_target_"}
    assert compose(["solver.lm.patience=8"]).solver["lm"]["patience"] == 8
    assert "patience: 8" in to_yaml(compose(["solver.lm.patience=8"]))


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("solver.lm.patienc=8", ["'patienc'", "did you mean 'patience'", "damping_gain"]),
        ("solver.lmm.patience=8", ["'lmm'", "did you mean 'lm'", "placo"]),
        ("+solver.lm.speed=8", ["speed", "patience"]),
        ("solver.lm.patience=abc", ["solver.lm.patience", "int", "'abc'"]),
        ("solver.lm.patience=1.5", ["solver.lm.patience", "int", "1.5"]),
        ("solver.lm.threads=null", ["solver.lm.threads", "int", "None"]),
        ("solver.lm.time_s=soon", ["solver.lm.time_s", "float or null", "'soon'"]),
        ("solver.placo.restarts=1", ["solver.placo.restarts", "bool", "1"]),
        ("solver.trac_ik.solve_type=3", ["solver.trac_ik.solve_type", "str", "3"]),
        ("solver.lm._target_=os.system", ["no key in solver.lm", "_target_"]),
        ("solver=lm", ["solver.<name>.<key>", "evaluate.solvers"]),
    ],
)
def test_what_a_solver_does_not_know_is_refused(override: str, words: list[str]) -> None:
    with pytest.raises(ConfigError) as caught:
        compose([override])
    assert all(word in str(caught.value) for word in words), caught.value
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", baselines.names())
def test_each_setting_has_a_type_and_its_file_keeps_it(name: str) -> None:
    types = setting_types(name)
    for key, value in file_settings(name).items():
        if key != "_target_":
            assert types[key], f"{key}: give the parameter of the class a type"
            check_setting(name, key, value)
            with pytest.raises(SettingError, match=key):
                check_setting(name, key, object())


def test_values_are_swept_each_into_a_folder_of_its_own() -> None:
    runs = sweep(["robot=panda", "solver.lm.patience=4,8"])
    assert [compose(run).solver["lm"]["patience"] for run in runs] == [4, 8]
    assert [run_name(run) for run in runs] == [
        "robot=panda,solver.lm.patience=4",
        "robot=panda,solver.lm.patience=8",
    ]


def test_they_reach_the_solver_and_stand_in_what_rows_depend_on(robot: Robot) -> None:
    poses = robot.forward_kinematics(robot.sample(2, seed=0))
    keys = []
    for override in ([], ["solver.lm.patience=8"]):
        config = compose([*override, "profile=smoke"])
        solver = solver_of("lm", robot, config)
        assert solver.settings == config.solver["lm"]
        keys.append(cache_key(EvaluationTask(robot, solver, poses), config.evaluate))
    assert [key["solver_identity"]["settings"]["patience"] for key in keys] == [3, 8]


def test_a_solver_that_refines_with_lm_takes_the_settings_of_the_run(robot: Robot) -> None:
    config = compose(["solver.lm.patience=8", "solver.cycleik_refined.hypotheses=2"])
    config = replace(config, weights={"cycleik_refined": str(shipped_weights("panda"))})
    solver = solver_of("cycleik_refined", robot, config)
    kernel = solver.kernel  # type: ignore[attr-defined]
    assert isinstance(kernel, LevenbergMarquardt)
    assert kernel.options(None).patience == 8
    assert solver.settings["hypotheses"] == 2
    assert solver.weights == shipped_weights("panda")
    plain = baselines.load("lm", robot)
    assert plain.settings["patience"] == 3, "outside of a run the file says"


def test_weights_may_be_named_as_a_setting(robot: Robot) -> None:
    folder = shipped_weights("panda")
    solver = solver_of("cycleik", robot, compose([f"solver.cycleik.weights={folder}"]))
    assert solver.weights == folder


def test_settings_of_a_run_end_with_it() -> None:
    with using({"lm": {"patience": 8}}):
        assert baselines.registry.settings("lm")["patience"] == 8
        assert baselines.registry.settings("placo")["patience"] == 10
    assert baselines.registry.settings("lm")["patience"] == 3


def test_a_budget_in_place_of_the_solvers_own_is_no_silent_one() -> None:
    run = ["evaluate.solvers=[trac_ik]", "solver.trac_ik.time_s=0.01"]
    with pytest.raises(ConfigError, match=r"evaluate\.time_s=0\.001 is in its place"):
        check_budgets(compose(run))
    check_budgets(compose([*run, "evaluate.time_s=null"]))
    check_budgets(compose([*run[1:], "evaluate.solvers=[lm]"]))


def test_an_edited_file_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = baselines.registry.FOLDER / "lm.yaml"
    monkeypatch.setattr(baselines.registry, "FOLDER", tmp_path)
    path = tmp_path / "lm.yaml"
    path.write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    assert file_settings("lm")["patience"] == 3
    path.write_text(
        source.read_text(encoding="utf-8").replace("patience: 3", "patience: 77"), "utf-8"
    )
    assert file_settings("lm")["patience"] == 77


def test_a_longer_patience_changes_the_answers_path(robot: Robot) -> None:
    """The setting is not only written down: with another patience other restarts are made."""
    poses = robot.forward_kinematics(robot.sample(300, seed=1))
    counts = [
        solver_of("lm", robot, compose([f"solver.lm.patience={value}"])).solve(poses).iterations
        for value in (1, 30)
    ]
    assert not np.array_equal(*counts)
