"""How far a thing reaches in a direction over the table, from the primitives that it is made of."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from pipeline.grasping.config import ObjectConfig, PartConfig


def extent(obj: ObjectConfig, yaw: float, direction: ArrayLike) -> tuple[float, float]:
    """Least and largest coordinate of a thing along a direction, from its centre.

    Args:
        obj: Parts of the thing.
        yaw: Its rotation about the vertical [rad].
        direction: Unit vector, base frame, shape (3,).

    Returns:
        From and to [m]; the first is negative where the thing surrounds its centre.
    """
    axis = Rotation.from_euler("z", yaw).inv().apply(np.asarray(direction, dtype=np.float64))
    ends = []
    for part in obj.parts:
        middle = float(np.dot(part.position, axis))
        half = _half(
            part, Rotation.from_euler("xyz", part.rotation, degrees=True).inv().apply(axis)
        )
        ends.append((middle - half, middle + half))
    return min(low for low, _ in ends), max(high for _, high in ends)


def _half(part: PartConfig, axis: np.ndarray) -> float:
    """Half the length of a primitive along an axis of its own frame [m]; its own axis is z."""
    if part.shape == "box":
        return float(0.5 * np.abs(axis) @ np.asarray(part.size))
    radius = part.size[0]
    if part.shape == "sphere":
        return radius
    along = 0.5 * part.size[1] * abs(float(axis[2]))
    if part.shape == "capsule":
        return along + radius
    return along + radius * float(np.hypot(axis[0], axis[1]))
