"""Input checks shared by all solvers, so that each refuses the same input by the same name."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.errors import InitialError, PoseError, SettingError
from robots.arguments import as_float, as_floats, as_int
from robots.limits import FARTHEST, nearest_turns
from robots.rotations import UNIT_TOLERANCE

# Poses from which on it is a compiled function that looks at each.
MANY = 64
# More threads than any machine has are a slip.
MOST_THREADS = 4096


def check_poses(poses: ArrayLike) -> NDArray[np.float64]:
    """Check target poses and make their quaternions exactly unit.

    Args:
        poses: (N, 7) tip poses in the base frame, x y z in m, then qw qx qy qz. An empty list
            counts as N = 0.

    Returns:
        (N, 7) float64 copy with quaternions normalised. Positions that no robot reaches are drawn
        in along their direction to `robots.limits.FARTHEST`, whose square is still a number.

    Raises:
        PoseError: No real numbers, wrong shape, a value that is not finite, or a quaternion that
            is not unit.
    """
    given = as_floats(poses, "poses", PoseError)
    if given.size == 0:
        return np.empty((0, 7))
    if given.ndim == 2 and given.shape[1] == 7 and len(given) >= MANY:
        from baselines.taken_poses import take_poses  # which is compiled when it is first called

        targets = np.empty_like(given)
        if take_poses(given, targets):
            return targets
    array = given.copy()
    if array.ndim != 2 or array.shape[1] != 7:
        raise PoseError(
            f"expected poses of shape (N, 7), x y z qw qx qy qz, got {array.shape}"
            + ("; for one pose pass pose[None]" if array.shape == (7,) else "")
        )
    finite = np.isfinite(array)
    if not finite.all():
        row = int(np.argmin(finite.all(axis=1)))
        raise PoseError(f"pose {row} has a value that is not finite (NaN or inf): {array[row]}")
    with np.errstate(over="ignore"):
        w, x, y, z = array[:, 3:].T  # by columns: five times as fast as by rows
        norm = np.sqrt(w * w + x * x + y * y + z * z)
    unit = np.abs(norm - 1.0) <= UNIT_TOLERANCE
    if not unit.all():
        row = int(np.argmin(unit))
        raise PoseError(
            f"pose {row} has a quaternion (qw qx qy qz) of norm {norm[row]:.6g}, expected a unit "
            "quaternion, scalar first; divide it by its norm"
        )
    for column in (w, x, y, z):
        column /= norm
    if np.abs(array).max() > FARTHEST:
        largest = np.abs(array[:, :3]).max(axis=1)
        far = largest > FARTHEST
        array[far, :3] *= FARTHEST / largest[far, None]
    return array


def check_initial(
    initial: ArrayLike | None,
    count: int,
    home: NDArray[np.float64],
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
    endless: NDArray[np.bool_] | None = None,
) -> NDArray[np.float64]:
    """Make one initial guess per pose, moved into the joint limits.

    Args:
        initial: (dof,) for all poses, (N, dof) one for each, or None for `home` [rad or m].
        count: Number of poses N.
        home: (dof,) the robot's idle configuration.
        lower: (dof,) lower joint limits.
        upper: (dof,) upper joint limits.
        endless: (dof,) which joints turn for ever and so by full turns; none if not given.

    Returns:
        (N, dof) float64 inside the limits.

    Raises:
        InitialError: No real numbers, wrong shape or a value that is not finite.
    """
    dof = home.shape[0]
    if initial is None:
        seeds = np.empty((count, dof))
        seeds[:] = np.minimum(np.maximum(home, lower), upper)
        return seeds
    array = as_floats(initial, "initial joints", InitialError)
    if array.shape not in ((dof,), (count, dof)):
        raise InitialError(
            f"expected initial joints of shape ({dof},) or ({count}, {dof}), got {array.shape}"
        )
    if not np.isfinite(array).all():
        raise InitialError("initial joints have a value that is not finite (NaN or inf)")
    rows = np.broadcast_to(array, (count, dof))
    if endless is not None and endless.any():
        near = np.where(np.abs(rows) <= FARTHEST, rows, 0.0)
        turned = nearest_turns(near, (lower + upper) / 2, endless, lower, upper)
        rows = np.where(endless, turned, rows)
    return np.clip(rows, lower, upper)


def positive_settings(values: Mapping[str, object]) -> dict[str, float]:
    """Check settings that must be finite numbers above zero.

    Raises:
        SettingError: One is not.
    """
    checked = {key: as_float(value, key, SettingError) for key, value in values.items()}
    for key, value in checked.items():
        if not 0.0 < value < math.inf:
            raise SettingError(f"expected {key} to be a finite number above 0, got {value:g}")
    return checked


def damping_settings(damping: object, damping_gain: object) -> tuple[float, float]:
    """Check the damping of a descent: neither part below zero, and not both zero.

    Raises:
        SettingError: They are, or no finite numbers.
    """
    parts = as_float(damping, "damping", SettingError), as_float(damping_gain, "gain", SettingError)
    if not (min(parts) >= 0.0 and 0.0 < sum(parts) < math.inf):
        raise SettingError(
            f"expected damping and its gain to be finite, not below 0 and not both 0, got "
            f"{parts[0]:g} and {parts[1]:g}"
        )
    return parts


def count_settings(values: Mapping[str, object], least: int = 1) -> dict[str, int]:
    """Check settings that must be whole numbers of at least `least`.

    Raises:
        SettingError: One is not.
    """
    checked = {key: as_int(value, key, SettingError) for key, value in values.items()}
    for key, value in checked.items():
        if not least <= value < 2**62:
            raise SettingError(f"expected {key} to be at least {least}, got {value}")
    return checked


def thread_setting(threads: object) -> int:
    """Check a number of threads: 0 for all there are, or a number that a machine may have.

    Raises:
        SettingError: It is neither.
    """
    count = as_int(threads, "threads", SettingError)
    if not 0 <= count <= MOST_THREADS:
        raise SettingError(f"expected threads of 0 (all) to {MOST_THREADS}, got {count}")
    return count
