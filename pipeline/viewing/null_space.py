"""Self-motion of a redundant arm: the joints move, the tip stays where it is.

Predictor and corrector: a step along the null space of the Jacobian, then Newton steps by its
pseudo-inverse back to the pose (Nakamura, Advanced Robotics: Redundancy and Optimization, 1991,
section 4.2; Allgower and Georg, Introduction to Numerical Continuation Methods, 2003, section 6.1).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.viewing.errors import ViewError
from robots.rotations import (
    quaternion_conjugate,
    quaternion_multiply,
    rotation_vector_from_quaternion,
)

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
RANK_TOLERANCE = 1e-6  # share of the largest singular value below which one counts as zero
CORRECTIONS = 6  # Newton steps at most
CLOSE = 1e-8  # m and rad, norm of the twist to the pose that ends the correction
LONGEST = 160  # steps to either side
SMALLEST = 1e-3  # length of a direction's projection below which it is taken for none


def self_motion(robot: Robot, joints: Array, step: float, seed: int = 0) -> Array:
    """Configurations with one pose of the tip: to a joint limit, to one on the other side, back.

    Args:
        robot: The robot.
        joints: Where it starts and ends [rad or m], shape (dof,).
        step: Length of a step in joint space [rad or m].
        seed: Of the direction, which counts where the null space has more than one dimension.

    Returns:
        (S, dof) joints [rad or m], neighbours about a step apart.

    Raises:
        ViewError: There is no null space here.
    """
    wish = np.random.default_rng(seed).normal(size=robot.dof)
    if np.linalg.norm(_projected(robot, joints, wish)) < SMALLEST:
        raise ViewError(
            f"{robot.name} has {robot.dof} joints and no null space here: only a redundant arm can "
            "move while its tip stays"
        )
    pose = robot.forward_kinematics(joints)[0]
    ahead, behind = (_branch(robot, joints, pose, sign * wish, step) for sign in (1.0, -1.0))
    there = [joints, *ahead]
    other = [joints, *behind]
    return np.array([*there, *there[-2::-1], *other[1:], *other[-2::-1]])


def _branch(robot: Robot, joints: Array, pose: Array, wish: Array, step: float) -> list[Array]:
    """Steps in one direction until a joint meets its limit or the pose is lost."""
    found: list[Array] = []
    at, direction = joints, wish
    for _ in range(LONGEST):
        direction = _projected(robot, at, direction)
        length = np.linalg.norm(direction)
        if length < SMALLEST:
            break
        direction = direction / length
        corrected = _corrected(robot, at + step * direction, pose)
        if corrected is None or not robot.within_limits(corrected)[0]:
            break
        found.append(corrected)
        at = corrected
    return found


def _projected(robot: Robot, joints: Array, direction: Array) -> Array:
    """The part of a direction (dof,) that moves no tip."""
    _, values, rows = np.linalg.svd(robot.jacobian(joints)[0])
    null = rows[int((values > RANK_TOLERANCE * values[0]).sum()) :]
    projected: Array = null.T @ (null @ direction)
    return projected


def _corrected(robot: Robot, joints: Array, pose: Array) -> Array | None:
    """Joints near others that have the pose, None where Newton's steps do not get there."""
    for _ in range(CORRECTIONS):
        twist = _twist(robot.forward_kinematics(joints)[0], pose)
        if np.linalg.norm(twist) < CLOSE:
            return joints
        joints = joints + np.linalg.pinv(robot.jacobian(joints)[0]) @ twist
    return None


def _twist(pose: Array, target: Array) -> Array:
    """Translation [m] and rotation vector [rad] from a pose to a target, axes of the base, (6,)."""
    turn = quaternion_multiply(target[3:], quaternion_conjugate(pose[3:]))
    return np.concatenate([target[:3] - pose[:3], rotation_vector_from_quaternion(turn)])
