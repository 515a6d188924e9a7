"""The pushing primitive: the closed hand comes down beside an object and slides it sideways."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.grasping.arm import Arm, MotionAborted, first_in_reach
from pipeline.grasping.grip import Reach, choose, tip_rotation, tip_yaw
from pipeline.grasping.outcome import ActionResult

Array = NDArray[np.float64]


class Push:
    """One attempt of an arm to push the object that its scene is about."""

    def __init__(self, arm: Arm) -> None:
        """Take the arm, which is at idle with an open hand."""
        arm.begin()
        self.arm, self.scene, self.push = arm, arm.scene, arm.scene.config.push

    def run(self, place: ArrayLike) -> ActionResult:
        """Push what is believed to be at a place.

        Args:
            place: Believed centre of the object, base frame [m], shape (3,).

        Returns:
            Whether the object moved far enough; never raises for a failed push.
        """
        before = self.scene.object_position()
        try:
            self._push(np.asarray(place, dtype=np.float64))
        except MotionAborted as reason:
            return ActionResult(False, str(reason))
        moved = float(np.linalg.norm((self.scene.object_position() - before)[:2]))
        if moved < self.push.min_displacement:
            return ActionResult(False, f"it moved {1e3 * moved:.0f} mm")
        return ActionResult(True, f"moved it {1e3 * moved:.0f} mm")

    def _push(self, place: Array) -> None:
        arm = self.arm
        arm.get_ready()
        chosen = first_in_reach(self._ways(place), arm.grip.tolerance, "a push")
        self.scene.hand.close()
        self.scene.wait(self.scene.config.hand.close_s / 2)
        arm.move("approach", chosen.joints, chosen.joints)
        self.scene.mark("behind the object")
        arm.move("push", chosen.lifted)
        self.scene.mark("pushed")
        raised = chosen.pose.copy()
        raised[:2], raised[2] = arm.tip_pose()[:2], raised[2] + arm.grip.lift
        arm.move("lift", pose=raised)
        arm.go_home()

    def _ways(self, place: Array) -> Iterator[Reach]:
        """The best pose to push from, direction by direction."""
        arm, push = self.arm, self.push
        for direction in push.directions:
            angle = np.deg2rad(tip_yaw(self.scene.config, place) + direction)
            along = np.array([np.cos(angle), np.sin(angle), 0.0])
            turns = np.array([(yaw, tilt) for yaw in push.yaws for tilt in push.tilts])
            poses = np.array([self._pose(place, along, yaw, tilt) for yaw, tilt in turns])
            ends = poses.copy()
            ends[:, :3] += push.distance * along
            yield choose(arm.robot, arm.solver, arm.grip, poses, ends, turns, arm.target)

    def _pose(self, place: Array, along: Array, yaw: float, tilt: float) -> Array:
        """Where the tip stands before the push: behind the object, low over the table."""
        rotation = tip_rotation(self.scene.config, place, yaw, tilt)
        position = place - self.push.stand_off * along
        position[2] = self.scene.config.table.height + self.push.height
        return np.concatenate([position, rotation.as_quat()[[3, 0, 1, 2]]])
