"""The tip's path and its control points: Bezier in position, Slerp or Bezier in rotation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.planning.bezier import bezier_curve, path_parameter
from pipeline.planning.rotation import slerp, spherical_bezier

if TYPE_CHECKING:
    from pipeline.planning.config import MotionConfig

Array = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])  # the base frames of all our robots have z pointing up
UNIT = 1e-6  # by how much the length of a unit quaternion may differ from 1


class PathError(ValueError):
    """An end, control points or key rotations that no path can have."""


def tip_path(
    start: ArrayLike,
    target: ArrayLike,
    control_points: ArrayLike | None = None,
    steps: int = 50,
    control_rotations: ArrayLike | None = None,
) -> Array:
    """Sample the poses of a path from its control points.

    Equations 10 to 12 of the paper. The k of `path_parameter` runs from 0 at the start to 1 at the
    target in `steps` samples, both included.

    Args:
        start: Start pose, base frame, shape (7,).
        target: Target pose, base frame, shape (7,).
        control_points: Inner control points, base frame [m], shape (n, 3); none is a straight line.
        steps: Number of poses, at least 2.
        control_rotations: Inner key rotations, unit quaternions, shape (m, 4); none is Slerp.

    Returns:
        Poses, base frame, shape (steps, 7).

    Raises:
        PathError: An argument of another shape, not finite, or with a quaternion that is not unit.
    """
    first, last = checked_pose("start", start), checked_pose("target", target)
    inner = _rows("control_points", control_points, 3)
    k = path_parameter(steps)
    positions = bezier_curve(np.vstack([first[:3], inner, last[:3]]), k)
    if control_rotations is None:
        rotations = slerp(first[3:], last[3:], k)
    else:
        keys = _rows("control_rotations", control_rotations, 4)
        if (np.abs(np.linalg.norm(keys, axis=1) - 1.0) > UNIT).any():
            raise PathError(f"control_rotations must be unit quaternions, got {keys.tolist()}")
        rotations = spherical_bezier(np.vstack([first[3:], keys, last[3:]]), k)
    return np.hstack([positions, rotations])


def control_points(start: ArrayLike, target: ArrayLike, motion: MotionConfig) -> Array:
    """Place the inner control points of a motion above its ends.

    A Bezier curve leaves its start towards its second control point and arrives from its last but
    one. Points straight above the ends therefore make the first and the last leg vertical; the more
    often such a point is repeated, the longer the vertical leg: with `arrive_repeat` r the share of
    the sideways distance still to go falls as the power r + 1 of what is left of k.

    Args:
        start: Start pose or position, base frame [m], shape (7,) or (3,).
        target: Target pose or position, base frame [m], shape (7,) or (3,).
        motion: Heights [m] and repetitions; a repetition of 0 leaves a point out.

    Returns:
        Inner control points from start to target, base frame [m], shape (n, 3); n may be 0.
    """
    leave = np.asarray(start, dtype=np.float64)[:3] + motion.leave_height * UP
    arrive = np.asarray(target, dtype=np.float64)[:3] + motion.arrive_height * UP
    points = [leave] * motion.leave_repeat + [arrive] * motion.arrive_repeat
    return np.array(points, dtype=np.float64).reshape(-1, 3)


def checked_pose(name: str, value: ArrayLike) -> Array:
    """Return a pose (7,) as an array.

    Args:
        name: What to call it in an error.
        value: x, y, z [m] and a unit quaternion w, x, y, z.

    Raises:
        PathError: It is no pose.
    """
    pose = _numbers(name, value)
    if pose.shape != (7,) or not abs(np.linalg.norm(pose[3:]) - 1.0) <= UNIT:
        raise PathError(
            f"{name} must be a pose (x, y, z, unit quaternion w, x, y, z) of 7 finite numbers, got "
            f"{pose.tolist()}"
        )
    return pose


def checked_joints(name: str, value: ArrayLike, dof: int) -> Array:
    """Return joint positions (dof,) as an array.

    Raises:
        PathError: They are not as many finite numbers as there are joints.
    """
    joints = _numbers(name, value)
    if joints.shape != (dof,) or not np.isfinite(joints).all():
        raise PathError(
            f"{name} must be the {dof} joint positions of the robot, all finite, got "
            f"{joints.tolist()}"
        )
    return joints


def _rows(name: str, value: ArrayLike | None, width: int) -> Array:
    """Return rows (n, width) of finite numbers; none at all where there is no value."""
    rows = np.zeros((0, width)) if value is None else _numbers(name, value)
    if rows.size == 0:
        return np.zeros((0, width))
    if rows.ndim != 2 or rows.shape[1] != width or not np.isfinite(rows).all():
        raise PathError(
            f"{name} must have shape (n, {width}) and finite numbers, got shape {rows.shape}: "
            f"{rows.tolist()}"
        )
    return rows


def _numbers(name: str, value: ArrayLike) -> Array:
    """Return a value as an array of floats."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise PathError(f"{name} must be numbers in an array, got {value!r}") from error
