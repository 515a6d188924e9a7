"""Motions of the tip: a Cartesian path, one batched inverse-kinematics query, what came of it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.planning.continuity import (
    Ends,
    branch_flips,
    fits,
    joint_steps,
    kernel_options,
    repair_path,
)
from pipeline.planning.path import tip_path
from pipeline.planning.query import solve_waypoints
from pipeline.planning.reach import out_of_reach
from pipeline.planning.route import Route, find_route
from robots.rotations import rotation_angle

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """A planned motion and how well its joints follow the path.

    Attributes:
        poses: Tip poses that are driven, base frame [m, unit quaternion w x y z], shape (S, 7).
        joints: Joint positions [rad or m], shape (S, dof).
        found: Claims at each waypoint, the solver's or the repair's, shape (S,).
        time_s: Wall time of planning: path, inverse kinematics and repair together [s].
        tip_error_mm: Euclidean distance of the tip from its pose in `poses` [mm], shape (S,).
        tip_error_deg: Angle of the tip's rotation from its pose's [deg], shape (S,).
        largest_step: Largest change of one joint between two waypoints [rad or m].
        flips: Number of branch flips, see `continuity.branch_flips`.
        answers: Joints as the batched query gave them, before any repair, shape (S, dof).
        answered: The solver's claims in it, shape (S,).
        query_s: Wall time of path and query alone [s].
        requested: Tip poses on the path that was asked for, shape (S, 7); `answers` are for these.
        route: The other curve that is driven where no joints were found for that path, or None:
            then `poses` and `requested` are the same.
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
    requested: Array
    route: Route | None


def plan_motion(
    robot: Robot,
    solver: Solver,
    start: ArrayLike,
    target: ArrayLike,
    control_points: ArrayLike | None = None,
    steps: int = 50,
    control_rotations: ArrayLike | None = None,
    repair: Solver | None = None,
    reroute: bool = True,
) -> Motion:
    """Plan a motion of the tip with one batched inverse-kinematics query.

    How the batch is solved is said in `query.solve_waypoints`. If its answers flip between branches
    of solutions or miss a waypoint, they are repaired, see `continuity.repair_path`. Where the
    joints at the start are not given, the branch is free.

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
        reroute: Whether another curve may be driven where no branch lives through this one. Forbid
            it where the way matters and not its ends alone.

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
    requested = tip_path(first, last, control_points, steps, control_rotations)
    ends = Ends(first_joints, last_joints)
    given = solve_waypoints(robot, solver, requested, ends)
    query_s = time.perf_counter() - begin
    poses, joints, found, route = requested, given.joints, given.found, None
    if options is not None:
        astray = reroute and out_of_reach(robot, requested, found, options)
        mending = (robot, requested, joints, found, ends, options, given.candidates)
        if not astray:  # else no search can help, so do without
            joints, found = repair_path(*mending, flip_free_only=reroute)
        if reroute and not fits(robot, joints, found, requested):
            route = find_route(robot, requested, ends, options)
            if route is None:
                joints, found = repair_path(*mending)
    if route is not None:
        poses, joints, found = route.poses, route.joints, np.ones(steps, dtype=bool)
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
        requested=requested,
        route=route,
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
