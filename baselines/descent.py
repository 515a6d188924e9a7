"""Step-by-step local solvers share one loop: descend, notice a stall, restart at random."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines.checks import count_settings, positive_settings
from baselines.protocol import Answer, Clock, QuerySolver
from baselines.restarts import restart_configurations

if TYPE_CHECKING:
    from robots import Robot

STALLED = "stalled"


class DescentSolver(QuerySolver):
    """A local method that is driven one step at a time and holds its joints as state.

    Args:
        robot: The robot to solve for.
        position_tolerance_m: Distance to the target at which a solution is claimed [m].
        rotation_tolerance_rad: Rotation angle to the target at which it is claimed [rad].
        restarts: Whether a stalled descent starts again from a random configuration.
        patience: Iterations within which the squared error has to halve; else it has stalled.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        position_tolerance_m: float,
        rotation_tolerance_rad: float,
        restarts: bool,
        patience: int,
        time_s: float | None,
        iterations: int | None,
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        tolerances = positive_settings(
            {
                "position_tolerance_m": position_tolerance_m,
                "rotation_tolerance_rad": rotation_tolerance_rad,
            }
        )
        self.position_tolerance_m, self.rotation_tolerance_rad = tolerances.values()
        self.tolerances = (self.position_tolerance_m, self.rotation_tolerance_rad)
        self.restarts = restarts
        self.patience = count_settings({"patience": patience})["patience"]

    @abstractmethod
    def _aim(self, pose: NDArray[np.float64]) -> None:
        """Set the target (7,) in the base frame."""

    @abstractmethod
    def _place(self, joints: NDArray[np.float64]) -> None:
        """Set the joints (dof,) to start from."""

    @abstractmethod
    def _joints(self) -> NDArray[np.float64]:
        """The joints reached so far, an array that later steps do not change."""

    @abstractmethod
    def _errors(self) -> tuple[float, float]:
        """Distance [m] and rotation angle [rad] from the tip to the target."""

    @abstractmethod
    def _step(self) -> None:
        """Move the joints by one iteration of the method, inside the limits."""

    def _solve_one(
        self, pose: NDArray[np.float64], initial: NDArray[np.float64], clock: Clock
    ) -> Answer:
        self._aim(pose)
        fresh = restart_configurations(pose, self.lower, self.upper)
        best, best_joints, start = np.inf, initial, initial
        while True:
            self._place(start)
            reason, squared = self._descend(clock)
            if reason == "":  # another descent may have less error in sum, yet outside a tolerance
                return Answer(self._joints(), reason)
            if squared < best:
                best, best_joints = squared, self._joints()
            if reason != STALLED or not self.restarts:
                return Answer(best_joints, reason)
            start = next(fresh)

    def _descend(self, clock: Clock) -> tuple[str, float]:
        """Step until converged (reason ""), stalled or out of budget; the last squared error."""
        since, reference = 0, np.inf
        while True:
            position, rotation = self._errors()
            squared = position**2 + rotation**2
            if position <= self.position_tolerance_m and rotation <= self.rotation_tolerance_rad:
                return "", squared
            reason = clock.expired()
            if reason:
                return reason, squared
            if since == self.patience:
                if squared > 0.5 * reference:
                    return STALLED, squared
                since = 0
            if since == 0:
                reference = squared
            self._step()
            clock.tick()
            since += 1
