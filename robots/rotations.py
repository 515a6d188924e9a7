"""Rotations in NumPy: unit quaternions, scalar first, and matrices, both batched.

The last axis (or the last two, for matrices) holds the rotation, every axis before it is batch.
Conventions: `R(q)` maps child-frame vectors to the parent frame, products compose left to right
along the chain, and a *canonical* quaternion has a scalar part that is not negative.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Of the norm of a quaternion that is handed in: poses often pass through float32, and one that is
# further off is so because something is wrong.
UNIT_TOLERANCE = 1e-3


def canonical(quaternion: ArrayLike) -> Array:
    """Choose the sign with w >= 0; both signs are the same rotation.

    Args:
        quaternion: (..., 4) scalar first. Where w is zero the first non-zero entry becomes
            positive, so that the choice is unique.
    """
    q = np.array(quaternion, dtype=np.float64)
    sign = np.sign(q)
    leading = np.take_along_axis(sign, np.argmax(sign != 0, axis=-1)[..., None], axis=-1)
    return np.where(leading < 0, -q, q)


def normalised(quaternion: ArrayLike) -> Array:
    """Scale to unit length.

    Args:
        quaternion: (..., 4) scalar first, not zero.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def matrix_from_quaternion(quaternion: ArrayLike) -> Array:
    """Rotation matrix of a unit quaternion.

    Args:
        quaternion: (..., 4) scalar first, unit length.

    Returns:
        (..., 3, 3) rotation matrices.
    """
    w, x, y, z = np.moveaxis(np.asarray(quaternion, dtype=np.float64), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """Canonical unit quaternion of a rotation matrix.

    Takes the largest of the four candidates, which is never small, as in Shepperd (1978),
    "Quaternion from rotation matrix": accurate near half turns too.

    Args:
        matrix: (..., 3, 3) rotation matrices.

    Returns:
        (..., 4) scalar first, w >= 0.
    """
    R = np.asarray(matrix, dtype=np.float64)
    m00, m11, m22 = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    zy, xz, yx = R[..., 2, 1], R[..., 0, 2], R[..., 1, 0]
    yz, zx, xy = R[..., 1, 2], R[..., 2, 0], R[..., 0, 1]
    # Row i is 4 q_i (w, x, y, z): each is the quaternion times four times one of its entries.
    rows = [
        [1 + m00 + m11 + m22, zy - yz, xz - zx, yx - xy],
        [zy - yz, 1 + m00 - m11 - m22, yx + xy, xz + zx],
        [xz - zx, yx + xy, 1 - m00 + m11 - m22, zy + yz],
        [yx - xy, xz + zx, zy + yz, 1 - m00 - m11 + m22],
    ]
    candidates = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    best = np.argmax(np.diagonal(candidates, axis1=-2, axis2=-1), axis=-1)
    chosen = np.take_along_axis(candidates, best[..., None, None], axis=-2)[..., 0, :]
    return canonical(normalised(chosen))


def quaternion_multiply(first: ArrayLike, second: ArrayLike) -> Array:
    """Hamilton product: the rotation `second`, then `first`.

    Args:
        first: (..., 4) scalar first.
        second: (..., 4) scalar first.
    """
    w1, x1, y1, z1 = np.moveaxis(np.asarray(first, dtype=np.float64), -1, 0)
    w2, x2, y2, z2 = np.moveaxis(np.asarray(second, dtype=np.float64), -1, 0)
    return np.stack(
        [
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
            w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
            w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
            w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        ],
        axis=-1,
    )


def quaternion_conjugate(quaternion: ArrayLike) -> Array:
    """Inverse of a unit quaternion, (..., 4) scalar first."""
    return np.asarray(quaternion, dtype=np.float64) * np.array([1.0, -1.0, -1.0, -1.0])


def rotation_angle(first: ArrayLike, second: ArrayLike) -> Array:
    """Geodesic distance: the angle of the rotation that takes one onto the other.

    The arctangent keeps full precision for small angles, where an arccosine of the inner
    product loses half of the digits.

    Args:
        first: (..., 4) unit quaternions, scalar first, either sign.
        second: (..., 4) unit quaternions, scalar first, either sign.

    Returns:
        (...) angles in rad, 0 to pi.
    """
    difference = quaternion_multiply(quaternion_conjugate(first), second)
    sine = np.linalg.norm(difference[..., 1:], axis=-1)
    return np.asarray(2.0 * np.arctan2(sine, np.abs(difference[..., 0])))


def rotation_vector_from_quaternion(quaternion: ArrayLike) -> Array:
    """Axis times angle (the logarithm), the shorter way round.

    Args:
        quaternion: (..., 4) unit, scalar first.

    Returns:
        (..., 3) in rad, in the parent frame, length at most pi.
    """
    q = canonical(quaternion)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    # angle / sine tends to 2 as the rotation vanishes.
    scale = np.divide(angle, sine, out=np.full_like(angle, 2.0), where=sine > 1e-12)
    return scale * q[..., 1:]


def quaternion_from_rotation_vector(vector: ArrayLike) -> Array:
    """Unit quaternion of a rotation vector (the exponential).

    Args:
        vector: (..., 3) axis times angle, rad.

    Returns:
        (..., 4) scalar first.
    """
    v = np.asarray(vector, dtype=np.float64)
    angle = np.linalg.norm(v, axis=-1, keepdims=True)
    # numpy.sinc is sin(pi x) / (pi x), finite at zero.
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * v], axis=-1)


def matrix_from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Rotation by `angle` about the unit vector `axis` (Rodrigues' formula).

    Args:
        axis: (..., 3) unit vectors.
        angle: (...) rad.
    """
    scaled = np.asarray(axis, dtype=np.float64) * np.asarray(angle, dtype=np.float64)[..., None]
    return matrix_from_quaternion(quaternion_from_rotation_vector(scaled))


def matrix_from_rpy(rpy: ArrayLike) -> Array:
    """Rotation of a URDF `rpy` attribute: roll, pitch, yaw about the fixed x, y, z axes.

    Args:
        rpy: (..., 3) rad. The matrix is Rz(yaw) Ry(pitch) Rx(roll).
    """
    roll, pitch, yaw = np.moveaxis(np.asarray(rpy, dtype=np.float64), -1, 0)
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rpy_from_matrix(matrix: ArrayLike) -> Array:
    """Roll, pitch, yaw about fixed axes, the inverse of `matrix_from_rpy`.

    Args:
        matrix: (..., 3, 3) rotation matrices.

    Returns:
        (..., 3) rad, pitch within +-pi/2; yaw is zero in gimbal lock.
    """
    R = np.asarray(matrix, dtype=np.float64)
    cosine = np.hypot(R[..., 0, 0], R[..., 1, 0])
    locked = cosine < 1e-12
    pitch = np.arctan2(-R[..., 2, 0], cosine)
    roll = np.arctan2(
        np.where(locked, -R[..., 1, 2], R[..., 2, 1]), np.where(locked, R[..., 1, 1], R[..., 2, 2])
    )
    yaw = np.where(locked, 0.0, np.arctan2(R[..., 1, 0], R[..., 0, 0]))
    return np.stack([roll, pitch, yaw], axis=-1)
