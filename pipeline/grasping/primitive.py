"""The grasping primitive: approach from above, close, lift, carry to a bin, let go, go home."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.grasping.config import GraspConfig
from pipeline.grasping.grip import Reach, reach
from pipeline.grasping.outcome import Report
from pipeline.grasping.scene import Scene
from pipeline.planning.config import MotionConfig
from pipeline.planning.control import control_points
from pipeline.planning.motion import Motion, motion_end, plan_motion
from pipeline.planning.timing import Trajectory, time_scale

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]
RESTING_SPEED = 0.02  # m/s below which a thing counts as lying still
SHAKES = 4  # times the hand is shaken at most
SWING_STEPS = 20  # waypoints of a motion from joints to joints


class Stopped(Exception):  # noqa: N818
    """The attempt cannot go on, and why."""


def motion_control_points(
    robot: Robot, start: Array, target: Array, rule: MotionConfig, scale: float
) -> Array:
    """Control points of a motion between configurations or poses, heights scaled to the robot."""
    first, _ = motion_end(robot, "start", start)
    last, _ = motion_end(robot, "target", target)
    scaled = replace(
        rule,
        leave_height=scale * rule.leave_height,
        arrive_height=scale * rule.arrive_height,
    )
    return control_points(first, last, scaled)


class Primitive:
    """One robot's grasping primitive, ready to run on a thing in a scene."""

    def __init__(
        self, scene: Scene, config: GraspConfig, solver: Solver, repair: Solver | None = None
    ) -> None:
        """Take the scene, the settings and the solver of the motions."""
        self.scene, self.config, self.solver, self.repair = scene, config, solver, repair
        self.robot, self.grip = scene.robot, scene.config.grip
        self.target = scene.robot.home.copy()
        self.report = Report()

    def run(self, place: ArrayLike) -> Report:
        """Grasp what is believed to be at a place and bring it to the bin on its side.

        Args:
            place: Believed centre of the thing, base frame [m], shape (3,).

        Returns:
            What happened; never raises for a failed grasp.
        """
        try:
            self._pick(np.asarray(place, dtype=np.float64))
            if self.report.lifted:
                self._deposit(np.asarray(place, dtype=np.float64))
            self._go_home()
        except Stopped as reason:
            self.report.stopped = self.report.stopped or str(reason)
        return self.report

    def side(self, place: ArrayLike) -> str:
        """Side of the area that a place is on: `left` or `right`, seen by the robot."""
        middle = float(np.mean(self.scene.config.area.y))
        return "left" if np.asarray(place)[1] > middle else "right"

    def move(self, name: str, target: Array, over: Array | None = None) -> None:
        """Plan a motion of the tip from where the arm was sent last, and follow it.

        Args:
            name: Which of the configured motions.
            target: Pose (7,) or joints (dof,) to end at.
            over: Joints to swing to first where the path of the tip cannot be followed, shape
                (dof,); none goes without.

        Raises:
            Stopped: The motion jumps between branches of solutions.
        """
        motion = self._plan(name, target)
        if over is not None and self._unfit(motion):
            self.report.swung.append(name)
            self._swing(over)
            motion = self._plan(name, target)
        self.report.motions[name] = motion
        speed = self.config.timing.speed
        seconds = self._timed(motion.joints, speed).duration
        if seconds > self.config.timing.longest_s:
            raise Stopped(f"{name}: the joints jump, it would take {seconds:.0f} s")
        self._follow(motion.joints, speed)

    def _unfit(self, motion: Motion) -> bool:
        """Whether the path leaves the reach, or the joints would have to race along it."""
        seconds = self._timed(motion.joints, self.config.timing.speed).duration
        astray = motion.tip_error_mm.max() > 1e3 * self.grip.tolerance
        return bool(astray or seconds > self.config.timing.longest_s)

    def _plan(self, name: str, target: Array) -> Motion:
        rule = self.config.motions[name]
        points = motion_control_points(self.robot, self.target, target, rule, self.grip.scale)
        return plan_motion(
            self.robot, self.solver, self.target, target, points, rule.steps, repair=self.repair
        )

    def _pick(self, place: Array) -> None:
        """Go to the thing, close the fingers and lift straight up."""
        scene, grip = self.scene, self.grip
        before = scene.thing_position()
        self._get_ready()
        chosen = self._reach(place, grip.yaws, grip.lift)
        self.report.reach_error = chosen.error
        if chosen.error > grip.tolerance:
            raise Stopped(f"out of reach: best tip error {1e3 * chosen.error:.0f} mm")
        scene.mark("ready")
        self.move("approach", chosen.joints, chosen.lifted)
        self.report.pushed = float(np.linalg.norm(scene.thing_position() - before))
        self._track(chosen.pose)
        scene.mark("at the object")
        self._close()
        scene.mark("closed")
        self._count_touching()
        rest = scene.thing_position()[2]
        self.move("lift", chosen.lifted)
        scene.mark("after the lift")
        self._count_touching()
        risen = scene.thing_position()[2] - rest
        self.report.lifted = bool(risen > self.config.lifted and self.report.touching[-1] > 0)

    def _deposit(self, place: Array) -> None:
        """Carry the thing over the bin on its side, let go, and see where it comes to rest."""
        scene, side = self.scene, self.side(place)
        if side not in scene.config.bins:
            raise Stopped(f"there is no {side} bin")
        box, grip = scene.config.bins[side], self.grip
        over = np.array([*(box.drop or box.centre), box.floor + grip.release])
        chosen = self._reach(over, grip.release_yaws, 0.0)
        if chosen.error > grip.tolerance:
            raise Stopped(f"the {side} bin is out of reach by {1e3 * chosen.error:.0f} mm")
        self.move("transfer", chosen.joints, chosen.joints)
        scene.mark("over the bin")
        self._count_touching()
        self.report.kept = self.report.touching[-1] > 0
        scene.hand.let_go()
        self.report.released = True
        scene.wait(scene.config.hand.open_s)
        scene.mark("let go")
        self._shake_off()
        self._wait_for_rest()
        self.report.clinging = bool(scene.hand.touching(scene.thing))
        self.report.bin = scene.bin_of_thing()

    def _get_ready(self) -> None:
        """Swing from the idle configuration to where the motions begin, joint by joint."""
        if self.grip.ready is not None:
            chosen = self._reach(np.array(self.grip.ready), self.grip.yaws, 0.0)
            self._swing(chosen.joints)

    def _go_home(self) -> None:
        """Return to the idle configuration: as it came, along a path or joint by joint."""
        self.scene.hand.let_go()
        if self.grip.ready is None:
            self.move("homeward", self.robot.home, self.robot.home)
        else:
            self._swing(self.robot.home)

    def _reach(self, place: Array, yaws: list[float], lift: float) -> Reach:
        return reach(self.robot, self.solver, self.scene.config, place, self.target, yaws, lift)

    def _swing(self, joints: Array) -> None:
        """Go straight from joints to joints; swift, unless something is held."""
        timing = self.config.timing
        holding = self.report.lifted and not self.report.released
        self._follow(
            np.linspace(self.target, joints, SWING_STEPS),
            timing.speed if holding else timing.swing,
        )

    def _follow(self, waypoints: Array, speed: float) -> None:
        trajectory = self._timed(waypoints, speed)
        for joints, velocities in zip(trajectory.joints, trajectory.velocities, strict=True):
            self.scene.command(joints, velocities)
            self.scene.step()
        self.target = waypoints[-1]
        self.scene.command(self.target)
        self.scene.wait(self.config.timing.pause_s)

    def _timed(self, waypoints: Array, speed: float) -> Trajectory:
        timing = self.config.timing
        limit = np.minimum(self.robot.velocity_limit, timing.fastest)
        return time_scale(waypoints, limit, speed, timing.rate)

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
        """Knead and shake the hand while the thing sticks between its open fingers."""
        sway = np.zeros(self.robot.dof)
        sway[-2:] = self.scene.config.hand.shake
        middle = np.clip(self.target, self.robot.lower + sway, self.robot.upper - sway)
        for _ in range(SHAKES):
            if not self.scene.hand.touching(self.scene.thing):
                return
            self.scene.hand.close()
            self.scene.wait(0.5 * self.scene.config.hand.open_s)
            self.scene.hand.let_go()
            self.scene.wait(self.scene.config.hand.open_s)
            waypoints = [self.target, middle + sway, middle - sway, middle + sway, self.target]
            self._follow(np.array(waypoints), self.config.timing.swing)

    def _wait_for_rest(self) -> None:
        """Wait until the dropped thing lies still, for as long as it would take to settle twice."""
        for _ in range(4):
            self.scene.wait(self.config.engine.settle_s / 2)
            if self.scene.thing_velocity() < RESTING_SPEED:
                return

    def _track(self, pose: Array) -> None:
        reached = self.robot.forward_kinematics(self.scene.joints())[0]
        self.report.tracking_error = float(np.linalg.norm(reached[:3] - pose[:3]))

    def _count_touching(self) -> None:
        self.report.touching.append(len(self.scene.hand.touching(self.scene.thing)))
