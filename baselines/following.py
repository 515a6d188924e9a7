"""Following a motion from Python: one compiled call a pose, and a search where that is lost."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.abilities import FOLLOW
from baselines.bound_kernel import BoundKernel, is_plain
from baselines.compiled_query import FEW, POSE_SHAPE, CompiledQuerySolver, solution_of
from baselines.follow_kernel import follow_query
from baselines.followed_path import FollowedPath
from baselines.joint_range import joint_range
from baselines.lm_kernel import FOUND, LmOptions
from baselines.path_kernel import follow_path
from baselines.protocol import Budget, Solution

Array = NDArray[np.float64]

# Of the attempts at a path after the first: pᵀ q against the barrier, which is 1 at a tenth of the
# range beside the middle, and the shares of `null_space` that they take in turn. With these most
# paths of a KUKA iiwa that one attempt loses are found by four; 1 or 10 instead of 3 change little.
PULL, SHARES = 3.0, (0.4, 2.0, 1.0)
PATH_SEED = 0
POSE_NUMBERS = 6  # joints that a pose takes; only what is beyond them is free to move


class FollowingSolver(CompiledQuerySolver[LmOptions]):
    """A solver that follows motions with the joints that it has to spare.

    A pose that a few steps from the last answer do not reach is answered as any other with that
    guess. So is every pose where the robot has no joints to spare, or the gain is 0.

    Attributes:
        null_space: Gain of the motion within the null space, `follow_kernel.find_null_motion`.
        max_jump: How far each joint may be from the last answer [rad or m]; None for any distance.
    """

    abilities: ClassVar[frozenset[str]] = frozenset({FOLLOW})
    null_space: float
    max_jump: float | None = None

    def follow_one(self, pose: ArrayLike, last: ArrayLike) -> tuple[Array, bool]:
        """See `Abilities.follow_one`."""
        answer = np.empty(self.robot.dof)
        if not (is_plain(pose, POSE_SHAPE) and is_plain(last, answer.shape)):
            return super().follow_one(pose, last)
        if self._next(pose, last, answer, self._options_now()) is None:
            return self.solve_one(pose, last)
        return answer, True

    def _follow_at_once(
        self, poses: ArrayLike, last: ArrayLike, budget: Budget | None
    ) -> Solution | None:
        """See `Abilities`: a few rows, each reached by a few steps."""
        if type(poses) is not np.ndarray or poses.ndim != 2 or not 0 < len(poses) <= FEW:
            return None
        if type(last) is not np.ndarray or last.ndim != 2 or len(last) != len(poses):
            return None
        if self._follow_query is None:
            return self._solve_at_once(poses, last, budget)
        options = self._options_now() if budget is None else self._options_of(budget)
        answers, outcomes = np.empty((len(poses), self.robot.dof)), []
        for row, answer in enumerate(answers):
            pose, guess = poses[row], last[row]
            if not (is_plain(pose, POSE_SHAPE) and is_plain(guess, answer.shape)):
                return None
            outcome = self._next(pose, guess, answer, options)
            if outcome is None:
                return self._solve_at_once(poses, last, budget) if len(poses) == 1 else None
            outcomes.append(outcome)
        return solution_of(answers, outcomes)

    def _follow(self, poses: Array, last: Array, budget: Budget | None) -> Solution:
        options = self.options(None if budget is None else self._validated_budget(budget))
        answers = np.empty_like(last)
        outcomes, lost = [], []
        for row, pose in enumerate(poses):
            outcome = self._next(pose, last[row], answers[row], options)
            outcomes.append(outcome or (FOUND, 0, 0, 0))
            if outcome is None:
                lost.append(row)
        solution = solution_of(answers, outcomes)
        if not lost:
            return solution
        searched = self.solve(poses[lost], last[lost], budget)
        reasons = np.array(solution.reason, dtype=object)
        reasons[lost] = searched.reason
        for name in ("joints", "found", "time_s", "iterations"):
            getattr(solution, name)[lost] = getattr(searched, name)
        return replace(solution, reason=tuple(reasons.tolist()))

    def _follow_path(
        self, poses: Array, start: Array, max_jump: float, attempts: int
    ) -> FollowedPath:
        robot = self.robot
        gain = self.null_space if robot.dof > POSE_NUMBERS else 0.0
        most = attempts if gain > 0.0 else 1
        half = np.where(robot.endless, np.pi, (robot.upper - robot.lower) / 2)
        pulls = np.random.default_rng(PATH_SEED).normal(size=(most, robot.dof))
        pulls *= PULL / np.where(half > 0.0, half, np.inf)
        gains = gain * np.resize(SHARES, most)
        pulls[0], gains[0] = 0.0, gain
        joints = np.full((len(poses), robot.dof), np.nan)
        bound = joint_range(robot), robot.chain, pulls, gains, max_jump
        reached, tried = follow_path(poses, start[None], joints, self._options_now(), *bound)
        return FollowedPath(joints, int(reached), int(tried))

    def _next(
        self, pose: Array, last: Array, answer: Array, options: LmOptions
    ) -> tuple[int, int, int, int] | None:
        """Follow to one pose; None where the pose is to be solved as any other."""
        query = self._follow_query
        if query is None:
            return None
        outcome: tuple[int, int, int, int] = query(pose, last[None], answer, options)
        return outcome if outcome[0] == FOUND else None

    @cached_property
    def _follow_query(self) -> BoundKernel | None:
        """The compiled query, as soon as it is needed; None where no joint is to spare."""
        robot = self.robot
        if self.null_space == 0.0 or robot.dof <= POSE_NUMBERS:
            return None
        query = np.empty(7), np.empty((1, robot.dof)), np.empty(robot.dof), self.options(None)
        bound = joint_range(robot), robot.chain, self.null_space, self.max_jump
        return BoundKernel(follow_query, query, bound)
