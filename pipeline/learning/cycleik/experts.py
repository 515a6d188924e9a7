"""Our compact network: many small networks, each for one region of pose space, and several heads.

Inverse kinematics is smooth almost everywhere but folded as a whole, so one network for all poses
has to be large. Here the set of reachable poses is cut into cells (k-means), and each cell has an
expert of its own: a small perceptron that sees the pose from the middle of its cell. A pose costs
one expert, however many there are, while the precision grows with all of them: a mixture of
experts with a hard, fixed gate (Jacobs et al., *Adaptive mixtures of local experts*, Neural
Computation 1991). Every expert has several heads, which may settle on different branches of
solutions; forward kinematics tells which of them is right.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import torch
from scipy.cluster.vq import kmeans2
from torch import Tensor, nn
from torch.nn.functional import gelu

from pipeline.learning.cycleik.config import CycleIkModel
from pipeline.learning.networks import MATRIX_POSE_SIZE, IkNetwork, matrix_pose
from robots import Robot

LLOYD_STEPS = 10
POSES_A_CELL = 100  # poses that the cells are found from
GELU_GAIN = 2.0  # He et al., 2015: keeps the variance through layers that are zero for half of it
# Of a number of the rotation matrix in the distance between poses; a shift across half of the
# workspace counts 1. A turn moves nine numbers, a shift three.
ROTATION_SHARE = 0.5
LAST_GAIN = 0.3  # answers start near the middle of the joints, where tanh is not flat


class Experts(IkNetwork):
    """Experts over cells of pose space.

    Args:
        robot: The robot.
        model: Neurons of each hidden layer of an expert, number of experts, heads.
    """

    metric: Tensor
    centres: Tensor
    mean: Tensor
    scale: Tensor

    def __init__(self, robot: Robot, model: CycleIkModel) -> None:
        super().__init__(robot, heads=model.heads)
        count = model.experts
        sizes = [MATRIX_POSE_SIZE, *model.hidden, model.heads * robot.dof]
        self.weights = nn.ParameterList(torch.randn(count, *pair) for pair in pairwise(sizes))
        self.biases = nn.ParameterList(torch.zeros(count, 1, size) for size in sizes[1:])
        with torch.no_grad():
            for index, weight in enumerate(self.weights):
                gain = LAST_GAIN if index == len(sizes) - 2 else GELU_GAIN
                weight *= (gain / sizes[index]) ** 0.5
        metric = torch.full((MATRIX_POSE_SIZE,), ROTATION_SHARE)
        metric[:3] = 1.0
        self.register_buffer("metric", metric)
        for name in ("centres", "mean"):
            self.register_buffer(name, torch.zeros(count, MATRIX_POSE_SIZE))
        self.register_buffer("scale", torch.ones(count, MATRIX_POSE_SIZE))

    @torch.no_grad()
    def prepare(self, poses: Tensor) -> None:
        """Find the cells of a set of poses (N, 7), and how the inputs vary within each."""
        features = matrix_pose(self.scaled(poses), poses[:, 3:])
        picked = features[:: max(1, len(features) // (POSES_A_CELL * len(self.centres)))]
        points = (picked * self.metric).double().cpu().numpy()
        centres, _ = kmeans2(points, len(self.centres), iter=LLOYD_STEPS, minit="++", rng=0)
        self.centres.copy_(torch.as_tensor(centres))
        cell = self.cell(features)
        for index in range(len(self.centres)):
            inside = features[cell == index]
            if len(inside) > 1:
                self.mean[index] = inside.mean(0)
                # A number that does not vary within a cell would be blown up by its noise.
                self.scale[index] = inside.std(0).clamp(min=1e-2)

    def cell(self, features: Tensor) -> Tensor:
        """Return the nearest cell (N,) of features (N, 12), see `matrix_pose`."""
        # |f - c|² without the part that all cells share.
        half = (self.centres * self.centres).sum(1) / 2
        return (half - (features * self.metric) @ self.centres.T).argmin(1)

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """See `IkNetwork.normalised`."""
        features = matrix_pose(position, quaternion)
        with torch.no_grad():
            slot, width = self._slots(self.cell(features))
        grid = features.new_zeros(len(self.centres) * width, MATRIX_POSE_SIZE)
        grid = grid.index_copy(0, slot, features).unflatten(0, (-1, width))
        values = (grid - self.mean[:, None]) / self.scale[:, None]
        last = len(self.weights) - 1
        for index, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = torch.baddbmm(bias, values, weight)
            values = torch.tanh(values) if index == last else gelu(values, approximate="tanh")
        return values.flatten(0, 1).index_select(0, slot)

    def _slots(self, cell: Tensor) -> tuple[Tensor, int]:
        """Return a row of its own for each pose in a grid of (cells, width) rows, and the width."""
        counts = torch.bincount(cell, minlength=len(self.centres))
        order = torch.argsort(cell, stable=True)
        first = counts.cumsum(0) - counts
        place = torch.empty_like(cell)
        place[order] = torch.arange(len(cell), device=cell.device) - first[cell[order]]
        width = int(counts.max())
        return cell * width + place, width

    def folded(self, centred: bool = False) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return weights (E, in, out) and biases (E, out) with the scaling of inputs folded in.

        Args:
            centred: Whether the mean of a cell is subtracted from its inputs before.
        """
        layers = [
            (weight.detach().double().cpu(), bias.detach()[:, 0].double().cpu())
            for weight, bias in zip(self.weights, self.biases, strict=True)
        ]
        weight, bias = layers[0]
        weight = weight / self.scale.double().cpu()[:, :, None]
        if not centred:
            bias = bias - (self.mean.double().cpu()[:, None] @ weight)[:, 0]
        layers[0] = (weight, bias)
        return [(weight.numpy(), bias.numpy()) for weight, bias in layers]


def host(tensor: Tensor) -> np.ndarray:
    """Return a copy of a tensor as an array of float64."""
    array: np.ndarray = tensor.detach().cpu().double().numpy()
    return array
