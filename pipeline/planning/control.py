"""Control points by rule: how a path leaves its start and how it arrives at its target."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.planning.config import MotionConfig

UP = np.array([0.0, 0.0, 1.0])  # the base frames of all our robots have z pointing up


def control_points(
    start: ArrayLike, target: ArrayLike, motion: MotionConfig
) -> NDArray[np.float64]:
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
