"""The grasping primitive: approach from above, close, lift, carry to a bin, let go, go home."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.grasping.config import GraspConfig
from pipeline.grasping.grip import reachable_pose
from pipeline.grasping.scene import Scene
from pipeline.planning.control import control_points
from pipeline.planning.motion import Motion, plan_motion
from pipeline.planning.timing import time_scale

if TYPE_CHECKING:
    from baselines import Solver

Array = NDArray[np.float64]
RESTING_SPEED = 0.02  # m/s below which a thing counts as lying still


@dataclass
class Report:
    """What happened in one attempt, from the simulator's state.

    Attributes:
        motions: Planned motions by name.
        reach_error: Tip error of the best top grasp [m].
        pushed: Way the thing moved before the fingers closed [m].
        tracking_error: Distance of the tip from where it was to be when it had arrived [m].
        touching: Links of the hand on the thing after closing, after the lift, after the carry.
        closing_s: Time the fingers took to stall [s].
        lifted: Whether the thing was off the table and in the hand after the lift.
        kept: Whether it was still in the hand over the bin.
        bin: Bin that it lies in at the end.
        stopped: Why the attempt ended early; empty if it did not.
    """

    motions: dict[str, Motion] = field(default_factory=dict)
    reach_error: float = np.nan
    pushed: float = np.nan
    tracking_error: float = np.nan
    touching: list[int] = field(default_factory=list)
    closing_s: float = np.nan
    lifted: bool = False
    kept: bool = False
    bin: str | None = None
    stopped: str = ""


class Primitive:
    """One robot's grasping primitive, ready to run on a thing in a scene."""

    def __init__(
        self, scene: Scene, config: GraspConfig, solver: Solver, repair: Solver | None = None
    ) -> None:
        """Take the scene, the settings and the solver of the motions."""
        self.scene, self.config, self.solver, self.repair = scene, config, solver, repair
        self.robot = scene.robot
        self.target = scene.robot.home.copy()
        self.report = Report()

    def run(self, place: ArrayLike) -> Report:
        """Grasp what is believed to be at a place and bring it to the bin on its side.

        Args:
            place: Believed centre of the thing, base frame [m], shape (3,).

        Returns:
            What happened; never raises for a failed grasp.
        """
        grip = self.scene.config.grip
        pose, self.report.reach_error = reachable_pose(
            self.robot, self.solver, self.scene.config, place, grip.lift
        )
        if self.report.reach_error > grip.tolerance:
            self.report.stopped = (
                f"out of reach: best tip error {1e3 * self.report.reach_error:.0f} mm"
            )
            return self.report
        side = self.side(place)
        before = self.scene.thing_position()
        self.move("approach", pose)
        self.report.pushed = float(np.linalg.norm(self.scene.thing_position() - before))
        self._track(pose)
        self._grasp(pose)
        if side is None:
            self.report.stopped = "there is no bin on the thing's side"
        elif self.report.lifted:
            self._deposit(side)
        self._go_home()
        return self.report

    def side(self, place: ArrayLike) -> str | None:
        """Name of the bin on the side of the area that a place is on, if there is one."""
        middle = float(np.mean(self.scene.config.area.y))
        side = "left" if np.asarray(place)[1] > middle else "right"
        return side if side in self.scene.config.bins else None

    def move(self, name: str, pose: Array, joints: Array | None = None) -> None:
        """Plan a motion of the tip from where the arm was sent last, and follow it.

        Args:
            name: Which of the configured motions.
            pose: Pose to end at, base frame, shape (7,).
            joints: Joints to end at, of that pose, shape (dof,); none leaves them to the solver.
        """
        rule = self.config.motions[name]
        begin = self.robot.forward_kinematics(self.target)[0]
        motion = plan_motion(
            self.robot,
            self.solver,
            self.target,
            pose if joints is None else joints,
            control_points(begin, pose, rule),
            rule.steps,
            repair=self.repair,
        )
        self.report.motions[name] = motion
        self._follow(motion.joints)

    def _grasp(self, pose: Array) -> None:
        """Close the fingers and lift straight up."""
        self._close()
        self._count_touching()
        rest = self.scene.thing_position()[2]
        above = pose.copy()
        above[2] += self.scene.config.grip.lift
        self.move("lift", above)
        self._count_touching()
        risen = self.scene.thing_position()[2] - rest
        self.report.lifted = risen > self.config.lifted and self.report.touching[-1] > 0

    def _deposit(self, side: str) -> None:
        """Carry the thing over a bin, let go, and see where it comes to rest."""
        scene = self.scene
        box = scene.config.bins[side]
        over = np.array([*box.centre, box.floor + scene.config.grip.release])
        pose, error = reachable_pose(self.robot, self.solver, scene.config, over, 0.0)
        if error > scene.config.grip.tolerance:
            self.report.stopped = f"the {side} bin is out of reach by {1e3 * error:.0f} mm"
            return
        self.move("transfer", pose)
        self._count_touching()
        self.report.kept = self.report.touching[-1] > 0
        scene.hand.let_go()
        scene.wait(scene.config.hand.open_s)
        self._wait_for_rest()
        self.report.bin = scene.bin_of_thing()

    def _go_home(self) -> None:
        """Return to the idle configuration."""
        home = self.robot.home
        self.scene.hand.let_go()
        self.move("homeward", self.robot.forward_kinematics(home)[0], home)

    def _follow(self, waypoints: Array) -> None:
        timing, limit = self.config.timing, self.robot.velocity_limit
        trajectory = time_scale(waypoints, limit, timing.speed, timing.rate)
        for joints, velocities in zip(trajectory.joints, trajectory.velocities, strict=True):
            self.scene.command(joints, velocities)
            self.scene.step()
        self.target = waypoints[-1]
        self.scene.command(self.target)
        self.scene.wait(self.config.timing.pause_s)

    def _close(self) -> None:
        """Pull until every finger has stalled, or the time is up."""
        scene, hand = self.scene, self.scene.config.hand
        begin, still = scene.time_s, 0.0
        scene.hand.close()
        while scene.time_s - begin < hand.close_s and still < hand.stall_s:
            scene.step()
            still = still + 1.0 / scene.engine.rate if scene.hand.speed() < hand.stall_speed else 0
        self.report.closing_s = scene.time_s - begin

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
