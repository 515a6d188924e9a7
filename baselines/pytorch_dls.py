"""Damped least squares of pytorch-kinematics, a batch at a time."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.checks import count_settings, damping_settings, positive_settings
from baselines.protocol import OUT_OF_ITERATIONS, Budget, Solution, Solver
from baselines.restarts import restart_configurations
from robots.rotations import matrix_from_quaternion

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


class PytorchDls(Solver):
    """`PseudoInverseIK` on the unsolved poses, round after round, in float64.

    In a round every pose descends from several configurations at once: in the first from the
    initial guess and random ones, later from random ones only. It heeds no time limit, since one
    iteration of a batch takes longer than many of them.

    Args:
        robot: The robot to solve for.
        position_tolerance_m: Distance to the target at which a solution is claimed [m].
        rotation_tolerance_rad: Rotation angle to the target at which it is claimed [rad].
        regularization: Constant damping on the diagonal of J Jᵀ [m² and rad²].
        damping_gain: Damping per squared error.
        retries: Configurations per pose and round.
        round_iterations: Iterations per round.
        batch: Poses solved together, which bounds the memory.
        device: Torch device.
        iterations: Iteration budget per pose where `solve` gets none.
    """

    requires: ClassVar[tuple[str, ...]] = ("torch", "pytorch_kinematics")
    mimics: ClassVar[bool] = False
    budgets: ClassVar[frozenset[str]] = frozenset({"iterations"})

    def __init__(
        self,
        robot: Robot,
        *,
        position_tolerance_m: float,
        rotation_tolerance_rad: float,
        regularization: float,
        damping_gain: float,
        retries: int,
        round_iterations: int,
        batch: int,
        device: str,
        iterations: int,
    ) -> None:
        import torch

        super().__init__(robot, iterations=iterations)
        sizes = positive_settings(
            {
                "position_tolerance_m": position_tolerance_m,
                "rotation_tolerance_rad": rotation_tolerance_rad,
            }
        )
        counts = count_settings(
            {"retries": retries, "round_iterations": round_iterations, "batch": batch}
        )
        regularization, damping_gain = damping_settings(regularization, damping_gain)
        self.position_tolerance_m, self.rotation_tolerance_rad = sizes.values()
        self.tolerances = (self.position_tolerance_m, self.rotation_tolerance_rad)
        self.retries, self.round_iterations, self.batch = counts.values()
        self._chain = robot.torch_chain(dtype=torch.float64, device=device)
        self._settings: dict[str, Any] = {
            "pos_tolerance": self.position_tolerance_m,
            "rot_tolerance": self.rotation_tolerance_rad,
            "regularlization": regularization,  # the library spells it so
            "lm_damping": damping_gain,
            "clamp_to_limits": True,
            "enforce_joint_limits": False,
            "early_stopping_any_converged": True,
            "early_stopping_no_improvement": None,
        }

    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        limit = budget.iterations if budget and budget.iterations else self.round_iterations
        solution = Solution.empty(len(poses), self.robot.dof)
        for first in range(0, len(poses), self.batch):
            rows = slice(first, first + self.batch)
            began = time.perf_counter()
            self._solve_rows(poses[rows], initial[rows], limit, solution, first)
            solution.time_s[rows] = (time.perf_counter() - began) / len(poses[rows])
        reasons = tuple("" if found else OUT_OF_ITERATIONS for found in solution.found)
        return self._only_true_claims(replace(solution, reason=reasons), poses)

    def _solve_rows(
        self, poses: Array, initial: Array, limit: int, solution: Solution, first: int
    ) -> None:
        """Rounds until all are solved or `limit` is used up; fills `solution` from `first` on."""
        fresh = [restart_configurations(pose, self.lower, self.upper) for pose in poses]
        least = np.full(len(poses), np.inf)
        unsolved = np.arange(len(poses))
        used, start = 0, initial[:, None, :]
        while used < limit and len(unsolved):
            count = self.retries - start.shape[1]
            if count:
                more = np.array([list(islice(fresh[row], count)) for row in unsolved])
                start = np.concatenate([start, more], axis=1)
            iterations = min(self.round_iterations, limit - used)
            joints, error, found, taken = self._round(poses[unsolved], start, iterations)
            better = found | (error < least[unsolved])
            rows = unsolved[better]
            least[rows] = error[better]
            solution.joints[first + rows] = joints[better]
            solution.found[first + unsolved] = found
            solution.iterations[first + unsolved] += taken
            used += iterations
            unsolved = unsolved[~found]
            start = np.empty((len(unsolved), 0, self.robot.dof))

    def _round(
        self, poses: Array, start: Array, iterations: int
    ) -> tuple[Array, Array, NDArray[np.bool_], int]:
        """Let the library descend from `start` (N, R, dof).

        Returns:
            The best joints of each pose (N, dof), their squared errors (N,), whether they are
            within tolerance (N,), and the iterations taken.
        """
        import torch
        from pytorch_kinematics import PseudoInverseIK, Transform3d

        matrices = np.tile(np.eye(4), (len(poses), 1, 1))
        matrices[:, :3, :3] = matrix_from_quaternion(poses[:, 3:])
        matrices[:, :3, 3] = poses[:, :3]
        device = self._chain.device
        method = PseudoInverseIK(
            self._chain,
            retry_configs=torch.as_tensor(start.reshape(-1, start.shape[2]), device=device),
            max_iterations=iterations,
            **self._settings,
        )
        # The library takes the number of retries from the first axis of one pose's configurations.
        method.num_retries = start.shape[1]
        target = torch.as_tensor(matrices, device=device)
        answer = method.solve(Transform3d(matrix=target, dtype=torch.float64, device=device))
        squared = answer.err_pos**2 + answer.err_rot**2
        squared[answer.converged] = -1.0  # a converged one goes before all others
        best = squared.argmin(dim=1)
        rows = torch.arange(len(poses), device=best.device)
        return (
            np.clip(answer.solutions[rows, best].cpu().numpy(), self.lower, self.upper),
            squared[rows, best].cpu().numpy(),
            answer.converged_any.cpu().numpy(),
            int(answer.iterations),
        )
