"""Units of a whole run: their order, hours and keys, and what is left out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pipeline.commands.paper import plan_text
from pipeline.commands.run import split_lists, step_overrides
from pipeline.config import compose
from pipeline.data.files import read_json, write_json
from pipeline.reporting.results import LEFT_OUT
from pipeline.stages.forecast import core_hours, rates
from pipeline.stages.whole_run import Unit, left_out, units, write_left_out


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


def test_hours_by_hand() -> None:
    """Ten epochs of a million poses at 1.70e-3 core seconds; 200 such trials of a search."""
    config = compose(["profile=paper", "robot=nicol"])
    assert core_hours("train", config) == pytest.approx(1e7 * 1.70e-3 / 3600)
    assert core_hours("tune", config) == pytest.approx(200 * 1e7 * 1.70e-3 / 3600)
    one = replace(config.evaluate, solvers=["bio_ik"])
    assert core_hours("evaluate", replace(config, evaluate=one)) == pytest.approx(
        200_000 * 1.5e-3 / 3600
    )


def test_every_rate_says_where_it_was_measured_and_by_what() -> None:
    assert (rates()[["stage", "unit", "machine", "source"]] != "").all().all()


def test_a_task_that_takes_too_long_is_left_out_with_what_reads_it(
    every: list[Unit], tmp_path: Path
) -> None:
    assert [*left_out(every, 24.0)] == ["tune-nico"]
    short = left_out(every, 1.0)
    assert short["train-nico"] == "would take 1 hours of one core"
    assert short["evaluate_neural-nico-cycleik"] == "needs train-nico, which is left out"
    assert "evaluate_numerical-nico-bio_ik" not in short
    write_left_out(tmp_path, every, short)
    rows = {row["step"]: row for row in read_json(tmp_path / LEFT_OUT)["left_out"]}
    assert rows["train"]["hours"] == pytest.approx(1.37, abs=0.01)
    text = plan_text(every, short, 2)
    assert "left out: tune-nico would take 273 hours" in text
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
