"""Where the hand goes to grasp: a top grasp, turned and tilted as little as reach demands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from baselines import Budget
from pipeline.grasping.config import GripConfig, SceneConfig
from robots.rotations import rotation_angle

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]
HAND_LENGTH = 0.1  # m from wrist to fingertip, turns an angle into a distance
ERROR_WEIGHT = 50.0  # rad of joint travel that a metre of tip error weighs
LIFT_WEIGHT = 3.0  # of the joints' way during the lift, which a change of branch makes long


def tip_yaw(scene: SceneConfig, place: ArrayLike) -> float:
    """Turn of the top grasp about the vertical at a place, before any turn for reach [deg]."""
    if scene.grip.pivot is None:
        return 0.0
    away = np.asarray(place, dtype=np.float64)[:2] - np.asarray(scene.grip.pivot)
    return float(np.rad2deg(np.arctan2(away[1], away[0])))


def tip_pose(scene: SceneConfig, place: ArrayLike, yaw: float, tilt: float) -> Array:
    """Pose of the tip with a point of the world at the grip's offset.

    Args:
        scene: Grip and table.
        place: Point to grasp around, base frame [m], shape (3,).
        yaw: Turn about the vertical, added to the one that follows the place [deg].
        tilt: Turn about the tip's x axis [deg].

    Returns:
        Pose, base frame [m, unit quaternion w x y z], shape (7,).
    """
    point = np.asarray(place, dtype=np.float64)
    rotation = tip_rotation(scene, point, yaw, tilt)
    position = point - rotation.apply(scene.grip.offset)
    position[2] = max(position[2], scene.table.height + scene.grip.floor)
    return np.concatenate([position, rotation.as_quat()[[3, 0, 1, 2]]])


def tip_rotation(scene: SceneConfig, place: ArrayLike, yaw: float, tilt: float) -> Rotation:
    """Rotation of the tip over a place, from its frame into the base frame.

    Args:
        scene: Grip.
        place: What the hand is turned to, base frame [m], shape (2,) or (3,).
        yaw: Turn about the vertical, added to the one that follows the place [deg].
        tilt: Turn about the horizontal axis across the hand; positive lowers what is in front
            [deg].
    """
    return (
        Rotation.from_euler("z", tip_yaw(scene, place) + yaw, degrees=True)
        * Rotation.from_euler("y", tilt, degrees=True)
        * Rotation.from_euler("xyz", scene.grip.rotation, degrees=True)
    )


@dataclass(frozen=True)
class Reach:
    """A top grasp that was chosen for a place.

    Attributes:
        pose: Of the tip, base frame, shape (7,).
        joints: Of the arm there [rad or m], shape (dof,).
        lifted: Of the arm at the lifted pose [rad or m], shape (dof,).
        error: Larger tip error of the pose and of the lifted pose [m].
    """

    pose: Array
    joints: Array
    lifted: Array
    error: float


def reach(
    robot: Robot,
    solver: Solver,
    scene: SceneConfig,
    place: ArrayLike,
    near: Array,
    yaws: list[float],
    lift: float,
) -> Reach:
    """Choose, among the scene's turns and tilts, the reachable top grasp nearest to the arm.

    One batched query for all candidates. The paper keeps one orientation throughout; a scene with
    one yaw and one tilt does the same. An arm of six joints needs some freedom to cover a table.

    Args:
        robot: The robot.
        solver: Inverse kinematics.
        scene: Grip: tilts and tolerance.
        place: Point to grasp around, base frame [m], shape (3,).
        near: Joints to stay close to, the seed of the query [rad or m], shape (dof,).
        yaws: Turns about the vertical to try [deg].
        lift: Height above the place that must be reached too [m].

    Returns:
        The candidate within the tolerance that costs least joint travel, turning from the first
        one and tip error; the most exact one if none is within it.
    """
    turns = np.array([(yaw, tilt) for yaw in yaws for tilt in scene.grip.tilts])
    poses = np.array([tip_pose(scene, place, yaw, tilt) for yaw, tilt in turns])
    lifted = poses.copy()
    lifted[:, 2] += lift
    return choose(robot, solver, scene.grip, poses, lifted, turns, near)


def choose(
    robot: Robot,
    solver: Solver,
    grip: GripConfig,
    poses: Array,
    lifted: Array,
    turns: Array,
    near: Array,
) -> Reach:
    """Choose among poses of the tip the reachable one nearest to the arm, in one batched query.

    Args:
        robot: The robot.
        solver: Inverse kinematics.
        grip: Tolerance, and effort of the search.
        poses: Candidates, base frame, shape (C, 7).
        lifted: Where the tip goes straight from each, which must be in reach too, shape (C, 7).
        turns: Yaw and tilt of each candidate [deg], shape (C, 2); turning from the first one costs.
        near: Joints to stay close to, the seed of the query [rad or m], shape (dof,).

    Returns:
        As `reach` does.
    """
    # Seeded by the arm's joints and by its idle ones: the nearest solution may end at a limit.
    poses, lifted = np.tile(poses, (2, 1)), np.tile(lifted, (2, 1))
    seeds = np.repeat([near, robot.home], len(poses) // 2, axis=0)
    budget = None
    if "iterations" in solver.budgets:
        # Many candidates are out of reach, and one without a solution would use up all restarts.
        budget = Budget(iterations=grip.search_iterations)
    joints = solver.solve(poses, initial=seeds, budget=budget).joints
    above = solver.solve(lifted, initial=joints, budget=budget).joints
    error = np.maximum(_tip_error(robot, joints, poses), _tip_error(robot, above, lifted))
    cost = np.abs(joints - near).max(axis=1) + LIFT_WEIGHT * np.abs(above - joints).max(axis=1)
    cost += np.tile(np.deg2rad(np.abs(turns - turns[0]).sum(axis=1)), 2)
    cost += ERROR_WEIGHT * error
    within = error < grip.tolerance
    best = int(np.argmin(np.where(within, cost, np.inf) if within.any() else error))
    return Reach(poses[best], joints[best], above[best], float(error[best]))


def _tip_error(robot: Robot, joints: Array, poses: Array) -> Array:
    """Distance of the tip from its pose [m]; an angle counts like a way at the fingertips."""
    reached = robot.forward_kinematics(joints)
    distance = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
    return distance + HAND_LENGTH * rotation_angle(reached[:, 3:], poses[:, 3:])
