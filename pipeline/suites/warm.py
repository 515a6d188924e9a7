"""Suite of targets near a start: what a controller asks of a solver from one moment to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.seeding import derive_seed
from pipeline.suites.config import WarmConfig
from pipeline.suites.drawing import draw, uniform_joints
from pipeline.suites.problems import Problems, in_turns, reached
from pipeline.suites.singularity import scale

if TYPE_CHECKING:
    from robots import Robot


def warm(robot: Robot, config: WarmConfig, seed: int) -> Problems:
    """Starts that are uniform, and targets with every joint that far away, up or down at random.

    A joint whose limit is nearer than that goes the other way. One that slides moves by the angle
    times the characteristic length of the robot (`pipeline.suites.singularity`).
    """
    kinds = len(config.offsets_deg)
    parts = []
    for kind, offset in enumerate(config.offsets_deg):
        if count := len(range(kind, config.poses, kinds)):
            parts.append(_near(robot, offset, count, derive_seed(seed, f"{offset:g}deg")))
    return in_turns(parts)


def _near(robot: Robot, offset_deg: float, count: int, seed: int) -> Problems:
    _, length_m = scale(robot)
    offset = np.where(robot.sliding, length_m, 1.0) * np.deg2rad(offset_deg)

    def propose(rng: np.random.Generator) -> Problems:
        start = uniform_joints(robot, rng)
        sign = np.where(rng.random(start.shape) < 0.5, 1.0, -1.0)
        outside = (start + sign * offset > robot.upper) | (start + sign * offset < robot.lower)
        target = start + np.where(outside, -sign, sign) * offset
        inside = robot.within_limits(target)
        return reached(robot, target[inside], f"{offset_deg:g}deg", start[inside])

    return draw(robot, count, seed, propose)
