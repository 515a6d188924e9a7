"""Secondary goals of training: postures of joints, poses of other links, and self-clearance."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from torch import Tensor

from pipeline.learning.config import ConstraintConfig, TrainConfig
from pipeline.learning.kinematics import make_link_kinematics
from pipeline.learning.losses import PoseLoss, position_loss
from pipeline.learning.self_clearance import SelfClearance
from robots import Robot
from robots.errors import ObstacleError
from robots.suggestions import unknown_name

Penalty = Callable[[Tensor], Tensor]
QUATERNION_SLACK = 1e-3


class ConstraintError(ValueError):
    """A secondary goal that this robot cannot have."""


def make_penalty(robot: Robot, train: TrainConfig, device: torch.device) -> Penalty | None:
    """Return the weighted sum of all secondary goals, or None where there are none.

    It maps joints (N, dof) in rad or m to penalties (N,).

    Raises:
        ConstraintError: A goal names a joint that the robot does not have, or a link that does not
            move; or clearance is wanted on an accelerator, or of a robot whose shapes have none.
        UrdfError: A goal names a link that is not there, or a collision shape cannot be used.
    """
    if not train.constraints or train.constraint_scale == 0:
        return None
    parts = [_penalty(robot, goal, train, device) for goal in train.constraints]
    weights = [train.constraint_scale * goal.weight for goal in train.constraints]

    def penalty(joints: Tensor) -> Tensor:
        terms = [weight * part(joints) for weight, part in zip(weights, parts, strict=True)]
        return torch.stack(terms).sum(dim=0)

    return penalty


def chosen_joints(robot: Robot, requested: list[Any]) -> list[int]:
    """Return the indices of joints that are given by name or by number.

    Raises:
        ConstraintError: The robot has no such joint, or none is requested.
    """
    numbers = []
    for joint in requested:
        known = joint in robot.joint_names
        if not known and not (isinstance(joint, int) and 0 <= joint < robot.dof):
            names = [*map(str, range(robot.dof)), *robot.joint_names]
            raise ConstraintError(
                f"train.constraints: {unknown_name(f'joint of {robot.name}', str(joint), names)}"
            )
        numbers.append(robot.joint_names.index(joint) if known else int(joint))
    if not numbers:
        raise ConstraintError("train.constraints: joints must name at least one joint")
    return numbers


def _penalty(
    robot: Robot, goal: ConstraintConfig, train: TrainConfig, device: torch.device
) -> Penalty:
    if goal.joints is not None:
        return _posture(robot, goal, device)
    if goal.clearance is not None:
        return _clearance(robot, goal.clearance, device)
    return _link(robot, goal, train, device)


def _posture(robot: Robot, goal: ConstraintConfig, device: torch.device) -> Penalty:
    """Mean squared distance of the chosen joints from a posture (the paper's: from zero)."""
    assert goal.joints is not None
    chosen = torch.as_tensor(chosen_joints(robot, goal.joints), device=device)
    try:
        posture = np.broadcast_to(np.asarray(goal.posture, dtype=np.float32), len(chosen))
    except ValueError as error:
        raise ConstraintError(
            f"train.constraints: posture must be one number or {len(chosen)}, one for each of the "
            f"joints, got {goal.posture}"
        ) from error
    wanted = torch.as_tensor(posture.copy(), device=device)
    return lambda joints: (joints[:, chosen] - wanted).square().mean(dim=1)


def _clearance(robot: Robot, clearance: float, device: torch.device) -> Penalty:
    if device.type != "cpu":
        raise ConstraintError(
            f"train.constraints: clearance is computed on a processor, not on {device.type}: set "
            f"train.device=cpu, or leave it out"
        )
    try:
        return SelfClearance(robot, clearance)
    except ObstacleError as error:
        raise ConstraintError(f"train.constraints: no clearance can be had: {error}") from error


def _link(
    robot: Robot, goal: ConstraintConfig, train: TrainConfig, device: torch.device
) -> Penalty:
    """The losses of the tip's pose, for another link and one goal."""
    assert goal.link is not None
    if not len(robot.chain_to(goal.link).variable):
        raise ConstraintError(
            f"train.constraints: link '{goal.link}' of {robot.name} stands still, expected one "
            f"that a joint of the chain moves"
        )
    kinematics = make_link_kinematics(robot, goal.link, device)
    values = torch.tensor(goal.position if goal.pose is None else goal.pose, device=device)[None]
    if goal.pose is None:  # weighted once, by its own weight: w_k L_k of equation 9
        return lambda joints: position_loss(
            kinematics(joints)[0], values.expand(len(joints), -1), train.position_beta
        )
    if abs(float(values[0, 3:].norm()) - 1) > QUATERNION_SLACK:
        raise ConstraintError(
            f"train.constraints: the quaternion of pose must be unit, got {goal.pose[3:]}"
        )
    pose_loss = PoseLoss(train)
    return lambda joints: pose_loss(*kinematics(joints), values.expand(len(joints), -1))
