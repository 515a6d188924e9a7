"""Losses of the paper and the errors that are shown while a network trains.

Positions are in metres, quaternions unit and scalar first; equation numbers are the paper's. Losses
come by row: the mean over the batch of these equations is taken where rows are weighed.
"""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor
from torch.nn.functional import l1_loss, smooth_l1_loss

from pipeline.settings import TrainConfig

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


def pose_losses(train: TrainConfig) -> tuple[Loss, Loss]:
    """Return the position and the rotation loss, both by row, that ``train.loss`` names."""
    if train.loss == "former":
        return former_position_loss, former_rotation_loss
    return (
        lambda predicted, target: position_loss(predicted, target, train.position_beta),
        lambda predicted, target: smooth_minimum_quaternion_loss(
            predicted, target, train.rotation_beta
        ),
    )


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
