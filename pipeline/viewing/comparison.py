"""Several solvers at one target: what each answers, how far off, how fast, and how far it jumps."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import median_low
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.evaluation.metrics import pose_errors
from robots.errors import UrdfError

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]
US_PER_S = 1e6


@dataclass(frozen=True)
class Answer:
    """What one solver says to a target.

    Attributes:
        solver: Its name.
        joints: Where it puts the joints [rad or m], shape (dof,).
        found: Its own claim.
        position_mm: Euclidean distance of the tip from the target [mm].
        rotation_deg: Angle of the tip's rotation from the target's [deg].
        call_us: Wall time of a call, the median of the last ones [us].
        jump: Largest change of a joint since its answer before [rad or m].
        colliding: Links that touch others that they should not.
    """

    solver: str
    joints: Array
    found: bool
    position_mm: float
    rotation_deg: float
    call_us: float
    jump: float
    colliding: frozenset[str]


class Comparison:
    """Solvers that follow the same target, each from its own last answer.

    Attributes:
        robot: The robot.
        solvers: Solvers by name.
        guided: Whether a solver starts from its last answer; without, it has no initial guess.
    """

    def __init__(self, robot: Robot, solvers: Mapping[str, Solver], timed_calls: int) -> None:
        """Start all at the robot's home and call each once, which compiles it.

        Args:
            robot: The robot.
            solvers: Solvers by name, at least one.
            timed_calls: Calls whose median is the time of a call.
        """
        self.robot, self.solvers, self.guided = robot, dict(solvers), True
        self._last = dict.fromkeys(self.solvers, robot.home)
        self._times: dict[str, deque[float]] = {
            name: deque(maxlen=timed_calls) for name in self.solvers
        }
        home = robot.forward_kinematics(robot.home)[0]
        for solver in self.solvers.values():
            solver.solve_one(home, robot.home)

    def restart(self, joints: Array) -> None:
        """Let every solver go on from joints (dof,), rad or m."""
        self._last = dict.fromkeys(self.solvers, joints.copy())

    def answers(self, target: Array) -> dict[str, Answer]:
        """Ask every solver.

        Args:
            target: Pose of the tip, base frame [m, unit quaternion w x y z], shape (7,).

        Returns:
            Answers by the solver's name.
        """
        return {name: self._answer(name, target) for name in self.solvers}

    def _answer(self, name: str, target: Array) -> Answer:
        before = self._last[name]
        begin = time.perf_counter()
        joints, found = self.solvers[name].solve_one(target, before if self.guided else None)
        self._times[name].append(time.perf_counter() - begin)
        self._last[name] = joints
        errors = pose_errors(target[None], self.robot.forward_kinematics(joints))
        return Answer(
            solver=name,
            joints=joints,
            found=found,
            position_mm=float(errors.position_mm[0]),
            rotation_deg=float(errors.rotation_deg[0]),
            call_us=US_PER_S * median_low(self._times[name]),
            jump=float(np.abs(joints - before).max()),
            colliding=colliding_links(self.robot, joints),
        )


def colliding_links(robot: Robot, joints: Array) -> frozenset[str]:
    """Links that touch others that they should not, none where the robot has no usable shapes.

    Args:
        robot: The robot.
        joints: (dof,) rad or m.
    """
    try:
        checker = robot.collision
    except UrdfError:
        return frozenset()
    touching = checker.touching(robot.as_joints(joints))[0]
    return frozenset(link for pair in np.flatnonzero(touching) for link in checker.pairs[pair])
