"""EAIK: analytical inverse kinematics of six-joint arms that it can take apart."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.analytical import AnalyticalSolver
from robots.limits import FULL_TURN

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

DOF = 6


class Eaik(AnalyticalSolver):
    """`eaik`, for six revolute joints with a spherical wrist, three parallel axes, and their kin.

    It knows all solutions of such an arm, so that its "no" is one (Ostermeier, Külz and Althoff,
    "Automatic Geometric Decomposition for Analytical Inverse Kinematics", IEEE RA-L 2025).

    Args:
        robot: The robot to solve for.
        **checks: Tolerances, see `AnalyticalSolver`.
    """

    requires: ClassVar[tuple[str, ...]] = ("eaik",)
    mimics: ClassVar[bool] = False

    def __init__(self, robot: Robot, **checks: Any) -> None:
        super().__init__(robot, tool=np.eye(4), **checks)
        self._library = _decomposed(robot)

    @classmethod
    def skip(cls, robot: Robot | None = None) -> str | None:
        """Skip chains that are no six revolute joints, and those that it cannot take apart."""
        reason = super().skip(robot)
        if reason or robot is None:
            return reason
        if robot.dof != DOF or robot.chain.prismatic.any():
            return f"EAIK is used for {DOF} revolute joints, {robot.name} has other ones"
        if not _decomposed(robot).hasKnownDecomposition():
            return f"EAIK knows no decomposition of {robot.name}"
        return None

    def _candidates(self, end: Array, guess: Array) -> Iterator[Array]:
        found = self._library.IK(end)
        exact = ~np.array(found.is_LS, dtype=bool)  # the others are nearest answers to no solution
        yield self._turned(np.array(found.Q).reshape(-1, DOF)[exact], guess)

    def _turned(self, joints: Array, guess: Array) -> Array:
        """Whole turns more or less: nearest to the guess where limits allow, else inside them."""
        near = joints + FULL_TURN * np.round((guess - joints) / FULL_TURN)
        middle = (self.lower + self.upper) / 2.0
        inside = joints + FULL_TURN * np.round((middle - joints) / FULL_TURN)
        return np.where((self.lower <= near) & (near <= self.upper), near, inside)


def _decomposed(robot: Robot) -> Any:
    """The library's model of a chain, from the frames of the joints and the tip at zero."""
    from eaik.IK_Homogeneous import HomogeneousRobot

    frames, frame = [], np.eye(4)
    for rotation, translation in zip(robot.chain.rotations, robot.chain.translations, strict=True):
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = rotation, translation
        frame = frame @ step
        frames.append(frame)
    return HomogeneousRobot(np.array(frames))
