"""Compiled tip error and Jacobian of one configuration: what every local method of ours stands on.

The same recursion as `robots.kinematics`, kept in scalars so that the compiler holds the frame in
registers; tests hold the two equal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Linearisation(NamedTuple):
    """Arrays that `linearise` writes for one configuration.

    Attributes:
        goal: (3, 3) rotation of the target, set by `aim`.
        axes: (m, 3) joint axes in the base frame.
        origins: (m, 3) points on the joint axes in the base frame [m].
        error: (6,) from tip to target: distance [m], then rotation vector [rad], axes of the base.
        jacobian: (dof, 6) geometric Jacobian at the tip, transposed: one row a joint.
        tip: (12,) tip position [m], then the rows of its rotation.
    """

    goal: Array
    axes: Array
    origins: Array
    error: Array
    jacobian: Array
    tip: Array


@njit(cache=True)
def new_linearisation(joints, dof):  # type: ignore[no-untyped-def]
    """Room for a chain of `joints` driven joints and `dof` variables."""
    return Linearisation(
        np.empty((3, 3)),
        np.empty((joints, 3)),
        np.empty((joints, 3)),
        np.empty(6),
        np.empty((dof, 6)),
        np.empty(12),
    )


@njit(cache=True)
def aim(pose, at):  # type: ignore[no-untyped-def]
    """Set the target rotation from a pose (7,) with a unit quaternion."""
    w, x, y, z = pose[3], pose[4], pose[5], pose[6]
    at.goal[0, 0] = 1 - 2 * (y * y + z * z)
    at.goal[0, 1] = 2 * (x * y - w * z)
    at.goal[0, 2] = 2 * (x * z + w * y)
    at.goal[1, 0] = 2 * (x * y + w * z)
    at.goal[1, 1] = 1 - 2 * (x * x + z * z)
    at.goal[1, 2] = 2 * (y * z - w * x)
    at.goal[2, 0] = 2 * (x * z - w * y)
    at.goal[2, 1] = 2 * (y * z + w * x)
    at.goal[2, 2] = 1 - 2 * (x * x + y * y)


@njit(cache=True, fastmath={"contract"})
def find_frames(chain, q, at):  # type: ignore[no-untyped-def]
    """Tip frame, and axis and origin of every joint, for the configuration q (dof,)."""
    F, t = chain.rotations, chain.translations
    px, py, pz = t[0, 0], t[0, 1], t[0, 2]
    xx, yx, zx = F[0, 0, 0], F[0, 0, 1], F[0, 0, 2]
    xy, yy, zy = F[0, 1, 0], F[0, 1, 1], F[0, 1, 2]
    xz, yz, zz = F[0, 2, 0], F[0, 2, 1], F[0, 2, 2]
    for k in range(chain.prismatic.shape[0]):
        at.axes[k, 0], at.axes[k, 1], at.axes[k, 2] = zx, zy, zz
        at.origins[k, 0], at.origins[k, 1], at.origins[k, 2] = px, py, pz
        position = chain.multiplier[k] * q[chain.variable[k]] + chain.offset[k]
        if chain.prismatic[k]:
            px += zx * position
            py += zy * position
            pz += zz * position
        else:
            sine, cosine = math.sin(position), math.cos(position)
            xx, yx = cosine * xx + sine * yx, cosine * yx - sine * xx
            xy, yy = cosine * xy + sine * yy, cosine * yy - sine * xy
            xz, yz = cosine * xz + sine * yz, cosine * yz - sine * xz
        a, b, c = t[k + 1, 0], t[k + 1, 1], t[k + 1, 2]
        px += xx * a + yx * b + zx * c
        py += xy * a + yy * b + zy * c
        pz += xz * a + yz * b + zz * c
        a, b, c = F[k + 1, 0, 0], F[k + 1, 1, 0], F[k + 1, 2, 0]
        d, e, f = F[k + 1, 0, 1], F[k + 1, 1, 1], F[k + 1, 2, 1]
        g, h, i = F[k + 1, 0, 2], F[k + 1, 1, 2], F[k + 1, 2, 2]
        xx, yx, zx = (
            xx * a + yx * b + zx * c,
            xx * d + yx * e + zx * f,
            xx * g + yx * h + zx * i,
        )
        xy, yy, zy = (
            xy * a + yy * b + zy * c,
            xy * d + yy * e + zy * f,
            xy * g + yy * h + zy * i,
        )
        xz, yz, zz = (
            xz * a + yz * b + zz * c,
            xz * d + yz * e + zz * f,
            xz * g + yz * h + zz * i,
        )
    tip = at.tip
    tip[0], tip[1], tip[2] = px, py, pz
    tip[3], tip[4], tip[5] = xx, yx, zx
    tip[6], tip[7], tip[8] = xy, yy, zy
    tip[9], tip[10], tip[11] = xz, yz, zz


@njit(cache=True, fastmath={"contract"})
def find_error(pose, at):  # type: ignore[no-untyped-def]
    """Write the error from tip to target; return its squared distance [m²] and angle [rad²].

    Twice the sine times the axis of the rotation between two frames is the sum of the cross
    products of their axes (Siciliano et al., "Robotics: Modelling, Planning and Control", 3.7.3).
    """
    goal, tip, error = at.goal, at.tip, at.error
    sx = sy = sz = 0.0
    trace = 0.0
    for k in range(3):
        rx, ry, rz = tip[3 + k], tip[6 + k], tip[9 + k]
        gx, gy, gz = goal[0, k], goal[1, k], goal[2, k]
        sx += ry * gz - rz * gy
        sy += rz * gx - rx * gz
        sz += rx * gy - ry * gx
        trace += rx * gx + ry * gy + rz * gz
    sine2 = math.sqrt(sx * sx + sy * sy + sz * sz)
    cosine2 = trace - 1.0
    angle = math.atan2(sine2, cosine2)
    if sine2 > 1e-9:
        scale = angle / sine2
    elif cosine2 > 0.0:
        scale = 0.5
    else:
        # Half a turn: any axis does to get away from here, the next step knows better.
        sx, sy, sz, scale = 1.0, 0.0, 0.0, math.pi
    dx, dy, dz = pose[0] - tip[0], pose[1] - tip[1], pose[2] - tip[2]
    error[0], error[1], error[2] = dx, dy, dz
    error[3], error[4], error[5] = scale * sx, scale * sy, scale * sz
    return dx * dx + dy * dy + dz * dz, angle * angle


@njit(cache=True, fastmath={"contract"})
def find_jacobian(chain, at):  # type: ignore[no-untyped-def]
    """Geometric Jacobian at the tip, axes of the base, transposed, after `find_frames`."""
    J, tip = at.jacobian, at.tip
    plain = chain.variable.shape[0] == J.shape[0]
    if not plain:
        J[:, :] = 0.0
    for k in range(chain.prismatic.shape[0]):
        scale = chain.multiplier[k]
        zx, zy, zz = scale * at.axes[k, 0], scale * at.axes[k, 1], scale * at.axes[k, 2]
        dx = tip[0] - at.origins[k, 0]
        dy = tip[1] - at.origins[k, 1]
        dz = tip[2] - at.origins[k, 2]
        vx, vy, vz = zy * dz - zz * dy, zz * dx - zx * dz, zx * dy - zy * dx
        if chain.prismatic[k]:
            vx, vy, vz, zx, zy, zz = zx, zy, zz, 0.0, 0.0, 0.0
        row = chain.variable[k]
        if plain:
            J[row, 0], J[row, 1], J[row, 2] = vx, vy, vz
            J[row, 3], J[row, 4], J[row, 5] = zx, zy, zz
        else:
            # A joint that mimics another one adds to its column.
            J[row, 0] += vx
            J[row, 1] += vy
            J[row, 2] += vz
            J[row, 3] += zx
            J[row, 4] += zy
            J[row, 5] += zz
