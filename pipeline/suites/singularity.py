"""How near a configuration is to a singular one: the smallest singular value of its Jacobian.

The rows of a Jacobian have different units. Here 1 rad weighs as much as the characteristic length
of the robot, the median distance of its tip from its first turning joint in a uniform sample:
linear rows are divided by that length, and so columns of sliding joints are multiplied by it. All
entries are then numbers without a unit.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robots.reach_bound import ReachBound, reach_bound
from robots.rounding import rounded

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

SAMPLES, SEED = 2000, 0  # of the characteristic length
SHORTEST_M = 1e-3  # of a robot whose tip lies on its first joint


def smallest_singular_value(robot: Robot, joints: Array, length_m: float) -> Array:
    """Return the smallest singular value of the scaled Jacobian of each configuration, (N,).

    Of fewer than six joints it is the smallest of as many as there are.

    Args:
        robot: The robot.
        joints: (N, dof) [rad or m].
        length_m: What weighs as much as 1 rad, see `characteristic_length`.
    """
    jacobians = robot.jacobian(joints)
    jacobians[:, :3] /= length_m
    jacobians[:, :, robot.sliding] *= length_m
    return np.asarray(np.linalg.svd(jacobians, compute_uv=False)[:, -1])


def characteristic_length(robot: Robot, bound: ReachBound) -> float:
    """Return the median distance of the tip from the first turning joint, m."""
    joints = robot.sample(SAMPLES, SEED, collision_free=False)
    points = robot.forward_kinematics(joints)[:, :3]
    distance = np.linalg.norm(points - bound.nearest(points), axis=1)
    return max(float(rounded(np.median(distance, keepdims=True))[0]), SHORTEST_M)


@lru_cache(maxsize=8)
def scale(robot: Robot) -> tuple[ReachBound, float]:
    """Return the reach and the characteristic length of a robot, found once."""
    bound = reach_bound(robot)
    return bound, characteristic_length(robot, bound)
