"""Compiled error and Jacobian of a target with freedoms, after those of `baselines.linearise`.

Rows are turned into the axes of the target's frame. A component inside its width has no error and
its row of the Jacobian is left out: the squared distance to a box has the Gauss-Newton matrix of
the components outside (Nocedal and Wright, "Numerical Optimization", section 10.3).

About a free axis the error is the swing that brings the tip's axis onto the target's, and the rows
are those about the axes of the target's frame after that swing, of which one is the tip's axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.compiled import njit

Array = NDArray[np.float64]

ALL_FREE, NONE_FREE = 3, -1


class FreedomRoom(NamedTuple):
    """Widths of one target, and what is worked out with them.

    Attributes:
        widths: (6,) of the target, see `baselines.freedom.Freedom` [m and rad].
        basis: (3, 3) axes, in columns, that the rows of the rotation are about.
        counts: (6,) rows whose component is outside its width.
    """

    widths: Array
    basis: Array
    counts: NDArray[np.bool_]


@njit()
def new_freedom_room():  # type: ignore[no-untyped-def]
    """Room for the freedoms of one target."""
    return FreedomRoom(np.empty(6), np.empty((3, 3)), np.empty(6, dtype=np.bool_))


@njit(_nrt=False)
def free_error(room, at):  # type: ignore[no-untyped-def]
    """Replace the error by what counts of it; return its squares [m²], [rad²].

    Args:
        room: `FreedomRoom` with the widths of the target.
        at: `Linearisation` after `find_error`; its error becomes that along and about the axes of
            the target's frame, from the tip to the nearest pose that is allowed.
    """
    error = at.error
    distance2 = _outside_widths(room, at, error[0], error[1], error[2], 0)
    free = _free_axis(room.widths)
    if free == ALL_FREE:
        for i in range(3, 6):
            error[i], room.counts[i] = 0.0, False
        return distance2, 0.0
    if free == NONE_FREE:
        for i in range(3):
            for j in range(3):
                room.basis[i, j] = at.goal[i, j]
        sx, sy, sz = error[3], error[4], error[5]
    else:
        sx, sy, sz = _swing(room, at, free)
    angle2 = _outside_widths(room, at, sx, sy, sz, 3)
    return distance2, angle2


@njit(_nrt=False)
def _free_axis(widths):  # type: ignore[no-untyped-def]
    """Which axis is free to turn about: 0 to 2, `NONE_FREE` or `ALL_FREE`."""
    count, axis = 0, NONE_FREE
    for i in range(3):
        if math.isinf(widths[3 + i]):
            count, axis = count + 1, i
    return ALL_FREE if count == 3 else axis


@njit(_nrt=False)
def _outside_widths(room, at, x, y, z, first):  # type: ignore[no-untyped-def]
    """Write the part of a vector that is outside the widths of three rows; return its square."""
    axes, total = at.goal, 0.0
    for i in range(3):
        value = axes[0, i] * x + axes[1, i] * y + axes[2, i] * z
        width = room.widths[first + i]
        rest = value - min(max(value, -width), width)
        at.error[first + i] = rest
        room.counts[first + i] = rest != 0.0 or width == 0.0
        total += rest * rest
    return total


@njit(_nrt=False)
def _swing(room, at, free):  # type: ignore[no-untyped-def]
    """Rotation vector [rad], axes of the base, of the least turn of the tip's free axis.

    Writes the basis: the axes of the target's frame, turned back by it (Rodrigues' formula).
    """
    goal, R = at.goal, at.rotation
    ax, ay, az = goal[0, free], goal[1, free], goal[2, free]
    dx, dy, dz = R[0, free], R[1, free], R[2, free]
    kx, ky, kz = dy * az - dz * ay, dz * ax - dx * az, dx * ay - dy * ax
    sine = math.sqrt(kx * kx + ky * ky + kz * kz)
    cosine = dx * ax + dy * ay + dz * az
    angle = math.atan2(sine, cosine)
    if sine > 1e-12:
        kx, ky, kz = kx / sine, ky / sine, kz / sine
    else:
        # Along or against the target's axis: any axis across it does.
        other = (free + 1) % 3
        kx, ky, kz = R[0, other], R[1, other], R[2, other]
    for i in range(3):
        gx, gy, gz = goal[0, i], goal[1, i], goal[2, i]
        cx, cy, cz = ky * gz - kz * gy, kz * gx - kx * gz, kx * gy - ky * gx
        along = (1.0 - cosine) * (kx * gx + ky * gy + kz * gz)
        room.basis[0, i] = cosine * gx - sine * cx + along * kx
        room.basis[1, i] = cosine * gy - sine * cy + along * ky
        room.basis[2, i] = cosine * gz - sine * cz + along * kz
    return angle * kx, angle * ky, angle * kz


@njit(_nrt=False)
def free_rows(room, at):  # type: ignore[no-untyped-def]
    """Turn the Jacobian after `find_jacobian` into the rows of `free_error`, others zero."""
    J = at.jacobian
    for k in range(J.shape[0]):
        vx, vy, vz = J[k, 0], J[k, 1], J[k, 2]
        wx, wy, wz = J[k, 3], J[k, 4], J[k, 5]
        for i in range(3):
            along, about = at.goal, room.basis
            v = along[0, i] * vx + along[1, i] * vy + along[2, i] * vz
            w = about[0, i] * wx + about[1, i] * wy + about[2, i] * wz
            J[k, i] = v if room.counts[i] else 0.0
            J[k, 3 + i] = w if room.counts[3 + i] else 0.0
