"""Jumps between waypoints: finding them, and repairing them from the neighbouring waypoint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]

# What counts as a branch flip is part of the metric's definition, so it is fixed here: the joints
# step further than a smooth motion would, and on the straight way between the two configurations
# the tip strays from the path. A wide but honest step of the wrist is none.
FLIP_STEP = 0.5  # rad or m, largest joint
FLIP_DEVIATION = 0.02  # m, tip from the middle of the two waypoints


def joint_steps(joints: Array) -> Array:
    """Largest change of a joint from each waypoint to the next.

    Args:
        joints: Joint positions [rad or m], shape (S, dof).

    Returns:
        Steps [rad or m], shape (S - 1,).
    """
    return np.abs(np.diff(joints, axis=0)).max(axis=1)


def branch_flips(robot: Robot, joints: Array, poses: Array) -> NDArray[np.bool_]:
    """Find the steps at which the joints change to another branch of solutions.

    Args:
        robot: The robot.
        joints: Joint positions at the waypoints [rad or m], shape (S, dof).
        poses: Wanted tip poses, base frame [m, unit quaternion], shape (S, 7).

    Returns:
        Whether step i, from waypoint i to i + 1, is a flip, shape (S - 1,).
    """
    flips = joint_steps(joints) > FLIP_STEP
    if flips.any():
        first = np.flatnonzero(flips)
        middle = robot.forward_kinematics(0.5 * (joints[first] + joints[first + 1]))[:, :3]
        wanted = 0.5 * (poses[first, :3] + poses[first + 1, :3])
        flips[first] = np.linalg.norm(middle - wanted, axis=1) > FLIP_DEVIATION
    return flips


def repair_jumps(
    robot: Robot, solver: Solver, joints: Array, poses: Array, found: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.bool_]]:
    """Solve again, from the neighbour before, every waypoint that was missed or jumped to.

    A waypoint is only replaced by a solution that is found and is no flip; what cannot be repaired
    stays as it was and is reported by `branch_flips`.

    Args:
        robot: The robot.
        solver: Solver to ask, one waypoint at a time, seeded with the neighbour's joints.
        joints: Joint positions [rad or m], shape (S, dof).
        poses: Wanted tip poses, base frame, shape (S, 7).
        found: What the batched query claimed, shape (S,).

    Returns:
        Repaired joints, shape (S, dof), and claims, shape (S,).
    """
    joints, found = joints.copy(), found.copy()
    for i in range(len(joints)):
        before = joints[max(i - 1, 0)]
        pair = np.stack([before, joints[i]])
        smooth = i == 0 or not branch_flips(robot, pair, poses[i - 1 : i + 1])[0]
        if found[i] and smooth:
            continue
        answer = solver.solve(poses[i : i + 1], initial=before)
        pair[1] = answer.joints[0]
        smooth = i == 0 or not branch_flips(robot, pair, poses[i - 1 : i + 1])[0]
        if answer.found[0] and smooth:
            joints[i], found[i] = answer.joints[0], True
    return joints, found
