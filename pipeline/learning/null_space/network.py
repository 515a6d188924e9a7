"""Null-space generators: pose and noise in, joints out, another solution for another noise."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from pipeline.learning.config import ModelConfig
from pipeline.learning.networks import (
    MATRIX_POSE_SIZE,
    POSE_SIZE,
    GeluTanhLayers,
    IkNetwork,
    ResidualBlocks,
    matrix_pose,
)
from robots import Robot


class NullSpaceGenerator(IkNetwork):
    """A network that draws solutions of a pose (section III of the paper, before III-A).

    The paper calls its method a "generative adversarial network"; its authors' code has no
    discriminator and neither has this: a generator, the loss of the cycle, a pull on the variance.

    The noise has as many values as the robot has joints and is uniform in [0, 1).

    Args:
        robot: The robot.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot, heads=1)

    def forward(self, poses: Tensor) -> Tensor:
        """Return the joints (N, 1, dof) that the middle of the noise stands for."""
        return self.answers(poses, poses.new_full((len(poses), self.dof), 0.5)).unsqueeze(1)

    def answers(self, poses: Tensor, noise: Tensor) -> Tensor:
        """Return joints (N, dof) in rad or m for poses (N, 7) and noise (N, dof)."""
        output = self.generated(self.scaled(poses), poses[:, 3:], noise)
        return self.joint_centre + self.joint_scale * output

    def generated(self, position: Tensor, quaternion: Tensor, noise: Tensor) -> Tensor:
        """Return (N, dof) in [-1, 1] for scaled positions (N, 3), quaternions, and noise."""
        raise NotImplementedError


class NullSpaceMlp(NullSpaceGenerator):
    """The generator of the paper: the layers of its CycleIK network with the noise joined on.

    Args:
        robot: The robot.
        model: Neurons of each hidden layer and the number of tanh layers, output included.
    """

    def __init__(self, robot: Robot, model: ModelConfig) -> None:
        super().__init__(robot)
        sizes = [POSE_SIZE + robot.dof, *model.hidden, robot.dof]
        self.layers = GeluTanhLayers(sizes, model.tanh_layers)

    def generated(self, position: Tensor, quaternion: Tensor, noise: Tensor) -> Tensor:
        """See `NullSpaceGenerator.generated`."""
        output: Tensor = self.layers(torch.cat((position, quaternion, noise), dim=1))
        return output


class NullSpaceResidual(NullSpaceGenerator):
    """Our generator: residual blocks, the rotation as a matrix, the noise scaled to [-1, 1].

    Args:
        robot: The robot.
        model: Width of the residual stream, neurons of each block's hidden layer.
    """

    def __init__(self, robot: Robot, model: ModelConfig) -> None:
        super().__init__(robot)
        self.entry = nn.Linear(MATRIX_POSE_SIZE + robot.dof, model.width)
        self.blocks = ResidualBlocks(model.width, model.hidden)
        self.norm = nn.LayerNorm(model.width)
        self.exit = nn.Linear(model.width, robot.dof)

    def generated(self, position: Tensor, quaternion: Tensor, noise: Tensor) -> Tensor:
        """See `NullSpaceGenerator.generated`."""
        pose = matrix_pose(position, quaternion)
        values = self.blocks(self.entry(torch.cat((pose, 2 * noise - 1), dim=1)))
        return torch.tanh(self.exit(self.norm(values)))
