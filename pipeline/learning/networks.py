"""Networks that map poses to joints, normalised inside: metres and radians in and out."""

from __future__ import annotations

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import gelu

from pipeline.learning.rotation import matrix_from_quaternion
from pipeline.settings import ModelConfig
from robots import Robot

POSE_SIZE = 7
MATRIX_POSE_SIZE = 12


class IkNetwork(nn.Module):
    """A network with K hypotheses for each pose, and the scaling between robot and network.

    Positions are scaled from the robot's workspace box to [-1, 1], rotations are in [-1, 1] by
    nature, and a tanh output is scaled to the joint limits, which are thereby kept by construction.

    Args:
        robot: Gives the workspace box (2, 3) in metres and the joint limits (dof,).
        heads: Number of hypotheses K.
    """

    position_centre: Tensor
    position_scale: Tensor
    joint_centre: Tensor
    joint_scale: Tensor

    def __init__(self, robot: Robot, heads: int) -> None:
        super().__init__()
        self.heads, self.dof = heads, robot.dof
        low, high = torch.as_tensor(robot.workspace, dtype=torch.float32)
        lower, upper = (
            torch.as_tensor(limit, dtype=torch.float32) for limit in (robot.lower, robot.upper)
        )
        self.register_buffer("position_centre", (low + high) / 2)
        self.register_buffer("position_scale", (high - low) / 2)
        self.register_buffer("joint_centre", (lower + upper) / 2)
        self.register_buffer("joint_scale", (upper - lower) / 2)

    def forward(self, poses: Tensor) -> Tensor:
        """Return joint values (N, K, dof) in rad or m for poses (N, 7), scalar first."""
        position = (poses[:, :3] - self.position_centre) / self.position_scale
        output = self.normalised(position, poses[:, 3:]).unflatten(1, (self.heads, self.dof))
        return self.joint_centre + self.joint_scale * output

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """Return (N, K dof) in [-1, 1] for scaled positions (N, 3) and quaternions (N, 4)."""
        raise NotImplementedError


class CycleIkMlp(IkNetwork):
    """The network of the paper (figure 1): fully connected, GELU layers, then tanh layers.

    Args:
        robot: The robot.
        model: Neurons of each hidden layer and the number of tanh layers, output included.
    """

    def __init__(self, robot: Robot, model: ModelConfig) -> None:
        super().__init__(robot, heads=1)
        sizes = [POSE_SIZE, *model.hidden, robot.dof]
        layers = [nn.Linear(inputs, outputs) for inputs, outputs in pairwise(sizes)]
        for layer in layers:
            nn.init.xavier_normal_(layer.weight)
        self.layers = nn.ModuleList(layers)
        self.first_tanh = len(self.layers) - model.tanh_layers

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """See `IkNetwork.normalised`."""
        values = torch.cat((position, quaternion), dim=1)
        for index, layer in enumerate(self.layers):
            values = layer(values)
            values = gelu(values) if index < self.first_tanh else torch.tanh(values)
        return values


class ResidualHeads(IkNetwork):
    """Our compact network: residual blocks and several output heads.

    Inverse kinematics has several answers and a network with one output averages between their
    branches. Each head may settle on a branch of its own, and forward kinematics tells which head
    is right for a pose. The rotation enters as a matrix, which has no double cover.

    Args:
        robot: The robot.
        model: Width of the residual stream, neurons of each block's hidden layer, heads.
    """

    def __init__(self, robot: Robot, model: ModelConfig) -> None:
        super().__init__(robot, heads=model.heads)
        self.entry = nn.Linear(MATRIX_POSE_SIZE, model.width)
        self.blocks = nn.ModuleList(
            nn.Sequential(
                nn.LayerNorm(model.width),
                nn.Linear(model.width, neurons),
                nn.GELU(approximate="tanh"),
                nn.Linear(neurons, model.width),
            )
            for neurons in model.hidden
        )
        self.norm = nn.LayerNorm(model.width)
        self.exit = nn.Linear(model.width, model.heads * robot.dof)

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """See `IkNetwork.normalised`."""
        rotation = matrix_from_quaternion(quaternion).flatten(1)
        values = self.entry(torch.cat((position, rotation), dim=1))
        for block in self.blocks:
            values = values + block(values)
        return torch.tanh(self.exit(self.norm(values)))


def build_network(robot: Robot, model: ModelConfig) -> IkNetwork:
    """Return the network that ``model.kind`` names, with fresh weights."""
    kinds = {"mlp": CycleIkMlp, "residual": ResidualHeads}
    return kinds[model.kind](robot, model)


def parameter_count(network: nn.Module) -> int:
    """Return the number of trained parameters: weights and biases."""
    return sum(parameter.numel() for parameter in network.parameters())
