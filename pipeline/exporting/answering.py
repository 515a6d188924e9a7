"""A trained network with all that stands around it, as one module of torch that can be exported.

Poses go in and joints come out: scaling, the choice of an expert, the joint limits, and the ranking
of several heads by forward kinematics are inside. It computes in one precision throughout, and the
trained numbers are kept in the smallest type that holds them exactly, as they were shipped.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import cast

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import normalize

from pipeline.errors import PipelineError
from pipeline.exporting.functions import arc_sine, exact_gelu, smooth_gelu
from pipeline.exporting.kinematics import tip_frames
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.cycleik.mlp import CycleIkMlp
from pipeline.learning.networks import IkNetwork, matrix_pose
from pipeline.learning.rotation import matrix_from_quaternion
from robots import Robot

OUTPUTS = ("joints", "candidates", "position_errors", "rotation_errors")


class Answering(nn.Module):
    """What the solver `cycleik` does, for poses (N, 7) with any N.

    Args:
        robot: The robot.
        network: Its network.
        ranking: (2,) what an error of 1 m and of 1 rad counts when hypotheses are compared.
        dtype: Of inputs, outputs and all arithmetic.
    """

    ranking: Tensor
    position_centre: Tensor
    position_scale: Tensor
    joint_centre: Tensor
    joint_scale: Tensor
    lower: Tensor
    upper: Tensor

    def __init__(
        self, robot: Robot, network: IkNetwork, ranking: np.ndarray, dtype: torch.dtype
    ) -> None:
        super().__init__()
        self.heads, self.dof = network.heads, network.dof
        for name in ("position_centre", "position_scale", "joint_centre", "joint_scale"):
            self.register_buffer(name, getattr(network, name).detach().to(dtype))
        for name, values in (("lower", robot.lower), ("upper", robot.upper), ("ranking", ranking)):
            self.register_buffer(name, torch.as_tensor(values, dtype=dtype))
        self.chain = robot.chain

    def forward(self, poses: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Answer poses.

        Args:
            poses: (N, 7) in the base frame, x y z [m], qw qx qy qz of any length but zero.

        Returns:
            Joints (N, dof) of the best head [rad or m], those of all heads (N, K, dof), and their
            errors (N, K) in m and in rad.
        """
        quaternion = normalize(poses[:, 3:], dim=1)
        position = (poses[:, :3] - self.position_centre) / self.position_scale
        output = self.normalised(position, quaternion).reshape(-1, self.heads, self.dof)
        scaled = self.joint_centre + self.joint_scale * output
        candidates = torch.minimum(torch.maximum(scaled, self.lower), self.upper)
        distance, angle = self._errors(candidates, poses[:, :3], quaternion)
        best = (self.ranking[0] * distance + self.ranking[1] * angle).argmin(dim=1)
        chosen = best[:, None, None].expand(-1, 1, self.dof)
        return candidates.gather(1, chosen)[:, 0], candidates, distance, angle

    def _errors(
        self, candidates: Tensor, position: Tensor, quaternion: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Distance [m] and angle [rad] (N, K) from the tips of joints (N, K, dof) to the poses."""
        *axes, origin = tip_frames(self.chain, candidates.reshape(-1, self.dof))
        away = origin.reshape(-1, self.heads, 3) - position[:, None]
        goal = matrix_from_quaternion(quaternion)
        chord = torch.zeros_like(candidates[:, :, 0])
        for k, axis in enumerate(axes):
            difference = axis.reshape(-1, self.heads, 3) - goal[:, None, :, k]
            chord = chord + difference.square().sum(dim=2)
        # |R - G|² = 8 sin²(angle / 2) for rotations R and G.
        angle = 2 * arc_sine((chord / 8).sqrt().clamp(max=1.0))
        return away.square().sum(dim=2).sqrt(), angle

    @abstractmethod
    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """Return (N, K dof) in [-1, 1] for scaled positions (N, 3) and quaternions (N, 4)."""


class AnsweringExperts(Answering):
    """`Answering` of a mixture of experts; arguments as there."""

    metric: Tensor
    centres: Tensor
    mean: Tensor
    scale: Tensor

    def __init__(
        self, robot: Robot, network: Experts, ranking: np.ndarray, dtype: torch.dtype
    ) -> None:
        super().__init__(robot, network, ranking, dtype)
        for name in ("metric", "centres", "mean", "scale"):
            self.register_buffer(name, getattr(network, name).detach().to(dtype))
        self.weights = [smallest(weight) for weight in network.weights]
        self.biases = [smallest(bias) for bias in network.biases]

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """See `Answering`."""
        features = matrix_pose(position, quaternion)
        half = self.centres.square().sum(1) / 2
        cell = (half - (features * self.metric) @ self.centres.T).argmin(1)
        values = (features - self.mean[cell]) / self.scale[cell]
        output: Tensor = through_experts(values, cell, self.weights, self.biases, values.dtype)
        return output


class AnsweringMlp(Answering):
    """`Answering` of one fully connected network; arguments as there."""

    def __init__(
        self, robot: Robot, network: CycleIkMlp, ranking: np.ndarray, dtype: torch.dtype
    ) -> None:
        super().__init__(robot, network, ranking, dtype)
        self.first_tanh = network.layers.first_tanh
        self.weights: list[Tensor] = [smallest(layer.weight.T) for layer in linear(network)]
        self.biases: list[Tensor] = [smallest(layer.bias) for layer in linear(network)]

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """See `Answering`."""
        values = torch.cat((position, quaternion), dim=1)
        for k, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = values @ weight.to(values.dtype) + bias.to(values.dtype)
            values = exact_gelu(values) if k < self.first_tanh else torch.tanh(values)
        return values


def answering(
    robot: Robot, network: IkNetwork, ranking: np.ndarray, dtype: torch.dtype
) -> Answering:
    """Return the module that answers with a network; arguments as of `Answering`.

    Raises:
        PipelineError: A network of another kind.
    """
    if isinstance(network, Experts):
        made: Answering = AnsweringExperts(robot, network, ranking, dtype)
    elif isinstance(network, CycleIkMlp):
        made = AnsweringMlp(robot, network, ranking, dtype)
    else:
        raise PipelineError(
            f"a {type(network).__name__} cannot be exported: expected a network of kind experts or "
            "mlp, such as model=compact or model=paper"
        )
    return made.eval().requires_grad_(False)


def linear(network: CycleIkMlp) -> list[nn.Linear]:
    """Return the layers of a fully connected network."""
    return [cast(nn.Linear, layer) for layer in network.layers]


def smallest(weight: Tensor) -> Tensor:
    """Return trained numbers as float16 where that holds them exactly, else as they are."""
    values = weight.detach()
    half = values.half()
    return half if torch.equal(half.to(values.dtype), values) else values


@torch.jit.script
def through_experts(
    values: Tensor, cell: Tensor, weights: list[Tensor], biases: list[Tensor], kind: torch.dtype
) -> Tensor:
    """Take inputs (N, 12) through the experts of their cells (N,): outputs (N, K dof).

    Few poses gather the weights of their cells. Of many, each gets a row of its own in a grid of
    (cells, width) rows, which goes through all experts as one product.
    """
    count, cells = cell.size(0), weights[0].size(0)
    last = len(weights) - 1
    if count <= 32:
        rows = values[:, None]
        for k in range(len(weights)):
            rows = biases[k][cell].to(kind) + rows @ weights[k][cell].to(kind)
            rows = torch.tanh(rows) if k == last else smooth_gelu(rows)
        return rows[:, 0]
    member = (cell[:, None] == torch.arange(cells)[None]).to(torch.int64)
    place = (member.cumsum(0) * member).sum(1) - 1
    width = int(member.sum(0).max())
    slot = cell * width + place
    grid = torch.zeros([cells * width, values.size(1)], dtype=kind)
    rows = grid.index_copy(0, slot, values.to(kind)).reshape(cells, width, values.size(1))
    for k in range(len(weights)):
        rows = biases[k].to(values.dtype) + rows @ weights[k].to(kind)
        rows = torch.tanh(rows) if k == last else smooth_gelu(rows)
    return rows.reshape(cells * width, -1)[slot]
