"""Motions of the tip: a Cartesian path, one batched inverse-kinematics query, what came of it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.planning.continuity import (
    Answers,
    Ends,
    branch_flips,
    fits,
    joint_steps,
    kernel_options,
    repair_path,
)
from pipeline.planning.path import PathError, checked_joints, checked_pose, tip_path
from pipeline.planning.query import solve_waypoints
from pipeline.planning.reach import out_of_reach
from pipeline.planning.route import Route, find_route
from robots.rotations import rotation_angle

if TYPE_CHECKING:
    from baselines import Solver
    from baselines.lm_kernel import LmOptions
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
        requested: Tip poses on the requested path, shape (S, 7); `answers` are for these.
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
    start: ArrayLike | None = None,
    target: ArrayLike | None = None,
    control_points: ArrayLike | None = None,
    steps: int = 50,
    control_rotations: ArrayLike | None = None,
    repair: Solver | None = None,
    reroute: bool = True,
    *,
    start_joints: ArrayLike | None = None,
    target_joints: ArrayLike | None = None,
) -> Motion:
    """Plan a motion of the tip with one batched inverse-kinematics query.

    How the batch is solved is said in `query.solve_waypoints`. If its answers flip between branches
    of solutions or miss a waypoint, they are repaired, see `continuity.repair_path`. Where the
    joints at the start are not given, the branch is free.

    No obstacle is avoided, as in the paper: clearance comes from the control points.

    Args:
        robot: The robot.
        solver: Solver for the whole batch of poses.
        start: Start pose (x, y, z [m], unit quaternion w, x, y, z), base frame, shape (7,).
        target: Target pose, base frame, shape (7,).
        control_points: Inner control points, base frame [m], shape (n, 3).
        steps: Number of poses, both ends included, at least 2.
        control_rotations: Inner key rotations, unit quaternions, shape (m, 4).
        repair: `lm` or a refined solver, whose tolerances and damping repair the path; where
            left out, a solver that has them repairs its own path, and others stay as answered.
        reroute: Whether another curve may be driven where no branch covers this one. Forbid it
            where the path matters and not its ends alone.
        start_joints: Instead of `start`: joint positions [rad or m], shape (dof,), which are kept
            as the first waypoint.
        target_joints: Instead of `target`: joint positions, which are kept as the last waypoint.

    Returns:
        The motion; an unreachable path is one too, with `found` false where the solver says so.

    Raises:
        PathError: An end is given twice or not at all; an end, control points or key rotations
            have another shape, are not finite or not unit; or `repair` is a solver that cannot
            repair a path.
    """
    first, first_joints = motion_end(robot, "start", start, start_joints)
    last, last_joints = motion_end(robot, "target", target, target_joints)
    options = kernel_options(solver if repair is None else repair)
    if options is None and repair is not None:
        raise PathError(
            f"repair must be lm or a refined solver, cycleik_refined for one, got "
            f"{repair.name or repair}"
        )
    begin = time.perf_counter()
    requested = tip_path(first, last, control_points, steps, control_rotations)
    ends = Ends(first_joints, last_joints)
    given = solve_waypoints(robot, solver, requested, ends)
    query_s = time.perf_counter() - begin
    joints, found, route = given.joints, given.found, None
    if options is not None:
        joints, found, route = _repaired(robot, requested, given, ends, options, reroute)
    poses = requested if route is None else route.poses
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


def _repaired(
    robot: Robot,
    requested: Array,
    given: Answers,
    ends: Ends,
    options: LmOptions,
    reroute: bool,
) -> tuple[Array, NDArray[np.bool_], Route | None]:
    """Repair the answers to a path, and find another curve where that is allowed and necessary."""
    joints, found, _ = given
    # Where a waypoint is out of reach no search can help, so do without.
    if not (reroute and out_of_reach(robot, requested, found, options)):
        joints, found = repair_path(robot, requested, given, ends, options, reroute)
    if not reroute or fits(robot, joints, found, requested):
        return joints, found, None
    route = find_route(robot, requested, ends, options)
    if route is not None:
        return route.joints, np.ones(len(requested), dtype=bool), route
    joints, found = repair_path(robot, requested, given, ends, options)
    return joints, found, None


def motion_end(
    robot: Robot, name: str, pose: ArrayLike | None, joints: ArrayLike | None
) -> tuple[Array, Array | None]:
    """Pose of one end of a motion, and its joints if it was given by joints.

    Args:
        robot: The robot.
        name: What to call the end in an error, start or target.
        pose: Pose (7,), base frame, or None.
        joints: Joint positions (dof,) [rad or m], or None.

    Returns:
        The pose, base frame, shape (7,), and the joints, shape (dof,), or None.

    Raises:
        PathError: Both are given or neither, or the value has another shape.
    """
    if (pose is None) == (joints is None):
        given = "both" if joints is not None else "neither"
        raise PathError(f"expected {name}, a pose, or {name}_joints, got {given}")
    if joints is None:
        assert pose is not None
        return checked_pose(name, pose), None
    known = checked_joints(f"{name}_joints", joints, robot.dof)
    return robot.forward_kinematics(known[None])[0], known
