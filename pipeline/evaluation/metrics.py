"""Errors of reached poses in two families, which are both stored and never mixed.

*geodesic*: Euclidean distance of the tips and the angle of ``R_target^T R``. *paper*: as the
authors' released evaluation, the mean of |dx|, |dy|, |dz| and of the absolute values of the three
Euler angles of ``R_target R^T``, the error in axes of the base, about fixed axes, z, then y, then x
(SciPy's ``as_euler("zyx")``); for errors without a preferred direction about half of the geodesic
family. The angle of both products is the same, their Euler angles are not: where errors are large
the mean differs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import PipelineError
from robots.rotations import (
    matrix_from_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    rotation_angle,
)

Array = NDArray[np.float64]
MM_PER_M = 1000.0
GIMBAL_COSINE = 1e-7  # below it two Euler axes coincide and only the sum of their angles is known
UNIT_SLACK = 1e-6


class MetricError(PipelineError):
    """Poses that no error can be computed of."""


@dataclass(frozen=True)
class PoseErrors:
    """Errors of N poses in both families, each (N,), in mm and deg.

    Attributes:
        position_mm: Euclidean distance.
        rotation_deg: Geodesic angle, 0 to 180.
        paper_position_mm: Mean absolute distance over the three axes.
        paper_rotation_deg: Mean absolute Euler angle over the three axes.
    """

    position_mm: Array
    rotation_deg: Array
    paper_position_mm: Array
    paper_rotation_deg: Array


def pose_errors(target: ArrayLike, reached: ArrayLike) -> PoseErrors:
    """Compute all errors of reached poses; the sign of a quaternion does not matter.

    Args:
        target: (N, 7) poses x y z [m], qw qx qy qz.
        reached: (N, 7) poses in the same frame.

    Raises:
        MetricError: Shapes that are not (N, 7) twice, values that are not finite, quaternions that
            are not of unit length.
    """
    goal, got = _checked(target, "target"), _checked(reached, "reached")
    if goal.shape != got.shape:
        raise MetricError(f"expected as many reached as target poses, got {len(got)}, {len(goal)}")
    offset = goal[:, :3] - got[:, :3]
    return PoseErrors(
        position_mm=np.linalg.norm(offset, axis=1) * MM_PER_M,
        rotation_deg=np.rad2deg(rotation_angle(goal[:, 3:], got[:, 3:])),
        paper_position_mm=np.abs(offset).mean(axis=1) * MM_PER_M,
        paper_rotation_deg=np.rad2deg(_mean_euler_angle(goal[:, 3:], got[:, 3:])),
    )


def euler_zyx(matrix: ArrayLike) -> Array:
    """Euler angles about the fixed axes z, then y, then x: ``R = R_x(c) R_y(b) R_z(a)``.

    Where the middle angle is a quarter turn only the sum or difference of the other two is known;
    the last one is zero then.

    Args:
        matrix: (..., 3, 3) rotation matrices.

    Returns:
        (..., 3) angles a, b, c [rad], b in [-pi/2, pi/2].
    """
    R = np.asarray(matrix, dtype=np.float64)
    cosine = np.hypot(R[..., 0, 0], R[..., 0, 1])
    locked = cosine < GIMBAL_COSINE
    z = np.where(
        locked,
        np.arctan2(R[..., 1, 0], R[..., 1, 1]),
        np.arctan2(-R[..., 0, 1], R[..., 0, 0]),
    )
    y = np.arctan2(R[..., 0, 2], cosine)
    x = np.where(locked, 0.0, np.arctan2(-R[..., 1, 2], R[..., 2, 2]))
    return np.stack([z, y, x], axis=-1)


def within(
    position_mm: ArrayLike, rotation_deg: ArrayLike, limit_mm: float, limit_deg: float
) -> NDArray[np.bool_]:
    """Return which errors lie below both limits; an error that is NaN lies below none."""
    position, rotation = np.asarray(position_mm), np.asarray(rotation_deg)
    return np.asarray((position < limit_mm) & (rotation < limit_deg))


def _mean_euler_angle(target: Array, reached: Array) -> Array:
    difference = quaternion_multiply(target, quaternion_conjugate(reached))
    return np.asarray(np.abs(euler_zyx(matrix_from_quaternion(difference))).mean(axis=-1))


def _checked(poses: ArrayLike, role: str) -> Array:
    array = np.asarray(poses, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 7:
        raise MetricError(f"expected {role} poses of shape (N, 7), got {array.shape}")
    if not np.isfinite(array).all():
        raise MetricError(f"expected finite {role} poses, got NaN or infinite values")
    if np.any(np.abs(np.linalg.norm(array[:, 3:], axis=1) - 1.0) > UNIT_SLACK):
        raise MetricError(f"expected unit quaternions (qw qx qy qz) in the {role} poses")
    return array
