"""The solver that samples from a null-space generator."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import torch
from torch import Tensor

from pipeline.learning.null_space import METHOD
from pipeline.learning.null_space.network import NullSpaceGenerator
from pipeline.learning.solver import SamplingSolver
from robots import Robot


class NullSpaceIk(SamplingSolver):
    """The first of the solutions that `sample` gives for each pose.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        **settings: Seed, tolerances and threads, see `SamplingSolver`.
    """

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
    network: NullSpaceGenerator

    def __init__(self, robot: Robot, weights: str, **settings: Any) -> None:
        super().__init__(robot, weights, samples=1, **settings)

    def _sampler(self, count: int, seed: int) -> Callable[[Tensor], Tensor]:
        generator = torch.Generator().manual_seed(seed)
        noise = torch.rand(count, self.robot.dof, generator=generator)

        def sampler(poses: Tensor) -> Tensor:
            targets = poses.repeat_interleave(count, dim=0)
            answers = self.network.answers(targets, noise.repeat(len(poses), 1))
            return answers.unflatten(0, (len(poses), count))

        return sampler
