"""What a trainer needs of an objective, and what a step captured as a CUDA graph needs."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import torch
from torch import Tensor

from pipeline.learning.config import TrainConfig
from pipeline.learning.kinematics import make_kinematics
from pipeline.learning.losses import PoseLoss, tip_errors
from pipeline.learning.networks import SamplingNetwork
from pipeline.seeding import derive_seed
from robots import Robot

ERRORS_BATCH = 4096  # poses of a forward pass when errors are measured


class Objective(Protocol):
    """What the trainer minimises. Noise, if any, follows from a seed and the step alone.

    Made of robot, network, `TrainConfig`, device and seed.
    """

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """Return the scalar loss of a batch.

        Args:
            poses: (N, 7) targets, metres and unit quaternions, scalar first.
            joints: (N, dof) rad or m, the joints that the poses were made from.
            step: Steps done so far.
            done: The same as a share of the run, in [0, 1).
        """

    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return errors (N,) in mm and deg of a solver's answers to poses (N, 7)."""


@runtime_checkable
class CapturableObjective(Protocol):
    """An objective whose loss is a function of tensors alone, for networks of one shape."""

    def network_input(self, poses: Tensor, step: int) -> Tensor:
        """Return what the network sees of poses (N, 7) in a step."""

    def loss_of(self, network_input: Tensor, poses: Tensor) -> Tensor:
        """Return the scalar loss of what the network sees (N, 7) against poses (N, 7)."""


class SamplingObjective:
    """What objectives of networks that draw solutions have in common: noise, and errors of draws.

    Args:
        robot: Gives forward kinematics.
        network: The network, on the device.
        train: Names the kinematics, and losses with their weights, which some objectives use.
        device: Where batches lie.
        seed: Root of the noise: that of a step follows from it and the step.
    """

    def __init__(
        self,
        robot: Robot,
        network: SamplingNetwork,
        train: TrainConfig,
        device: torch.device,
        seed: int,
    ) -> None:
        self.network: SamplingNetwork = network
        self.seed = seed
        self.pose_loss = PoseLoss(train)
        self.kinematics = make_kinematics(robot, train.kinematics, device)

    def latents(self, poses: Tensor, count: int, step: int) -> Tensor:
        """Return the latents (N, count, L) of a step's draws of poses (N, 7)."""
        seed = derive_seed(self.seed, "draws", step)
        return self.network.latents(len(poses), count, seed)

    def generator(self, step: int) -> torch.Generator:
        """Return the generator, on the CPU, of a step's further noise."""
        return torch.Generator().manual_seed(derive_seed(self.seed, "step", step))

    @torch.no_grad()
    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return errors (N,) in mm and deg of one draw for each of poses (N, 7).

        Their mean is that over draws, not of the best one.
        """
        latents = self.network.latents(len(poses), 1, derive_seed(self.seed, "errors"))
        parts = zip(poses.split(ERRORS_BATCH), latents.split(ERRORS_BATCH), strict=True)
        answers = torch.cat([self.network.draws(*part) for part in parts])
        return tip_errors(self.kinematics(answers.flatten(0, 1)), poses)
