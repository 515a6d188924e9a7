"""A curve of the tip as control points: fitted to poses, and between two others."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.planning.bezier import bernstein, path_parameter
from pipeline.planning.path import tip_path
from pipeline.planning.rotation import slerp

Array = NDArray[np.float64]


class Curve(NamedTuple):
    """Bezier curve in position, piecewise cubic spherical Bezier curve in rotation.

    Attributes:
        points: Control points, both ends included, base frame [m], shape (degree + 1, 3).
        rotations: Key rotations, both ends included, unit quaternions, shape (stretches + 1, 4).
    """

    points: Array
    rotations: Array

    @property
    def degree(self) -> int:
        """Degree in position."""
        return len(self.points) - 1

    @property
    def stretches(self) -> int:
        """Number of pieces in rotation."""
        return len(self.rotations) - 1

    def poses(self, steps: int) -> Array:
        """Sample the curve, shape (steps, 7)."""
        first, last = np.hstack([self.points, np.zeros((len(self.points), 4))])[[0, -1]]
        first[3:], last[3:] = self.rotations[[0, -1]]
        return tip_path(first, last, self.points[1:-1], steps, self.rotations[1:-1])


def fit(poses: Array, degree: int, stretches: int) -> Curve:
    """Fit a curve to poses that lie evenly in k; it begins and ends with the first and the last.

    The inner control points are those of least squares (Farin, Curves and Surfaces for CAGD, 5th
    edition, section 7.8), the key rotations are taken where they belong on the Slerp between the
    two poses around them.

    Args:
        poses: Poses, base frame [m, unit quaternion], shape (S, 7).
        degree: Degree in position, at least 2.
        stretches: Pieces in rotation, at least 1.
    """
    weights, inverse = _least_squares(len(poses), degree)
    ends = poses[[0, -1], :3]
    inner = inverse @ (poses[:, :3] - weights @ ends)
    place = np.linspace(0.0, len(poses) - 1.0, stretches + 1)
    low = np.minimum(place.astype(np.int64), len(poses) - 2)
    rotations = slerp(poses[low, 3:], poses[low + 1, 3:], place - low)
    return Curve(np.vstack([ends[:1], inner, ends[1:]]), rotations)


def between(first: Curve, second: Curve, share: float) -> Curve:
    """Curve at a share of the way from one to another of the same degree and stretches."""
    points = (1.0 - share) * first.points + share * second.points
    shares = np.full(len(first.rotations), share)
    return Curve(points, slerp(first.rotations, second.rotations, shares))


@cache
def _least_squares(steps: int, degree: int) -> tuple[Array, Array]:
    """Weights of the ends (S, 2), and the matrix from positions to inner points (degree - 1, S)."""
    weights = bernstein(degree, path_parameter(steps))
    inverse = np.asarray(np.linalg.pinv(weights[:, 1:-1]), dtype=np.float64)
    return weights[:, [0, -1]], inverse
