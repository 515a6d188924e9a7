"""What is evaluated: one solver of one robot on one set of poses, and where it starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines import Budget, Solver
from pipeline.evaluation.config import HOME, EvaluateConfig

if TYPE_CHECKING:
    from robots import Obstacles, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EvaluationTask:
    """One solver of one robot on one set of poses.

    Attributes:
        robot: The robot.
        solver: The solver, made for that robot.
        poses: (N, 7) targets in the base frame.
        seed: Seed of the solver or of the training behind it; a column of the rows.
        name: Name of the solver in the rows; its own where left out.
        initial: (dof,) or (N, dof) initial guesses; the robot's home configuration if None.
        seeder: Solver whose answers are the initial guesses instead, computed call by call.
        follows: (N,) poses whose initial guess is the answer to the pose before; None for none. All
            are solved one by one then.
        avoid: Obstacles of each pose, N sets; solvers that know nothing of them solve without. None
            for no question of collision.
        code: Digest of the code behind the rows; rows of other code are not reused.
    """

    robot: Robot
    solver: Solver
    poses: Array
    seed: int = 0
    name: str = ""
    initial: Array | None = None
    seeder: Solver | None = None
    follows: NDArray[np.bool_] | None = None
    avoid: Sequence[Obstacles] | None = None
    code: str = ""

    @property
    def label(self) -> str:
        """Name of the solver in the rows."""
        return self.name or self.solver.name

    @property
    def seeded_by(self) -> str:
        """Where initial guesses come from: home, given, or the name of the seeding solver."""
        if self.seeder is not None:
            return self.seeder.name
        return HOME if self.initial is None else "given"

    def part(self, start: int, stop: int) -> EvaluationTask:
        """Return it on the poses ``start`` to ``stop``; the first follows the last."""
        if stop <= len(self.poses):
            return self._at(slice(start, stop))
        return self._at(np.arange(start, stop) % len(self.poses))

    def _at(self, rows: slice | NDArray[np.int64]) -> EvaluationTask:
        initial = self.initial
        if initial is not None and initial.ndim == 2:
            initial = initial[rows]
        follows = None if self.follows is None else self.follows[rows]
        avoid = self.avoid
        if avoid is not None:
            avoid = [avoid[row] for row in np.arange(len(self.poses))[rows]]
        return replace(self, poses=self.poses[rows], initial=initial, follows=follows, avoid=avoid)

    @property
    def asks_to_avoid(self) -> bool:
        """Whether the solver is told what to avoid."""
        return self.avoid is not None and self.solver.skip_avoiding() is None

    def seeded(self) -> EvaluationTask:
        """Return the same task with the seeder's answers as initial guesses."""
        if self.seeder is None:
            return self
        return replace(self, initial=self.seeder.solve(self.poses).joints, seeder=None)


def accepted_budget(solver: Solver, config: EvaluateConfig) -> Budget | None:
    """Return the configured budget as far as a solver accepts it; None leaves it its own."""
    time_s = config.time_s if "time_s" in solver.budgets else None
    iterations = config.iterations if "iterations" in solver.budgets else None
    return None if time_s is None and iterations is None else Budget(time_s, iterations)
