"""Training: it learns, resumes bitwise, survives bad gradients, and refuses what cannot be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.data.dataset import PoseSet
from pipeline.learning.batches import Batches
from pipeline.learning.checkpoint import Progress, restore
from pipeline.learning.factory import build_network
from pipeline.learning.trainer import Trainer, TrainingError, TrainingRun, error_score
from pipeline.settings import Config
from robots import Robot, load_robot

SMALL = ["profile=smoke", "train.batch_size=50", "train.epochs=2", "train.validations=4"]


class Killed(Exception):  # noqa: N818 - no error, it stands for the end of a process
    """Stands for a process that ends without a word."""


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("nico")


@pytest.fixture(scope="module")
def poses(robot: Robot) -> PoseSet:
    joints = robot.sample(500, seed=1, collision_free=False)
    return PoseSet(robot.forward_kinematics(joints), joints)


@pytest.fixture(scope="module")
def held_out(poses: PoseSet) -> PoseSet:
    return PoseSet(poses.poses[:100], poses.joints[:100])


def trainer(robot: Robot, config: Config, run: TrainingRun) -> Trainer:
    torch.manual_seed(3)
    return Trainer(robot, build_network(robot, config.model), config.train, run)


def weights(made: Trainer) -> dict[str, torch.Tensor]:
    return {name: value.clone() for name, value in made.network.state_dict().items()}


@pytest.mark.parametrize("model", ["tiny", "compact"])
def test_the_loss_falls(robot: Robot, poses: PoseSet, held_out: PoseSet, model: str) -> None:
    config = compose([*SMALL, f"model={model}", "train.epochs=6", "train.warm_up_steps=0"])
    made = trainer(robot, config, TrainingRun(seed=0, digest="", label="test"))
    curve = made.fit(poses, held_out).curve
    assert curve[-1]["loss"] < 0.8 * curve[0]["loss"]
    assert curve[-1]["learning_rate"] == 0.0


def test_a_killed_run_ends_with_the_same_bits(
    robot: Robot, poses: PoseSet, held_out: PoseSet, tmp_path: Path
) -> None:
    config = compose([*SMALL, "train.checkpoint_s=1.0e-9"])
    whole = trainer(robot, config, TrainingRun(seed=0, digest="d", label="whole"))
    expected = whole.fit(poses, held_out)
    path = tmp_path / "state.safetensors"

    def die(step: int, row: dict[str, float]) -> None:
        if step >= 10:
            raise Killed

    first = trainer(robot, config, TrainingRun(0, "d", "first", checkpoint=path, report=die))
    with pytest.raises(Killed):
        first.fit(poses, held_out)
    before, _ = restore(path, "d", first.network, first.optimizer) or (Progress(), {})
    assert before.processor_s > 0.0
    rows = []
    again = TrainingRun(0, "d", "second", path, report=lambda _, row: rows.append(row))
    second = trainer(robot, config, again)
    resumed = second.fit(poses, held_out)
    assert resumed.curve == rows == expected.curve
    for name, value in weights(whole).items():
        assert torch.equal(value, weights(second)[name]), name
    for name, value in whole.states()["best"].items():
        assert torch.equal(value, second.states()["best"][name]), name
    assert resumed.best_step == expected.best_step
    assert resumed.processor_s > before.processor_s  # that of both processes
    second.finish()
    assert not path.exists()


def test_the_best_validation_is_kept_beside_the_last_step(
    robot: Robot, poses: PoseSet, held_out: PoseSet
) -> None:
    seen = {}

    def remember(step: int, row: dict[str, float]) -> None:
        seen[step] = (error_score(row), weights(made))

    # So high a rate jumps about: the last step is not the best one.
    rate = ["train.learning_rate=0.1", "train.warm_up_steps=0", "train.validations=10"]
    made = trainer(robot, compose([*SMALL, *rate]), TrainingRun(0, "", "best", report=remember))
    progress = made.fit(poses, held_out)
    best = min(seen, key=lambda step: seen[step][0])
    assert progress.best_step == best < progress.step
    assert progress.best_error == seen[best][0]
    states = made.states()
    for name, value in weights(made).items():
        assert torch.equal(states["best"][name], seen[best][1][name])
        assert torch.equal(states["last"][name], value)


def test_a_checkpoint_of_another_configuration_is_not_resumed(
    robot: Robot, poses: PoseSet, held_out: PoseSet, tmp_path: Path
) -> None:
    path = tmp_path / "state.safetensors"
    config = compose([*SMALL, "train.checkpoint_s=1.0e-9"])
    trainer(robot, config, TrainingRun(0, "one", "one", checkpoint=path)).fit(poses, held_out)
    assert path.exists()
    fresh = trainer(robot, config, TrainingRun(0, "two", "two", checkpoint=path))
    assert fresh.fit(poses, held_out).curve[0]["step"] == 5


def test_a_damaged_checkpoint_starts_anew(
    robot: Robot, poses: PoseSet, held_out: PoseSet, tmp_path: Path
) -> None:
    path = tmp_path / "state.safetensors"
    path.write_bytes(b"cut off")
    made = trainer(robot, compose(SMALL), TrainingRun(0, "d", "x", checkpoint=path))
    assert made.fit(poses, held_out).step == 20


def test_steps_with_a_gradient_that_is_not_finite_change_nothing(
    robot: Robot, poses: PoseSet, held_out: PoseSet
) -> None:
    broken = PoseSet(poses.poses.copy(), poses.joints)
    broken.poses[:, 0] = np.nan
    made = trainer(robot, compose([*SMALL, "train.weight_decay=0.1"]), TrainingRun(0, "", "nan"))
    before = weights(made)
    progress = made.fit(broken, held_out)
    assert progress.skipped == progress.step == 20
    assert all(torch.equal(before[name], value) for name, value in weights(made).items())


def test_a_batch_larger_than_the_set_is_refused(
    robot: Robot, poses: PoseSet, held_out: PoseSet
) -> None:
    made = trainer(robot, compose([*SMALL, "train.batch_size=501"]), TrainingRun(0, "", "big"))
    with pytest.raises(TrainingError, match=r"batch_size 501 .*500 poses"):
        made.fit(poses, held_out)


def test_an_epoch_shows_every_pose_once_and_in_another_order() -> None:
    batches = Batches(count=100, size=20, seed=4)
    first = torch.cat([batches.indices(step) for step in range(5)])
    second = torch.cat([batches.indices(step) for step in range(5, 10)])
    assert sorted(first.tolist()) == sorted(second.tolist()) == list(range(100))
    assert first.tolist() != second.tolist()
    assert torch.equal(Batches(100, 20, 4).indices(7), second[40:60])


def test_the_first_poses_of_a_set_are_taken(poses: PoseSet) -> None:
    assert len(poses.first(0).poses) == len(poses.first(501).joints) == 500
    part = poses.first(7)
    assert torch.equal(torch.as_tensor(part.joints), torch.as_tensor(poses.joints[:7]))
    assert len(part.poses) == 7
