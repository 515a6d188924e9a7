"""An arm in a scene that plans its motions and follows them: what all primitives share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.grasping.config import GraspConfig
from pipeline.grasping.grip import Reach, reach
from pipeline.grasping.scene import Scene
from pipeline.planning.config import MotionConfig
from pipeline.planning.motion import Motion, motion_end, plan_motion
from pipeline.planning.path import control_points
from pipeline.planning.timing import Trajectory, time_scale

if TYPE_CHECKING:
    from baselines import Solver

Array = NDArray[np.float64]
SWING_STEPS = 20  # waypoints of a motion from joints to joints


class MotionAborted(Exception):  # noqa: N818
    """The attempt cannot continue, and why."""


def scaled_rule(rule: MotionConfig, scale: float) -> MotionConfig:
    """The rule of a motion with its heights scaled to the robot."""
    return replace(
        rule,
        leave_height=scale * rule.leave_height,
        arrive_height=scale * rule.arrive_height,
    )


class Arm:
    """A robot's arm, moved by plans of its tip.

    Attributes:
        target: Joints that the arm was sent to last [rad or m], shape (dof,).
        holding: Whether something is held, which is carried more slowly.
        motions: Planned motions by name since `begin`, as they were followed.
        watch: Called after each step of the simulator while the arm moves; none without.
        swung: Motions since `begin` whose path could not be followed: the joints moved straight.
    """

    def __init__(
        self, scene: Scene, config: GraspConfig, solver: Solver, repair: Solver | None = None
    ) -> None:
        """Take the scene, the settings and the solver of the motions; the arm is at idle."""
        self.scene, self.config, self.solver, self.repair = scene, config, solver, repair
        self.robot, self.grip = scene.robot, scene.config.grip
        self.target = scene.robot.home.copy()
        self.holding = False
        self.motions: dict[str, Motion] = {}
        self.swung: list[str] = []
        self.watch: Callable[[], None] | None = None

    def begin(self) -> None:
        """Start a new record of motions: another primitive begins."""
        self.motions, self.swung = {}, []

    def move(
        self,
        name: str,
        joints: Array | None = None,
        over: Array | None = None,
        *,
        pose: Array | None = None,
    ) -> None:
        """Plan a motion of the tip from where the arm was sent last, and follow it.

        Args:
            name: Which of the configured motions.
            joints: Joints to end at [rad or m], shape (dof,).
            over: Joints to swing to first where the path of the tip cannot be followed, shape
                (dof,), if `grasp.detour` allows it; none goes without.
            pose: Instead of joints: pose to end at, base frame, shape (7,).

        Raises:
            MotionAborted: The motion jumps between branches of solutions.
        """
        motion = self._plan(name, joints, pose)
        if over is not None and self.config.detour and self._unfit(motion):
            self.swung.append(name)
            self.swing(over)
            motion = self._plan(name, joints, pose)
        self.motions[name] = motion
        speed = self.config.timing.speed
        seconds = self._timed(motion.joints, speed).duration
        if seconds > self.config.timing.max_duration_s:
            raise MotionAborted(f"{name}: the joints jump, it would take {seconds:.0f} s")
        self.follow(motion.joints, speed)

    def reach(self, place: Array, yaws: list[float], lift: float) -> Reach:
        """Choose the top grasp for a place that is nearest to where the arm was sent last."""
        return reach(self.robot, self.solver, self.scene.config, place, self.target, yaws, lift)

    def get_ready(self) -> None:
        """Swing from the idle configuration to where the motions begin, joint by joint."""
        if self.grip.ready is not None:
            chosen = self.reach(np.array(self.grip.ready), self.grip.yaws, 0.0)
            self.swing(chosen.joints)

    def go_home(self) -> None:
        """Return to the idle configuration: as it came, along a path or joint by joint."""
        self.scene.hand.let_go()
        self.holding = False
        if self.grip.ready is None:
            self.move("homeward", self.robot.home, self.robot.home)
        else:
            self.swing(self.robot.home)

    def retreat(self) -> None:
        """Move to the idle configuration with an open hand, from wherever an attempt ended."""
        self.scene.hand.let_go()
        self.holding = False
        if not np.array_equal(self.target, self.robot.home):
            self.swing(self.robot.home)

    def swing(self, joints: Array) -> None:
        """Go straight from joints to joints; fast, unless something is held."""
        timing = self.config.timing
        self.follow(
            np.linspace(self.target, joints, SWING_STEPS),
            timing.speed if self.holding else timing.swing,
        )

    def follow(self, waypoints: Array, speed: float) -> None:
        """Drive through waypoints of joints, shape (S, dof), at a share of the joints' speeds."""
        trajectory = self._timed(waypoints, speed)
        for joints, velocities in zip(trajectory.joints, trajectory.velocities, strict=True):
            self.scene.command(joints, velocities)
            self.scene.step()
            if self.watch is not None:
                self.watch()
        self.target = waypoints[-1]
        self.scene.command(self.target)
        self.scene.wait(self.config.timing.pause_s)

    def tip_pose(self) -> Array:
        """Where the tip is by the joints of the simulator, base frame, shape (7,)."""
        pose: Array = self.robot.forward_kinematics(self.scene.joints()[None])[0]
        return pose

    def _plan(self, name: str, joints: Array | None, pose: Array | None) -> Motion:
        rule = scaled_rule(self.config.motions[name], self.grip.scale)
        start, _ = motion_end(self.robot, "start", None, self.target)
        target, _ = motion_end(self.robot, "target", pose, joints)
        return plan_motion(
            self.robot,
            self.solver,
            target=pose,
            control_points=control_points(start, target, rule),
            steps=rule.steps,
            repair=self.repair,
            reroute=rule.reroute,
            start_joints=self.target,
            target_joints=joints,
        )

    def _unfit(self, motion: Motion) -> bool:
        """Whether the path leaves the reach, or the joints would have to race along it."""
        seconds = self._timed(motion.joints, self.config.timing.speed).duration
        astray = motion.tip_error_mm.max() > 1e3 * self.grip.tolerance
        return bool(astray or seconds > self.config.timing.max_duration_s)

    def _timed(self, waypoints: Array, speed: float) -> Trajectory:
        timing = self.config.timing
        limit = np.minimum(self.robot.velocity_limit, timing.velocity_cap)
        return time_scale(waypoints, limit, speed, timing.rate)


def first_in_reach(candidates: Iterable[Reach], tolerance: float, what: str) -> Reach:
    """Return the first of several candidates that is in reach; later ones are not computed.

    Args:
        candidates: The best of each distance or direction, computed lazily.
        tolerance: Largest tip error [m].
        what: What is to be reached for, as the failure names it.

    Raises:
        MotionAborted: None is.
    """
    nearest = np.inf
    for candidate in candidates:
        if candidate.error <= tolerance:
            return candidate
        nearest = min(nearest, candidate.error)
    raise MotionAborted(f"out of reach: best tip error of {what} {1e3 * nearest:.0f} mm")
