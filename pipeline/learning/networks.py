"""Networks that map poses to joints, normalised inside: metres and radians in and out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import ClassVar

import torch
from torch import Tensor, nn
from torch.nn.functional import gelu

from pipeline.learning.rotation import matrix_from_quaternion
from robots import Robot

POSE_SIZE = 7
MATRIX_POSE_SIZE = 12
# Uniform joints, scaled from their limits to this, have the variance of normal numbers.
HALF_WIDTH = math.sqrt(3)


class IkNetwork(nn.Module):
    """A network with K hypotheses for each pose, and the scaling between robot and network.

    Positions are scaled from the robot's workspace box to [-1, 1], rotations are in [-1, 1] by
    nature, and a tanh output is scaled to the joint limits, which are thereby kept by construction.

    Args:
        robot: Gives the workspace box (2, 3) in metres and the joint limits (dof,).
        heads: Number of hypotheses K.

    Attributes:
        capturable: Whether every batch of one size goes through tensors of the same shapes and
            without a decision of the host, as a step that is captured as a CUDA graph needs.
        roundable: Whether hidden layers can be `rounded`.
        rounded: Whether they take bfloat16 factors and give bfloat16, see ``train.precision``. The
            last layer and all that is scaled stay float32.
    """

    capturable: ClassVar[bool] = False
    roundable: ClassVar[bool] = False
    rounded: bool = False
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
        # A weight is used once a pass, so that a cache of rounded ones would only be filled.
        with torch.autocast(
            poses.device.type, torch.bfloat16, enabled=self.rounded, cache_enabled=False
        ):
            output = self.normalised(self.scaled(poses), poses[:, 3:]).to(poses.dtype)
        return self.joint_centre + self.joint_scale * output.unflatten(1, (self.heads, self.dof))

    def scaled(self, poses: Tensor) -> Tensor:
        """Return the positions (N, 3) of poses (N, 7), from the workspace box to [-1, 1]."""
        return (poses[:, :3] - self.position_centre) / self.position_scale

    def prepare(self, poses: Tensor) -> None:
        """Look at the training poses (N, 7) before the first step; most networks need not."""

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """Return (N, K dof) in [-1, 1] for scaled positions (N, 3) and quaternions (N, 4)."""
        raise NotImplementedError


class SamplingNetwork(IkNetwork):
    """A network that draws solutions: what it draws is a function of the pose and of latents.

    Args:
        robot: The robot.
        normals: Latents of a draw that are standard normal.
        choices: Latents of a draw that are uniform in [0, 1), to pick one of several by.
    """

    def __init__(self, robot: Robot, normals: int, choices: int = 0) -> None:
        super().__init__(robot, heads=1)
        self.normals, self.choices = normals, choices

    def forward(self, poses: Tensor) -> Tensor:
        """Return joints (N, 1, dof) in rad or m: one draw of each of poses (N, 7), always it."""
        return self.draws(poses, self.latents(1, 1, seed=0))

    def latents(self, poses: int, count: int, seed: int, scale: float = 1.0) -> Tensor:
        """Return the latents of ``count`` draws of each of ``poses`` poses: a function of the seed.

        They are drawn on the CPU: the same for every device.

        Args:
            poses: Poses N; 1 for draws that all poses share.
            count: Draws K of each.
            seed: Of the numbers.
            scale: Standard deviation of the normal ones; the others stay as they are.

        Returns:
            (N, K, normals + choices), the normal ones first.
        """
        generator = torch.Generator().manual_seed(seed)
        choices = torch.rand(poses, count, self.choices, generator=generator)
        normals = torch.randn(poses, count, self.normals, generator=generator)
        return torch.cat((scale * normals, choices), dim=2)

    def draws(self, poses: Tensor, latents: Tensor) -> Tensor:
        """Return joints (N, K, dof) in rad or m, inside the limits, that should reach poses (N, 7).

        Args:
            poses: (N, 7) metres and unit quaternions, scalar first.
            latents: (N or 1, K, normals + choices), see `latents`.
        """
        raise NotImplementedError

    def described(self, poses: Tensor) -> Tensor:
        """Return poses (N, 7) as scaled positions and rotation matrices (N, 12)."""
        return matrix_pose(self.scaled(poses), poses[:, 3:])

    def unit(self, joints: Tensor) -> Tensor:
        """Return joints (..., dof) in rad or m, from their limits to [-1, 1]."""
        return (joints - self.joint_centre) / self.joint_scale

    def inside(self, unit: Tensor) -> Tensor:
        """Return joints (..., dof) in rad or m of scaled ones, clamped to the limits."""
        return self.joint_centre + self.joint_scale * unit.clamp(-1, 1)


class GeluTanhLayers(nn.ModuleList):
    """The layers of the paper's networks (figure 1): fully connected, GELU first and then tanh.

    Args:
        sizes: Values that go in, neurons of each hidden layer, values that come out.
        tanh_layers: Layers with tanh, counted from the output.
    """

    def __init__(self, sizes: Sequence[int], tanh_layers: int) -> None:
        layers = [nn.Linear(inputs, outputs) for inputs, outputs in pairwise(sizes)]
        for layer in layers:
            nn.init.xavier_normal_(layer.weight)
        super().__init__(layers)
        self.first_tanh = len(self) - tanh_layers

    def forward(self, values: Tensor) -> Tensor:
        """Return what comes out (N, outputs) of values (N, inputs)."""
        given = values.dtype
        *hidden, last = self
        for index, layer in enumerate(hidden):
            values = layer(values)
            values = gelu(values) if index < self.first_tanh else torch.tanh(values)
        with torch.autocast(values.device.type, enabled=False):  # two digits would be centimetres
            return torch.tanh(last(values.to(given)))


class ResidualBlocks(nn.ModuleList):
    """Residual blocks of one hidden layer each, normalised before it.

    Args:
        width: Of the residual stream.
        hidden: Neurons of the hidden layer of each block.
    """

    def __init__(self, width: int, hidden: Sequence[int]) -> None:
        super().__init__(
            nn.Sequential(
                nn.LayerNorm(width),
                nn.Linear(width, neurons),
                nn.GELU(approximate="tanh"),
                nn.Linear(neurons, width),
            )
            for neurons in hidden
        )

    def forward(self, values: Tensor) -> Tensor:
        """Return the stream (N, width) after the last block."""
        for block in self:
            values = values + block(values)
        return values


def perceptron(sizes: Sequence[int], activation: type[nn.Module]) -> nn.Sequential:
    """Return fully connected layers with an activation behind each but the last.

    Args:
        sizes: Values that go in, neurons of each hidden layer, values that come out.
        activation: Of the hidden layers.
    """
    layers: list[nn.Module] = []
    for inputs, outputs in pairwise(sizes):
        layers += [nn.Linear(inputs, outputs), activation()]
    return nn.Sequential(*layers[:-1])


def matrix_pose(position: Tensor, quaternion: Tensor) -> Tensor:
    """Return positions (N, 3) and the rotation matrices of quaternions (N, 4) as rows (N, 12)."""
    return torch.cat((position, matrix_from_quaternion(quaternion).flatten(1)), dim=1)


def parameter_count(network: nn.Module) -> int:
    """Return the number of trained parameters: weights and biases."""
    return sum(parameter.numel() for parameter in network.parameters())
