"""A conditional generative adversarial network over the joints that reach a pose.

Lembono, Pignat, Jankowski and Calinon, *Learning Constrained Distributions of Robot Configurations
with Generative Adversarial Network*, IEEE RA-L 6(2), 2021. Noise and pose go into one of several
generators; a discriminator tells their configurations from those of the training set.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.func import functional_call

from pipeline.learning.gan.config import GanModel
from pipeline.learning.networks import MATRIX_POSE_SIZE, SamplingNetwork, perceptron
from robots import Robot


class Gan(SamplingNetwork):
    """Generators, of which a draw picks one at random, and the discriminator of all of them.

    Args:
        robot: The robot.
        model: Neurons of generators (`hidden`) and discriminator, generators, size of the noise.
    """

    def __init__(self, robot: Robot, model: GanModel) -> None:
        super().__init__(robot, normals=model.noise, choices=1)
        self.adversarial_weight = model.adversarial_weight
        self.limit_weight = model.limit_weight
        sizes = [MATRIX_POSE_SIZE + model.noise, *model.hidden, robot.dof]
        self.generators = nn.ModuleList(
            perceptron(sizes, nn.LeakyReLU) for _ in range(model.generators)
        )
        judged = [MATRIX_POSE_SIZE + robot.dof, *model.discriminator, 1]
        self.discriminator = perceptron(judged, nn.LeakyReLU)

    def generated(self, poses: Tensor, latents: Tensor) -> Tensor:
        """Return scaled joints (N, K, dof), limits at -1 and 1, which they may exceed.

        Args:
            poses: (N, 7) metres and unit quaternions, scalar first.
            latents: (N or 1, K, normals + 1), see `SamplingNetwork.latents`.
        """
        count = latents.shape[1]
        latents = latents.to(poses.device).expand(len(poses), -1, -1)
        noise, choice = latents.flatten(0, 1).split((self.normals, 1), dim=1)
        described = self.described(poses).repeat_interleave(count, dim=0)
        inputs = torch.cat((described, noise), dim=1)
        picked = (choice[:, 0] * len(self.generators)).long()
        unit = inputs.new_zeros(len(inputs), self.dof)
        for index, generator in enumerate(self.generators):
            rows = (picked == index).nonzero().squeeze(1)
            unit = unit.index_copy(0, rows, generator(inputs[rows]))
        return unit.unflatten(0, (len(poses), count))

    def draws(self, poses: Tensor, latents: Tensor) -> Tensor:
        """See `SamplingNetwork.draws`."""
        return self.inside(self.generated(poses, latents))

    def judged(self, poses: Tensor, unit: Tensor, frozen: bool) -> Tensor:
        """Return logits (N,): positive for joints that look like those of the training set.

        Args:
            poses: (N, 7) that the joints are for.
            unit: (N, dof) scaled joints.
            frozen: Whether the discriminator is a constant: gradients reach the joints alone.
        """
        inputs = torch.cat((self.described(poses), unit), dim=1)
        parameters = self.discriminator.named_parameters()
        weights: dict[str, Tensor] = {
            name: weight.detach() if frozen else weight for name, weight in parameters
        }
        logits: Tensor = functional_call(self.discriminator, weights, (inputs,))
        return logits.squeeze(1)
