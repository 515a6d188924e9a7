"""Compiled tip error and Jacobian of one configuration: what every local method of ours stands on.

The recursion is that of `robots.kinematics`, from the same parts; but a descent needs the Jacobian
only where it goes on, one row a joint, so the joints' axes are kept and the Jacobian comes after.

All of a step is inlined by force, here, in `baselines.damped_step` and in `baselines.damped_solve`:
a call hands over every array of a `Linearisation` by itself, 49 numbers, and `lm` takes 1.6 to 1.8
times as long with calls.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.compiled import njit
from robots.frames import constant_frame, moved, multiplied, store_frame
from robots.trigonometry import sine_cosine

Array = NDArray[np.float64]


class Linearisation(NamedTuple):
    """Arrays that `linearise` writes for one configuration.

    Attributes:
        goal: (3, 3) rotation of the target, set by `set_target`.
        axes: (m, 3) joint axes in the base frame.
        origins: (m, 3) points on the joint axes in the base frame [m].
        error: (6,) from tip to target: distance [m], then rotation vector [rad], axes of the base.
        jacobian: (dof, 6) geometric Jacobian at the tip, transposed: one row a joint.
        rotation: (3, 3) of the tip.
        position: (3,) of the tip [m].
    """

    goal: Array
    axes: Array
    origins: Array
    error: Array
    jacobian: Array
    rotation: Array
    position: Array


@njit()
def new_linearisation(joints, dof):  # type: ignore[no-untyped-def]
    """Room for a chain of `joints` driven joints and `dof` variables."""
    return Linearisation(
        np.empty((3, 3)),
        np.empty((joints, 3)),
        np.empty((joints, 3)),
        np.empty(6),
        np.empty((dof, 6)),
        np.empty((3, 3)),
        np.empty(3),
    )


@njit(_nrt=False)
def set_target(pose, at):  # type: ignore[no-untyped-def]
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


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def _find_frames(chain, q, at):  # type: ignore[no-untyped-def]
    """Tip frame, and axis and origin of every joint, for the configuration q (dof,)."""
    frame = constant_frame(chain.rotations[0], chain.translations[0])
    for k in range(chain.prismatic.shape[0]):
        at.axes[k, 0], at.axes[k, 1], at.axes[k, 2] = frame[2], frame[5], frame[8]
        at.origins[k, 0], at.origins[k, 1], at.origins[k, 2] = frame[9], frame[10], frame[11]
        position = chain.multiplier[k] * q[chain.variable[k]] + chain.offset[k]
        sine, cosine = sine_cosine(position)
        frame = moved(frame, chain.prismatic[k], position, sine, cosine)
        frame = multiplied(frame, chain.rotations[k + 1], chain.translations[k + 1])
    store_frame(frame, at.rotation, at.position)


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def find_error(chain, q, pose, at):  # type: ignore[no-untyped-def]
    """Write the frames of q and the error from tip to target; return its squares [m²], [rad²].

    Args:
        chain: The `Chain`.
        q: (dof,) joints [rad or m].
        pose: (7,) target, base frame [m, unit quaternion]; its rotation by `set_target`.
        at: The `Linearisation`; all but goal and jacobian is written.

    Twice the sine times the axis of the rotation between two frames is the sum of the cross
    products of their axes (Siciliano et al., "Robotics: Modelling, Planning and Control", 3.7.3).
    """
    _find_frames(chain, q, at)
    goal, R, p, error = at.goal, at.rotation, at.position, at.error
    sx = sy = sz = 0.0
    trace = 0.0
    for k in range(3):
        rx, ry, rz = R[0, k], R[1, k], R[2, k]
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
    dx, dy, dz = pose[0] - p[0], pose[1] - p[1], pose[2] - p[2]
    error[0], error[1], error[2] = dx, dy, dz
    error[3], error[4], error[5] = scale * sx, scale * sy, scale * sz
    return dx * dx + dy * dy + dz * dz, angle * angle


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def find_jacobian(chain, at):  # type: ignore[no-untyped-def]
    """Geometric Jacobian at the tip, axes of the base, transposed, after `find_error`."""
    J, p = at.jacobian, at.position
    plain = chain.variable.shape[0] == J.shape[0]
    if not plain:
        J[:, :] = 0.0
    for k in range(chain.prismatic.shape[0]):
        scale = chain.multiplier[k]
        zx, zy, zz = scale * at.axes[k, 0], scale * at.axes[k, 1], scale * at.axes[k, 2]
        dx = p[0] - at.origins[k, 0]
        dy = p[1] - at.origins[k, 1]
        dz = p[2] - at.origins[k, 2]
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
