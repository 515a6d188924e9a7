"""Where the tip really is: poses of returned joints, recomputed by Pinocchio in float64."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pinocchio
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import PipelineError
from robots.errors import RobotError, UrdfError
from robots.rotations import canonical

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


class VerificationError(PipelineError):
    """Joints that no tip pose can be computed of."""


def tip_poses(robot: Robot, joints: ArrayLike) -> Array:
    """Compute tip poses with Pinocchio, independently of the robot's own kinematics.

    A robot whose chain has coupled joints has no plain Pinocchio model; its own kinematics, which
    tests hold to Pinocchio's, are taken then.

    Args:
        robot: Whose tip.
        joints: (N, dof) base to tip [rad or m], finite.

    Returns:
        (N, 7) poses of the tip in the base frame, x y z [m], qw qx qy qz with w >= 0.

    Raises:
        VerificationError: Joints of the wrong shape or not finite.
    """
    q = np.asarray(joints, dtype=np.float64)
    if q.ndim != 2 or q.shape[1] != robot.dof:
        raise VerificationError(f"expected joints of shape (N, {robot.dof}), got {q.shape}")
    if not np.isfinite(q).all():
        raise VerificationError("expected finite joints, got NaN or infinite values")
    try:
        model, tip = robot.pinocchio()
    except RobotError:
        return robot.forward_kinematics(q)
    data = model.createData()
    poses = np.empty((len(q), 7))
    for row, configuration in enumerate(q):
        pinocchio.framesForwardKinematics(model, data, configuration)
        poses[row] = pinocchio.SE3ToXYZQUAT(data.oMf[tip])
    poses[:, 3:] = canonical(poses[:, [6, 3, 4, 5]])  # Pinocchio puts the scalar last
    return poses


def within_limits(robot: Robot, joints: ArrayLike, slack: float) -> NDArray[np.bool_]:
    """Return which configurations keep every joint within its limits.

    Args:
        robot: Whose limits.
        joints: (N, dof) [rad or m].
        slack: How far beyond a limit is still taken for rounding [rad or m].

    Returns:
        (N,) flags.
    """
    return robot.within_limits(joints, slack)


def self_collisions(robot: Robot, joints: ArrayLike) -> pd.arrays.BooleanArray:
    """Return which configurations bring a robot into collision with itself.

    Args:
        robot: The robot, with the pairs of links that it may let touch.
        joints: (N, dof) [rad or m].

    Returns:
        (N,) flags; none is known of a robot with a collision shape that cannot be used.
    """
    try:
        touching = robot.in_collision(joints)
    except UrdfError:
        unknown = np.ones(len(np.asarray(joints)), dtype=bool)
        return pd.arrays.BooleanArray(np.zeros_like(unknown), unknown)
    return pd.arrays.BooleanArray(touching, np.zeros_like(touching))
