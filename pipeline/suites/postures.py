"""Suites of reachable poses whose configurations are hard: at limits, near singular, stretched."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.seeding import derive_seed
from pipeline.suites.config import AtLimitsConfig, ShareConfig, SuiteConfig
from pipeline.suites.drawing import NoProblemsError, draw, uniform_joints
from pipeline.suites.problems import Problems, reached
from pipeline.suites.singularity import scale, smallest_singular_value

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

STEPS = 200  # of the climb to the edge of reach
GRAIN_DECIMALS = 6  # of joints on the way: the last bits of a machine do not add up over the steps
FIRST_STEP, SHORTER = 0.3, 0.97  # rad or m; each step of the climb is so much of the one before


def uniform(robot: Robot, config: SuiteConfig, seed: int) -> Problems:
    """Uniform configurations: what the plain evaluation has, in the shape of a suite."""
    return draw(
        robot, config.poses, seed, lambda rng: reached(robot, uniform_joints(robot, rng), "uniform")
    )


def at_limits(robot: Robot, config: AtLimitsConfig, seed: int) -> Problems:
    """Configurations with two joints or more within a share of their range of a limit.

    How many joints is drawn uniformly, then which, and for each lower or upper limit and how far
    within the margin; the others are uniform. The stratum is the number of joints.

    Raises:
        NoProblemsError: Fewer than two joints have limits.
    """
    limited = np.flatnonzero(~robot.endless)
    if len(limited) < 2:
        raise NoProblemsError(
            f"suite at_limits needs two joints with limits, '{robot.name}' has {len(limited)}; "
            "leave this suite out"
        )
    most = min(config.most_joints, len(limited))
    width = robot.upper - robot.lower

    def propose(rng: np.random.Generator) -> Problems:
        joints = uniform_joints(robot, rng)
        count = rng.integers(2, most + 1, len(joints))
        rank = np.argsort(rng.random((len(joints), len(limited))), axis=1).argsort(axis=1)
        near = np.zeros(joints.shape, dtype=bool)
        near[:, limited] = rank < count[:, None]
        margin = config.margin * width * rng.random(joints.shape)
        upper = rng.random(joints.shape) < 0.5
        edge = np.where(upper, robot.upper - margin, robot.lower + margin)
        parts = reached(robot, np.where(near, edge, joints))
        names = np.array([f"{number} joints" for number in count])
        return Problems(parts.poses, names, parts.joints)

    return draw(robot, config.poses, seed, propose)


def near_singular(robot: Robot, config: ShareConfig, seed: int) -> Problems:
    """Configurations whose smallest singular value is among the lowest of a uniform sample."""
    singular = singular_joints(robot, config, seed)
    return draw(
        robot, config.poses, seed, lambda rng: reached(robot, singular(rng), "near singular")
    )


def singular_joints(
    robot: Robot, config: ShareConfig, seed: int
) -> Callable[[np.random.Generator], Array]:
    """Return a function that draws configurations near a singular one, (N, dof).

    The threshold is the quantile of a reference sample that is free of self-collision.

    Args:
        robot: The robot.
        config: Share and size of the reference.
        seed: Of the suite; the reference has one derived of it.
    """
    _, length_m = scale(robot)
    reference = robot.sample(config.reference, derive_seed(seed, "reference"))
    values = smallest_singular_value(robot, reference, length_m)
    threshold = float(np.quantile(values, config.share))

    def drawn(rng: np.random.Generator) -> Array:
        joints = uniform_joints(robot, rng)
        return joints[smallest_singular_value(robot, joints, length_m) <= threshold]

    return drawn


def boundary(robot: Robot, config: ShareConfig, seed: int) -> Problems:
    """Configurations whose tip is in the outermost share of reach; see `stretched_joints`."""
    stretched = stretched_joints(robot, config, seed)
    return draw(robot, config.poses, seed, lambda rng: reached(robot, stretched(rng), "boundary"))


def stretched_joints(
    robot: Robot, config: ShareConfig, seed: int
) -> Callable[[np.random.Generator], Array]:
    """Return a function that draws configurations at the edge of reach, (N, dof).

    Reach is the distance of the tip from the nearest place where the first turning joint can be,
    and the greatest is found by climbing from a reference sample. To draw, uniform configurations
    climb likewise; each stops where it first has a share of the greatest reach that is drawn
    uniformly from the outermost one, and those that never have it are dropped.

    Args:
        robot: The robot.
        config: Share and size of the reference.
        seed: Of the suite; the reference has one derived of it.
    """
    reference = robot.sample(config.reference, derive_seed(seed, "reference"))
    greatest = float(np.max(_climb(robot, reference, np.full(len(reference), np.inf))[1]))

    def drawn(rng: np.random.Generator) -> Array:
        joints = uniform_joints(robot, rng)
        wanted = greatest * rng.uniform(1.0 - config.share, 1.0, len(joints))
        joints, distance = _climb(robot, joints, wanted)
        return joints[distance >= wanted]

    return drawn


def _climb(robot: Robot, joints: Array, wanted: Array) -> tuple[Array, Array]:
    """Move the tip outward by projected gradient steps until it is as far as wanted (N,), m.

    Returns:
        Configurations (N, dof), and how far the tip is (N,): that of the farthest that was met.
    """
    bound, _ = scale(robot)
    joints = joints.copy()
    best, farthest = joints.copy(), np.zeros(len(joints))
    step = FIRST_STEP
    moving = np.arange(len(joints))
    for _ in range(STEPS):
        at = joints[moving]
        points = robot.forward_kinematics(at)[:, :3]
        offset = points - bound.nearest(points)
        distance = np.linalg.norm(offset, axis=1)
        better = distance > farthest[moving]
        best[moving[better]], farthest[moving[better]] = at[better], distance[better]
        going = distance < wanted[moving]
        moving, at, offset = moving[going], at[going], offset[going]
        if len(moving) == 0:
            break
        slope = np.einsum("nid,ni->nd", robot.jacobian(at)[:, :3], offset)
        slope /= np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-12)
        joints[moving] = np.clip(
            np.round(at + step * slope, GRAIN_DECIMALS), robot.lower, robot.upper
        )
        step *= SHORTER
    return best, farthest
