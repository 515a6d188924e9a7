"""Bezier curves of any degree: the tip's path in position (equations 10 to 12 of the paper)."""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def path_parameter(steps: int) -> Array:
    """Sample the path parameter k evenly on [0, 1], both ends included.

    Equation 11 of the paper, k = n / N with 0 <= n <= N, gives N + 1 samples. Here `steps` counts
    the samples, so N = steps - 1 and `steps=50` is exactly the paper's batch of 50 poses: the first
    one is the start, the last one the target.

    Args:
        steps: Number of samples, at least 2.

    Returns:
        Increasing parameters, shape (steps,).

    Raises:
        ValueError: If there are fewer than two samples.
    """
    if steps < 2:
        raise ValueError(f"a path needs at least 2 steps (its two ends), got {steps}")
    return np.arange(steps, dtype=np.float64) / (steps - 1)


def bernstein(degree: int, k: ArrayLike) -> Array:
    """Weights of the control points: the Bernstein polynomials of equation 12.

    Args:
        degree: Degree t of the curve, number of control points minus one.
        k: Path parameters in [0, 1], shape (S,).

    Returns:
        Weights C(t, i) (1 - k)^(t - i) k^i, shape (S, degree + 1); every row sums to one.
    """
    parameter = np.asarray(k, dtype=np.float64)[:, None]
    index = np.arange(degree + 1)
    choices = np.array([comb(degree, chosen) for chosen in range(degree + 1)], dtype=np.float64)
    return choices * (1.0 - parameter) ** (degree - index) * parameter**index


def bezier_curve(control_points: ArrayLike, k: ArrayLike) -> Array:
    """Points of the Bezier curve (equation 12 of the paper).

    Args:
        control_points: c_0 (start) to c_t (target) [m], shape (t + 1, D).
        k: Path parameters in [0, 1], shape (S,).

    Returns:
        Points [m], shape (S, D).

    Raises:
        ValueError: If there is no control point or one is not finite.
    """
    points = _checked(control_points)
    return bernstein(len(points) - 1, k) @ points


def bezier_derivative(control_points: ArrayLike, k: ArrayLike) -> Array:
    """Derivative of the curve by its parameter, dp/dk: its hodograph, a curve one degree lower.

    Farin, Curves and Surfaces for CAGD, 5th edition, section 5.3.

    Args:
        control_points: c_0 to c_t [m], shape (t + 1, D).
        k: Path parameters in [0, 1], shape (S,).

    Returns:
        Derivatives [m], shape (S, D).
    """
    points = _checked(control_points)
    degree = len(points) - 1
    if degree == 0:
        return np.zeros((np.size(k), points.shape[1]))
    return bezier_curve(degree * np.diff(points, axis=0), k)


def _checked(control_points: ArrayLike) -> Array:
    points = np.asarray(control_points, dtype=np.float64)
    if points.ndim != 2 or len(points) == 0:
        raise ValueError(f"control points must have shape (number, 3), got {points.shape}")
    if not np.isfinite(points).all():
        raise ValueError(f"control points must be finite, got {points.tolist()}")
    return points
