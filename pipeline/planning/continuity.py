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

BRANCH_SEEDS = 24  # configurations that solutions of one waypoint are searched from
SAME_BRANCH = 0.2  # rad or m, nearer solutions are one


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
    return _are_flips(robot, joints[:-1], joints[1:], 0.5 * (poses[:-1, :3] + poses[1:, :3]))


def _are_flips(robot: Robot, before: Array, after: Array, middle: Array) -> NDArray[np.bool_]:
    """Whether steps between rows of joints are flips; the path's middles [m] have shape (N, 3)."""
    flips: NDArray[np.bool_] = np.abs(after - before).max(axis=1) > FLIP_STEP
    wide = np.flatnonzero(flips)
    if len(wide):
        halfway = robot.forward_kinematics(0.5 * (before[wide] + after[wide]))[:, :3]
        flips[wide] = np.linalg.norm(halfway - middle[wide], axis=1) > FLIP_DEVIATION
    return flips


def continuous_path(
    robot: Robot, solver: Solver, poses: Array, start: Array | None
) -> Array | None:
    """Search a branch of solutions that follows the whole path without a flip.

    Several solutions of one waypoint are followed at once, each waypoint seeded from its
    neighbour, to both ends; what is lost or flips on the way is dropped. Where the start's joints
    are given, it is the only solution to follow.

    Args:
        robot: The robot.
        solver: Solver to ask, all branches of one waypoint in one query.
        poses: Wanted tip poses, base frame, shape (S, 7).
        start: Joints at the first waypoint [rad or m], shape (dof,), or None to choose.

    Returns:
        Joints of the branch that moves least, shape (S, dof), or None if none was found.
    """
    origins = (0,) if start is not None else (len(poses) // 2, 0, len(poses) - 1)
    for origin in origins:
        branches = start[None] if start is not None else _branches(robot, solver, poses[origin])
        forward = _followed(robot, solver, branches, poses[origin:])
        backward = _followed(robot, solver, branches, poses[origin::-1])
        paths = np.concatenate([backward[:, :0:-1], forward], axis=1)
        paths = paths[np.isfinite(paths).all(axis=(1, 2))]
        if len(paths):
            travel = np.abs(np.diff(paths, axis=1)).sum(axis=(1, 2))
            return np.array(paths[int(np.argmin(travel))])
    return None


def _branches(robot: Robot, solver: Solver, pose: Array) -> Array:
    """Different solutions of one pose, shape (K, dof); K may be 0."""
    seeds = robot.sample(BRANCH_SEEDS, collision_free=False)
    seeds[0] = robot.home
    answer = solver.solve(np.tile(pose, (len(seeds), 1)), initial=seeds)
    kept: list[Array] = []
    for joints in answer.joints[answer.found]:
        if all(np.abs(joints - other).max() > SAME_BRANCH for other in kept):
            kept.append(joints)
    return np.array(kept).reshape(-1, robot.dof)


def _followed(robot: Robot, solver: Solver, branches: Array, poses: Array) -> Array:
    """Follow branches from the first pose on, shape (K, S, dof); NaN from where one is lost."""
    paths = np.full((len(branches), len(poses), robot.dof), np.nan)
    paths[:, 0] = branches
    alive = np.arange(len(branches))
    for i in range(1, len(poses)):
        if len(alive) == 0:
            break
        before = paths[alive, i - 1]
        answer = solver.solve(np.tile(poses[i], (len(alive), 1)), initial=before)
        middle = np.tile(0.5 * (poses[i - 1, :3] + poses[i, :3]), (len(alive), 1))
        good = answer.found & ~_are_flips(robot, before, answer.joints, middle)
        alive = alive[good]
        paths[alive, i] = answer.joints[good]
    return paths


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
