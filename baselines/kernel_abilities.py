"""Abilities of the solvers that descend by the kernel of `lm`; they differ in where they start."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from itertools import chain, islice
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.abilities import EXPLAIN, MANY, PARTIAL, Abilities
from baselines.distinct import distinct, nearest_first
from baselines.explanation import Explanation, explain
from baselines.lm_kernel import LmOptions
from baselines.refine import refine, refine_freely
from baselines.restarts import restart_configurations
from baselines.seed_library import SeedLibrary, empty_seed_library, nearest_remembered

if TYPE_CHECKING:
    from baselines.protocol import Budget, Solution

Array = NDArray[np.float64]

DESCENTS = 2048  # of a search for solutions of one pose, at most
ROUND = 256  # of them are started together


class KernelAbilities(Abilities):
    """Many solutions, poses in part and reasons, by descents from the solver's own starts."""

    abilities: ClassVar[frozenset[str]] = frozenset({MANY, PARTIAL, EXPLAIN})

    @abstractmethod
    def options(self, budget: Budget | None) -> LmOptions:
        """The kernel's options under a budget."""

    def seed_memory(self) -> SeedLibrary:
        """What is descended from after the first seeds: nothing, where a subclass has nothing."""
        return empty_seed_library(self.robot.dof)

    @abstractmethod
    def first_seeds(self, poses: Array, initial: Array | None) -> Array:
        """Where descents start before random configurations.

        Args:
            poses: (N, 7) targets.
            initial: (N, dof) initial guesses, or None.

        Returns:
            (N, K, dof) [rad or m].
        """

    def _solve_all(self, pose: Array, count: int, apart: float, guess: Array | None) -> Array:
        robot = self.robot
        first = self.first_seeds(pose[None], None if guess is None else guess[None])[0]
        near = nearest_remembered(self.seed_memory(), pose)
        fresh = restart_configurations(pose, robot.chain.lower, robot.chain.upper)
        starts = chain(first, near, fresh)
        once = self.options(None)._replace(starts=1, time_ns=0)
        kept = np.empty((0, robot.dof))
        for _ in range(0, DESCENTS, ROUND):
            seeds = np.stack(list(islice(starts, ROUND)))
            met = refine(robot, np.tile(pose, (len(seeds), 1)), seeds[:, None], once)
            kept = distinct(robot, met.joints[met.found], apart, kept)
            if len(kept) >= count:
                break
        return nearest_first(robot, kept[:count], guess)

    def _solve_partial(
        self, poses: Array, widths: Array, initial: Array | None, budget: Budget | None
    ) -> Solution:
        seeds = self.first_seeds(poses, initial)
        bound = self.options(budget), self.seed_memory()
        refined = refine_freely(self.robot.chain, poses, seeds, widths, *bound)
        return replace(refined, joints=self.robot.nearest_turns(refined.joints)).solution()

    def _nearest_turns(self, solution: Solution, initial: ArrayLike | None) -> Solution:
        """See `Abilities`: without an initial guess the answers are as near as they can be."""
        return solution if initial is None else super()._nearest_turns(solution, initial)

    def _explain(self, pose: Array) -> Explanation:
        seeds = self.first_seeds(pose[None], None)
        return explain(self.robot, pose, seeds, self.options(None))
