"""The tip's path: Bezier in position, Slerp or spherical Bezier in rotation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.planning.bezier import bezier_curve, path_parameter
from pipeline.planning.rotation import slerp, spherical_bezier

Array = NDArray[np.float64]


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
    """
    first, last = np.asarray(start, dtype=np.float64), np.asarray(target, dtype=np.float64)
    inner = np.zeros((0, 3)) if control_points is None else np.asarray(control_points, np.float64)
    k = path_parameter(steps)
    positions = bezier_curve(np.vstack([first[:3], inner.reshape(-1, 3), last[:3]]), k)
    if control_rotations is None:
        rotations = slerp(first[3:], last[3:], k)
    else:
        keys = np.asarray(control_rotations, dtype=np.float64).reshape(-1, 4)
        rotations = spherical_bezier(np.vstack([first[3:], keys, last[3:]]), k)
    return np.hstack([positions, rotations])
