"""How far a file's answers are from the network's, heads that are equally good apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.exporting.source import Source

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """Answers beside those of the network evaluated in float64, and of the solver.

    Attributes:
        poses: Number of poses.
        largest: Largest difference from the network's answer of the same head [rad or m].
        ties: Poses where another head was taken that is as good.
        other: Poses where another head was taken that is not.
        precision: In which the solver `cycleik` computes.
        solver_largest: As `largest`, between the solver and the network.
        solver_other: Poses where the solver took another head, or, between two cells, another
            expert.
        from_solver: Largest difference between the answers and the solver's, of the other poses.
    """

    poses: int
    largest: float
    ties: int
    other: int
    precision: str
    solver_largest: float
    solver_other: int
    from_solver: float

    def sentence(self) -> str:
        """All of it for a person."""
        return (
            f"largest difference over {self.poses} poses {self.from_solver:.1e} from the solver, "
            f"which computes in {self.precision} (another head or expert: {self.solver_other}), "
            f"{self.largest:.1e} from the network evaluated in float64 (ties: {self.ties})"
        )


def compare(source: Source, poses: Array, joints: Array, tie: float) -> Comparison:
    """Compare answers.

    Args:
        source: The robot and its network.
        poses: (N, 7) targets.
        joints: (N, dof) answers of a file [rad or m].
        tie: Heads whose errors, in tolerances, differ by less are equally good.
    """
    assert source.solver is not None
    truth = source.precise_hypotheses(poses)
    errors = source.ranking[0] * truth.position_mm / 1e3
    errors = errors + source.ranking[1] * np.radians(truth.rotation_deg)
    best, rows = errors.argmin(axis=1), np.arange(len(poses))
    taken, away = _nearest_head(truth.joints, joints)
    changed = taken != best
    tied = np.abs(errors[rows, taken] - errors[rows, best]) < tie
    answers = source.solver.hypotheses(poses).joints[:, 0]
    theirs, far = _nearest_head(truth.joints, answers)
    same = (theirs == best) & (far < tie)
    apart = np.abs(joints - answers).max(axis=1)
    return Comparison(
        len(poses),
        float(away.max(initial=0.0)),
        int((changed & tied).sum()),
        int((changed & ~tied).sum()),
        source.solver.precision,
        float(far[same].max(initial=0.0)),
        int((~same).sum()),
        float(apart[same & ~changed].max(initial=0.0)),
    )


def _nearest_head(heads: Array, joints: Array) -> tuple[NDArray[np.int64], Array]:
    """Which of the answers (N, K, dof) the joints (N, dof) are nearest to, and how near."""
    away = np.abs(heads - joints[:, None]).max(axis=2)
    nearest = away.argmin(axis=1)
    return nearest, away[np.arange(len(joints)), nearest]
