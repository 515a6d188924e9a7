"""Motions of the tip: a Cartesian path, one batched inverse-kinematics query, what came of it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.planning.bezier import bezier_curve, path_parameter
from pipeline.planning.continuity import Ends, branch_flips, joint_steps, kernel_options, mend
from pipeline.planning.query import answer
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
        found: Claims at each waypoint, the solver's or the repair's, shape (S,).
        time_s: Wall time of planning: path, inverse kinematics and repair together [s].
        tip_error_mm: Euclidean distance of the tip from its pose [mm], shape (S,).
        tip_error_deg: Angle of the tip's rotation from its pose's [deg], shape (S,).
        largest_step: Largest change of one joint between two waypoints [rad or m].
        flips: Number of branch flips, see `continuity.branch_flips`.
        answers: Joints as the batched query gave them, before any repair, shape (S, dof).
        answered: The solver's claims in it, shape (S,).
        query_s: Wall time of path and query alone [s].
    """

    poses: Array
    joints: Array
    found: NDArray[np.bool_]
    time_s: float
    tip_error_mm: Array
    tip_error_deg: Array
    largest_step: float
    flips: int
    answers: Array
    answered: NDArray[np.bool_]
    query_s: float


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

    How the batch is asked is said in `query.answer`. If its answers flip between branches of
    solutions or miss a waypoint, they are mended, see `continuity.mend`. Where the joints at the
    start are not given, the branch is free.

    No obstacle is avoided, as in the paper: clearance comes from the control points.

    Args:
        robot: The robot.
        solver: Solver for the whole batch of poses.
        start: Start pose (7,) or joint positions (dof,), which are kept as the first waypoint.
        target: Target pose (7,) or joint positions (dof,), which are kept as the last waypoint.
        control_points: Inner control points, base frame [m], shape (n, 3).
        steps: Number of poses, both ends included, at least 2.
        control_rotations: Inner key rotations, unit quaternions, shape (m, 4).
        repair: `lm` or `cycleik_refined`, whose tolerances and damping mend the path; where left
            out, a solver that is one of them mends its own, and others stay as they answered.

    Returns:
        The motion; an unreachable path is one too, with `found` false where the solver says so.

    Raises:
        ValueError: If start or target is neither a pose nor a joint vector of this robot, or
            `repair` is a solver that cannot mend.
    """
    first, first_joints = motion_end(robot, "start", start)
    last, last_joints = motion_end(robot, "target", target)
    options = kernel_options(solver if repair is None else repair)
    if options is None and repair is not None:
        raise ValueError(f"repair must be lm or cycleik_refined, got {repair.name or repair}")
    begin = time.perf_counter()
    poses = tip_path(first, last, control_points, steps, control_rotations)
    ends = Ends(first_joints, last_joints)
    given = answer(robot, solver, poses, ends)
    query_s = time.perf_counter() - begin
    joints, found = given.joints, given.found
    if options is not None:
        joints, found = mend(robot, poses, joints, found, ends, options, given.candidates)
    seconds = time.perf_counter() - begin
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
        answers=given.joints,
        answered=given.found,
        query_s=query_s,
    )


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
