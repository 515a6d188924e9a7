"""The CycleIK multi-layer perceptron: pose in, joint angles out, both normalised to [-1, 1]."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from pipeline.settings import ModelConfig
from robots import Robot

POSE_SIZE = 7


class CycleIkMlp(nn.Module):
    """Fully connected network of the paper (figure 1): GELU layers, then tanh layers.

    The normalisation belongs to the network, so that a user hands over poses in metres and takes
    joint angles in radians: positions are scaled from the robot's workspace box to [-1, 1],
    quaternions are in [-1, 1] by nature, and the tanh output is scaled to the joint limits, which
    are thereby kept by construction.

    Args:
        robot: Gives the workspace box (2, 3) in metres and the joint limits (dof,).
        model: Neurons of each hidden layer and the number of tanh layers, output included.
    """

    def __init__(self, robot: Robot, model: ModelConfig) -> None:
        super().__init__()
        sizes = [POSE_SIZE, *model.hidden, robot.dof]
        self.layers = nn.ModuleList(
            nn.Linear(inputs, outputs)
            for inputs, outputs in zip(sizes[:-1], sizes[1:], strict=True)
        )
        for layer in self.layers:
            nn.init.xavier_normal_(layer.weight)
        self.tanh_layers = model.tanh_layers
        low, high = torch.as_tensor(robot.workspace, dtype=torch.float32)
        lower, upper = (
            torch.as_tensor(limit, dtype=torch.float32) for limit in (robot.lower, robot.upper)
        )
        self.register_buffer("position_centre", (low + high) / 2)
        self.register_buffer("position_scale", (high - low) / 2)
        self.register_buffer("joint_centre", (lower + upper) / 2)
        self.register_buffer("joint_scale", (upper - lower) / 2)

    def forward(self, poses: Tensor) -> Tensor:
        """Return joint values (N, dof) in radians or metres for poses (N, 7), scalar first."""
        position = (poses[:, :3] - self.position_centre) / self.position_scale
        values = torch.cat((position, poses[:, 3:]), dim=1)
        first_tanh = len(self.layers) - self.tanh_layers
        for index, layer in enumerate(self.layers):
            values = layer(values)
            values = nn.functional.gelu(values) if index < first_tanh else torch.tanh(values)
        return self.joint_centre + self.joint_scale * values


def parameter_count(network: nn.Module) -> int:
    """Return the number of trained parameters: weights and biases."""
    return sum(parameter.numel() for parameter in network.parameters())
