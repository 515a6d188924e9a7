"""The compiled Levenberg-Marquardt solver, from home and then from random configurations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from baselines.checks import (
    count_settings,
    damping_settings,
    positive_settings,
    thread_setting,
)
from baselines.lm_kernel import LmOptions
from baselines.protocol import Budget, Solution, Solver
from baselines.refine import refine

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# Without an iteration limit the time limit ends a query; this one is never reached.
UNLIMITED = 2**62


class LevenbergMarquardt(Solver):
    """Levenberg-Marquardt with joint limits as an active set and random restarts.

    Args:
        robot: The robot to solve for.
        threads: Threads that share a batch; 0 for all of numba's.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
        **options: The other fields of `LmOptions`.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        threads: int,
        time_s: float | None,
        iterations: int | None,
        **options: Any,
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        self.threads = thread_setting(threads)
        # The kernel is compiled for these types; others would have it compiled again.
        sizes = ("position_tolerance_m", "rotation_tolerance_rad")
        damping, gain = damping_settings(options.pop("damping"), options.pop("damping_gain"))
        checked: dict[str, Any] = {
            **positive_settings({key: options.pop(key) for key in sizes}),
            **count_settings({"patience": options.pop("patience")}),
            **count_settings({key: options.pop(key) for key in list(options)}, least=0),
        }
        self._options = LmOptions(
            **checked,
            damping=damping,
            damping_gain=gain,
            iterations=UNLIMITED,
            starts=UNLIMITED,
            time_ns=0,
        )
        self.position_tolerance_m = self._options.position_tolerance_m
        self.rotation_tolerance_rad = self._options.rotation_tolerance_rad
        self.tolerances = (self.position_tolerance_m, self.rotation_tolerance_rad)

    def options(self, budget: Budget | None) -> LmOptions:
        """The kernel's options under a budget."""
        if budget is None:
            budget = self.budget or Budget(iterations=UNLIMITED)
        return self._options._replace(
            iterations=UNLIMITED if budget.iterations is None else budget.iterations,
            time_ns=0 if budget.time_s is None else max(1, int(budget.time_s * 1e9)),
        )

    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        refined = refine(self.robot, poses, initial[:, None, :], self.options(budget), self.threads)
        return refined.solution()
