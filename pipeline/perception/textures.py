"""Patterns of tables and surroundings, laid on the pixels of a picture.

The software renderer draws textured meshes six times slower than plain ones, so the pattern is
multiplied to the plain picture: light and shadows stay as they were rendered.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]
WAVES = 6  # of a sum of plane waves
LENGTHS = (0.01, 0.3)  # m, shortest and longest wave


def pattern(draw: Generator, kind: str, points: Array) -> Array:
    """Draw a pattern.

    Args:
        draw: Random numbers.
        kind: plain, waves (a sum of plane waves), stripes, rings, dots, checks or blotches.
        points: x and y in the pattern's plane [m], shape (..., 2).

    Returns:
        Values between -1 and 1, shape (...).
    """
    if kind == "plain":
        return np.zeros(points.shape[:-1])
    if kind == "waves":
        return _waves(draw, points, LENGTHS) / np.sqrt(WAVES)
    if kind == "blotches":
        return cast(Array, np.sign(_waves(draw, points, (0.05, LENGTHS[1]))))
    if kind == "rings":
        away = np.linalg.norm(points - draw.uniform(-0.5, 1.5, size=2), axis=-1)
        return cast(Array, np.sign(np.sin(2.0 * np.pi * away / draw.uniform(0.04, 0.2))))
    angle, length = draw.uniform(0.0, np.pi), draw.uniform(0.02, 0.2)
    turned = points @ np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    rising = np.sin(2.0 * np.pi * turned / length + draw.uniform(0.0, 2.0 * np.pi))
    if kind == "dots":
        return cast(Array, np.sign(rising.sum(axis=-1) - draw.uniform(0.5, 1.5)))
    sides = np.sign(rising)
    if kind == "stripes":
        return cast(Array, sides[..., 0])
    return cast(Array, sides[..., 0] * sides[..., 1])


def _waves(draw: Generator, points: Array, lengths: tuple[float, float]) -> Array:
    total = np.zeros(points.shape[:-1])
    for _ in range(WAVES):
        angle, phase = draw.uniform(0.0, 2.0 * np.pi, size=2)
        length = np.exp(draw.uniform(*np.log(lengths)))
        along = points @ np.array([np.cos(angle), np.sin(angle)])
        total += np.sin(2.0 * np.pi * along / length + phase)
    return total
