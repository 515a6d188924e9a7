"""Solvers of libraries that search until they have a solution or a time is used up."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.errors import BudgetError
from baselines.protocol import (
    NO_SOLUTION,
    OUT_OF_TIME,
    Answer,
    Budget,
    Clock,
    QuerySolver,
    Solution,
)

Array = NDArray[np.float64]

LONGEST_S = 1e6  # more than anybody waits, and not too much for a library's clock


class TimedSolver(QuerySolver):
    """A library that keeps the time by itself; it is told the time once for a batch."""

    mimics: ClassVar[bool] = False
    budgets: ClassVar[frozenset[str]] = frozenset({"time_s"})

    @abstractmethod
    def _set_time(self, time_s: float) -> None:
        """Set the time that the library may use for a pose [s], `LONGEST_S` at most."""

    @abstractmethod
    def _search(self, pose: Array, initial: Array) -> Array | None:
        """Joints (dof,) for one pose (7,), from `initial` (dof,), or None without a solution."""

    def _solve_rows(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        if budget is None or budget.time_s is None:
            raise BudgetError(f"solver {self.name!r} needs a budget of time_s")
        self._set_time(min(budget.time_s, LONGEST_S))
        return super()._solve_rows(poses, initial, budget)

    def _solve_one(self, pose: Array, initial: Array, clock: Clock) -> Answer:
        joints = self._search(pose, initial)
        if joints is not None:
            return Answer(joints, "")
        return Answer(initial, OUT_OF_TIME if clock.time_left_s <= 0 else NO_SOLUTION)
