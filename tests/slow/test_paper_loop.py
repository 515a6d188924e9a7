"""The paper's training loop for 10,000 steps: not one gradient that is not finite.

    pytest -m slow tests/slow/test_paper_loop.py

Losses, weights, learning rate, depth and tanh layers of Table I and the input's alternating sign;
an eighth of the width and small batches, since the number of steps is what matters here.
"""

from __future__ import annotations

import math

import pytest
import torch

from pipeline.config import compose
from pipeline.data.dataset import PoseSet
from pipeline.learning.factory import build_network
from pipeline.learning.trainer import Trainer, TrainingRun
from robots import available_robots, load_robot

STEPS, BATCH, NARROWER = 10_000, 32, 8


def paper_loop(name: str, kinematics: str, steps: int) -> Trainer:
    """Train; fails if a step was skipped for its gradient."""
    robot = load_robot(name)
    wide = compose([f"robot={name}", "profile=paper"]).model.hidden
    config = compose(
        [
            f"robot={name}",
            "profile=paper",
            f"model.hidden={[width // NARROWER for width in wide]}",
            f"train.kinematics={kinematics}",
            f"train.batch_size={BATCH}",
            "train.loss=smooth",
            "train.negate_input=true",
            "train.gradient_clip=1.0e+9",
            "train.validations=2",
            "train.epochs=10",
            "train.device=cpu",
        ]
    )
    joints = robot.sample(BATCH * steps // 10, seed=3, collision_free=False)
    poses = PoseSet(robot.forward_kinematics(joints), joints)
    torch.manual_seed(0)
    network = build_network(robot, config.model)
    trainer = Trainer(robot, network, config.train, TrainingRun(0, "", f"{name} {kinematics}"))
    progress = trainer.fit(poses, PoseSet(poses.poses[:500], poses.joints[:500]))
    assert progress.step == steps
    assert progress.skipped == 0
    assert all(math.isfinite(value) for row in progress.curve for value in row.values())
    assert all(torch.isfinite(parameter).all() for parameter in network.parameters())
    return trainer


@pytest.mark.parametrize("kinematics", ["compiled", "pytorch_kinematics"])
def test_a_short_loop_skips_no_step(kinematics: str) -> None:
    paper_loop("nico", kinematics, 100)


@pytest.mark.slow
@pytest.mark.parametrize("kinematics", ["compiled", "pytorch_kinematics"])
@pytest.mark.parametrize("name", available_robots())
def test_ten_thousand_steps_skip_none(name: str, kinematics: str) -> None:
    paper_loop(name, kinematics, STEPS)
