"""The grasping primitive: approach from above, close, lift and carry to a bin, let go, go home.

The paper lifts and deposits in one motion (section III-F); `grasp.carry=two_motions` lifts straight
up first and looks whether something was lifted before it goes on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.grasping.arm import Arm, MotionAborted
from pipeline.grasping.config import ONE_MOTION
from pipeline.grasping.grip import Reach
from pipeline.grasping.outcome import GraspReport

Array = NDArray[np.float64]
RESTING_SPEED = 0.02  # m/s below which an object counts as lying still
SHAKES = 4  # times the hand is shaken at most


class Grasp:
    """One attempt of an arm to grasp the object that its scene is about."""

    def __init__(self, arm: Arm) -> None:
        """Take the arm, which is at idle with an open hand."""
        arm.begin()
        self.arm, self.scene, self.config, self.grip = arm, arm.scene, arm.config, arm.grip
        self.report = GraspReport(motions=arm.motions, swung=arm.swung)
        self._rest = np.inf  # height of the object when the fingers had closed [m]

    def run(self, place: ArrayLike) -> GraspReport:
        """Grasp what is believed to be at a place and bring it to the bin on its side.

        Args:
            place: Believed centre of the object, base frame [m], shape (3,).

        Returns:
            What happened; never raises for a failed grasp.
        """
        try:
            believed = np.asarray(place, dtype=np.float64)
            lifted = self._pick(believed)
            if self.config.carry == ONE_MOTION:
                self._lift_and_deposit(believed)
            else:
                self._lift(lifted)
                if self.report.lifted:
                    self._carry(believed)
            self.arm.go_home()
        except MotionAborted as reason:
            self.report.stopped = self.report.stopped or str(reason)
        return self.report

    def side(self, place: ArrayLike) -> str:
        """Side of the area that a place is on: `left` or `right` of the robot."""
        middle = float(np.mean(self.scene.config.area.y))
        return "left" if np.asarray(place)[1] > middle else "right"

    def _pick(self, place: Array) -> Array:
        """Go to the object and close the fingers; return the joints straight above it."""
        scene, grip = self.scene, self.grip
        before = scene.object_position()
        self.arm.get_ready()
        chosen = self.arm.reach(place, grip.yaws, grip.lift)
        self.report.reach_error = chosen.error
        if chosen.error > grip.tolerance:
            raise MotionAborted(f"out of reach: best tip error {1e3 * chosen.error:.0f} mm")
        scene.mark("ready")
        self.arm.move("approach", chosen.joints, chosen.lifted)
        self.report.pushed = float(np.linalg.norm(scene.object_position() - before))
        reached = self.arm.tip_pose()
        self.report.tracking_error = float(np.linalg.norm(reached[:3] - chosen.pose[:3]))
        scene.mark("at the object")
        self._close()
        scene.mark("closed")
        self._count_touching()
        self._rest = float(scene.object_position()[2])
        return chosen.lifted

    def _lift(self, lifted: Array) -> None:
        """Lift straight up and see whether the object came along."""
        self.arm.move("lift", lifted)
        self.scene.mark("after the lift")
        self._count_touching()
        self.report.lifted = self._is_lifted()
        self.arm.holding = self.report.lifted
        if self.report.lifted and self.config.shake_after_lift:
            self._sway(self.config.shake_after_lift)
            self.scene.mark("shaken")
            if not self._is_lifted():
                raise MotionAborted("lost when the hand was shaken")

    def _carry(self, place: Array) -> None:
        """Carry what was lifted over the bin on its side and let go."""
        chosen = self._over_bin(place)
        self.arm.move("transfer", chosen.joints, chosen.joints)
        self._let_go()

    def _lift_and_deposit(self, place: Array) -> None:
        """Lift and carry over the bin on its side in one motion, and let go.

        Nobody looks in between: the hand goes on if it holds nothing.
        """
        chosen = self._over_bin(place)
        self.arm.watch = self._see_lift
        try:
            self.arm.move("deposit", chosen.joints, chosen.joints)
        finally:
            self.arm.watch = None
            self.arm.holding = self.report.lifted
        self._let_go()

    def _see_lift(self) -> None:
        """Note when the object is off the table and in the hand for the first time."""
        if not self.report.lifted and self._is_lifted():
            self.report.lifted = True
            self._count_touching()
            self.scene.mark("after the lift")

    def _is_lifted(self) -> bool:
        risen = self.scene.object_position()[2] - self._rest
        if risen <= self.config.lift_threshold:
            return False
        return bool(self.scene.hand.touching(self.scene.object_id))

    def _over_bin(self, place: Array) -> Reach:
        """Where the hand lets go: over the bin on the side of a place."""
        scene, side = self.scene, self.side(place)
        if side not in scene.config.bins:
            raise MotionAborted(f"there is no {side} bin")
        box, grip = scene.config.bins[side], self.grip
        over = np.array([*(box.drop or box.centre), box.floor + grip.release])
        chosen = self.arm.reach(over, grip.release_yaws, 0.0)
        if chosen.error > grip.tolerance:
            raise MotionAborted(f"the {side} bin is out of reach by {1e3 * chosen.error:.0f} mm")
        return chosen

    def _let_go(self) -> None:
        """Open the hand over the bin and see where the object comes to rest."""
        scene = self.scene
        scene.mark("over the bin")
        self._count_touching()
        self.report.kept = self.report.touching[-1] > 0
        scene.hand.let_go()
        self.report.released, self.arm.holding = True, False
        scene.wait(scene.config.hand.open_s)
        scene.mark("let go")
        self._shake_off()
        self._wait_for_rest()
        self.report.clinging = bool(scene.hand.touching(scene.object_id))
        self.report.bin = scene.bin_of_object()

    def _close(self) -> None:
        """Pull until every finger has stalled, or the time is up."""
        scene, hand = self.scene, self.scene.config.hand
        begin, opened = scene.time_s, scene.hand.positions()
        before = opened
        scene.hand.close()
        while scene.time_s - begin < hand.close_s:
            scene.wait(hand.stall_s)
            now = scene.hand.positions()
            if np.abs(now - before).max() < hand.stall_speed * hand.stall_s:
                break
            before = now
        self.report.closing_s = scene.time_s - begin
        travel = np.abs(scene.hand.positions() - opened).max()
        self.report.closing_share = float(travel / abs(scene.hand.closed - scene.hand.open))

    def _shake_off(self) -> None:
        """Knead and shake the hand while the object sticks between its open fingers."""
        for _ in range(SHAKES):
            if not self.scene.hand.touching(self.scene.object_id):
                return
            self.scene.hand.close()
            self.scene.wait(0.5 * self.scene.config.hand.open_s)
            self.scene.hand.let_go()
            self.scene.wait(self.scene.config.hand.open_s)
            self._sway(self.scene.config.hand.shake)

    def _sway(self, angle: float) -> None:
        """Shake the hand by an angle of the last two joints [rad], as fast as the arm swings."""
        arm, robot = self.arm, self.arm.robot
        sway = np.zeros(robot.dof)
        sway[-2:] = angle
        middle = np.clip(arm.target, robot.lower + sway, robot.upper - sway)
        waypoints = [arm.target, middle + sway, middle - sway, middle + sway, arm.target]
        arm.follow(np.array(waypoints), self.config.timing.swing)

    def _wait_for_rest(self) -> None:
        """Wait until the dropped object lies still, at most twice the settling time."""
        for _ in range(4):
            self.scene.wait(self.config.physics.settle_s / 2)
            if self.scene.object_velocity() < RESTING_SPEED:
                return

    def _count_touching(self) -> None:
        self.report.touching.append(len(self.scene.hand.touching(self.scene.object_id)))
