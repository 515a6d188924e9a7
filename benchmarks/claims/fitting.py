"""A plain training of a small network of the paper's kind, for losses that the pipeline has not."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from pipeline.config import compose
from pipeline.data.dataset import PoseSet
from pipeline.learning.config import TrainConfig
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.learning.factory import build_network
from pipeline.learning.networks import IkNetwork
from robots import Robot

CPU = torch.device("cpu")
CLIP = 10.0
TRAINING, HELD_OUT = 100_000, 5_000  # poses


class Batch(NamedTuple):
    """Poses (N, 7) and the joints (N, dof) that they were made from, float32."""

    poses: Tensor
    joints: Tensor


class Fit(NamedTuple):
    """What came of a training.

    Attributes:
        position_mm: Mean Euclidean error on the held-out poses.
        rotation_deg: Mean geodesic error on them.
        gradient_norms: (steps,) before clipping.
    """

    position_mm: float
    rotation_deg: float
    gradient_norms: np.ndarray


def pose_sets(robot: Robot, seed: int = 0) -> tuple[Batch, Batch]:
    """Return training and held-out poses of uniform configurations free of collisions."""
    return _batch(robot, TRAINING, 2 * seed), _batch(robot, HELD_OUT, 2 * seed + 1)


def recipe(robot: Robot, *overrides: str) -> TrainConfig:
    """Return the recipe of model=small_mlp for a robot, with overrides."""
    return compose([f"robot={robot.name}", "model=small_mlp", "train.device=cpu", *overrides]).train


def small_network(robot: Robot, seed: int) -> IkNetwork:
    """Return model=small_mlp with fresh weights."""
    torch.manual_seed(seed)
    return build_network(robot, compose([f"robot={robot.name}", "model=small_mlp"]).model)


def fit(
    robot: Robot,
    train: TrainConfig,
    loss: Callable[[IkNetwork, Batch], Tensor],
    data: tuple[Batch, Batch],
    seed: int,
) -> Fit:
    """Train model=small_mlp with Adam and a rate that rises over the warm-up and falls to zero.

    Args:
        robot: The robot.
        train: Batch size, rate, warm-up and epochs.
        loss: Scalar loss of a network on a batch.
        data: Training and held-out poses.
        seed: Of the first weights and the order of the batches.
    """
    network = small_network(robot, seed)
    training, held_out = data
    optimizer = torch.optim.Adam(network.parameters(), fused=True)
    order = torch.Generator().manual_seed(seed)
    per_epoch = len(training.poses) // train.batch_size
    total = per_epoch * train.epochs
    norms = []
    for step in range(total):
        if step % per_epoch == 0:
            shuffled = torch.randperm(len(training.poses), generator=order)
        rows = shuffled[(step % per_epoch) * train.batch_size :][: train.batch_size]
        warm = min(1.0, (step + 1) / (train.warm_up_steps + 1))
        optimizer.param_groups[0]["lr"] = train.learning_rate * warm * (1 - step / total)
        optimizer.zero_grad()
        loss(network, Batch(training.poses[rows], training.joints[rows])).backward()
        norms.append(float(torch.nn.utils.clip_grad_norm_(network.parameters(), CLIP)))
        optimizer.step()
    position, rotation = CycleObjective(robot, network, train, CPU).errors(held_out.poses)
    return Fit(float(position.mean()), float(rotation.mean()), np.array(norms))


def _batch(robot: Robot, count: int, seed: int) -> Batch:
    joints = robot.sample(count, seed=seed)
    data = PoseSet(robot.forward_kinematics(joints), joints)
    return Batch(torch.tensor(data.poses).float(), torch.tensor(data.joints).float())
