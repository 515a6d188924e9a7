"""The study of harder trials: every setting composes, and its table counts what the rows say."""

from __future__ import annotations

import pandas as pd
import pytest

from benchmarks.harder import SETTINGS, text_of
from pipeline.config import compose
from pipeline.embodiment.loading import is_embodied
from pipeline.stages import grasp


@pytest.mark.parametrize("robot", ["nico", "nicol"])
@pytest.mark.parametrize("setting", SETTINGS)
def test_every_setting_can_be_run_and_is_what_it_is_called(setting: str, robot: str) -> None:
    config = compose([f"robot={robot}", *SETTINGS[setting][1], "grasp.trials=100"])
    grasp.check(config)
    assert is_embodied(config) == (setting in ("protocol", "clutter", "spoken", "off", "retries"))
    assert (config.grasp.protocol.attempts > 1) == (setting == "retries")
    assert bool(config.speech.loop.voices) == (setting == "spoken")
    assert (config.grasp.shake_after_lift > 0) == (setting == "shake")
    error = config.perception.calibration_error.translation
    assert (error > 0) == (setting in ("off", "retries"))


def test_trials_are_counted_by_robot_and_setting() -> None:
    def rows(robot: str, setting: str, *classes: str, attempts: float) -> pd.DataFrame:
        facts = {"robot": robot, "setting": setting, "attempts": attempts, "wall_s": 2.0}
        return pd.DataFrame([{**facts, "class": each} for each in classes])

    lost = rows("nicol", "off", "Success", "Slipped", "Detection", attempts=1.0)
    saved = rows("nicol", "retries", "Success", "Success", "Detection", attempts=1.5)
    other = rows("nico", "shake", "Not Grasped", attempts=float("nan"))
    said = text_of(pd.concat([saved, other, lost], ignore_index=True), ["nico", "nicol"])
    lines = [line for line in said.splitlines() if line.startswith("| NICO")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert [line[0] for line in cells] == ["NICO", "NICOL", "NICOL"]
    assert [line[2:4] for line in cells] == [["1", "0"], ["3", "1"], ["3", "2"]]
    assert [line[7:11] for line in cells] == [
        ["0", "1", "0", "0"],
        ["1", "0", "1", "0"],
        ["0", "0", "1", "0"],
    ]
    assert [line[11] for line in cells] == ["–", "–", "1.50"]
