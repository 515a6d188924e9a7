"""Frankik: analytical inverse kinematics of the Franka Emika Panda, its last joint sampled."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.analytical import AnalyticalSolver
from baselines.checks import count_settings
from baselines.errors import SettingError
from baselines.transforms import pose_matrix

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# Two tip transforms are the same if no entry differs by more.
SAME = 1e-6


class Frankik(AnalyticalSolver):
    """`frankik.ik_sample_q7`, for chains with the kinematics of the Panda.

    Args:
        robot: The robot to solve for.
        samples: Angles of the last joint that are tried, once few and, where none of them leads to
            a solution, more.
        interval_deg: Range of these angles around the initial guess [deg].
        **checks: Tolerances, see `AnalyticalSolver`.
    """

    requires: ClassVar[tuple[str, ...]] = ("frankik",)

    def __init__(
        self, robot: Robot, *, samples: Sequence[int], interval_deg: float, **checks: Any
    ) -> None:
        import frankik

        # Its inverse takes the flange, its forward kinematics gives the tip of the hand.
        home = np.array(frankik.kQDefault)
        reached = frankik.fk(home)
        flange_to_tip = np.linalg.inv(reached) @ frankik.fk(frankik.ik(reached, home, home[6]))
        super().__init__(robot, tool=np.linalg.inv(flange_to_tip), **checks)
        if isinstance(samples, str) or not isinstance(samples, Sequence) or not samples:
            raise SettingError(f"expected samples as a list such as [5, 60], got {samples!r}")
        counts = count_settings({f"samples[{i}]": count for i, count in enumerate(samples)})
        self.samples, self.interval_deg = tuple(counts.values()), interval_deg
        self._library = frankik

    @classmethod
    def skip(cls, robot: Robot | None = None) -> str | None:
        """Skip robots other than the Panda, judged by their kinematics."""
        reason = super().skip(robot)
        if reason or robot is None:
            return reason
        import frankik

        # In the middle, and a little off it in every joint.
        for share in (0.5, np.linspace(0.4, 0.6, robot.dof)):
            joints = robot.lower + share * (robot.upper - robot.lower)
            same = robot.dof == 7 and np.allclose(
                frankik.fk(joints),
                pose_matrix(robot.forward_kinematics(joints[None])[0]),
                atol=SAME,
            )
            if not same:
                return f"frankik knows the Franka Emika Panda only, {robot.name} is another robot"
        return None

    def _candidates(self, end: Array, guess: Array) -> Iterator[Array]:
        for count in self.samples:
            found = self._library.ik_sample_q7(end, guess, False, count, self.interval_deg, True)
            if found:
                yield np.array(found)
