"""The protocol of every inverse-kinematics solver: poses in, joints and a claim out.

A solver subclasses `Solver` (it answers a whole batch) or `QuerySolver` (it answers one pose at a
time), names the packages it needs in `requires`, and says in `budgets` which budgets it heeds.
"""

from __future__ import annotations

import importlib.util
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.checks import check_initial, check_poses
from baselines.errors import BudgetError

if TYPE_CHECKING:
    from robots import Robot

OUT_OF_TIME = "out of time"
OUT_OF_ITERATIONS = "out of iterations"
NO_SOLUTION = "no solution"


@dataclass(frozen=True)
class Budget:
    """What one query may cost; whichever runs out first ends it.

    Attributes:
        time_s: Wall-clock seconds per pose, or None for no limit.
        iterations: Iterations per pose, summed over restarts, or None for no limit.
    """

    time_s: float | None = None
    iterations: int | None = None

    def __post_init__(self) -> None:
        if self.time_s is None and self.iterations is None:
            raise BudgetError("a budget needs time_s [s], iterations or both, got neither")
        if self.time_s is not None and not 0 < self.time_s < float("inf"):
            raise BudgetError(f"expected a budget time_s > 0 s, got {self.time_s}")
        if self.iterations is not None and self.iterations < 1:
            raise BudgetError(f"expected a budget of at least 1 iteration, got {self.iterations}")


@dataclass(frozen=True)
class Solution:
    """Answers to N poses, one row each; a failed row keeps the best joints that were met.

    Attributes:
        joints: (N, dof) joint values inside the limits [rad or m].
        found: (N,) the solver's own claim to have met its tolerance.
        time_s: (N,) seconds per pose; the batch's time shared out where poses are solved together.
        iterations: (N,) iterations, summed over restarts; 0 for analytical solvers.
        reason: (N,) why there is no solution, "" where found.
    """

    joints: NDArray[np.float64]
    found: NDArray[np.bool_]
    time_s: NDArray[np.float64]
    iterations: NDArray[np.int64]
    reason: tuple[str, ...]

    def __len__(self) -> int:
        return self.joints.shape[0]

    @classmethod
    def empty(cls, count: int, dof: int) -> Solution:
        """Room for `count` answers of `dof` joints, none found yet."""
        return cls(
            np.zeros((count, dof)),
            np.zeros(count, dtype=bool),
            np.zeros(count),
            np.zeros(count, dtype=np.int64),
            ("",) * count,
        )


class Solver(ABC):
    """Inverse kinematics of one robot.

    Attributes:
        name: Name in the registry.
        requires: Modules that must be installed.
        budgets: Budgets that the solver heeds, of "time_s" and "iterations". One that heeds none
            (an analytical solver) takes any budget and needs none.
        mimics: Whether it can solve a chain where one joint mimics another.
        always_answers: Whether every answer counts with its own error, found or not, as a network's
            does in the paper.
        robot: The robot that it solves for.
        budget: Used where `solve` gets none.
        settings: Its YAML with overrides, as the registry made it; empty where made by hand.
        weights: Folder of the trained weights that the registry made it with; None for a solver
            without any.
    """

    name: str = ""
    weights: Path | None = None
    requires: ClassVar[tuple[str, ...]] = ()
    budgets: ClassVar[frozenset[str]] = frozenset({"time_s", "iterations"})
    mimics: ClassVar[bool] = True
    always_answers: bool = False

    def __init__(
        self, robot: Robot, *, time_s: float | None = None, iterations: int | None = None
    ) -> None:
        self.robot = robot
        self.settings: dict[str, Any] = {}
        self.lower = np.array(robot.lower, dtype=np.float64)
        self.upper = np.array(robot.upper, dtype=np.float64)
        unbounded = time_s is None and iterations is None
        self.budget = None if unbounded else self._validated_budget(Budget(time_s, iterations))

    @classmethod
    def skip(cls, robot: Robot | None = None) -> str | None:
        """Say why this solver cannot run here (for `robot`, if given), or None if it can."""
        missing = [name for name in cls.requires if importlib.util.find_spec(name) is None]
        if missing:
            return f"not installed: {', '.join(missing)}"
        if robot is not None and not cls.mimics and len(robot.chain.variable) != robot.dof:
            return f"a joint of {robot.name} mimics another one, which this solver does not know"
        return None

    def solve(
        self, poses: ArrayLike, initial: ArrayLike | None = None, budget: Budget | None = None
    ) -> Solution:
        """Find joints whose tip poses are `poses`.

        Args:
            poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz.
            initial: (dof,) or (N, dof) initial guess [rad or m], moved into the limits; the
                robot's home if None.
            budget: Cost allowed per pose; the solver's own (its YAML) if None.

        Returns:
            One row per pose, also for those that were not found.

        Raises:
            PoseError: Poses of wrong shape, not finite or with a quaternion that is not unit.
            InitialError: An initial guess of wrong shape or not finite.
            BudgetError: A budget of a kind that this solver does not heed.
        """
        targets = check_poses(poses)
        seeds = check_initial(
            initial, len(targets), np.asarray(self.robot.home), self.lower, self.upper
        )
        chosen = self.budget if budget is None else self._validated_budget(budget)
        if len(targets) == 0:
            return Solution.empty(0, self.robot.dof)
        return self._solve_batch(targets, seeds, chosen)

    @abstractmethod
    def _solve_batch(
        self,
        poses: NDArray[np.float64],
        initial: NDArray[np.float64],
        budget: Budget | None,
    ) -> Solution:
        """Solve checked poses (N, 7), N > 0, from initial guesses (N, dof) inside the limits."""

    def _validated_budget(self, budget: Budget) -> Budget:
        given = {kind for kind in ("time_s", "iterations") if getattr(budget, kind) is not None}
        if self.budgets and not given & self.budgets:
            raise BudgetError(
                f"solver {self.name or type(self).__name__!r} heeds a budget of "
                f"{' or '.join(sorted(self.budgets))}, got only {' and '.join(sorted(given))}"
            )
        return budget


class Clock:
    """The budget of one query while it runs."""

    def __init__(self, budget: Budget | None) -> None:
        self.start_ns = time.perf_counter_ns()
        self.iterations = 0
        seconds = None if budget is None else budget.time_s
        limit = None if budget is None else budget.iterations
        self.end_ns = None if seconds is None else self.start_ns + int(seconds * 1e9)
        self.limit = limit

    def tick(self) -> None:
        """Count one iteration."""
        self.iterations += 1

    @property
    def time_left_s(self) -> float:
        """Seconds until the time runs out, infinite without a limit."""
        if self.end_ns is None:
            return float("inf")
        return (self.end_ns - time.perf_counter_ns()) * 1e-9

    def expired(self) -> str:
        """The reason to stop, "" while there is budget left."""
        if self.limit is not None and self.iterations >= self.limit:
            return OUT_OF_ITERATIONS
        if self.end_ns is not None and time.perf_counter_ns() >= self.end_ns:
            return OUT_OF_TIME
        return ""


@dataclass(frozen=True)
class Answer:
    """What a `QuerySolver` found for one pose; reason is "" exactly where it was found."""

    joints: NDArray[np.float64]
    reason: str


class QuerySolver(Solver):
    """A solver that answers one pose at a time; the clock runs per query."""

    def _solve_batch(
        self,
        poses: NDArray[np.float64],
        initial: NDArray[np.float64],
        budget: Budget | None,
    ) -> Solution:
        solution = Solution.empty(len(poses), self.robot.dof)
        reasons: list[str] = []
        for row, (pose, seed) in enumerate(zip(poses, initial, strict=True)):
            clock = Clock(budget)
            answer = self._solve_one(pose, seed, clock)
            solution.time_s[row] = (time.perf_counter_ns() - clock.start_ns) * 1e-9
            solution.iterations[row] = clock.iterations
            # Rounding inside a library may leave a joint 1e-16 outside its limit.
            solution.joints[row] = np.clip(answer.joints, self.lower, self.upper)
            solution.found[row] = answer.reason == ""
            reasons.append(answer.reason)
        return Solution(
            solution.joints, solution.found, solution.time_s, solution.iterations, tuple(reasons)
        )

    @abstractmethod
    def _solve_one(
        self, pose: NDArray[np.float64], initial: NDArray[np.float64], clock: Clock
    ) -> Answer:
        """Solve one pose (7,) from `initial` (dof,) until done or `clock.expired()`."""
