"""What tests of networks that draw solutions share: small sizes, poses, some steps of training."""

from __future__ import annotations

from functools import cache
from typing import Any

import torch
from torch import Tensor

from pipeline.config import compose
from pipeline.learning.config import TrainConfig
from pipeline.learning.networks import IkNetwork
from pipeline.learning.objective import Objective
from robots import Robot

SMALL: dict[str, Any] = {"name": "small", "hidden": [16], "tanh_layers": 1, "width": 8, "heads": 1}


@cache
def train_config() -> TrainConfig:
    """The recipe of model=iknet: a composition takes a second."""
    return compose(["model=iknet"]).train


def pose_set(robot: Robot, count: int) -> tuple[Tensor, Tensor]:
    joints = robot.sample(count, seed=1)
    poses = robot.forward_kinematics(joints)
    return torch.tensor(poses, dtype=torch.float32), torch.tensor(joints, dtype=torch.float32)


def check_training(
    objective: Objective, network: IkNetwork, data: tuple[Tensor, Tensor], steps: int
) -> tuple[float, float]:
    """Train on one batch; return the first loss and the mean of the last five."""
    poses, joints = data
    first = objective.loss(poses, joints, 0, 0.0)
    assert torch.equal(first, objective.loss(poses, joints, 0, 0.0)), "noise is the step's alone"
    optimizer = torch.optim.Adam(network.parameters(), lr=5e-3)
    losses = []
    for step in range(steps):
        optimizer.zero_grad()
        loss = objective.loss(poses, joints, step, step / steps)
        loss.backward()
        assert all(p.grad is None or p.grad.isfinite().all() for p in network.parameters())
        optimizer.step()
        losses.append(float(loss.detach()))
    position, rotation = objective.errors(poses)
    assert position.shape == rotation.shape == (len(poses),)
    assert torch.equal(position, objective.errors(poses)[0])
    return losses[0], sum(losses[-5:]) / 5
