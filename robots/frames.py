# ruff: noqa: RUF005 - numba knows tuple sums, but no unpacking inside a tuple
"""Frames in compiled code: tuples of twelve numbers, the rotation row by row, then the origin.

The compiler keeps such a tuple in registers, where small arrays would go through memory. The
functions are inlined into the kernels of `robots.kinematics`, `robots.collision_kernel` and
`baselines.linearise`.

Each states `fastmath` and `forceinline`: what a function leaves open, numba takes from the caller
that needs it first, and its results in all other callers would depend on the order of compilation.
Left to LLVM, some of these calls stay calls and pass their frames through memory.
"""

from __future__ import annotations

import math

from robots.compiled import njit


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def constant_frame(rotation, translation):  # type: ignore[no-untyped-def]
    """Frame tuple of a rotation (3, 3) and a translation (3,) in m."""
    return (
        (rotation[0, 0], rotation[0, 1], rotation[0, 2])
        + (rotation[1, 0], rotation[1, 1], rotation[1, 2])
        + (rotation[2, 0], rotation[2, 1], rotation[2, 2])
        + (translation[0], translation[1], translation[2])
    )


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def turned(frame, sine, cosine):  # type: ignore[no-untyped-def]
    """Turn a frame about its own z axis, by an angle given by its sine and cosine."""
    a, b, c, d, e, f, g, h, i, x, y, z = frame
    return (
        (cosine * a + sine * b, cosine * b - sine * a, c)
        + (cosine * d + sine * e, cosine * e - sine * d, f)
        + (cosine * g + sine * h, cosine * h - sine * g, i)
        + (x, y, z)
    )


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def slid(frame, length):  # type: ignore[no-untyped-def]
    """Shift a frame along its own z axis, by a length in m."""
    a, b, c, d, e, f, g, h, i, x, y, z = frame
    return (a, b, c, d, e, f, g, h, i, x + c * length, y + f * length, z + i * length)


@njit(inline="always")
def moved(frame, prismatic, position, sine, cosine):  # type: ignore[no-untyped-def]
    """Move a frame by its joint, whose axis is the frame's own z axis.

    Args:
        frame: Frame tuple.
        prismatic: Whether the joint slides.
        position: Of the joint, m where it slides.
        sine: Of the position of a joint that turns.
        cosine: Of the same.
    """
    if prismatic:
        return slid(frame, position)
    return turned(frame, sine, cosine)


@njit(fastmath={"contract"}, forceinline=True)
def multiplied(frame, rotation, translation):  # type: ignore[no-untyped-def]
    """Multiply a frame by a constant transform on its right.

    Args:
        frame: Frame tuple.
        rotation: (3, 3) of the constant transform.
        translation: (3,) of the constant transform, m.
    """
    return composed(frame, constant_frame(rotation, translation))


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def composed(frame, constant):  # type: ignore[no-untyped-def]
    """Multiply a frame by another one on its right, which may hold for many frames."""
    a, b, c, d, e, f, g, h, i, x, y, z = frame
    xx, xy, xz, yx, yy, yz, zx, zy, zz, tx, ty, tz = constant
    return (
        (a * xx + b * yx + c * zx, a * xy + b * yy + c * zy, a * xz + b * yz + c * zz)
        + (d * xx + e * yx + f * zx, d * xy + e * yy + f * zy, d * xz + e * yz + f * zz)
        + (g * xx + h * yx + i * zx, g * xy + h * yy + i * zy, g * xz + h * yz + i * zz)
        + (x + a * tx + b * ty + c * tz, y + d * tx + e * ty + f * tz, z + g * tx + h * ty + i * tz)
    )


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def store_frame(frame, R, p):  # type: ignore[no-untyped-def]
    """Write a frame tuple into a rotation (3, 3) and an origin (3,)."""
    R[0, 0], R[0, 1], R[0, 2] = frame[0], frame[1], frame[2]
    R[1, 0], R[1, 1], R[1, 2] = frame[3], frame[4], frame[5]
    R[2, 0], R[2, 1], R[2, 2] = frame[6], frame[7], frame[8]
    p[0], p[1], p[2] = frame[9], frame[10], frame[11]


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def quaternion_of(R, quaternion):  # type: ignore[no-untyped-def]
    """Canonical unit quaternion of a rotation, after Shepperd (1978).

    Args:
        R: (3, 3) rotation.
        quaternion: (4,) receives w x y z, w >= 0.
    """
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    if trace > R[0, 0] and trace > R[1, 1] and trace > R[2, 2]:
        w, x, y, z = 1 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    elif R[0, 0] >= R[1, 1] and R[0, 0] >= R[2, 2]:
        w, x = R[2, 1] - R[1, 2], 1 + R[0, 0] - R[1, 1] - R[2, 2]
        y, z = R[1, 0] + R[0, 1], R[0, 2] + R[2, 0]
    elif R[1, 1] >= R[2, 2]:
        w, y = R[0, 2] - R[2, 0], 1 - R[0, 0] + R[1, 1] - R[2, 2]
        x, z = R[1, 0] + R[0, 1], R[2, 1] + R[1, 2]
    else:
        w, z = R[1, 0] - R[0, 1], 1 - R[0, 0] - R[1, 1] + R[2, 2]
        x, y = R[0, 2] + R[2, 0], R[2, 1] + R[1, 2]
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    if w < 0.0:
        scale = -scale
    quaternion[0] = w * scale
    quaternion[1] = x * scale
    quaternion[2] = y * scale
    quaternion[3] = z * scale
