"""Ssik: analytical inverse kinematics of the arms that ssik ships, of those that are known here."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.analytical import AnalyticalSolver
from baselines.errors import SolverError
from baselines.transforms import pose_matrix

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# The library can derive a solver for other chains, but that takes it minutes (and for NICO's arm,
# whose wrist axes do not meet, found nothing).
ARMS = ("franka_panda_ik", "iiwa14_ik", "ur5_ik")
# Two transforms are the same if no entry differs by more.
SAME = 1e-6


class Ssik(AnalyticalSolver):
    """The solver that ssik ships for an arm, for chains that are that arm but for the tool.

    Args:
        robot: The robot to solve for.
        solutions: Solutions that the library is to return for each pose.
        **checks: Tolerances, see `AnalyticalSolver`.
    """

    requires: ClassVar[tuple[str, ...]] = ("ssik",)

    def __init__(self, robot: Robot, *, solutions: int, **checks: Any) -> None:
        known = _arm_and_offset(robot)
        if known is None:
            raise SolverError(_no_arm(robot))
        self._arm, offset = known
        super().__init__(robot, tool=offset, **checks)
        self.solutions = solutions

    @classmethod
    def skip(cls, robot: Robot | None = None) -> str | None:
        """Skip robots that are none of the arms, judged by their kinematics."""
        reason = super().skip(robot)
        if reason is None and robot is not None and _arm_and_offset(robot) is None:
            return _no_arm(robot)
        return reason

    def _candidates(self, end: Array, guess: Array) -> Iterator[Array]:
        found = self._arm.solve(end, max_solutions=self.solutions, q_seed=guess)
        yield np.array([solution.q for solution in found]).reshape(-1, self.robot.dof)


def _no_arm(robot: Robot) -> str:
    return f"ssik is used for {', '.join(ARMS)}, {robot.name} is another robot"


def _arm_and_offset(robot: Robot) -> tuple[Any, Array] | None:
    """The shipped arm, and the transform (4, 4) from our tip to its end; None if there is none."""
    import ssik

    share = np.linspace(0.4, 0.6, robot.dof)[None]
    joints = robot.lower + np.concatenate([share, share[:, ::-1]]) * (robot.upper - robot.lower)
    poses = robot.forward_kinematics(joints)
    for name in ARMS:
        arm = ssik.Manipulator.from_prebuilt(name)
        if arm.dof != robot.dof:
            continue
        first, second = (
            np.linalg.inv(pose_matrix(pose)) @ arm.fk(q)
            for q, pose in zip(joints, poses, strict=True)
        )
        if np.allclose(first, second, atol=SAME):
            return arm, first
    return None
