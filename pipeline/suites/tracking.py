"""Suite of smooth trajectories that a continuous solution is known to.

A trajectory is the image of a path in joint space: a parabola through three configurations, the
middle one uniform or near a singular one, driven with minimum jerk (Flash and Hogan, 1985) from
rest to rest. Its ends are drawn so that every joint has a part in it, however slow it is, and its
speed is such that the fastest joint takes a given share of its limit. The whole path keeps limits
and is free of self-collision at every waypoint, so that following it is possible. A solver is given
the poses one after the other, the first with the known configuration as its start and every other
with its own answer to the one before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.suites.config import TrackingConfig
from pipeline.suites.drawing import PATIENCE, NoProblemsError, uniform_joints
from pipeline.suites.postures import singular_joints
from pipeline.suites.problems import Problems, joined, reached

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

PLAIN, SINGULAR = "plain", "singular"
PEAK = 2.0 * 1.875  # greatest speed of a minimum-jerk motion over [-1, 1] in a second
LOOKED_AT = 65  # places of a path where limits, collisions and speed are looked at first


@dataclass(frozen=True)
class _Path:
    """A parabola in joint space, q(p) = c0 + c1 p + c2 p² for p from -1 to 1, driven in a time."""

    coefficients: Array
    duration_s: float

    def at(self, place: Array) -> Array:
        """Return the configurations (N, dof) at places (N,) in [-1, 1]."""
        powers = np.stack([np.ones_like(place), place, place * place], axis=1)
        return np.asarray(powers @ self.coefficients)

    def waypoints(self, rate_hz: float) -> Array:
        """Return the configurations (N, dof) at so many places a second, both ends included."""
        steps = max(int(np.ceil(self.duration_s * rate_hz)), 2)
        t = np.arange(steps + 1) / steps
        return self.at(2.0 * t * t * t * (10.0 + t * (6.0 * t - 15.0)) - 1.0)


def tracking(robot: Robot, config: TrackingConfig, seed: int) -> Problems:
    """Trajectories at each rate; every second one leads past a near-singular configuration.

    Every trajectory stands at every rate; trajectory and rate together name a series of poses.
    """
    singular = singular_joints(robot, config, seed)
    parts = []
    for number in range(config.trajectories):
        kind = SINGULAR if number % 2 else PLAIN
        generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
        path = _path(robot, config, generator, singular if number % 2 else None)
        parts += [_poses(robot, path, rate, number, kind) for rate in config.rates_hz]
    return joined(parts)


def _path(
    robot: Robot,
    config: TrackingConfig,
    rng: np.random.Generator,
    singular: Callable[[np.random.Generator], Array] | None,
) -> _Path:
    """Draw paths until one keeps limits and is free of collision at its finest waypoints.

    Where none does, ends are drawn within the limits. Of a robot whose fast joints have narrow
    ranges hardly any path is left otherwise.

    Raises:
        NoProblemsError: None does.
    """
    span = config.duration_s * _speed(robot, config) / PEAK
    places = np.linspace(-1.0, 1.0, LOOKED_AT)
    lower = np.where(robot.endless, -np.inf, robot.lower)
    upper = np.where(robot.endless, np.inf, robot.upper)
    for attempt in range(2 * PATIENCE):
        middle = uniform_joints(robot, rng) if singular is None else singular(rng)
        part = rng.uniform(-1.0, 1.0, (len(middle), 2, robot.dof))
        ends = middle[:, None] + span * part
        if attempt >= PATIENCE:
            least = np.maximum(middle - span, lower)[:, None]
            most = np.minimum(middle + span, upper)[:, None]
            ends = least + (most - least) * (1.0 + part) / 2.0
        for centre, (first, last) in zip(middle, ends, strict=True):
            curve = np.stack([centre, (last - first) / 2.0, (first + last) / 2.0 - centre])
            path = _Path(curve, _duration(robot, config, curve))
            if not robot.within_limits(path.at(places)).all():
                continue
            if robot.in_collision(path.at(places)).any():
                continue
            finest = path.waypoints(max(config.rates_hz))
            if robot.within_limits(finest).all() and not robot.in_collision(finest).any():
                return path
    raise NoProblemsError(
        f"no path of {config.duration_s:g} s of '{robot.name}' keeps its limits and is free of "
        "self-collision; take a smaller suite.duration_s, or leave this suite out"
    )


def _duration(robot: Robot, config: TrackingConfig, curve: Array) -> float:
    """Seconds in which no joint is faster than its share of its limit; at least one period."""
    fastest = PEAK * (np.abs(curve[1]) + 2.0 * np.abs(curve[2]))  # of a motion of one second
    return float(max(np.max(fastest / _speed(robot, config)), 1.0 / min(config.rates_hz)))


def _speed(robot: Robot, config: TrackingConfig) -> Array:
    """Greatest speed that each joint is driven at, (dof,) rad/s or m/s."""
    limits = robot.velocity_limit
    known = np.isfinite(limits) & (limits > 0.0)
    return config.speed * np.where(known, limits, config.default_velocity)


def _poses(robot: Robot, path: _Path, rate_hz: float, number: int, kind: str) -> Problems:
    joints = path.waypoints(rate_hz)
    start = np.full_like(joints, np.nan)
    start[0] = joints[0]
    steps = np.arange(len(joints))
    return reached(
        robot,
        joints,
        kind,
        start,
        trajectory=np.full(len(joints), number),
        step=steps,
        rate_hz=np.full(len(joints), float(rate_hz)),
    )
