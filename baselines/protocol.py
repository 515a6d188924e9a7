"""The protocol of every inverse-kinematics solver: poses in, joints and a claim out.

A solver subclasses `Solver` (it answers a whole batch) or `QuerySolver` (it answers one pose at a
time), names the packages it needs in `requires`, and says in `budgets` which budgets it heeds.
"""

from __future__ import annotations

import copy
import importlib.util
import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.abilities import AVOID, Abilities
from baselines.checks import check_initial, check_poses
from baselines.errors import BudgetError, InitialError, PoseError
from robots.arguments import as_float, as_floats, as_int
from robots.limits import search_range
from robots.obstacles import Obstacles, each_obstacles
from robots.rotations import rotation_angle

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

OUT_OF_TIME = "out of time"
OUT_OF_ITERATIONS = "out of iterations"
NO_SOLUTION = "no solution"
OUTSIDE_TOLERANCE = "outside the tolerance"
# Longer budgets, about 30 years and 2^62 iterations, are no limits and would not fit 64 bits.
LONGEST_S, MOST_ITERATIONS = 1e9, 2**62
# What two ways to compute a tip pose may differ by, a share of the tolerance and absolutely.
ROUNDING, LEAST_ROUNDING = 1e-6, 1e-9
# What a solver is made with again, beside its arguments.
_KEPT = ("name", "settings", "budget", "weights")


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
        if self.time_s is not None:
            seconds = as_float(self.time_s, "time_s of a budget", BudgetError)
            if not 0 < seconds < math.inf:
                raise BudgetError(f"expected a budget time_s > 0 s, got {self.time_s}")
            object.__setattr__(self, "time_s", min(seconds, LONGEST_S))
        if self.iterations is not None:
            count = as_int(self.iterations, "iterations of a budget", BudgetError)
            if count < 1:
                raise BudgetError(f"expected a budget of at least 1 iteration, got {count}")
            object.__setattr__(self, "iterations", min(count, MOST_ITERATIONS))


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

    joints: Array
    found: NDArray[np.bool_]
    time_s: Array
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


class Solver(Abilities, ABC):
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
        lower: (dof,) where its search stops, rad or m (`Chain.lower`).
        upper: (dof,) the same above.
        tolerances: Largest distance [m] and rotation angle [rad] of what it calls found, infinite
            where a subclass judges by itself.
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
    _made_with: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *arguments: Any, **settings: Any) -> Self:
        """Keep what the solver is made with, so that it can be made again elsewhere."""
        solver = super().__new__(cls)
        solver._made_with = (arguments, settings)
        return solver

    def __init__(
        self, robot: Robot, *, time_s: float | None = None, iterations: int | None = None
    ) -> None:
        self.robot = robot
        self.settings: dict[str, Any] = {}
        self.lower, self.upper = search_range(robot.lower, robot.upper, robot.endless)
        self.tolerances = (math.inf, math.inf)
        unbounded = time_s is None and iterations is None
        self.budget = None if unbounded else self._validated_budget(Budget(time_s, iterations))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle and copy a solver as what it was made with: libraries' objects are made anew."""
        kept = {key: self.__dict__[key] for key in _KEPT if key in self.__dict__}
        return _made_again, (type(self), *self._made_with), kept

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
        self,
        poses: ArrayLike,
        initial: ArrayLike | None = None,
        budget: Budget | None = None,
        avoid: Obstacles | Sequence[Obstacles] | None = None,
    ) -> Solution:
        """Find joints whose tip poses are `poses`.

        Args:
            poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz.
            initial: (dof,) or (N, dof) initial guess [rad or m], moved into the limits; the
                robot's home if None. Joints that turn for ever come back within half a turn of
                it, or within their limits if None.
            budget: Cost allowed per pose; the solver's own (its YAML) if None.
            avoid: Obstacles in the base frame with the clearance from them, for all poses or a set
                for each. What is found is then free of self-collision as well; `Obstacles()`
                asks for that alone. None asks for neither.

        Returns:
            One row per pose, also for those that were not found.

        Raises:
            PoseError: Poses of wrong shape, not finite or with a quaternion that is not unit.
            InitialError: An initial guess of wrong shape or not finite.
            BudgetError: A budget of a kind that this solver does not heed.
            AbilityError: Something to avoid, of which this solver knows nothing.
            ObstacleError: Neither one set of obstacles nor one for each pose.
        """
        if avoid is None and (answer := self._solve_at_once(poses, initial, budget)) is not None:
            return answer
        targets = check_poses(poses)
        guesses = self._guesses(initial, len(targets))
        chosen = self.budget if budget is None else self._validated_budget(budget)
        if avoid is not None:
            self._need(AVOID)
        sets = None if avoid is None else each_obstacles(avoid, len(targets))
        if len(targets) == 0:
            return Solution.empty(0, self.robot.dof)
        if sets is not None:
            solution = self._solve_avoiding(targets, guesses, chosen, sets)
        elif guesses is None:
            solution = self._solve_unguided(targets, chosen)
        else:
            solution = self._solve_batch(targets, guesses, chosen)
        return self._nearest_turns(solution, initial)

    def solve_one(self, pose: ArrayLike, initial: ArrayLike | None = None) -> tuple[Array, bool]:
        """Find joints whose tip pose is `pose`, under the solver's own budget.

        What `solve` answers to a batch of one, by the shortest path there is.

        Args:
            pose: (7,) target in the base frame, x y z in m, then unit qw qx qy qz.
            initial: (dof,) initial guess [rad or m], see `solve`.

        Returns:
            (dof,) joints [rad or m], the best that were met where it is not found, and whether
            it is.

        Raises:
            PoseError: As `solve`.
            InitialError: As `solve`.
        """
        target = as_floats(pose, "pose", PoseError)
        if target.shape != (7,):
            raise PoseError(
                f"expected one pose of shape (7,), x y z qw qx qy qz, got {target.shape}"
            )
        guess = None if initial is None else as_floats(initial, "initial joints", InitialError)
        if guess is not None and guess.shape != (self.robot.dof,):
            raise InitialError(
                f"expected initial joints of shape ({self.robot.dof},), got {guess.shape}"
            )
        solution = self.solve(target[None], guess)
        return solution.joints[0], bool(solution.found[0])

    def _only_true_claims(self, solution: Solution, poses: Array) -> Solution:
        """Take back claims for joints whose tip is outside the tolerances, as we compute it.

        A library may judge by another measure, or before a joint was moved into its limits.
        """
        if not solution.found.any():
            return solution
        reached = self.robot.forward_kinematics(solution.joints)
        distance = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
        angle = rotation_angle(reached[:, 3:], poses[:, 3:])
        room = [limit * (1.0 + ROUNDING) + LEAST_ROUNDING for limit in self.tolerances]
        true = (distance <= room[0]) & (angle <= room[1])
        reasons = tuple(
            OUTSIDE_TOLERANCE if claimed and not held else reason
            for claimed, held, reason in zip(solution.found, true, solution.reason, strict=True)
        )
        return replace(solution, found=solution.found & true, reason=reasons)

    def _solve_at_once(
        self, poses: ArrayLike, initial: ArrayLike | None, budget: Budget | None
    ) -> Solution | None:
        """Solve what needs no check, on a shorter path; None for what takes the way of all."""
        return None

    @abstractmethod
    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        """Solve checked poses (N, 7), N > 0, from initial guesses (N, dof) inside the limits."""

    def _solve_unguided(self, poses: Array, budget: Budget | None) -> Solution:
        """Solve checked poses (N, 7), N > 0, without a guess: from home if it knows no better."""
        robot = self.robot
        home = check_initial(None, len(poses), robot.home, robot.lower, robot.upper)
        return self._solve_batch(poses, home, budget)

    def _solve_avoiding(
        self, poses: Array, initial: Array | None, budget: Budget | None, sets: list[Obstacles]
    ) -> Solution:
        """Solve checked poses (N, 7) free of collision; see `Abilities`.

        Args:
            poses: (N, 7), N > 0.
            initial: (N, dof) initial guesses inside the limits, or None.
            budget: Cost allowed per pose.
            sets: N sets of obstacles.
        """
        raise NotImplementedError

    def _validated_budget(self, budget: Budget) -> Budget:
        given = {kind for kind in ("time_s", "iterations") if getattr(budget, kind) is not None}
        if self.budgets and not given & self.budgets:
            raise BudgetError(
                f"solver {self.name or type(self).__name__!r} heeds a budget of "
                f"{' or '.join(sorted(self.budgets))}, got only {' and '.join(sorted(given))}"
            )
        return budget


def _made_again(kind: type[Solver], arguments: tuple[Any, ...], settings: dict[str, Any]) -> Solver:
    return kind(*arguments, **settings)


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

    joints: Array
    reason: str


class QuerySolver(Solver):
    """A solver that answers one pose at a time; the clock runs per query.

    What it works in belongs to the thread that made it; another thread works in a copy of its own.
    """

    def __init__(
        self, robot: Robot, *, time_s: float | None = None, iterations: int | None = None
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        self._owner = threading.get_ident()
        self._copies = threading.local()

    def _of_this_thread(self) -> QuerySolver:
        if threading.get_ident() == self._owner:
            return self
        if not hasattr(self._copies, "solver"):
            self._copies.solver = copy.copy(self)
        solver: QuerySolver = self._copies.solver
        return solver

    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        return self._of_this_thread()._solve_rows(poses, initial, budget)

    def _solve_rows(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        """Solve checked poses one after the other, in the thread that made the solver."""
        solution = Solution.empty(len(poses), self.robot.dof)
        reasons: list[str] = []
        for row, (pose, seed) in enumerate(zip(poses, initial, strict=True)):
            clock = Clock(budget)
            answer = self._solve_one(pose, seed, clock)
            solution.time_s[row] = (time.perf_counter_ns() - clock.start_ns) * 1e-9
            solution.iterations[row] = clock.iterations
            # Rounding inside a library may leave a joint 1e-16 outside its limit.
            joints = np.where(np.isfinite(answer.joints), answer.joints, seed)
            solution.joints[row] = np.clip(joints, self.lower, self.upper)
            solution.found[row] = answer.reason == ""
            reasons.append(answer.reason)
        return self._only_true_claims(replace(solution, reason=tuple(reasons)), poses)

    @abstractmethod
    def _solve_one(self, pose: Array, initial: Array, clock: Clock) -> Answer:
        """Solve one pose (7,) from `initial` (dof,) until done or `clock.expired()`."""
