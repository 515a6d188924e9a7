"""The neural solver: one forward pass of the network answers a whole batch of poses."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from baselines import Budget, Solution, Solver
from baselines.refine import numba_threads
from pipeline.learning.experts import Experts
from pipeline.learning.experts_kernel import (
    CompiledExperts,
    answer_rows,
    answer_rows_parallel,
    compiled_experts,
)
from pipeline.learning.weights import load_network
from robots import Robot, rotations

_TO_MM_AND_DEG = np.array([1e3, 180 / np.pi])
NOT_PRECISE = "outside the tolerance"


class Hypotheses(NamedTuple):
    """Answers of a network with K heads to N poses, best first, with their errors.

    Attributes:
        joints: (N, K, dof) rad or m, inside the limits.
        position_mm: (N, K) Euclidean position errors.
        rotation_deg: (N, K) geodesic rotation errors.
    """

    joints: NDArray[np.float64]
    position_mm: NDArray[np.float64]
    rotation_deg: NDArray[np.float64]


@contextmanager
def torch_threads(count: int) -> Iterator[None]:
    """Let torch use ``count`` threads, 0 for as many as it has; afterwards it is as before."""
    before = torch.get_num_threads()
    if count and count != before:
        torch.set_num_threads(count)
    try:
        yield
    finally:
        if torch.get_num_threads() != before:
            torch.set_num_threads(before)


class CycleIk(Solver):
    """CycleIK: deterministic, one forward pass, no iterations and no initial guess.

    Of several hypotheses the one with the smallest error, each measured in tolerances, is taken.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        position_tolerance_mm: Largest position error that the solver calls found.
        rotation_tolerance_deg: Largest rotation error that the solver calls found.
        threads: Threads while it solves; 0 leaves torch as it is and takes all of numba's.

    Attributes:
        kinds: Kinds of networks (``model.kind``) whose weights it takes.
        default_model: What is trained for it (conf/model) where a run's model is of another kind.
    """

    kinds: ClassVar[tuple[str, ...]] = ("mlp", "experts")
    default_model: ClassVar[str] = "compact"
    requires: ClassVar[tuple[str, ...]] = ("torch",)
    budgets: ClassVar[frozenset[str]] = frozenset()
    always_answers = True

    def __init__(
        self,
        robot: Robot,
        weights: str,
        position_tolerance_mm: float,
        rotation_tolerance_deg: float,
        threads: int,
    ) -> None:
        super().__init__(robot)
        self.network = load_network(Path(weights), robot, self.kinds)
        self.position_tolerance_mm = position_tolerance_mm
        self.rotation_tolerance_deg = rotation_tolerance_deg
        self.threads = threads
        self.compiled = (
            compiled_experts(self.network) if isinstance(self.network, Experts) else None
        )

    def hypotheses(self, poses: NDArray[np.float64]) -> Hypotheses:
        """Return the network's answers to poses (N, 7), best first."""
        if self.compiled is not None:
            return self._compiled_hypotheses(poses, self.compiled)
        joints = self._answers(poses)
        position, rotation = self._errors(joints, poses)
        in_tolerances = (
            position / self.position_tolerance_mm + rotation / self.rotation_tolerance_deg
        )
        order = np.argsort(in_tolerances, axis=1, kind="stable")
        rows = np.arange(len(poses))[:, None]
        return Hypotheses(joints[rows, order], position[rows, order], rotation[rows, order])

    def _compiled_hypotheses(
        self, poses: NDArray[np.float64], experts: CompiledExperts
    ) -> Hypotheses:
        """The same without torch, for networks that have a kernel."""
        count, heads = len(poses), self.network.heads
        joints = np.empty((count, heads, self.robot.dof))
        errors = np.empty((count, heads, 2))
        weights = 1 / np.array([self.position_tolerance_mm, self.rotation_tolerance_deg])
        arguments = (
            self.robot.chain,
            experts,
            np.ascontiguousarray(poses, dtype=np.float64),
            weights * _TO_MM_AND_DEG,
            joints,
            errors,
        )
        if self.threads == 1 or count == 1:
            answer_rows(*arguments)
        else:
            with numba_threads(self.threads):
                answer_rows_parallel(*arguments)
        errors *= _TO_MM_AND_DEG
        return Hypotheses(joints, errors[..., 0], errors[..., 1])

    def _answers(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the network's answers (N, K, dof) to poses (N, 7), inside the limits."""
        with torch_threads(self.threads), torch.inference_mode():
            output = self.network(torch.as_tensor(poses, dtype=torch.float32))
        return np.clip(output.numpy().astype(np.float64), self.lower, self.upper)

    def _solve_batch(
        self,
        poses: NDArray[np.float64],
        initial: NDArray[np.float64],
        budget: Budget | None,
    ) -> Solution:
        start = time.perf_counter()
        answers = self.hypotheses(poses)
        found = (answers.position_mm[:, 0] <= self.position_tolerance_mm) & (
            answers.rotation_deg[:, 0] <= self.rotation_tolerance_deg
        )
        seconds = time.perf_counter() - start
        return Solution(
            joints=answers.joints[:, 0],
            found=found,
            time_s=np.full(len(poses), seconds / len(poses)),
            iterations=np.ones(len(poses), dtype=np.int64),
            reason=tuple("" if good else NOT_PRECISE for good in found),
        )

    def _errors(
        self, hypotheses: NDArray[np.float64], poses: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return errors (N, K) in mm and deg of hypotheses (N, K, dof)."""
        count, heads, dof = hypotheses.shape
        reached = self.robot.forward_kinematics(hypotheses.reshape(-1, dof))
        reached = reached.reshape(count, heads, 7)
        position = np.linalg.norm(reached[..., :3] - poses[:, None, :3], axis=2) * 1e3
        targets = np.broadcast_to(poses[:, None, 3:], (count, heads, 4))
        return position, np.degrees(rotations.rotation_angle(reached[..., 3:], targets))
