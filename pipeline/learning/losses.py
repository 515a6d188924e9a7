"""Losses of the paper and ours, and the errors that are shown while a network trains.

Positions are in metres, quaternions unit and scalar first; equation numbers are the paper's. Losses
come by row: the mean over the batch of these equations is taken where rows are weighed.
"""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor
from torch.nn.functional import l1_loss, smooth_l1_loss

from pipeline.learning.config import TrainConfig
from pipeline.learning.rotation import matrix_from_quaternion, quaternion_from_matrix

Loss = Callable[[Tensor, Tensor], Tensor]


def position_loss(predicted: Tensor, target: Tensor, beta: float) -> Tensor:
    """Return smooth L1 distances (N,) of positions (N, 3), mean over axes (equations 4 and 5)."""
    return smooth_l1_loss(predicted, target, beta=beta, reduction="none").mean(dim=-1)


def smooth_minimum_quaternion_loss(predicted: Tensor, target: Tensor, beta: float) -> Tensor:
    """Return smooth L1 (N,) to the nearer of q and -q, summed over components (equation 8)."""
    near = smooth_l1_loss(predicted, target, beta=beta, reduction="none").sum(dim=-1)
    far = smooth_l1_loss(predicted, -target, beta=beta, reduction="none").sum(dim=-1)
    return torch.minimum(near, far)


def former_position_loss(predicted: Tensor, target: Tensor) -> Tensor:
    """Return mean absolute errors (N,) of positions (N, 3) (equation 3)."""
    return l1_loss(predicted, target, reduction="none").mean(dim=-1)


def former_rotation_loss(predicted: Tensor, target: Tensor) -> Tensor:
    """Return mean absolute errors (N,) of quaternions, blind to their double cover (equation 6)."""
    return l1_loss(predicted, target, reduction="none").mean(dim=-1)


def matrix_loss(predicted: Tensor, target: Tensor, beta: float) -> Tensor:
    """Return smooth L1 (N,) of rotation matrices (N, 3, 3), mean over components."""
    return smooth_l1_loss(predicted, target, beta=beta, reduction="none").mean(dim=(-1, -2))


class PoseLoss:
    """Weighted sum of a position and a rotation loss (equation 9), by row.

    Args:
        train: Names the losses, their betas and weights.
    """

    def __init__(self, train: TrainConfig) -> None:
        self.train = train

    def __call__(self, position: Tensor, rotation: Tensor, target: Tensor) -> Tensor:
        """Return losses (N,) of positions (N, 3), rotations (N, 3, 3) against poses (N, 7)."""
        parts = self.parts(position, rotation, target)
        return self.train.position_weight * parts[0] + self.train.rotation_weight * parts[1]

    def parts(self, position: Tensor, rotation: Tensor, target: Tensor) -> tuple[Tensor, Tensor]:
        """Return the position and the rotation loss by row, unweighted."""
        train, goal = self.train, target[:, :3]
        if train.loss == "former":
            # Of the two signs the one that the data have, w >= 0: the former loss sees no other.
            quaternion = quaternion_from_matrix(rotation)
            quaternion = torch.where(quaternion[:, :1] < 0, -quaternion, quaternion)
            turned = former_rotation_loss(quaternion, target[:, 3:])
            return former_position_loss(position, goal), turned
        moved = position_loss(position, goal, train.position_beta)
        if train.loss == "matrix":
            wanted = matrix_from_quaternion(target[:, 3:])
            return moved, matrix_loss(rotation, wanted, train.rotation_beta)
        quaternion = quaternion_from_matrix(rotation)
        return moved, smooth_minimum_quaternion_loss(quaternion, target[:, 3:], train.rotation_beta)


def winner_takes_most(losses: Tensor, share: float) -> Tensor:
    """Return the loss of a batch from losses (N, K) of K hypotheses.

    The best hypothesis of a pose counts 1 - share and the mean of all of them ``share``, which
    keeps hypotheses alive that never win (Rupprecht et al., *Learning in an Uncertain World*, ICCV
    2017). With one hypothesis it is the mean over the batch.
    """
    if losses.shape[1] == 1:
        return losses.mean()
    return (1 - share) * losses.amin(dim=1).mean() + share * losses.mean()


def position_error_mm(predicted: Tensor, target: Tensor) -> Tensor:
    """Return Euclidean distances (N,) in millimetres of positions (N, 3) in metres."""
    return torch.linalg.vector_norm(predicted - target, dim=1) * 1e3


def rotation_error_deg(predicted: Tensor, target: Tensor) -> Tensor:
    """Return geodesic angles (N,) in degrees between unit quaternions (N, 4).

    4 asin(|q - p| / 2) of the nearer sign keeps its digits at small angles, where acos loses them.
    """
    near = torch.linalg.vector_norm(predicted - target, dim=1)
    far = torch.linalg.vector_norm(predicted + target, dim=1)
    half_chord = torch.minimum(near, far) / 2
    return torch.rad2deg(4 * torch.asin(half_chord.clamp(max=1.0)))


def tip_errors(frames: tuple[Tensor, Tensor], poses: Tensor) -> tuple[Tensor, Tensor]:
    """Return errors (N,) in mm and deg of tip frames, (N, 3) and (N, 3, 3), from poses (N, 7)."""
    position, rotation = frames
    quaternion = quaternion_from_matrix(rotation)
    return (
        position_error_mm(position, poses[:, :3]),
        rotation_error_deg(quaternion, poses[:, 3:]),
    )
