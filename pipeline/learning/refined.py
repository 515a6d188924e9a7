"""Refined CycleIK: the network's hypotheses as seeds of the compiled Levenberg-Marquardt kernel."""

from __future__ import annotations

import time
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

import baselines
from baselines import Budget, Solution
from baselines.checks import check_initial, check_poses
from baselines.lm import LevenbergMarquardt
from baselines.refine import refine
from baselines.refine_torch import refine_place, refine_torch
from baselines.seed_library import build_seed_library
from pipeline.learning.solver import CycleIk
from robots import Robot

LIBRARY_SEED = 0  # one solver is one function of its settings


class CycleIkRefined(CycleIk):
    """The best hypotheses first, each refined to the tolerances of `lm`, then random restarts.

    An initial guess that is given comes before the hypotheses, so that a motion stays on its branch
    of solutions; without one the network's best hypothesis is the first seed.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        hypotheses: Hypotheses tried first.
        seed_library: Random configurations that are remembered with their poses; 0 for none.
        neighbours: Of these, the nearest that are tried next, before random configurations.
        device: Where the refinement runs: cpu is the compiled kernel, cuda its twin in torch, auto
            takes an accelerator where there is one.
        threads: Threads of the network and of the kernel; 0 leaves torch as it is, and takes all of
            numba's.
        time_s: Wall-clock budget per pose of the refinement where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
        **tolerances: Tolerances of the network, see `CycleIk`.
    """

    budgets: ClassVar[frozenset[str]] = frozenset({"time_s", "iterations"})
    always_answers = False  # what is not refined to the tolerances is not found

    def __init__(
        self,
        robot: Robot,
        weights: str,
        hypotheses: int,
        seed_library: int,
        neighbours: int,
        device: str,
        threads: int,
        time_s: float | None,
        iterations: int | None,
        **tolerances: Any,
    ) -> None:
        super().__init__(robot, weights, threads=threads, **tolerances)
        self.tried = hypotheses
        self.library = build_seed_library(robot, seed_library, neighbours, LIBRARY_SEED)
        place = refine_place(robot, device, "float64")
        self.accelerator = place if place.device.type == "cuda" else None
        kernel = baselines.load("lm", robot, time_s=time_s, iterations=iterations)
        assert isinstance(kernel, LevenbergMarquardt)
        self.kernel = kernel
        self.budget = kernel.budget

    def solve(
        self, poses: ArrayLike, initial: ArrayLike | None = None, budget: Budget | None = None
    ) -> Solution:
        """See `baselines.Solver.solve`."""
        targets = check_poses(poses)
        chosen = self.budget if budget is None else self._validated_budget(budget)
        if len(targets) == 0:
            return Solution.empty(0, self.robot.dof)
        if initial is None:
            return self._refined(targets, np.empty((len(targets), 0, self.robot.dof)), chosen)
        home = np.asarray(self.robot.home)
        first = check_initial(initial, len(targets), home, self.lower, self.upper)
        return self._refined(targets, first[:, None], chosen)

    def _refined(
        self, poses: NDArray[np.float64], first: NDArray[np.float64], budget: Budget | None
    ) -> Solution:
        start = time.perf_counter()
        answers = self.hypotheses(poses).joints[:, : self.tried]
        network_s = (time.perf_counter() - start) / len(poses)
        seeds = np.concatenate((first, answers), axis=1)
        options = self.kernel.options(budget)
        if self.accelerator is not None:
            refined = refine_torch(self.accelerator, poses, seeds, options, self.library)
        else:
            refined = refine(self.robot, poses, seeds, options, self.threads, self.library)
        refined.time_s[:] += network_s
        return refined.solution()
