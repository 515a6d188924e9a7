"""Poses as the matrices that other libraries want."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def pose_matrix(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Homogeneous transform (4, 4) of one pose (7,) with a unit quaternion, scalar first.

    In plain numbers: it runs inside a timed query, where small NumPy operations would show.
    """
    x, y, z, qw, qx, qy, qz = pose.tolist()
    return np.array(
        [
            [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy), x],
            [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx), y],
            [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy), z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
