"""Motions of the tip: a Cartesian path, one batched inverse-kinematics query, what came of it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.planning.bezier import bezier_curve, path_parameter
from pipeline.planning.continuity import (
    branch_flips,
    continuous_path,
    joint_steps,
    repair_jumps,
)
from pipeline.planning.rotation import slerp, spherical_bezier
from robots.rotations import rotation_angle

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """A planned motion and how well its joints follow the path.

    Attributes:
        poses: Wanted tip poses, base frame [m, unit quaternion w x y z], shape (S, 7).
        joints: Joint positions [rad or m], shape (S, dof).
        found: The solver's own claim at each waypoint, shape (S,).
        time_s: Wall time of planning, path and inverse kinematics together [s].
        tip_error_mm: Euclidean distance of the tip from its pose [mm], shape (S,).
        tip_error_deg: Angle of the tip's rotation from its pose's [deg], shape (S,).
        largest_step: Largest change of one joint between two waypoints [rad or m].
        flips: Number of branch flips, see `continuity.branch_flips`.
    """

    poses: Array
    joints: Array
    found: NDArray[np.bool_]
    time_s: float
    tip_error_mm: Array
    tip_error_deg: Array
    largest_step: float
    flips: int


def tip_path(
    start: ArrayLike,
    target: ArrayLike,
    control_points: ArrayLike | None = None,
    steps: int = 50,
    control_rotations: ArrayLike | None = None,
) -> Array:
    """Sample the tip's path: Bezier in position, Slerp or spherical Bezier in rotation.

    Equations 10 to 12 of the paper. The k of `path_parameter` runs from 0 at the start to 1 at the
    target in `steps` samples, both included.

    Args:
        start: Start pose, base frame, shape (7,).
        target: Target pose, base frame, shape (7,).
        control_points: Inner control points, base frame [m], shape (n, 3); none is a straight line.
        steps: Number of poses, at least 2.
        control_rotations: Inner key rotations, unit quaternions, shape (m, 4); none is Slerp.

    Returns:
        Poses, base frame, shape (steps, 7).
    """
    first, last = np.asarray(start, dtype=np.float64), np.asarray(target, dtype=np.float64)
    inner = np.zeros((0, 3)) if control_points is None else np.asarray(control_points, np.float64)
    k = path_parameter(steps)
    positions = bezier_curve(np.vstack([first[:3], inner.reshape(-1, 3), last[:3]]), k)
    if control_rotations is None:
        rotations = slerp(first[3:], last[3:], k)
    else:
        keys = np.asarray(control_rotations, dtype=np.float64).reshape(-1, 4)
        rotations = spherical_bezier(np.vstack([first[3:], keys, last[3:]]), k)
    return np.hstack([positions, rotations])


def plan_motion(
    robot: Robot,
    solver: Solver,
    start: ArrayLike,
    target: ArrayLike,
    control_points: ArrayLike | None = None,
    steps: int = 50,
    control_rotations: ArrayLike | None = None,
    repair: Solver | None = None,
) -> Motion:
    """Plan a motion of the tip with one batched inverse-kinematics query.

    The two ends are solved first, and the batch is seeded with the straight way between their
    joints: neighbouring seeds keep an iterative solver on one branch of solutions. A solver that
    takes no seed is not changed by that.

    No obstacle is avoided, as in the paper: clearance comes from the control points.

    Args:
        robot: The robot.
        solver: Solver for the whole batch of poses.
        start: Start pose (7,) or joint positions (dof,), which are kept as the first waypoint; a
            start pose is solved from the robot's home configuration.
        target: Target pose (7,) or joint positions (dof,), which are kept as the last waypoint.
        control_points: Inner control points, base frame [m], shape (n, 3).
        steps: Number of poses, both ends included, at least 2.
        control_rotations: Inner key rotations, unit quaternions, shape (m, 4).
        repair: Solver that mends branch flips, by another branch for the whole path or else from
            the neighbouring waypoint; none leaves them as the query gave them.

    Returns:
        The motion; an unreachable path is one too, with `found` false where the solver says so.

    Raises:
        ValueError: If start or target is neither a pose nor a joint vector of this robot.
    """
    first, first_joints = motion_end(robot, "start", start)
    last, last_joints = motion_end(robot, "target", target)
    begin = time.perf_counter()
    poses = tip_path(first, last, control_points, steps, control_rotations)
    seed = robot.home if first_joints is None else first_joints
    ends = np.array(solver.solve(poses[[0, -1]], initial=seed).joints)
    given = {0: first_joints, -1: last_joints}
    for i, known in given.items():
        ends[i] = ends[i] if known is None else known
    solution = solver.solve(poses, initial=_straight_way(ends[0], ends[-1], steps))
    joints, found = np.array(solution.joints), np.array(solution.found)
    for i, known in given.items():
        if known is not None:
            joints[i], found[i] = known, True
    if repair is not None and not (found.all() and not branch_flips(robot, joints, poses).any()):
        joints, found = _repaired(robot, repair, joints, poses, found, given)
    return _judged(robot, poses, joints, found, time.perf_counter() - begin)


def _repaired(
    robot: Robot,
    solver: Solver,
    joints: Array,
    poses: Array,
    found: NDArray[np.bool_],
    given: dict[int, Array | None],
) -> tuple[Array, NDArray[np.bool_]]:
    """Another branch for the whole path if there is one, else neighbour by neighbour."""
    if given[-1] is None and found.all():
        path = continuous_path(robot, solver, poses, given[0])
        if path is not None:
            return path, found
    return repair_jumps(robot, solver, joints, poses, found)


def _straight_way(first: Array, last: Array, steps: int) -> Array:
    """Joints evenly from one configuration to another, shape (steps, dof)."""
    k = path_parameter(steps)[:, None]
    return (1.0 - k) * first + k * last


def motion_end(robot: Robot, name: str, value: ArrayLike) -> tuple[Array, Array | None]:
    """Pose of one end of a motion, and its joints if it was given by joints.

    With seven joints a vector of length seven could be both; a unit quaternion in its last four
    places decides for the pose.

    Args:
        robot: The robot.
        name: What to call the end in an error.
        value: Pose (7,) or joint positions (dof,).

    Returns:
        The pose, base frame, shape (7,), and the joints, shape (dof,), or None.

    Raises:
        ValueError: If the value is neither.
    """
    vector = np.asarray(value, dtype=np.float64)
    if vector.ndim == 1 and np.isfinite(vector).all():
        if len(vector) == 7 and abs(np.linalg.norm(vector[3:]) - 1.0) < 1e-6:
            return vector, None
        if len(vector) == robot.dof:
            return robot.forward_kinematics(vector[None])[0], vector
    raise ValueError(
        f"{name} must be a pose (x, y, z, unit quaternion w, x, y, z) or {robot.dof} joint "
        f"positions of {robot.name}, all finite, got {vector.tolist()}"
    )


def _judged(
    robot: Robot, poses: Array, joints: Array, found: NDArray[np.bool_], seconds: float
) -> Motion:
    reached = robot.forward_kinematics(joints)
    return Motion(
        poses=poses,
        joints=joints,
        found=found,
        time_s=seconds,
        tip_error_mm=1e3 * np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1),
        tip_error_deg=np.rad2deg(rotation_angle(reached[:, 3:], poses[:, 3:])),
        largest_step=float(joint_steps(joints).max()),
        flips=int(branch_flips(robot, joints, poses).sum()),
    )
