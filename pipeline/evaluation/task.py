"""What is evaluated: one solver of one robot on one set of poses, and where it starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from baselines import Budget, Freedom, Solver
from baselines.abilities import AVOID, FOLLOW, PARTIAL
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
        freedoms: What each of the N targets leaves open; None for whole poses. A solver that
            knows whole poses only solves those, and is judged under the freedoms all the same.
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
    freedoms: tuple[Freedom, ...] | None = None
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

    @property
    def in_part(self) -> bool:
        """Whether the solver is asked under the freedoms, not for whole poses."""
        return self.freedoms is not None and self.solver.lacks(PARTIAL) is None

    def part(self, start: int, stop: int) -> EvaluationTask:
        """Return it on the poses ``start`` to ``stop``; the first follows the last."""
        if stop <= len(self.poses):
            return self._at(slice(start, stop))
        return self._at(np.arange(start, stop) % len(self.poses))

    def _at(self, rows: slice | NDArray[np.int64]) -> EvaluationTask:
        initial = self.initial
        if initial is not None and initial.ndim == 2:
            initial = np.ascontiguousarray(initial[rows])
        follows = None if self.follows is None else self.follows[rows]
        freedoms, avoid = _of(self.freedoms, rows), _of(self.avoid, rows)
        return replace(
            self,
            # Columns of a file lie one after another; a caller's pose is in one piece.
            poses=np.ascontiguousarray(self.poses[rows]),
            initial=initial,
            follows=follows,
            freedoms=None if freedoms is None else tuple(freedoms),
            avoid=avoid,
        )

    @property
    def asks_to_avoid(self) -> bool:
        """Whether the solver is told what to avoid."""
        return self.avoid is not None and self.solver.lacks(AVOID) is None

    @property
    def asks_to_follow(self) -> bool:
        """Whether all poses follow others, and the solver is told so."""
        return (
            self.follows is not None
            and bool(self.follows.all())
            and self.solver.lacks(FOLLOW) is None
        )

    def seeded(self) -> EvaluationTask:
        """Return the same task with the seeder's answers as initial guesses."""
        if self.seeder is None:
            return self
        return replace(self, initial=self.seeder.solve(self.poses).joints, seeder=None)


def _of(each: Sequence[Any] | None, rows: slice | NDArray[np.int64]) -> list[Any] | None:
    """What some rows have of a list with one thing a pose."""
    return None if each is None else [each[row] for row in np.arange(len(each))[rows]]


def accepted_budget(solver: Solver, config: EvaluateConfig) -> Budget | None:
    """Return the configured budget as far as a solver accepts it; None leaves it its own."""
    time_s = config.time_of(solver.name) if "time_s" in solver.budgets else None
    iterations = config.iterations if "iterations" in solver.budgets else None
    return None if time_s is None and iterations is None else Budget(time_s, iterations)
