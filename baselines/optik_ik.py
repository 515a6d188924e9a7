"""OptIK: sequential quadratic programming in Rust with random restarts, on one thread."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.chain_urdf import chain_urdf_file
from baselines.checks import positive_settings, thread_setting
from baselines.errors import BudgetError, SettingError
from baselines.protocol import (
    NO_SOLUTION,
    OUT_OF_TIME,
    Answer,
    Budget,
    Clock,
    QuerySolver,
    Solution,
)
from baselines.transforms import pose_matrix
from robots.serial_urdf import BASE, TIP

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

LONGEST_S = 1e6  # more than anybody waits, and not too much for the library's clock


class Optik(QuerySolver):
    """OptIK's solver, until its cost is below the tolerance or the time is used up.

    Args:
        robot: The robot to solve for.
        tolerance: Squared error (m² + rad²) below which a solution is claimed.
        solution_mode: "speed" for the first solution, "quality" for the one nearest the initial
            guess, which uses up the time.
        threads: Threads that search in parallel; 0 for all.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
    """

    requires: ClassVar[tuple[str, ...]] = ("optik",)
    mimics: ClassVar[bool] = False
    budgets: ClassVar[frozenset[str]] = frozenset({"time_s"})

    def __init__(
        self, robot: Robot, *, tolerance: float, solution_mode: str, threads: int, time_s: float
    ) -> None:
        import optik

        super().__init__(robot, time_s=time_s)
        if solution_mode not in ("speed", "quality"):
            raise SettingError(f"expected solution_mode speed or quality, got {solution_mode!r}")
        tolerance = positive_settings({"tolerance": tolerance})["tolerance"]
        self.tolerances = (math.sqrt(tolerance),) * 2
        self._settings: dict[str, Any] = {"tol_f": tolerance, "solution_mode": solution_mode}
        with chain_urdf_file(robot) as urdf:
            self._library = optik.Robot.from_urdf_file(str(urdf), BASE, TIP)
        self._library.set_parallelism(thread_setting(threads) or os.cpu_count() or 1)

    @classmethod
    def skip(cls, robot: Robot | None = None) -> str | None:
        """Skip chains with a sliding joint, for which the library aborts the whole process."""
        if robot is not None and robot.chain.prismatic.any():
            return f"optik knows turning joints only, {robot.name} has a sliding one"
        return super().skip(robot)

    def _solve_rows(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        import optik

        if budget is None or budget.time_s is None:
            raise BudgetError(f"solver {self.name!r} needs a budget of time_s")
        self._config = optik.SolverConfig(max_time=min(budget.time_s, LONGEST_S), **self._settings)
        return super()._solve_rows(poses, initial, budget)

    def _solve_one(self, pose: Array, initial: Array, clock: Clock) -> Answer:
        answer = self._library.ik(self._config, pose_matrix(pose), initial)
        if answer is not None:
            return Answer(np.array(answer[0]), "")
        return Answer(initial, OUT_OF_TIME if clock.time_left_s <= 0 else NO_SOLUTION)
