"""Solvers that draw from a normalizing flow, with and without refinement of the draws."""

from __future__ import annotations

import time
from typing import Any, ClassVar

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

import baselines
from baselines import Budget, Solution
from baselines.checks import check_initial, check_poses
from baselines.lm import LevenbergMarquardt
from baselines.refine import refine
from pipeline.learning.flow import FlowNetwork, draw_latents
from pipeline.learning.solver import CycleIk, torch_threads
from robots import Robot

ROWS = 16384  # draws a pass of the network


class FlowIk(CycleIk):
    """The best of many draws of each pose; `sample` gives all of them.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        samples: Draws for each pose.
        latent_scale: Scale of the normal numbers that draws start from. Below 1 the draws keep
            closer to the likeliest solutions of each component.
        seed: Of the draws. All poses share their random numbers, so that an answer does not depend
            on the poses beside it.
        **settings: Tolerances and threads, see `CycleIk`.
    """

    kinds: ClassVar[tuple[str, ...]] = ("flow",)
    default_model: ClassVar[str] = "flow"
    requires: ClassVar[tuple[str, ...]] = ("torch", "zuko")
    network: FlowNetwork

    def __init__(
        self,
        robot: Robot,
        weights: str,
        samples: int,
        latent_scale: float,
        seed: int,
        **settings: Any,
    ) -> None:
        super().__init__(robot, weights, **settings)
        if samples < 1:
            raise baselines.SettingError(f"flow: expected samples >= 1, got {samples}")
        if not latent_scale >= 0:
            raise baselines.SettingError(f"flow: expected latent_scale >= 0, got {latent_scale}")
        self.samples, self.latent_scale, self.seed = samples, latent_scale, seed

    def sample(self, poses: ArrayLike, count: int, seed: int) -> NDArray[np.float64]:
        """Draw solutions.

        Args:
            poses: (N, 7) or one pose (7,), x y z in m, then unit qw qx qy qz.
            count: Draws K for each pose.
            seed: Of the draws; all poses share their random numbers.

        Returns:
            (N, K, dof), or (K, dof) for one pose: joints [rad or m] inside the limits, in no order.

        Raises:
            PoseError: Poses of wrong shape, not finite or with a quaternion that is not unit.
        """
        array = np.asarray(poses, dtype=np.float64)
        drawn = self._draws(check_poses(np.atleast_2d(array)), count, seed)
        return drawn[0] if array.ndim == 1 else drawn

    def _answers(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._draws(poses, self.samples, self.seed)

    def _draws(self, poses: NDArray[np.float64], count: int, seed: int) -> NDArray[np.float64]:
        latents = draw_latents(1, count, self.robot.dof, seed)
        latents = latents._replace(normal=latents.normal * self.latent_scale)
        drawn = np.empty((len(poses), count, self.robot.dof))
        step = max(1, ROWS // count)
        with torch_threads(self.threads), torch.inference_mode():
            for start in range(0, len(poses), step):
                rows = slice(start, start + step)
                targets = torch.as_tensor(poses[rows], dtype=torch.float32)
                drawn[rows] = self.network.draws(targets, latents).numpy()
        return np.clip(drawn, self.lower, self.upper)


class FlowIkRefined(FlowIk):
    """The best draws first, each refined to the tolerances of `lm`, then random restarts.

    An initial guess that is given comes before the draws, so that a motion stays on its branch.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        hypotheses: Draws tried before random configurations.
        threads: Threads of the network and of the kernel; 0 leaves torch as it is, and takes all of
            numba's.
        time_s: Wall-clock budget per pose of the refinement where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
        **settings: Draws and tolerances, see `FlowIk`.
    """

    budgets: ClassVar[frozenset[str]] = frozenset({"time_s", "iterations"})
    always_answers = False  # what is not refined to the tolerances is not found

    def __init__(
        self,
        robot: Robot,
        weights: str,
        hypotheses: int,
        threads: int,
        time_s: float | None,
        iterations: int | None,
        **settings: Any,
    ) -> None:
        super().__init__(robot, weights, threads=threads, **settings)
        self.tried = hypotheses
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
        start = time.perf_counter()
        seeds = self.hypotheses(targets).joints[:, : self.tried]
        if initial is not None:
            home = np.asarray(self.robot.home)
            first = check_initial(initial, len(targets), home, self.lower, self.upper)
            seeds = np.concatenate((first[:, None], seeds), axis=1)
        drawing_s = (time.perf_counter() - start) / len(targets)
        refined = refine(self.robot, targets, seeds, self.kernel.options(chosen), self.threads)
        refined.time_s[:] += drawing_s
        return refined.solution()
