"""Rotations along a path: Slerp, and cubic spherical Bezier curves through key rotations.

All quaternions are unit and scalar first. Both q and -q are one rotation, so every pair of keys is
first brought to the same half of the sphere: the path always takes the shorter way round.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def slerp(start: ArrayLike, target: ArrayLike, k: ArrayLike) -> Array:
    """Spherical linear interpolation the shorter way round (Shoemake 1985, section 3.3).

    Args:
        start: Rotation at k = 0, shape (4,) or (S, 4).
        target: Rotation at k = 1, shape (4,) or (S, 4).
        k: Path parameters in [0, 1], shape (S,).

    Returns:
        Unit quaternions, shape (S, 4); the angular speed is constant.

    Raises:
        ValueError: If an end is not a unit quaternion.
    """
    first, second = _unit(start), _unit(target)
    second = np.where(np.sum(first * second, axis=-1, keepdims=True) < 0.0, -second, second)
    return _arc(first, second, np.asarray(k, dtype=np.float64))


def spherical_bezier(keys: ArrayLike, k: ArrayLike) -> Array:
    """Smooth rotation through every key: one cubic spherical Bezier curve between neighbours.

    The inner control rotations are Shoemake's (1985, sections 4.1, 4.2): at an inner key the curve
    leaves along the bisector of the way it came, continued, and the way it goes on. The keys lie
    evenly in k, so the angular velocity is continuous there. Two keys give Slerp.

    Args:
        keys: Key rotations from start to target, shape (n, 4), at least two.
        k: Path parameters in [0, 1], shape (S,).

    Returns:
        Unit quaternions, shape (S, 4).

    Raises:
        ValueError: If there are fewer than two keys or one is not a unit quaternion.
    """
    rotations = _same_half(_unit(keys))
    if rotations.ndim != 2 or len(rotations) < 2:
        raise ValueError(f"a rotation path needs at least 2 keys, got shape {rotations.shape}")
    leave, arrive = _handles(rotations)
    parameter = np.asarray(k, dtype=np.float64) * (len(rotations) - 1)
    segment = np.clip(parameter.astype(np.int64), 0, len(rotations) - 2)
    control = np.stack(
        [rotations[segment], leave[segment], arrive[segment], rotations[segment + 1]], axis=0
    )
    return _de_casteljau(control, parameter - segment)


def _arc(first: Array, second: Array, k: Array) -> Array:
    """Point at share k of the arc from first to second, which must be less than a half circle."""
    apart = np.linalg.norm(first - second, axis=-1)
    together = np.linalg.norm(first + second, axis=-1)
    angle = np.atleast_1d(2.0 * np.arctan2(apart, together))
    sine = np.sin(angle)
    # Below this the arc is straight to the last digit and sin(angle) would divide by zero.
    straight = sine < 1e-9
    safe = np.where(straight, 1.0, sine)
    one = np.where(straight, 1.0 - k, np.sin((1.0 - k) * angle) / safe)
    other = np.where(straight, k, np.sin(k * angle) / safe)
    point = one[:, None] * first + other[:, None] * second
    return point / np.linalg.norm(point, axis=-1, keepdims=True)


def _de_casteljau(control: Array, k: Array) -> Array:
    """Repeated Slerp of the control rotations, shape (4, S, 4), at k, shape (S,)."""
    while len(control) > 1:
        control = np.stack([_arc(a, b, k) for a, b in pairwise(control)])
    return control[0]


def _handles(keys: Array) -> tuple[Array, Array]:
    """Inner control rotations: where each segment leaves its first key and arrives at its second.

    Returns:
        Two arrays of shape (n - 1, 4), each a third of the way from its key.
    """
    third = np.full(len(keys) - 1, 1.0 / 3.0)
    leave = _arc(keys[:-1], keys[1:], third)
    arrive = _arc(keys[1:], keys[:-1], third)
    for i in range(1, len(keys) - 1):
        onward = _bisect(_double(keys[i - 1], keys[i]), keys[i + 1])
        backward = _double(onward, keys[i])
        leave[i] = _arc(keys[i], onward, third[:1])[0]
        arrive[i - 1] = _arc(keys[i], backward, third[:1])[0]
    return leave, arrive


def _double(first: Array, second: Array) -> Array:
    """The arc from first to second, continued as far again."""
    return 2.0 * np.dot(first, second) * second - first


def _bisect(first: Array, second: Array) -> Array:
    middle = first + second
    length = np.linalg.norm(middle)
    # Opposite points have no middle; any smooth choice will do, so keep the way it came.
    return first if length < 1e-9 else middle / length


def _same_half(keys: Array) -> Array:
    chosen = keys.copy()
    for i in range(1, len(chosen)):
        if np.dot(chosen[i - 1], chosen[i]) < 0.0:
            chosen[i] = -chosen[i]
    return chosen


def _unit(quaternion: ArrayLike) -> Array:
    value = np.asarray(quaternion, dtype=np.float64)
    length = np.linalg.norm(value, axis=-1, keepdims=True)
    if value.shape[-1:] != (4,) or not np.allclose(length, 1.0, atol=1e-6):
        raise ValueError(f"expected unit quaternions (w, x, y, z), got {value.tolist()}")
    return value / length
