"""Errors of draws and of answers, and the time of a call of 100 poses."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from statistics import median

import numpy as np
import torch
from numpy.typing import NDArray

from pipeline import load_solver
from pipeline.evaluation.metrics import pose_errors
from pipeline.evaluation.verification import tip_poses
from pipeline.learning.networks import SamplingNetwork
from pipeline.learning.solver import LatentSolver, NeuralSolver, torch_threads
from pipeline.seeding import derive_seed
from robots import Robot

Array = NDArray[np.float64]

CALL = 100  # poses of a call, as the paper and IKFlow time them
DRAWS = 10  # of each pose, each with latents of its own
WARM_UP_CALLS = 2
SEED = 41


@dataclass(frozen=True)
class Errors:
    """Mean errors in both families.

    Attributes:
        position_mm: Euclidean.
        rotation_deg: Geodesic.
        paper_position_mm: Mean over the axes.
        paper_rotation_deg: Mean over the Euler angles.
    """

    position_mm: float
    rotation_deg: float
    paper_position_mm: float
    paper_rotation_deg: float


@dataclass(frozen=True)
class Measured:
    """What a network's answers are like.

    Attributes:
        draws: Errors of single draws as learned, mean over draws of all poses; of a network without
            latents the mean over its hypotheses.
        answers: Errors of the solver's answers: the best of several by forward kinematics.
        answers_of: How many those are.
        draws_ms: Processor time of a call of 100 poses, a draw each [ms]; median.
        answers_ms: Likewise of the solver [ms].
    """

    draws: Errors
    answers: Errors
    answers_of: int
    draws_ms: float
    answers_ms: float


def measured(robot: Robot, solver_name: str, weights: Path, poses: Array) -> Measured:
    """Measure a network on poses (N, 7), a multiple of `CALL`, on one thread."""
    solver = load_solver(solver_name, robot, weights=weights, threads=1)
    assert isinstance(solver, NeuralSolver)
    calls = poses.reshape(-1, CALL, 7)
    answers, answers_s = _timed(lambda call: solver.solve(call).joints, calls)
    with torch_threads(1), torch.inference_mode():
        if isinstance(solver, LatentSolver):
            draws, draws_s = _drawn(solver.network, calls)
            answers_of = solver.samples
        else:
            draws, draws_s = _timed(lambda call: solver.hypotheses(call).joints, calls)
            answers_of = draws.shape[1]
    targets = np.repeat(poses, draws.shape[1], axis=0)
    return Measured(
        draws=_errors(robot, targets, draws.reshape(-1, robot.dof)),
        answers=_errors(robot, poses, answers),
        answers_of=answers_of,
        draws_ms=1e3 * draws_s,
        answers_ms=1e3 * answers_s,
    )


def _drawn(network: SamplingNetwork, calls: Array) -> tuple[Array, float]:
    """Return draws (N, K, dof), each of latents of its own, and the seconds of a call."""
    seeds = count()

    def draw(call: Array) -> Array:
        latents = network.latents(len(call), 1, derive_seed(SEED, "draws", next(seeds)))
        drawn = network.draws(torch.as_tensor(call, dtype=torch.float32), latents)
        return drawn[:, 0].numpy().astype(np.float64)

    found, seconds = zip(*(_timed(draw, calls) for _ in range(DRAWS)), strict=True)
    return np.stack(found, axis=1), median(seconds)


def _timed(answer: Callable[[Array], Array], calls: Array) -> tuple[Array, float]:
    """Return the answers to calls (C, 100, 7), one behind the other, and the median seconds."""
    for call in calls[:WARM_UP_CALLS]:
        answer(call)
    found, seconds = [], []
    for call in calls:
        began = time.process_time()
        found.append(answer(call))
        seconds.append(time.process_time() - began)
    return np.concatenate(found), median(seconds)


def _errors(robot: Robot, targets: Array, joints: Array) -> Errors:
    """Return the mean errors of joints (N, dof) for poses (N, 7), recomputed by Pinocchio."""
    errors = pose_errors(targets, tip_poses(robot, joints))
    return Errors(*(float(each.mean()) for each in vars(errors).values()))
