"""The pointing primitive: the hand stops in front of an object with its finger towards it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from pipeline.grasping.arm import Arm, MotionAborted, first_in_reach
from pipeline.grasping.grip import Reach, choose, tip_rotation
from pipeline.grasping.outcome import ActionResult

Array = NDArray[np.float64]


class Point:
    """One gesture of an arm towards the object that its scene is about."""

    def __init__(self, arm: Arm) -> None:
        """Take the arm, which is at idle with an open hand."""
        arm.begin()
        self.arm, self.scene, self.point = arm, arm.scene, arm.scene.config.point
        hand = arm.robot.description.hand or {}
        axis = hand.get("finger_axis", hand.get("approach_axis")) if self.point.stretched else None
        self.axis = np.array(axis or hand["approach_axis"], dtype=np.float64)

    def run(self, place: ArrayLike) -> ActionResult:
        """Point at what is believed to be at a place, and go back.

        Args:
            place: Believed centre of the object, base frame [m], shape (3,).

        Returns:
            Whether the line of the finger passes near the object; never raises for a failure.
        """
        try:
            beside = self._gesture(np.asarray(place, dtype=np.float64))
        except MotionAborted as reason:
            return ActionResult(False, str(reason))
        if beside > self.point.beside:
            return ActionResult(False, f"pointed {1e3 * beside:.0f} mm beside it")
        return ActionResult(True, f"pointed {1e3 * beside:.0f} mm off its centre")

    def _gesture(self, place: Array) -> float:
        """Make the gesture and return how far the finger's line passes the object's centre [m]."""
        arm, scene = self.arm, self.scene
        arm.get_ready()
        chosen = first_in_reach(self._ways(place), arm.grip.tolerance, "a gesture")
        arm.swing(chosen.lifted)
        arm.move("lift", chosen.joints)
        scene.hand.close(self.point.stretched)
        scene.wait(self.point.hold_s)
        tip = arm.tip_pose()
        beside = distance_to_line(scene.object_position(), tip[:3], turned(tip, self.axis))
        scene.mark("pointing")
        arm.move("lift", chosen.lifted)
        arm.go_home()
        return beside

    def _ways(self, place: Array) -> Iterator[Reach]:
        """The best gesture, distance by distance."""
        arm, point = self.arm, self.point
        for distance in point.distances:
            turns = np.array([(yaw, tilt) for yaw in point.yaws for tilt in point.tilts])
            poses = np.array([self._pose(place, distance, yaw, tilt) for yaw, tilt in turns])
            above = poses.copy()
            above[:, 2] += arm.grip.lift
            yield choose(arm.robot, arm.solver, arm.grip, poses, above, turns, arm.target)

    def _pose(self, place: Array, distance: float, yaw: float, tilt: float) -> Array:
        """Pose of the tip at a distance from a place, its finger's axis through it."""
        rotation = tip_rotation(self.scene.config, place, yaw, tilt)
        position = place - distance * rotation.apply(self.axis)
        return np.concatenate([position, rotation.as_quat()[[3, 0, 1, 2]]])


def turned(pose: Array, axis: Array) -> Array:
    """An axis of the tip's frame in the base frame, shape (3,)."""
    direction: Array = Rotation.from_quat(pose[[4, 5, 6, 3]]).apply(axis)
    return direction


def distance_to_line(point: Array, origin: Array, direction: Array) -> float:
    """Distance of a point from a half-line [m]; what is behind its origin is as far as that."""
    away = point - origin
    along = max(float(away @ direction), 0.0)
    return float(np.linalg.norm(away - along * direction))
