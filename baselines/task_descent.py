"""Pink and mink share one way: a quadratic program with joint limits for every step of a task.

Both libraries have a configuration that is moved, a frame task for the tip with Levenberg-Marquardt
damping, and a limit on the configuration; mink is modelled on pink.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.checks import damping_settings, positive_settings
from baselines.descent import DescentSolver

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# A step is a displacement rather than a velocity over some time.
STEP_S = 1.0


class TaskDescent(DescentSolver):
    """Steps of a library's `solve_ik` with a frame task, restarted when they stall.

    Args:
        robot: The robot to solve for.
        qp_solver: Name of the quadratic-program solver (of qpsolvers).
        lm_damping: The library's damping of the task per squared error.
        limit_gain: Share of the way to a joint limit that one step may take, in (0, 1].
        **descent: Tolerances, restarts and budget, see `DescentSolver`.
    """

    mimics: ClassVar[bool] = False
    _configuration: Any
    _task: Any
    _infeasible: type[Exception]

    def __init__(
        self, robot: Robot, *, qp_solver: str, lm_damping: float, limit_gain: float, **descent: Any
    ) -> None:
        super().__init__(robot, **descent)
        self.qp_solver = qp_solver
        limit_gain = positive_settings({"limit_gain": limit_gain})["limit_gain"]
        lm_damping = damping_settings(lm_damping, 1.0)[0]
        self._set_up(
            {"position_cost": 1.0, "orientation_cost": 1.0, "lm_damping": lm_damping}, limit_gain
        )

    @abstractmethod
    def _set_up(self, task: dict[str, float], limit_gain: float) -> None:
        """Make what the library solves with: its configuration, the task of the tip and limits.

        Args:
            task: Costs and damping of the task.
            limit_gain: Share of the way to a joint limit that one step may take.
        """

    @abstractmethod
    def _velocity(self) -> Any:
        """The next step; raises `_infeasible` where the program has no solution."""

    def _place(self, joints: Array) -> None:
        self._configuration.update(joints)

    def _joints(self) -> Array:
        return np.array(self._configuration.q)

    def _step(self) -> None:
        try:
            velocity = self._velocity()
        except self._infeasible:
            # Rounding left a joint outside its limit: no step is feasible from there.
            self._place(np.clip(self._joints(), self.lower, self.upper))
            return
        self._configuration.integrate_inplace(velocity, STEP_S)
