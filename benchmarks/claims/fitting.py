"""Trainings of a small network of the paper's kind, by the project's trainer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from pipeline.config import compose
from pipeline.data.dataset import PoseSet
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.learning.factory import build_network
from pipeline.learning.step import total_gradient_norm
from pipeline.learning.trainer import Trainer, TrainingRun
from robots import Robot

CPU = torch.device("cpu")
TRAINING, HELD_OUT = 100_000, 5_000  # poses


class Fit(NamedTuple):
    """What came of a training.

    Attributes:
        position_mm: Mean Euclidean error on the held-out poses.
        rotation_deg: Mean geodesic error on them.
        gradient_norms: (steps,) as the optimiser has them: after clipping, where there is any.
    """

    position_mm: float
    rotation_deg: float
    gradient_norms: NDArray[np.float64]


def pose_sets(robot: Robot) -> tuple[PoseSet, PoseSet]:
    """Return training and held-out poses of uniform configurations free of collisions."""
    joints = robot.sample(TRAINING, seed=0), robot.sample(HELD_OUT, seed=1)
    training, held_out = (PoseSet(robot.forward_kinematics(q), q) for q in joints)
    return training, held_out


def fit(
    robot: Robot,
    data: tuple[PoseSet, PoseSet],
    seed: int,
    *overrides: str,
    objective: type[CycleObjective] = CycleObjective,
) -> Fit:
    """Train model=small_mlp.

    Args:
        robot: The robot.
        data: Training and held-out poses.
        seed: Of the first weights and the order of the batches.
        *overrides: Of its recipe.
        objective: What it is trained for.
    """
    plain = [f"robot={robot.name}", "model=small_mlp", "train.device=cpu", "train.validations=1"]
    config = compose([*plain, *overrides])
    torch.manual_seed(seed)
    network = build_network(robot, config.model)
    aim = objective(robot, network, config.train, CPU)
    trainer = Trainer(robot, network, config.train, TrainingRun(seed, "", robot.name), aim)
    norms: list[float] = []

    def note(*_: object) -> None:
        norms.append(float(total_gradient_norm(list(network.parameters()))))

    trainer.optimizer.register_step_pre_hook(note)
    last = trainer.fit(*data).curve[-1]
    return Fit(
        last["validation_position_error_mm"],
        last["validation_rotation_error_deg"],
        np.array(norms),
    )
