"""OptIK: sequential quadratic programming in Rust with random restarts, on one thread."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from baselines.chain_urdf import chain_urdf_file
from baselines.checks import positive_settings, thread_setting
from baselines.errors import SettingError
from baselines.timed import Array, TimedSolver
from baselines.transforms import pose_matrix
from robots.serial_urdf import BASE, TIP

if TYPE_CHECKING:
    from robots import Robot


class Optik(TimedSolver):
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

    def _set_time(self, time_s: float) -> None:
        import optik

        self._config = optik.SolverConfig(max_time=time_s, **self._settings)

    def _search(self, pose: Array, initial: Array) -> Array | None:
        answer = self._library.ik(self._config, pose_matrix(pose), initial)
        return None if answer is None else np.array(answer[0])
