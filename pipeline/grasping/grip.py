"""Where the hand goes to grasp: a top grasp, turned and tilted as little as reach demands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from pipeline.grasping.config import SceneConfig
from pipeline.planning.rotation import angle_between

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]


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
    rotation = (
        Rotation.from_euler("z", tip_yaw(scene, point) + yaw, degrees=True)
        * Rotation.from_euler("y", tilt, degrees=True)
        * Rotation.from_euler("xyz", scene.grip.rotation, degrees=True)
    )
    position = point - rotation.apply(scene.grip.offset)
    position[2] = max(position[2], scene.table.height + scene.grip.floor)
    return np.concatenate([position, rotation.as_quat()[[3, 0, 1, 2]]])


def reachable_pose(
    robot: Robot, solver: Solver, scene: SceneConfig, place: ArrayLike, lift: float
) -> tuple[Array, float]:
    """First of the scene's top grasps that the arm reaches, at the place and lifted.

    One batched query for all candidates, the least turned first. The paper keeps one orientation
    throughout; a scene with one yaw and one tilt does the same.

    Args:
        robot: The robot.
        solver: Inverse kinematics.
        scene: Grip: candidates and tolerance.
        place: Point to grasp around, base frame [m], shape (3,).
        lift: Height above the place that must be reached too [m].

    Returns:
        The pose, shape (7,), and the larger tip error of the two [m]; the best one if none is
        within the tolerance.
    """
    turns = [(yaw, tilt) for yaw in scene.grip.yaws for tilt in scene.grip.tilts]
    turns.sort(key=lambda turn: abs(turn[0]) + abs(turn[1] - scene.grip.tilts[0]))
    poses = np.array([tip_pose(scene, place, yaw, tilt) for yaw, tilt in turns])
    lifted = poses.copy()
    lifted[:, 2] += lift
    query = np.concatenate([poses, lifted])
    reached = robot.forward_kinematics(solver.solve(query).joints)
    distance = np.linalg.norm(reached[:, :3] - query[:, :3], axis=1)
    # An angle counts like the way a fingertip 10 cm from the wrist goes.
    distance += 0.1 * angle_between(reached[:, 3:], query[:, 3:])
    error = np.maximum(*np.split(distance, 2))
    near = np.flatnonzero(error < scene.grip.tolerance)
    best = int(near[0]) if len(near) else int(np.argmin(error))
    return poses[best], float(error[best])
