"""Suite of targets that leave something open: a position alone, a position and one axis.

A uniform configuration solves each. Then what is free is given a random value, as by somebody who
has a point, or a point and a direction, and fills in the rest: `position` has any rotation, and
`axis z` is turned about z of the tip by any angle. The freedoms stand beside the pose.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines.freedom import AXES, Freedom
from pipeline.seeding import derive_seed
from pipeline.suites.config import PartialConfig
from pipeline.suites.drawing import draw, uniform_joints
from pipeline.suites.problems import FREEDOM, Problems, in_turns, reached
from robots.rotations import (
    canonical,
    normalised,
    quaternion_from_rotation_vector,
    quaternion_multiply,
)
from robots.rounding import rounded

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

POSITION = "position"


def partial(robot: Robot, config: PartialConfig, seed: int) -> Problems:
    """Positions alone, and positions with an axis, in turns."""
    counts = [len(range(kind, config.poses, 2)) for kind in range(2)]
    axis = f"axis {config.axis}"
    kinds = ((POSITION, Freedom.position_only()), (axis, Freedom.free_about(config.axis)))
    parts = [
        _freed(robot, name, freedom, count, derive_seed(seed, name))
        for (name, freedom), count in zip(kinds, counts, strict=True)
        if count
    ]
    return in_turns(parts)


def _freed(robot: Robot, name: str, freedom: Freedom, count: int, seed: int) -> Problems:
    columns = dict(zip(FREEDOM, freedom.widths, strict=True))

    def propose(rng: np.random.Generator) -> Problems:
        joints = uniform_joints(robot, rng)
        known = reached(
            robot, joints, name, **{key: np.full(len(joints), w) for key, w in columns.items()}
        )
        turned = quaternion_multiply(known.poses[:, 3:], _turns(freedom, len(joints), rng))
        poses = np.hstack([known.poses[:, :3], rounded(canonical(turned))])
        return replace(known, poses=poses)

    return draw(robot, count, seed, propose)


def _turns(freedom: Freedom, count: int, rng: np.random.Generator) -> Array:
    """Random rotations (N, 4) that a target may be turned by in its own frame."""
    free = np.isinf(freedom.about_rad)
    if free.all():
        return normalised(rng.standard_normal((count, 4)))
    axis = np.eye(len(AXES))[int(np.argmax(free))]
    return quaternion_from_rotation_vector(rng.uniform(-np.pi, np.pi, (count, 1)) * axis)
