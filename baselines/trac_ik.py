"""TRAC-IK through pytracik: a Newton descent and a sequential quadratic program race each other.

Beeson and Ames, "TRAC-IK: an open-source library for improved solving of generic inverse
kinematics", Humanoids 2015. The library runs its two methods on two threads of its own and stops by
the wall clock, so its answers are not the same twice.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.chain_urdf import chain_urdf
from baselines.errors import BudgetError, SolverError
from baselines.protocol import (
    NO_SOLUTION,
    OUT_OF_TIME,
    Answer,
    Budget,
    Clock,
    QuerySolver,
    Solution,
)

if TYPE_CHECKING:
    from robots import Robot

# A library's own slack, m or rad, when its limits are compared with the robot's.
LIMIT_TOLERANCE = 1e-6


class TracIk(QuerySolver):
    """TRAC-IK with its random restarts, until a solution or the time limit.

    Args:
        robot: The robot to solve for.
        epsilon: Largest error of any component of the tip's twist [m or rad].
        solve_type: "Speed" for the first solution, "Distance" for the one nearest the initial
            guess, "Manip1" or "Manip2" for manipulability; all but "Speed" use up the time.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
    """

    requires: ClassVar[tuple[str, ...]] = ("pytracik",)
    mimics: ClassVar[bool] = False
    budgets: ClassVar[frozenset[str]] = frozenset({"time_s"})

    def __init__(self, robot: Robot, *, epsilon: float, solve_type: str, time_s: float) -> None:
        super().__init__(robot, time_s=time_s)
        self.epsilon = epsilon
        self.solve_type = solve_type
        self._urdf = chain_urdf(robot)
        # The time limit is fixed when the library's solver is made: one for each.
        self._solvers: dict[float, Any] = {}
        self._library(time_s)

    def _library(self, time_s: float) -> Any:
        if time_s not in self._solvers:
            import pytracik

            kind = getattr(pytracik.SolveType, self.solve_type)
            solver = pytracik.TRAC_IK(
                self.robot.base, self.robot.tip, self._urdf, time_s, self.epsilon, kind
            )
            lower = np.array(pytracik.get_joint_lower_bounds(solver))
            upper = np.array(pytracik.get_joint_upper_bounds(solver))
            if lower.shape != self.lower.shape or not (
                np.allclose(lower, self.lower, atol=LIMIT_TOLERANCE)
                and np.allclose(upper, self.upper, atol=LIMIT_TOLERANCE)
            ):
                raise SolverError(
                    f"pytracik read the limits of {self.robot.name} as {lower} to {upper}, "
                    f"expected {self.lower} to {self.upper}"
                )
            self._solvers[time_s] = solver
        return self._solvers[time_s]

    def _solve_batch(
        self,
        poses: NDArray[np.float64],
        initial: NDArray[np.float64],
        budget: Budget | None,
    ) -> Solution:
        if budget is None or budget.time_s is None:
            raise BudgetError(f"solver {self.name!r} needs a budget of time_s")
        self._current = self._library(budget.time_s)
        return super()._solve_batch(poses, initial, budget)

    def _solve_one(
        self, pose: NDArray[np.float64], initial: NDArray[np.float64], clock: Clock
    ) -> Answer:
        import pytracik

        x, y, z, qw, qx, qy, qz = pose.tolist()
        answer = pytracik.ik(self._current, initial, x, y, z, qx, qy, qz, qw)
        if answer[0] >= 0:
            return Answer(answer[1:], "")
        return Answer(initial, OUT_OF_TIME if clock.time_left_s <= 0 else NO_SOLUTION)
