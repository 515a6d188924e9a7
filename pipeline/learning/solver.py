"""The neural solver: one forward pass of the network answers a whole batch of poses."""

from __future__ import annotations

import time
from pathlib import Path
from typing import ClassVar

import numpy as np
import torch
from numpy.typing import NDArray

from baselines import Budget, Solution, Solver
from pipeline.learning.weights import load_network
from robots import Robot, rotations

NOT_PRECISE = "outside the tolerance"


class CycleIk(Solver):
    """CycleIK: deterministic, one answer a pose, no iterations and no initial guess.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        position_tolerance_mm: Largest position error that the solver calls found.
        rotation_tolerance_deg: Largest rotation error that the solver calls found.
        threads: Threads of torch while it solves; 0 leaves torch as it is.
    """

    requires: ClassVar[tuple[str, ...]] = ("torch",)
    budgets: ClassVar[frozenset[str]] = frozenset()

    def __init__(
        self,
        robot: Robot,
        weights: str,
        position_tolerance_mm: float,
        rotation_tolerance_deg: float,
        threads: int,
    ) -> None:
        super().__init__(robot)
        self.network = load_network(Path(weights), robot)
        self.position_tolerance_mm = position_tolerance_mm
        self.rotation_tolerance_deg = rotation_tolerance_deg
        self.threads = threads

    def _solve_batch(
        self,
        poses: NDArray[np.float64],
        initial: NDArray[np.float64],
        budget: Budget | None,
    ) -> Solution:
        if self.threads:
            torch.set_num_threads(self.threads)
        start = time.perf_counter()
        with torch.inference_mode():
            output = self.network(torch.as_tensor(poses, dtype=torch.float32))
        joints = np.clip(output.numpy().astype(np.float64), self.lower, self.upper)
        seconds = time.perf_counter() - start
        found = self._within_tolerance(joints, poses)
        return Solution(
            joints=joints,
            found=found,
            time_s=np.full(len(poses), seconds / len(poses)),
            iterations=np.ones(len(poses), dtype=np.int64),
            reason=tuple("" if good else NOT_PRECISE for good in found),
        )

    def _within_tolerance(
        self, joints: NDArray[np.float64], poses: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        reached = self.robot.forward_kinematics(joints)
        position = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1) * 1e3
        angle = np.degrees(rotations.rotation_angle(reached[:, 3:], poses[:, 3:]))
        return (position <= self.position_tolerance_mm) & (angle <= self.rotation_tolerance_deg)
