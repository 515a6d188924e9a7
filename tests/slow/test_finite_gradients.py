"""Gradients of every loss through both kinematics: finite for any joints and any target.

pytest -m slow tests/slow/test_finite_gradients.py       a million joint states a robot
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import pytest
import torch
from torch import Tensor

from pipeline.config import compose
from pipeline.learning.config import TrainConfig
from pipeline.learning.kinematics import make_kinematics
from pipeline.learning.losses import PoseLoss
from pipeline.learning.rotation import matrix_from_quaternion, quaternion_from_matrix
from robots import Robot, available_robots, load_robot

LOSSES = ("smooth", "former", "matrix")
KINEMATICS = ("compiled", "products", "pytorch_kinematics")
CHUNK = 20_000


@cache
def defaults() -> TrainConfig:
    return compose().train


def pose_loss(name: str) -> PoseLoss:
    return PoseLoss(replace(defaults(), loss=name))


def half_turns(quaternion: Tensor, axis: Tensor) -> Tensor:
    """Quaternions (N, 4), each turned by 180 deg about axis (N, 3): (0, a) q."""
    w, v = quaternion[:, :1], quaternion[:, 1:]
    scalar = -(axis * v).sum(dim=1, keepdim=True)
    return torch.cat((scalar, w * axis + torch.linalg.cross(axis, v)), dim=1)


def targets(position: Tensor, rotation: Tensor, generator: torch.Generator) -> Tensor:
    """Targets (N, 7): the pose itself, a random one, and half a turn off, in turns."""
    count = len(position)
    reached = quaternion_from_matrix(rotation)
    anywhere = torch.nn.functional.normalize(torch.randn(count, 4, generator=generator), dim=1)
    axis = torch.nn.functional.normalize(torch.randn(count, 3, generator=generator), dim=1)
    # Every second half turn is about an axis of the base.
    axis[::2] = torch.eye(3)[torch.arange(count) % 3][::2]
    turned = half_turns(reached, axis)
    moved = position + torch.randn(count, 3, generator=generator)
    kind = torch.arange(count)[:, None] % 3
    return torch.where(
        kind == 0,
        torch.cat((position, reached), dim=1),
        torch.where(kind == 1, torch.cat((moved, anywhere), 1), torch.cat((position, turned), 1)),
    )


def worst_gradient(robot: Robot, states: int) -> float:
    """Largest gradient entry that was met; fails at the first that is not finite."""
    cpu = torch.device("cpu")
    losses = [pose_loss(name) for name in LOSSES]
    chains = [make_kinematics(robot, name, cpu) for name in KINEMATICS]
    lower, upper = (torch.as_tensor(v, dtype=torch.float32) for v in (robot.lower, robot.upper))
    generator = torch.Generator().manual_seed(0)
    largest = 0.0
    for first in range(0, states, CHUNK):
        count = min(CHUNK, states - first)
        share = torch.rand(count, robot.dof, generator=generator)
        # A tenth of the joints stands at a limit, where a tanh output saturates.
        share = torch.where(
            torch.rand(count, robot.dof, generator=generator) < 0.1, share.round(), share
        )
        values = lower + share * (upper - lower)
        for chain in chains:
            joints = values.clone().requires_grad_()
            frames = chain(joints)
            target = targets(*(frame.detach() for frame in frames), generator)
            for loss in losses:
                (gradient,) = torch.autograd.grad(
                    loss(*frames, target).sum(), joints, retain_graph=True
                )
                assert torch.isfinite(gradient).all(), (robot.name, type(chain), loss.train.loss)
                largest = max(largest, float(gradient.abs().max()))
    return largest


@pytest.mark.parametrize("name", available_robots())
def test_gradients_are_finite_for_some_joint_states(name: str) -> None:
    assert 0 < worst_gradient(load_robot(name), 3000) < 1e4


@pytest.mark.slow
@pytest.mark.parametrize("name", available_robots())
def test_gradients_are_finite_for_a_million_joint_states(name: str) -> None:
    assert 0 < worst_gradient(load_robot(name), 1_000_000) < 1e4


@pytest.mark.parametrize("loss", LOSSES)
def test_gradients_are_finite_at_exact_half_turns(loss: str) -> None:
    """Reached rotations of half a turn and none, against each other as targets."""
    diagonal = math.sqrt(0.5)
    turns = torch.tensor(
        [[0.0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, diagonal, diagonal, 0], [1, 0, 0, 0]]
    )
    rotation = matrix_from_quaternion(turns.repeat_interleave(5, dim=0)).requires_grad_()
    position = torch.zeros(25, 3, requires_grad=True)
    target = torch.cat((torch.zeros(25, 3), turns.repeat(5, 1)), dim=1)
    value = pose_loss(loss)(position, rotation, target)
    assert torch.isfinite(value).all()
    for gradient in torch.autograd.grad(value.sum(), (position, rotation)):
        assert torch.isfinite(gradient).all()
