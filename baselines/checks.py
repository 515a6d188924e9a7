"""Input checks shared by all solvers, so that each refuses the same input by the same name."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.errors import InitialError, PoseError

# Poses often pass through float32; a quaternion is further off only if something is wrong.
UNIT_TOLERANCE = 1e-3


def check_poses(poses: ArrayLike) -> NDArray[np.float64]:
    """Check target poses and make their quaternions exactly unit.

    Args:
        poses: (N, 7) tip poses in the base frame, x y z in m, then qw qx qy qz. An empty list
            counts as N = 0.

    Returns:
        (N, 7) float64 copy with quaternions normalised.

    Raises:
        PoseError: Wrong shape, a value that is not finite, or a quaternion that is not unit.
    """
    array = np.array(poses, dtype=np.float64)
    if array.size == 0:
        return np.empty((0, 7))
    if array.ndim != 2 or array.shape[1] != 7:
        raise PoseError(
            f"expected poses of shape (N, 7), x y z qw qx qy qz, got {array.shape}"
            + ("; for one pose pass pose[None]" if array.shape == (7,) else "")
        )
    finite = np.isfinite(array).all(axis=1)
    if not finite.all():
        row = int(np.argmin(finite))
        raise PoseError(f"pose {row} has a value that is not finite (NaN or inf): {array[row]}")
    norm = np.linalg.norm(array[:, 3:], axis=1)
    unit = np.abs(norm - 1.0) <= UNIT_TOLERANCE
    if not unit.all():
        row = int(np.argmin(unit))
        raise PoseError(
            f"pose {row} has a quaternion (qw qx qy qz) of norm {norm[row]:.6g}, expected a unit "
            "quaternion, scalar first; divide it by its norm"
        )
    array[:, 3:] /= norm[:, None]
    return array


def check_initial(
    initial: ArrayLike | None,
    count: int,
    home: NDArray[np.float64],
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Make one initial guess per pose, moved into the joint limits.

    Args:
        initial: (dof,) for all poses, (N, dof) one for each, or None for `home` [rad or m].
        count: Number of poses N.
        home: (dof,) the robot's idle configuration.
        lower: (dof,) lower joint limits.
        upper: (dof,) upper joint limits.

    Returns:
        (N, dof) float64 inside the limits.

    Raises:
        InitialError: Wrong shape or a value that is not finite.
    """
    dof = home.shape[0]
    array = np.asarray(home if initial is None else initial, dtype=np.float64)
    if array.shape not in ((dof,), (count, dof)):
        raise InitialError(
            f"expected initial joints of shape ({dof},) or ({count}, {dof}), got {array.shape}"
        )
    if not np.isfinite(array).all():
        raise InitialError("initial joints have a value that is not finite (NaN or inf)")
    return np.clip(np.broadcast_to(array, (count, dof)), lower, upper)
