"""Instructions of the suite carried out by Panda: deeds apart from plans."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import baselines
from pipeline.agent import Agent
from pipeline.agent.loading import agent_factory
from pipeline.commands import instructions as command
from pipeline.config import compose
from pipeline.data.rows import RowCheckpoint
from pipeline.instructions.execution import World, laid_out
from pipeline.instructions.plans import SuiteError
from pipeline.instructions.suite import Instruction, read_suite
from pipeline.reporting.instructions import execution_success
from robots import load_robot

CONFIG = compose(["profile=smoke", "robot=panda", "agent=policy", "experiment=refined_grasp"])
SUITE = read_suite()
OFF_THE_TABLE = 1.5  # m to the left: what is laid there falls


def said(words: str) -> int:
    return next(each.number for each in SUITE if each.says.startswith(words))


def world(shift: float = 0.0) -> World:
    robot, solver = load_robot("panda"), baselines.load("lm", load_robot("panda"))
    scene = CONFIG.grasp.scenes["panda"]
    area = replace(scene.area, y=[y + shift for y in scene.area.y])
    grasp = replace(CONFIG.grasp, scenes={"panda": replace(scene, area=area)})
    return World(robot, grasp, solver, solver, 0)


def rows(numbers: list[int], shift: float = 0.0) -> pd.DataFrame:
    agents, place = agent_factory(CONFIG.agent, "panda"), world(shift)
    return pd.DataFrame([place.row(SUITE[number], agents(), "policy") for number in numbers])


def test_right_plans_are_carried_out_and_words_are_deeds() -> None:
    numbers = [said("Have a look at the baseball"), said("Take the pineapple")]
    grasped = said("Don't touch the pear, just take the banana")
    found = rows([*numbers, grasped])
    assert found["class"].tolist() == ["right"] * 3
    assert found["executed"].tolist() == [True] * 3
    assert found["failed"].tolist() == [""] * 3
    assert (found["lasted_s"] > 1.0).tolist() == [False, False, True]


def test_a_right_plan_without_its_object_is_no_deed() -> None:
    found = rows([said("Don't touch the pear, just take the banana")], shift=OFF_THE_TABLE)
    assert found["class"].tolist() == ["right"]
    assert not found["executed"].any()
    assert found["failed"][0].startswith("grasp banana: it is out of sight")
    last = execution_success(found, 0.95).records()[-1]
    assert (last["planned"], last["executed"], last["share"]) == (1, 0, 0.0)
    (first, _) = execution_success(found, 0.95).records()
    assert first["failed"] == "grasp: it is out of sight (1)"


def test_a_scene_that_reaches_into_a_bin_is_refused() -> None:
    scene = CONFIG.grasp.scenes["nico"]
    with pytest.raises(SuiteError, match="would lie in the left bin; choose another robot"):
        for each in SUITE:
            laid_out(each, CONFIG.grasp, scene)


@pytest.mark.parametrize("robot", ["nicol", "panda"])
def test_scenes_keep_their_shape(robot: str) -> None:
    scene = CONFIG.grasp.scenes[robot]
    for each in SUITE:
        setups = laid_out(each, CONFIG.grasp, scene)
        assert [setup.name for setup in setups] == [seen.name for seen in each.seen]
        for one, other in zip(setups, each.seen, strict=True):
            for second, third in zip(setups, each.seen, strict=True):
                for axis in range(2):
                    ours = one.place[axis] - second.place[axis]
                    theirs = other.position[axis] - third.position[axis]
                    assert ours == pytest.approx(theirs)


def test_deeds_that_were_done_are_not_done_again_after_a_kill(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The third instruction kills the run; the second call begins with it."""
    agents = agent_factory(CONFIG.agent, "panda")
    monkeypatch.setattr(command, "_kept", lambda *_: RowCheckpoint(tmp_path / "rows", ("number",)))
    asked: list[int] = []

    class Killed(World):
        def row(self, instruction: Instruction, agent: Agent, name: str) -> dict[str, Any]:
            asked.append(instruction.number)
            if asked == [0, 1, 2]:
                raise KeyboardInterrupt
            return {"number": instruction.number, "executed": True}

    place = Killed(**vars(world()))
    with pytest.raises(KeyboardInterrupt):
        command._rows(CONFIG, agents, "policy", place)
    rows = command._rows(CONFIG, agents, "policy", place)
    assert [row["number"] for row in rows] == [*range(len(SUITE))]
    assert asked == [0, 1, 2, *range(2, len(SUITE))]
