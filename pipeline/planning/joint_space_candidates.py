"""Ways between joints that lead from one end of a path to the other, the best first."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines.lm_kernel import LmOptions
from pipeline.planning.bezier import path_parameter
from pipeline.planning.continuity import Ends
from pipeline.planning.search import QUICK, solutions
from pipeline.planning.search_kernel import thinned
from robots.rotations import rotation_angle

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

PAIRS = 32  # of solutions of both ends that are looked at
OVER = 128  # configurations that candidates pass near where no other is free of collisions
NEAREST = 8  # pairs that these candidates are tried for
OVER_SEED = 0  # of these configurations
STRIDE = 4  # waypoints between two that are looked at for collisions
LEVER_M = 0.3  # m of detour that a turn of 1 rad away from the path is worth


def joint_space_candidates(
    robot: Robot, requested: Array, ends: Ends, options: LmOptions
) -> Iterator[Array]:
    """Yield paths of joints inside the limits from solutions of a path's start to its target's.

    First come straight lines in the joints and curves that bend over the middle of their ranges,
    as far as they are free of collisions, those first whose tip stays nearest to the path; then
    such that bend over one or two other configurations; then those with collisions.

    Args:
        robot: The robot.
        requested: Waypoints of the path, base frame [m, unit quaternion], shape (S, 7).
        ends: Joints that the path has to start and end with.
        options: Tolerances and damping.

    Yields:
        Joints [rad or m], shape (S, dof); none where an end is out of reach.
    """
    starts = _solutions(robot, requested[0], ends.first, options)
    goals = _solutions(robot, requested[-1], ends.last, options)
    if len(starts) == 0 or len(goals) == 0:
        return
    k = path_parameter(len(requested))[:, None]
    pairs = _nearest_pairs(starts, goals)
    straight = np.stack([(1.0 - k) * starts[a] + k * goals[b] for a, b in pairs])
    bent = _bent(straight, 0.5 * (robot.lower + robot.upper)[None])
    colliding: list[tuple[int, Array]] = []
    yield from _free(robot, requested, np.concatenate([straight, bent]), colliding)
    over = robot.sample(OVER, seed=OVER_SEED)
    for candidate in straight[:NEAREST, None]:
        yield from _free(robot, requested, _bent(candidate, over), colliding)
    for candidate in straight[:: -(-len(straight) // NEAREST), None]:
        yield from _free(
            robot, requested, _bent_twice(candidate, over, np.roll(over, 1, axis=0)), colliding
        )
    yield from (candidate for _, candidate in sorted(colliding, key=lambda pair: pair[0]))


def _bent(straight: Array, over: Array) -> Array:
    """Bend straight lines (W, S, dof) towards one configuration each or all, (W or 1, dof).

    These are quadratic Bezier curves in the joints: inside the limits, as their control points are.
    """
    k = path_parameter(straight.shape[1])[:, None]
    middle = 0.5 * (straight[:, :1] + straight[:, -1:])
    return straight + 2.0 * k * (1.0 - k) * (over[:, None] - middle)


def _bent_twice(straight: Array, first: Array, second: Array) -> Array:
    """Bend a straight line (1, S, dof) towards pairs of configurations (W, dof), a cubic each."""
    k = path_parameter(straight.shape[1])[:, None]
    begin, end = straight[:, :1], straight[:, -1:]
    inner = 3.0 * k * (1.0 - k) * ((1.0 - k) * first[:, None] + k * second[:, None])
    return (1.0 - k) ** 3 * begin + inner + k**3 * end


def _solutions(robot: Robot, pose: Array, given: Array | None, options: LmOptions) -> Array:
    """Distinct solutions of an end, free of collisions if any of them is."""
    if given is not None:
        return given[None]
    found = solutions(robot, pose, options, QUICK)
    chosen = np.empty(QUICK.samples, np.int64)
    count = thinned(found, np.arange(len(found)), QUICK.gap, chosen) if len(found) else 0
    distinct = found[chosen[:count]]
    free = distinct[~robot.in_collision(distinct)]
    return free if len(free) else distinct


def _nearest_pairs(starts: Array, goals: Array) -> list[tuple[int, int]]:
    """Index pairs, least travel first, each of a start or a goal and what is nearest to it."""
    travel = np.sum((starts[:, None] - goals[None]) ** 2, axis=2)
    pairs = {(a, int(b)) for a, b in enumerate(travel.argmin(axis=1))}
    pairs |= {(int(a), b) for b, a in enumerate(travel.argmin(axis=0))}
    return sorted(pairs, key=lambda pair: (travel[pair], pair))[:PAIRS]


def _free(
    robot: Robot, requested: Array, candidates: Array, colliding: list[tuple[int, Array]]
) -> Iterator[Array]:
    """Yield candidates (W, S, dof) that are free of collisions, nearest to the path first.

    The others are added to a list, each with how many of the waypoints looked at collide.
    """
    count, steps, dof = candidates.shape
    tips = robot.forward_kinematics(candidates.reshape(-1, dof)).reshape(count, steps, 7)
    away = np.linalg.norm(tips[..., :3] - requested[:, :3], axis=2).mean(axis=1)
    turned = rotation_angle(tips[..., 3:], requested[None, :, 3:]).mean(axis=1)
    looked = np.ascontiguousarray(candidates[:, ::STRIDE].reshape(-1, dof))
    hits = robot.in_collision(looked).reshape(count, -1).sum(axis=1)
    for candidate in np.argsort(away + LEVER_M * turned, kind="stable"):
        # Few waypoints say that a candidate collides, only all of them that it is free.
        if hits[candidate] == 0:
            hits[candidate] = robot.in_collision(candidates[candidate]).sum()
        if hits[candidate] == 0:
            yield candidates[candidate]
        else:
            colliding.append((int(hits[candidate]), candidates[candidate]))
