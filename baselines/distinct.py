"""Solutions of one pose that differ: what counts as another one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robots.limits import FULL_TURN

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


def joint_distances(robot: Robot, joints: Array, other: Array) -> Array:
    """Return how far configurations are from another one: the joint that differs most, (N,).

    Joints that turn for ever differ by half a turn at most.

    Args:
        robot: The robot.
        joints: (N, dof) [rad or m].
        other: (dof,) [rad or m].
    """
    offset = joints - other
    turned = offset - FULL_TURN * np.round(offset / FULL_TURN)
    return np.asarray(np.abs(np.where(robot.endless, turned, offset)).max(axis=1, initial=0.0))


def distinct(robot: Robot, joints: Array, apart: float, known: Array | None = None) -> Array:
    """Return of configurations those that differ, in their order.

    Args:
        robot: The robot.
        joints: (N, dof) [rad or m].
        apart: Least distance, see `joint_distances` [rad or m].
        known: (K, dof) that differ already, and come first.

    Returns:
        (M, dof), `known` included.
    """
    kept = np.empty((0, robot.dof)) if known is None else known
    for row in joints:
        if (joint_distances(robot, kept, row) > apart).all():
            kept = np.vstack([kept, row])
    return kept


def nearest_first(robot: Robot, joints: Array, guess: Array | None) -> Array:
    """Return configurations (N, dof) by their distance from a guess (dof,), if there is one."""
    if guess is None:
        return joints
    return joints[np.argsort(joint_distances(robot, joints, guess), kind="stable")]
