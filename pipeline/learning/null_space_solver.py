"""The solver that draws from a null-space generator: as many solutions of a pose as are wanted."""

from __future__ import annotations

import time
from typing import Any, ClassVar

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

import baselines
from baselines import Budget, Solution
from baselines.checks import check_poses
from baselines.lm import LevenbergMarquardt
from baselines.refine import refine
from pipeline.learning.null_space import NullSpaceGenerator
from pipeline.learning.solver import CycleIk, torch_threads
from robots import Robot

ROWS = 16384  # answers a pass of the network


class NullSpaceIk(CycleIk):
    """The first of the solutions that `sample` draws for each pose.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        seed: Of the noise. All poses share it, so that an answer does not depend on the poses
            beside it.
        refined: Whether the answer is refined to the tolerances of `lm`.
        **settings: Tolerances and threads, see `CycleIk`.
    """

    kinds: ClassVar[tuple[str, ...]] = ("null_space", "null_space_mlp")
    default_model: ClassVar[str] = "null_space"
    network: NullSpaceGenerator

    def __init__(
        self, robot: Robot, weights: str, seed: int, refined: bool, **settings: Any
    ) -> None:
        super().__init__(robot, weights, **settings)
        self.seed, self.refined = seed, refined
        kernel = baselines.load("lm", robot)
        assert isinstance(kernel, LevenbergMarquardt)
        self.kernel = kernel

    def sample(self, poses: ArrayLike, count: int, seed: int) -> NDArray[np.float64]:
        """Draw solutions.

        Args:
            poses: (N, 7) or one pose (7,), x y z in m, then unit qw qx qy qz.
            count: Solutions K of each pose.
            seed: Of the noise, which all poses share.

        Returns:
            (N, K, dof), or (K, dof) for one pose: joints [rad or m] inside the limits, not refined.

        Raises:
            PoseError: Poses of wrong shape, not finite or with a quaternion that is not unit.
        """
        array = np.asarray(poses, dtype=np.float64)
        drawn = self._draws(check_poses(np.atleast_2d(array)), count, seed)
        return drawn[0] if array.ndim == 1 else drawn

    def _answers(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._draws(poses, 1, self.seed)

    def _draws(self, poses: NDArray[np.float64], count: int, seed: int) -> NDArray[np.float64]:
        generator = torch.Generator().manual_seed(seed)
        noise = torch.rand(count, self.robot.dof, generator=generator)
        drawn = np.empty((len(poses), count, self.robot.dof))
        step = max(1, ROWS // count)
        with torch_threads(self.threads), torch.inference_mode():
            for start in range(0, len(poses), step):
                part = torch.as_tensor(poses[start : start + step], dtype=torch.float32)
                targets = part.repeat_interleave(count, dim=0)
                answers = self.network.answers(targets, noise.repeat(len(part), 1))
                drawn[start : start + step] = answers.unflatten(0, (len(part), count)).numpy()
        return np.clip(drawn, self.lower, self.upper)

    def _solve_batch(
        self, poses: NDArray[np.float64], initial: NDArray[np.float64], budget: Budget | None
    ) -> Solution:
        if not self.refined:
            return super()._solve_batch(poses, initial, budget)
        start = time.perf_counter()
        seeds = self._answers(poses)
        drawing_s = (time.perf_counter() - start) / len(poses)
        refined = refine(self.robot, poses, seeds, self.kernel.options(budget))
        refined.time_s[:] += drawing_s
        return refined.solution()
