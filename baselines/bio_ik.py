"""BioIK, re-implemented from its publications as a compiled solver on one thread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from baselines import bio_ik_kernel
from baselines.bio_ik_kernel import BioOptions
from baselines.checks import count_settings, positive_settings
from baselines.protocol import OUT_OF_ITERATIONS, OUT_OF_TIME, Budget, Solution, Solver

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# Without an iteration limit the time limit ends a query; this one is never reached.
UNLIMITED = 2**62
REASONS = {
    bio_ik_kernel.FOUND: "",
    bio_ik_kernel.OUT_OF_ITERATIONS: OUT_OF_ITERATIONS,
    bio_ik_kernel.OUT_OF_TIME: OUT_OF_TIME,
}


class BioIk(Solver):
    """Memetic evolution of joint configurations; an iteration is one step of one species.

    The paper's BioIK is the authors' C++ code inside MoveIt, on four threads; this one is ours
    and runs on one.

    Args:
        robot: The robot to solve for.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
        **options: The other fields of `BioOptions`.
    """

    def __init__(
        self, robot: Robot, *, time_s: float | None, iterations: int | None, **options: Any
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        # The kernel is compiled for these types; others would have it compiled again.
        sizes = ("position_tolerance_m", "rotation_tolerance_rad", "rotation_weight")
        counts = ("species", "children", "generations", "patience")
        none_too = ("line_searches", "mutation_octaves")
        checked: dict[str, Any] = {
            **positive_settings({key: options.pop(key) for key in sizes}),
            **count_settings({key: options.pop(key) for key in counts}),
            **count_settings({key: options.pop(key) for key in none_too}, least=0),
        }
        self._options = BioOptions(**checked, **options, iterations=UNLIMITED, time_ns=0)
        self.position_tolerance_m = self._options.position_tolerance_m
        self.rotation_tolerance_rad = self._options.rotation_tolerance_rad
        self.tolerances = (self.position_tolerance_m, self.rotation_tolerance_rad)

    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        budget = budget or Budget(iterations=UNLIMITED)
        options = self._options._replace(
            iterations=UNLIMITED if budget.iterations is None else budget.iterations,
            time_ns=0 if budget.time_s is None else max(1, int(budget.time_s * 1e9)),
        )
        count = len(poses)
        joints = np.zeros((count, self.robot.dof))
        status, steps, time_ns = (np.zeros(count, dtype=np.int64) for _ in range(3))
        bio_ik_kernel.evolve_rows(
            self.robot.chain,
            poses,
            np.ascontiguousarray(initial),
            options,
            joints,
            status,
            steps,
            time_ns,
        )
        reasons = tuple(REASONS[code] for code in status.tolist())
        found = status == bio_ik_kernel.FOUND
        return Solution(joints, found, np.asarray(time_ns * 1e-9), steps, reasons)
