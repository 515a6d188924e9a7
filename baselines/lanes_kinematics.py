"""Tip error and Jacobian of LANES configurations side by side; `baselines.linearise` for lanes."""

from __future__ import annotations

import math

from baselines.lanes import lanes_of, load, root, select, store
from baselines.lanes_trigonometry import lanes_angle, lanes_sine_cosine
from robots.compiled import njit
from robots.frames import constant_frame, multiplied, slid, turned


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def _lanes_frame(frame):  # type: ignore[no-untyped-def]
    """The same frame in all lanes."""
    a, b, c, d, e, f, g, h, i, x, y, z = frame
    first = (lanes_of(a), lanes_of(b), lanes_of(c), lanes_of(d), lanes_of(e), lanes_of(f))
    return first + (lanes_of(g), lanes_of(h), lanes_of(i), lanes_of(x), lanes_of(y), lanes_of(z))  # noqa: RUF005 - numba unpacks nothing inside a tuple


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def find_lanes_frames(chain, q, axes):  # type: ignore[no-untyped-def]
    """Tip frames; axis and origin of every joint on the way.

    Args:
        chain: The `Chain`.
        q: (dof, LANES) configurations [rad or m].
        axes: (6 m, LANES) receives for every joint the axis, then a point on it [m], in the base
            frame.

    Returns:
        Frame tuple of lanes.
    """
    frame = _lanes_frame(constant_frame(chain.rotations[0], chain.translations[0]))
    for k in range(chain.prismatic.shape[0]):
        store(axes, 6 * k, frame[2])
        store(axes, 6 * k + 1, frame[5])
        store(axes, 6 * k + 2, frame[8])
        store(axes, 6 * k + 3, frame[9])
        store(axes, 6 * k + 4, frame[10])
        store(axes, 6 * k + 5, frame[11])
        position = chain.multiplier[k] * load(q, chain.variable[k]) + chain.offset[k]
        if chain.prismatic[k]:
            frame = slid(frame, position)
        else:
            sine, cosine = lanes_sine_cosine(position)
            frame = turned(frame, sine, cosine)
        frame = multiplied(frame, chain.rotations[k + 1], chain.translations[k + 1])
    return frame


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def find_lanes_error(target, frame):  # type: ignore[no-untyped-def]
    """Errors from tips to targets, as `baselines.linearise.find_error`.

    Args:
        target: (12, LANES) rotations of the targets row by row, then their positions [m].
        frame: Frame tuple of the tips.

    Returns:
        Error, a tuple of 6; its squared distance [m²] and angle [rad²].
    """
    # Twice the sine times the axis of the rotation, and its trace, column by column.
    sx = sy = sz = trace = lanes_of(0.0)
    for k in range(3):
        rx, ry, rz = frame[k], frame[3 + k], frame[6 + k]
        gx, gy, gz = load(target, k), load(target, 3 + k), load(target, 6 + k)
        sx, sy, sz = sx + (ry * gz - rz * gy), sy + (rz * gx - rx * gz), sz + (rx * gy - ry * gx)
        trace = trace + (rx * gx + ry * gy + rz * gz)
    sine2 = root(sx * sx + sy * sy + sz * sz)
    cosine2 = trace - 1.0
    angle = lanes_angle(sine2, cosine2)
    turns, ahead = sine2 > 1e-9, cosine2 > 0.0
    half_turn = ~(turns | ahead)
    sx, sy = select(half_turn, 1.0, sx), select(half_turn, 0.0, sy)
    sz = select(half_turn, 0.0, sz)
    scale = select(turns, angle / sine2, select(ahead, lanes_of(0.5), lanes_of(math.pi)))
    dx, dy, dz = (
        load(target, 9) - frame[9],
        load(target, 10) - frame[10],
        load(target, 11) - frame[11],
    )
    error = (dx, dy, dz, scale * sx, scale * sy, scale * sz)
    return error, dx * dx + dy * dy + dz * dz, angle * angle


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def find_lanes_jacobian(chain, axes, frame, J):  # type: ignore[no-untyped-def]
    """Geometric Jacobians at the tips after `find_lanes_frames`.

    Args:
        chain: The `Chain`.
        axes: (6 m, LANES) axes and points on them.
        frame: Frame tuple of the tips.
        J: (6 dof, LANES) receives the Jacobians transposed, six rows a variable.
    """
    plain = chain.variable.shape[0] * 6 == J.shape[0]
    if not plain:
        J[:, :] = 0.0
    for k in range(chain.prismatic.shape[0]):
        scale = chain.multiplier[k]
        zx, zy, zz = (
            scale * load(axes, 6 * k),
            scale * load(axes, 6 * k + 1),
            scale * load(axes, 6 * k + 2),
        )
        if chain.prismatic[k]:
            zero = lanes_of(0.0)
            row = (zx, zy, zz, zero, zero, zero)
        else:
            dx = frame[9] - load(axes, 6 * k + 3)
            dy = frame[10] - load(axes, 6 * k + 4)
            dz = frame[11] - load(axes, 6 * k + 5)
            row = (zy * dz - zz * dy, zz * dx - zx * dz, zx * dy - zy * dx, zx, zy, zz)
        first = 6 * chain.variable[k]
        if not plain:
            # A joint that mimics another one adds to its column.
            row = _added(row, J, first)
        for i in range(6):
            store(J, first + i, row[i])


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def _added(row, J, first):  # type: ignore[no-untyped-def]
    a, b, c, d, e, f = row
    a, b, c = a + load(J, first), b + load(J, first + 1), c + load(J, first + 2)
    d, e, f = d + load(J, first + 3), e + load(J, first + 4), f + load(J, first + 5)
    return a, b, c, d, e, f
