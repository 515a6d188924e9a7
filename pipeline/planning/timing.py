"""From a path of joints to a trajectory in time that keeps to the joints' velocity limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
CLOSEST = 0.1  # share of the mean distance of waypoints in the parameter that any two have at least


@dataclass(frozen=True)
class Trajectory:
    """Joints over time; at rest at both ends.

    Attributes:
        time: Time from the start [s], shape (T,).
        joints: Joint positions [rad or m], shape (T, dof).
        velocities: Joint velocities [rad/s or m/s], shape (T, dof).
    """

    time: Array
    joints: Array
    velocities: Array

    @property
    def duration(self) -> float:
        """Time from start to rest [s]."""
        return float(self.time[-1])


def minimum_jerk(share: ArrayLike) -> tuple[Array, Array]:
    """Smooth start and stop: the quintic with zero velocity and acceleration at both ends.

    Flash and Hogan 1985, equation 6: s = 10 u^3 - 15 u^4 + 6 u^5, at most 1.875 fast.

    Args:
        share: Share u of the duration in [0, 1], shape (T,).

    Returns:
        s and ds/du, each of shape (T,).
    """
    u = np.asarray(share, dtype=np.float64)
    position = u**3 * (10.0 + u * (6.0 * u - 15.0))
    velocity = 30.0 * u**2 * (1.0 - u) ** 2
    return position, velocity


def time_scale(
    waypoints: ArrayLike, velocity_limit: ArrayLike, speed: float, rate: float
) -> Trajectory:
    """Run through the waypoints as fast as the velocity limits allow, starting and ending at rest.

    A cubic spline joins the waypoints; its parameter runs by `minimum_jerk`. Waypoints lie as far
    apart in that parameter as the slowest joint needs from one to the next (chord length, de Boor,
    A Practical Guide to Splines, 1978, XVII): a jump between branches of solutions costs the time
    that the joints need for it, not that of a motion slowed down throughout. The duration is the
    shortest one for which no joint exceeds its limit at any sample.

    Args:
        waypoints: Joint positions [rad or m], shape (S, dof), at least two.
        velocity_limit: Largest joint speeds [rad/s or m/s], positive, shape (dof,).
        speed: Share of the limits to use, in (0, 1].
        rate: Samples a second [Hz].

    Returns:
        The trajectory; its first and last joints are the first and last waypoints.

    Raises:
        ValueError: If a limit is not positive or there are fewer than two waypoints.
    """
    path = np.asarray(waypoints, dtype=np.float64)
    limit = speed * np.asarray(velocity_limit, dtype=np.float64)
    if len(path) < 2 or not (limit > 0.0).all():
        raise ValueError(
            "time scaling needs at least 2 waypoints and positive velocity limits, "
            f"got {len(path)} waypoints and limits {limit.tolist()}"
        )
    from scipy.interpolate import CubicSpline  # slower to import than all of the planner

    spline = CubicSpline(_knots(path, limit), path, bc_type="natural")
    # Fine enough that the peak speed between two samples is caught to a fraction of a percent.
    share = np.linspace(0.0, 1.0, 20 * len(path))
    position, rise = minimum_jerk(share)
    demand = np.abs(spline(position, 1)) * rise[:, None] / limit
    samples = max(2, int(np.ceil(demand.max() * rate)) + 1)
    time = np.arange(samples) / rate
    position, rise = minimum_jerk(time / time[-1])
    return Trajectory(time, spline(position), spline(position, 1) * rise[:, None] / time[-1])


def _knots(path: Array, limit: Array) -> Array:
    """Parameter of each waypoint in [0, 1], shape (S,): shares of the time that the joints need."""
    needed = (np.abs(np.diff(path, axis=0)) / limit).max(axis=1)
    total = needed.sum()
    if total == 0.0:
        return np.linspace(0.0, 1.0, len(path))
    # Waypoints that coincide stay apart, or the spline would have no slope there.
    spaced = np.maximum(needed, CLOSEST * total / len(needed))
    return np.concatenate([[0.0], np.cumsum(spaced) / spaced.sum()])
