"""Units of a whole run: their order, hours and keys, and what is left out."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pipeline.commands.run import split_lists, step_overrides
from pipeline.commands.whole import plan_text
from pipeline.config import compose
from pipeline.data.files import read_json, write_json
from pipeline.engine.scheduler import Scheduler
from pipeline.reporting.results import LEFT_OUT
from pipeline.stages.forecast import core_seconds, rates, seconds_of_command
from pipeline.stages.whole_run import Unit, UnitTasks, left_out, units, write_left_out


def made(folder: Path, *more: str) -> list[Unit]:
    lists, overrides = split_lists(
        ["profile=paper", "robots=[nico]", f"results_dir={folder}", *more]
    )
    return units(lists, lambda step, axes: step_overrides(step, axes, overrides), compose)


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> list[Unit]:
    return made(tmp_path_factory.mktemp("results"))


def by_name(every: list[Unit]) -> dict[str, Unit]:
    return {unit.name: unit for unit in every}


def test_units_come_after_what_they_read(every: list[Unit]) -> None:
    before: set[str] = set()
    for unit in every:
        assert {*unit.needs} <= before
        before.add(unit.name)
    named = by_name(every)
    assert named["evaluate_neural-nico-cycleik"].needs == ("dataset-nico", "train-nico")
    assert {*named["report"].needs} == before - {"report"}


def test_seconds_by_hand() -> None:
    """A start of 4 s, ten epochs of a million poses at 1.70e-3 s; 200 such trials of a search."""
    config = compose(["profile=paper", "robot=nicol"])
    assert core_seconds("train", config) == pytest.approx(4 + 1e7 * 1.70e-3)
    assert core_seconds("tune", config) == pytest.approx(4 + 200 * 1e7 * 1.70e-3)
    one = replace(config.evaluate, solvers=["bio_ik"])
    assert core_seconds("evaluate", replace(config, evaluate=one)) == pytest.approx(4 + 300)


# What tasks took at the quick scale on one core [s], by the commands of dvc.yaml.
MEASURED = {
    "dataset": 12,
    "tune model=compact tune=default": 150,
    "train train.from=shipped model=compact": 8,
    "train train.from=default model=compact": 250,
    "train model=flow": 400,
    "evaluate evaluate.solvers=[cycleik] model=compact": 12,
    "evaluate evaluate.solvers=[flow] model=flow": 20,
    "evaluate evaluate.solvers=[lm]": 14,
    "evaluate evaluate.solvers=[lm] evaluate.seeded_by=cycleik model=compact": 10,
    "plan model=compact": 48,
    "detector detector.from=shipped": 60,
    "detector detector.from=default": 550,
    "grasp perception=perfect agent=none model=compact": 60,
    "grasp perception=camera agent=policy model=compact": 120,
}


@pytest.mark.parametrize("command", MEASURED)
def test_the_forecast_of_the_quick_scale_is_near_what_was_measured(command: str) -> None:
    stage, *overrides = command.split()
    said = seconds_of_command(stage, ["robot=nico", "profile=quick", *overrides])
    assert said == pytest.approx(MEASURED[command], rel=0.2)


def test_no_more_poses_are_counted_than_there_are() -> None:
    """A search of the smoke scale: 3 trials of the 2,000 poses, not of 500,000."""
    said = seconds_of_command("tune", ["profile=smoke"])
    assert said == pytest.approx(4 + 3 * 2000 * 2.0e-5)


def test_robots_and_solvers_of_a_command_have_rates_of_their_own() -> None:
    many = ["profile=paper", "evaluate.solvers=[cycleik]"]
    said = [seconds_of_command("evaluate", [f"robot={name}", *many]) for name in ("nico", "nicol")]
    assert said == pytest.approx([4 + 200_000 * 3.2e-3, 4 + 200_000 * 6.5e-3])


def test_every_rate_says_where_it_was_measured_and_by_what() -> None:
    assert (rates()[["stage", "unit", "machine", "source"]] != "").all().all()


def test_a_task_that_takes_too_long_is_left_out_with_what_reads_it(
    every: list[Unit], tmp_path: Path
) -> None:
    assert [*left_out(every, 24.0)] == ["tune-nico"]
    short = left_out(every, 1.0)
    assert short["train-nico"] == "would take 82 min of one core"
    assert short["evaluate_neural-nico-cycleik"] == "needs train-nico, which is left out"
    assert "evaluate_numerical-nico-bio_ik" not in short
    write_left_out(tmp_path, every, short)
    rows = {row["step"]: row for row in read_json(tmp_path / LEFT_OUT)["left_out"]}
    assert rows["train"]["hours"] == pytest.approx(1.37, abs=0.01)
    scheduler = Scheduler(UnitTasks(every, 2), tmp_path, 2)
    text = plan_text(every, {"dataset-nico"}, short, scheduler)
    assert re.search(r"^train +1 +1 +0 +-$", text, re.MULTILINE)
    assert re.search(r"^dataset +1 +0 +1 +14 s$", text, re.MULTILINE)
    assert re.search(r"left out: tune-nico would take 27\d\.\d h of one core", text)
    assert "rates of results/rates.csv" in text


def test_what_is_done_is_known_by_values_code_and_inputs(every: list[Unit]) -> None:
    unit = by_name(every)["train-nico"]
    assert not unit.is_done
    for path in unit.outputs:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    unit.sign(12.0)
    assert unit.is_done
    facts: dict[str, Any] = dict(read_json(unit.stamp))
    assert facts["seconds"] == 12.0
    assert facts["profile"] == "paper"
    write_json(unit.stamp, {**facts, "key": "another"})
    assert not unit.is_done


def test_an_override_changes_the_keys_of_what_it_shapes_only(
    every: list[Unit], tmp_path: Path
) -> None:
    plain = by_name(every)
    changed = by_name(made(tmp_path, "train.learning_rate=1.0e-3"))
    same = {name for name, unit in changed.items() if unit.key == plain[name].key}
    assert {"dataset-nico", "evaluate_numerical-nico-bio_ik", "detector-nico"} <= same
    assert not {"train-nico", "evaluate_neural-nico-cycleik", "plan-nico", "grasp-nico"} & same
