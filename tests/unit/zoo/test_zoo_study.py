"""One arm of the zoo: trained once, measured once, and taken up where it was stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline.learning.trainer import Trainer
from pipeline.zoo import study
from pipeline.zoo.arms import Arm, ZooConfig
from pipeline.zoo.measuring import Descent, descents
from robots import load_robot
from robots.robot import Robot

SIZES = ZooConfig(minutes=1e-3, train=5000, validation=50, poses=20, rounds=1, seed=0)
HOME = Descent(iterations=12.0, first_start=0.8, found=1.0, time_us=3.0)
SEEDED = Descent(iterations=3.0, first_start=0.9, found=1.0, time_us=4.0)


class Killed(Exception):  # noqa: N818 - no error, it stands for the end of a process
    """Stands for a process that ends without a word."""


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """How often a network is trained and the descent is measured, which takes no time here."""
    seen = {"trainings": 0, "measurements": 0}
    fit = Trainer.fit

    def trains(self: Trainer, *sets: Any) -> Any:
        seen["trainings"] += 1
        return fit(self, *sets)

    def measures(robot: Robot, weights: Path, poses: Any, rounds: int) -> tuple[Descent, Descent]:
        seen["measurements"] += 1
        if seen["measurements"] == 1:
            raise Killed
        return HOME, SEEDED

    monkeypatch.setattr(Trainer, "fit", trains)
    monkeypatch.setattr(study, "descents", measures)
    return seen


def test_a_killed_study_goes_on_and_a_whole_one_is_kept(
    counts: dict[str, int], tmp_path: Path
) -> None:
    nico = Arm("nico")
    with pytest.raises(Killed):
        study.row_of(nico, tmp_path, SIZES)
    row = study.row_of(nico, tmp_path, SIZES)
    assert counts == {"trainings": 1, "measurements": 2}  # the network was there already
    assert (row["joints"], row["gain_iterations"], row["gain_time"]) == (6, 4.0, 0.75)
    assert row["seed"] == 0
    assert row["training_s"] > 0.0
    assert study.row_of(nico, tmp_path, SIZES) == row
    assert counts == {"trainings": 1, "measurements": 2}


def test_other_sizes_are_another_question(counts: dict[str, int], tmp_path: Path) -> None:
    counts["measurements"] = 1
    study.row_of(Arm("nico"), tmp_path, SIZES)
    longer = ZooConfig(**{**vars(SIZES), "minutes": 2e-3})
    study.row_of(Arm("nico"), tmp_path, longer)
    assert counts == {"trainings": 2, "measurements": 3}


@pytest.mark.slow
def test_a_trained_seed_leaves_fewer_iterations_than_home() -> None:
    robot = load_robot("nico")
    poses = robot.forward_kinematics(robot.sample(300, seed=5))
    weights = Path(study.__file__).parents[2] / "robots" / "nico" / "weights"
    home, seeded = descents(robot, weights, poses, rounds=1)
    assert home.found == seeded.found == 1.0
    assert seeded.iterations < 0.7 * home.iterations
    assert seeded.first_start > home.first_start
