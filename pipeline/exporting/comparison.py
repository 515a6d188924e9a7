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
        solver_largest: As `largest`, between the solver `cycleik`, which computes in float32, and
            the network.
        solver_other: Poses where the solver took another head, or, between two cells, another
            expert.
    """

    poses: int
    largest: float
    ties: int
    other: int
    solver_largest: float
    solver_other: int

    def sentence(self) -> str:
        """All of it for a person."""
        return (
            f"largest difference over {self.poses} poses {self.largest:.1e} from the network in "
            f"float64 (ties: {self.ties}); the solver, in float32, is {self.solver_largest:.1e} "
            f"from it (another head or expert: {self.solver_other})"
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
    theirs, far = _nearest_head(truth.joints, source.solver.hypotheses(poses).joints[:, 0])
    same = (theirs == best) & (far < tie)
    return Comparison(
        len(poses),
        float(away.max(initial=0.0)),
        int((changed & tied).sum()),
        int((changed & ~tied).sum()),
        float(far[same].max(initial=0.0)),
        int((~same).sum()),
    )


def _nearest_head(heads: Array, joints: Array) -> tuple[NDArray[np.int64], Array]:
    """Which of the answers (N, K, dof) the joints (N, dof) are nearest to, and how near."""
    away = np.abs(heads - joints[:, None]).max(axis=2)
    nearest = away.argmin(axis=1)
    return nearest, away[np.arange(len(joints)), nearest]
