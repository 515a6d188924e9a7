"""What generators and discriminator are trained for, in one step of one optimiser."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import softplus

from pipeline.learning.gan.network import Gan
from pipeline.learning.objective import SamplingObjective


class GanObjective(SamplingObjective):
    """The game of Goodfellow et al. (NeurIPS 2014) with losses of pose and joint limits.

    The sum of both players' losses is returned. Each term's gradient reaches one player alone: the
    discriminator is a constant for the generators and their joints are constants for it, so both
    descend on their own loss at the same time.
    """

    network: Gan

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`."""
        unit = self.network.generated(poses, self.latents(poses, 1, step)).squeeze(1)
        real = self.network.unit(joints)
        return self.generator_loss(poses, unit) + self.discriminator_loss(poses, real, unit)

    def generator_loss(self, poses: Tensor, unit: Tensor) -> Tensor:
        """Return the loss of generators for scaled joints (N, dof) and poses (N, 7).

        The tip shall reach the pose, no joint leave its limits, and the discriminator be deceived
        (the non-saturating form).
        """
        network = self.network
        joints = network.joint_centre + network.joint_scale * unit
        reached = self.pose_loss(*self.kinematics(joints), poses).mean()
        outside = torch.relu(unit.abs() - 1).square().mean()
        found_out = softplus(-network.judged(poses, unit, frozen=True)).mean()
        return reached + network.limit_weight * outside + network.adversarial_weight * found_out

    def discriminator_loss(self, poses: Tensor, real: Tensor, generated: Tensor) -> Tensor:
        """Return the cross-entropy of telling real from generated scaled joints (N, dof)."""
        missed = softplus(-self.network.judged(poses, real, frozen=False))
        deceived = softplus(self.network.judged(poses, generated.detach(), frozen=False))
        return missed.mean() + deceived.mean()
