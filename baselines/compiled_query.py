"""One query of a compiled solver as one call: checks, seeds, descent and turns in machine code.

An array API of one row pays tens of microseconds for its checks and its arrays, several times what
the kernel needs. Here Python looks at types and shapes alone; numbers are looked at in the compiled
function, which refuses what the array API has to name, move or draw in, so that there is one place
where errors are worded.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.bound_kernel import BoundKernel, is_plain
from baselines.protocol import Budget, Solution, Solver
from baselines.refine import REASONS

Array = NDArray[np.float64]

REFUSED = -1  # status of a query whose numbers the array API has to look at
FEW = 4  # poses for which queries in a row take less than the arrays of a batch
POSE_SHAPE = (7,)


class QueryOptions(Protocol):
    """What changes from query to query, a named tuple."""

    @property
    def time_ns(self) -> int:
        """Limit of time, 0 for none."""
        ...


Options = TypeVar("Options", bound=QueryOptions)


class CompiledQuery(BoundKernel):
    """A compiled function with all its arguments bound but those of one query.

    Args:
        function: Takes (pose (7,), initial (0 or 1, dof), answer (dof,), options, None or True
            where these limit the time, *bound) and returns (status, iterations, starts, ns); a
            status of `REFUSED` has changed nothing.
        options: `LmOptions` or others, of the types that it is compiled for.
        dof: Joints.
        bound: The other arguments.
    """

    def __init__(self, function: Any, options: QueryOptions, dof: int, *bound: Any) -> None:
        query = np.empty(7), np.empty((0, dof)), np.empty(dof), options
        super().__init__(function, query, (True if options.time_ns > 0 else None, *bound))


class CompiledQuerySolver(Solver, Generic[Options]):
    """A solver whose `solve_one` is one call of a compiled function, and batches of few rows a few.

    Answers are those of its other batches, bit for bit.

    Attributes:
        reasons: What a status other than 0 means.
    """

    reasons: ClassVar[Mapping[int, str]] = REASONS
    _bound: tuple[Budget | None, Options] | None = None
    _given: tuple[Budget, Options] | None = None

    @abstractmethod
    def options(self, budget: Budget | None) -> Options:
        """The kernel's options under a budget."""

    @abstractmethod
    def compile_query(self, options: Options) -> CompiledQuery | None:
        """Return the compiled query; None where this solver, as it is set, has none."""

    def solve_one(self, pose: ArrayLike, initial: ArrayLike | None = None) -> tuple[Array, bool]:
        """See `Solver.solve_one`."""
        answer = np.empty(self.robot.dof)
        outcome = self._answer(pose, initial, answer, self._options_now())
        if outcome is None:
            return super().solve_one(pose, initial)
        return answer, outcome[0] == 0

    def _solve_at_once(
        self, poses: ArrayLike, initial: ArrayLike | None, budget: Budget | None
    ) -> Solution | None:
        """See `Solver`: a batch of few rows, as plain as the kernel wants it."""
        if type(poses) is not np.ndarray or poses.ndim != 2 or not 0 < len(poses) <= FEW:
            return None
        count = len(poses)
        given = type(initial) is np.ndarray and initial.ndim == 2 and len(initial) == count
        answers = np.empty((count, self.robot.dof))
        options = self._options_now() if budget is None else self._options_of(budget)
        outcomes = []
        for k in range(count):
            first = initial[k] if given else initial  # type: ignore[index]
            outcome = self._answer(poses[k], first, answers[k], options)
            if outcome is None:
                return None
            outcomes.append(outcome)
        return solution_of(answers, outcomes, self.reasons)

    def _answer(
        self, pose: ArrayLike, initial: ArrayLike | None, answer: Array, options: Options
    ) -> tuple[int, int, int, int] | None:
        """Solve one pose; None where the array API has to."""
        timed = options.time_ns > 0
        if timed not in self._queries:
            self._queries[timed] = self.compile_query(options)
        query = self._queries[timed]
        if query is None or not is_plain(pose, POSE_SHAPE):
            return None
        if initial is None:
            guess = answer[:0].reshape(0, len(answer))
        elif is_plain(initial, answer.shape):
            guess = initial[None]
        else:
            return None
        outcome: tuple[int, int, int, int] = query(pose, guess, answer, options)
        return None if outcome[0] == REFUSED else outcome

    @cached_property
    def _queries(self) -> dict[bool, CompiledQuery | None]:
        """The query without a limit of time and with one, each as soon as it is needed."""
        return {}

    def _options_now(self) -> Options:
        """The kernel's options under the solver's own budget, made anew when that is replaced."""
        bound = self._bound
        if bound is None or bound[0] is not self.budget:
            bound = self._bound = (self.budget, self.options(None))
        return bound[1]

    def _options_of(self, budget: Budget) -> Options:
        """The kernel's options under a budget; those of the last one are kept."""
        given = self._given
        if given is None or given[0] is not budget:
            given = self._given = (budget, self.options(self._validated_budget(budget)))
        return given[1]


def solution_of(
    answers: Array,
    outcomes: Sequence[tuple[int, int, int, int]],
    reasons: Mapping[int, str] = REASONS,
) -> Solution:
    """Return answers (N, dof) with the status, iterations, starts and time [ns] of each."""
    return Solution(
        answers,
        np.array([outcome[0] == 0 for outcome in outcomes]),
        np.array([outcome[3] * 1e-9 for outcome in outcomes]),
        np.array([outcome[1] for outcome in outcomes]),
        tuple([reasons[outcome[0]] for outcome in outcomes]),
    )
