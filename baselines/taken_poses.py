"""Poses as solvers take them, compiled: what `baselines.checks.check_poses` does to sound ones."""

from __future__ import annotations

import numpy as np

from robots.compiled import njit
from robots.limits import FARTHEST
from robots.rotations import UNIT_TOLERANCE


@njit(_nrt=False)
def take_pose(pose, target):  # type: ignore[no-untyped-def]
    """Copy a pose with its quaternion made exactly unit, as `checks.check_poses` does.

    Args:
        pose: (7,) x y z [m], qw qx qy qz.
        target: (7,) receives it.

    Returns:
        Whether that function would take it and leave its position as it is.
    """
    for i in range(3):
        if not abs(pose[i]) <= FARTHEST:
            return False
    square = 0.0
    for i in range(3, 7):
        square += pose[i] * pose[i]
    norm = np.sqrt(square)
    if not abs(norm - 1.0) <= UNIT_TOLERANCE:
        return False
    for i in range(7):
        target[i] = pose[i] if i < 3 else pose[i] / norm
    return True


@njit(nogil=True, _nrt=False)
def take_poses(poses, targets):  # type: ignore[no-untyped-def]
    """Copy poses (N, 7) into targets (N, 7) by `take_pose`; return whether it took all."""
    taken = True
    for row in range(poses.shape[0]):
        taken &= take_pose(poses[row], targets[row])
    return taken
