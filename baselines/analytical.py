"""What analytical solvers share: a library proposes configurations, the best inside is taken."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.abilities import MANY
from baselines.bound_kernel import BoundKernel, is_plain
from baselines.candidates import prepare_query, take_candidate
from baselines.checks import positive_settings
from baselines.distinct import distinct, nearest_first
from baselines.joint_range import JointRange
from baselines.protocol import NO_SOLUTION, Answer, Clock, QuerySolver
from robots.arguments import compiled_floats

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


class AnalyticalSolver(QuerySolver):
    """A closed-form solver: no iterations, no budget; the nearest to the initial guess is taken.

    Around the library's own call there are two compiled ones, since such a library answers within
    microseconds.

    Args:
        robot: The robot to solve for.
        limit_tolerance: How far outside a limit a joint may be and still be moved onto it
            [rad or m].
        matrix_tolerance: Largest difference of an entry of the reached (4, 4) tip transform from
            the target's that is claimed as a solution.
        tool: (4, 4) transform from the robot's tip to the end of the arm as the library has it.
    """

    budgets: ClassVar[frozenset[str]] = frozenset()
    abilities: ClassVar[frozenset[str]] = frozenset({MANY})

    def __init__(
        self, robot: Robot, *, limit_tolerance: float, matrix_tolerance: float, tool: Array
    ) -> None:
        super().__init__(robot)
        tolerances = positive_settings(
            {"limit_tolerance": limit_tolerance, "matrix_tolerance": matrix_tolerance}
        )
        self.limit_tolerance, self.matrix_tolerance = tolerances.values()
        # Three entries make a distance; nine make a rotation's chord, 2 sqrt(2) sin(angle / 2).
        chord = min(3.0 * self.matrix_tolerance / math.sqrt(8.0), 1.0)
        self.tolerances = (math.sqrt(3.0) * self.matrix_tolerance, 2.0 * math.asin(chord))
        self._tool = np.ascontiguousarray(tool, dtype=np.float64)
        self._none = np.empty((0, robot.dof))

    @abstractmethod
    def _candidates(self, end: Array, guess: Array) -> Iterator[Array]:
        """Propose configurations (K, dof) for a transform (4, 4) of the library's end of the arm.

        They come in lots, each in any order; of the first lot with a solution one is taken.
        """

    def solve_one(self, pose: ArrayLike, initial: ArrayLike | None = None) -> tuple[Array, bool]:
        """See `Solver.solve_one`."""
        solver = self._of_this_thread()
        assert isinstance(solver, AnalyticalSolver)
        shape = (self.robot.dof,)
        if is_plain(pose, (7,)) and (initial is None or is_plain(initial, shape)):
            first = self._none if initial is None else initial[None]
            answer = solver._answer(pose, first)
            if answer is not None:
                return answer.joints, answer.reason == ""
        return super().solve_one(pose, initial)

    def _solve_one(self, pose: Array, initial: Array, clock: Clock) -> Answer:
        answer = self._answer(np.array(pose), np.array(initial)[None])
        assert answer is not None, "poses and guesses were checked before"
        return answer

    def _solve_all(self, pose: Array, count: int, apart: float, guess: Array | None) -> Array:
        seed, target, end = self.robot.home[None].copy(), np.empty((4, 4)), np.empty((4, 4))
        self._prepare(pose, self._none if guess is None else guess[None], seed, target, end)
        kept, answer = self._none, np.empty(self.robot.dof)
        for candidates in self._candidates(end, seed[0]):
            for row in compiled_floats(candidates):  # each by itself: all that are good are wanted
                if self._take(row[None].copy(), target, seed, answer):
                    kept = distinct(self.robot, answer[None], apart, kept)
            if len(kept) >= count:
                break
        return nearest_first(self.robot, kept[:count], guess)

    def _answer(self, pose: Array, initial: Array) -> Answer | None:
        """Solve one pose (7,) from a guess (0 or 1, dof); None for numbers that are refused."""
        guess, answer = self.robot.home[None].copy(), np.empty(self.robot.dof)
        target, end = np.empty((4, 4)), np.empty((4, 4))
        if not self._prepare(pose, initial, guess, target, end):
            return None
        for candidates in self._candidates(end, guess[0]):
            # What a library returns goes where no types are looked at.
            if self._take(compiled_floats(candidates), target, guess, answer):
                return Answer(answer, "")
        return Answer(guess[0], NO_SOLUTION)

    @cached_property
    def _range(self) -> JointRange:
        return JointRange(self.lower, self.upper, self.robot.endless)

    @cached_property
    def _prepare(self) -> BoundKernel:
        frame, dof = np.empty((4, 4)), self.robot.dof
        examples = np.empty(7), self._none, np.empty((1, dof)), frame, frame
        return BoundKernel(prepare_query, examples, (self._range, self._tool))

    @cached_property
    def _take(self) -> BoundKernel:
        dof = self.robot.dof
        examples = self._none, np.empty((4, 4)), np.empty((1, dof)), np.empty(dof)
        bound = self.robot.chain, self._range, self.limit_tolerance, self.matrix_tolerance
        return BoundKernel(take_candidate, examples, bound)
