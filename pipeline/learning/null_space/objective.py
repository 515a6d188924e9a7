"""What a null-space generator is trained for: its answers reach the pose, and they vary."""

from __future__ import annotations

import torch
from torch import Tensor

from pipeline.learning.config import TrainConfig
from pipeline.learning.constraints import make_penalty
from pipeline.learning.kinematics import make_kinematics
from pipeline.learning.losses import PoseLoss, tip_errors
from pipeline.learning.null_space.network import NullSpaceGenerator
from pipeline.learning.objective import ERRORS_BATCH
from pipeline.seeding import derive_seed
from robots import Robot

UNIFORM_VARIANCE = 1 / 12  # of a number that is uniform in [0, 1)


class NullSpaceObjective:
    """Cycle losses of several answers to each pose, and a pull of their variance.

    The variance of the answers to one pose is pulled to that of the noise, so that the noise is not
    ignored (rad², or m² of a sliding joint): in the paper the mean over the joints, which two of
    them can bear alone, or that of each joint.

    Args:
        robot: Gives forward kinematics.
        network: The generator.
        train: Losses, weights, answers a pose.
        device: Where batches lie.
        seed: Root of the noise: that of a step follows from it and the step.
    """

    def __init__(
        self,
        robot: Robot,
        network: NullSpaceGenerator,
        train: TrainConfig,
        device: torch.device,
        seed: int,
    ) -> None:
        self.network, self.train, self.seed = network, train, seed
        self.kinematics = make_kinematics(robot, train.kinematics, device)
        self.pose_loss = PoseLoss(train)
        self.penalty = make_penalty(robot, train, device)

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`."""
        samples = self.train.variance_samples
        targets = poses.repeat_interleave(samples, dim=0)
        answers = self.network.answers(targets, self._noise(targets, "step", step))
        losses = self.pose_loss(*self.kinematics(answers), targets)
        if self.penalty is not None:
            losses = losses + self.penalty(answers)
        each = self.train.variance_of == "each"
        spread = variance_loss(answers.unflatten(0, (len(poses), samples)), each)
        return losses.mean() + self.train.variance_weight * spread

    @torch.no_grad()
    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return errors (N,) in mm and deg of one answer to each of poses (N, 7)."""
        noise = self._noise(poses, "errors", 0)
        parts = zip(poses.split(ERRORS_BATCH), noise.split(ERRORS_BATCH), strict=True)
        answers = [self.network.answers(*part) for part in parts]
        return tip_errors(self.kinematics(torch.cat(answers)), poses)

    def _noise(self, poses: Tensor, use: str, step: int) -> Tensor:
        """Noise (N, dof) for poses (N, 7), drawn on the CPU: the same on every device."""
        generator = torch.Generator().manual_seed(derive_seed(self.seed, use, step))
        return torch.rand(len(poses), self.network.dof, generator=generator).to(poses.device)


def variance_loss(answers: Tensor, each: bool) -> Tensor:
    """Return how far answers (N, S, dof) are from the variance of the noise, mean over poses.

    Args:
        answers: S answers to each of N poses, rad or m.
        each: Whether the variance of each joint counts, or the mean of them, as in the paper.
    """
    variance = answers.var(dim=1)
    if not each:
        variance = variance.mean(dim=1)
    return (variance - UNIFORM_VARIANCE).abs().mean()
