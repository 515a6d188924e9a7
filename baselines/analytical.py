"""What analytical solvers share: a library proposes configurations, the best inside is taken."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.checks import positive_settings
from baselines.protocol import NO_SOLUTION, Answer, Clock, QuerySolver
from baselines.transforms import pose_matrix

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


class AnalyticalSolver(QuerySolver):
    """A closed-form solver: no iterations, no budget; the nearest to the initial guess is taken.

    Args:
        robot: The robot to solve for.
        limit_tolerance: How far outside a limit a joint may be and still be moved onto it
            [rad or m].
        matrix_tolerance: Largest difference of an entry of the reached (4, 4) tip transform from
            the target's that is claimed as a solution.
    """

    budgets: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, robot: Robot, *, limit_tolerance: float, matrix_tolerance: float) -> None:
        super().__init__(robot)
        tolerances = positive_settings(
            {"limit_tolerance": limit_tolerance, "matrix_tolerance": matrix_tolerance}
        )
        self.limit_tolerance, self.matrix_tolerance = tolerances.values()
        # Three entries make a distance; nine make a rotation's chord, 2 sqrt(2) sin(angle / 2).
        chord = min(3.0 * self.matrix_tolerance / math.sqrt(8.0), 1.0)
        self.tolerances = (math.sqrt(3.0) * self.matrix_tolerance, 2.0 * math.asin(chord))

    @abstractmethod
    def _candidates(self, target: Array, initial: Array) -> Array:
        """Configurations (K, dof) for a tip transform (4, 4), in any order; K may be 0."""

    def _solve_one(self, pose: Array, initial: Array, clock: Clock) -> Answer:
        target = pose_matrix(pose)
        candidates = self._candidates(target, initial)
        slack = self.limit_tolerance
        with np.errstate(invalid="ignore"):
            inside = (candidates >= self.lower - slack) & (candidates <= self.upper + slack)
        candidates = np.clip(candidates[inside.all(axis=1)], self.lower, self.upper)
        nearest = np.argsort(np.abs(candidates - initial).max(axis=1, initial=0.0))
        for row in nearest:
            # Libraries now and then return a wrong branch at a singularity.
            reached = pose_matrix(self.robot.forward_kinematics(candidates[row][None])[0])
            if np.abs(reached - target).max() <= self.matrix_tolerance:
                return Answer(candidates[row], "")
        return Answer(initial, NO_SOLUTION)
