"""Networks that map poses to joints, normalised inside: metres and radians in and out."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import gelu

from pipeline.learning.config import ModelConfig
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
        output = self.normalised(self.scaled(poses), poses[:, 3:])
        return self.joint_centre + self.joint_scale * output.unflatten(1, (self.heads, self.dof))

    def scaled(self, poses: Tensor) -> Tensor:
        """Return the positions (N, 3) of poses (N, 7), from the workspace box to [-1, 1]."""
        return (poses[:, :3] - self.position_centre) / self.position_scale

    def prepare(self, poses: Tensor) -> None:
        """Look at the training poses (N, 7) before the first step; most networks need not."""

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


def build_network(robot: Robot, model: ModelConfig) -> IkNetwork:
    """Return the network that ``model.kind`` names, with fresh weights."""
    # These build on this module.
    from pipeline.learning.experts import Experts
    from pipeline.learning.flow import FlowNetwork
    from pipeline.learning.null_space import NullSpaceMlp, NullSpaceResidual

    kinds: dict[str, Callable[[Robot, ModelConfig], IkNetwork]] = {
        "mlp": CycleIkMlp,
        "experts": Experts,
        "null_space": NullSpaceResidual,
        "null_space_mlp": NullSpaceMlp,
        "flow": FlowNetwork,
    }
    return kinds[model.kind](robot, model)


def parameter_count(network: nn.Module) -> int:
    """Return the number of trained parameters: weights and biases."""
    return sum(parameter.numel() for parameter in network.parameters())
