"""What a path allows any planner: whether it stays in reach, and whether it can be followed.

Both are found by search alone, whatever solver plans the path, and both say "yes" only with joints
in hand. A "no" is what an exhaustive search did not find, not a proof.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines.lm_kernel import LmOptions
from baselines.refine import refine
from pipeline.planning.search import EXHAUSTIVE, Effort, longest_path, one_branch, solutions

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

REACH_ITERATIONS = 20_000  # of descents from random configurations before a pose is out of reach


@dataclass(frozen=True)
class PathFeasibility:
    """What a path allows.

    Attributes:
        in_reach: Every waypoint by itself has a solution within tolerance and joint limits.
        continuous: There is a path of joints through all of them without a branch flip.
    """

    in_reach: bool
    continuous: bool


def judge_path(robot: Robot, poses: Array, options: LmOptions) -> PathFeasibility:
    """Find out whether a path stays in reach and can be followed without a flip.

    The branch at the start is free. Branches are followed one by one first, then all of them are
    searched at once from the start and, where that ends early, from the target: the samples of the
    two searches differ.

    Args:
        robot: The robot.
        poses: Waypoints, base frame [m, unit quaternion], shape (S, 7).
        options: Tolerances and damping.
    """
    if not stays_in_reach(robot, poses, options):
        return PathFeasibility(in_reach=False, continuous=False)
    continuous = one_branch(robot, poses, options, EXHAUSTIVE) is not None
    for path in (poses, poses[::-1].copy()):
        continuous = continuous or _any_branch(robot, path, options, EXHAUSTIVE)
    return PathFeasibility(in_reach=True, continuous=continuous)


def out_of_reach(robot: Robot, poses: Array, found: NDArray[np.bool_], options: LmOptions) -> bool:
    """Whether the middle one of the waypoints that a solver missed cannot be solved at all.

    Args:
        robot: The robot.
        poses: Waypoints, base frame [m, unit quaternion], shape (S, 7).
        found: The solver's claims, shape (S,).
        options: Tolerances and damping.
    """
    missed = np.flatnonzero(~found)
    if len(missed) == 0:
        return False
    middle = missed[len(missed) // 2]
    seed = np.tile(robot.home, (1, 1, 1))
    return not refine(robot, poses[middle][None], seed, options).found[0]


def stays_in_reach(robot: Robot, poses: Array, options: LmOptions) -> bool:
    """Whether every waypoint has a solution; far ones from one another are looked at first."""
    thorough = options._replace(iterations=REACH_ITERATIONS)
    stride = max(1, len(poses) // 7)
    for first in range(stride):
        part = poses[first::stride]
        seeds = np.tile(robot.home, (len(part), 1, 1))
        # One descent each, then the random ones only as far as the first waypoint that has none.
        if not refine(robot, part, seeds, options._replace(starts=8)).found.all():
            for pose in part:
                if not refine(robot, pose[None], seeds[:1], thorough).found[0]:
                    return False
    return True


def _any_branch(robot: Robot, poses: Array, options: LmOptions, effort: Effort) -> bool:
    starts = solutions(robot, poses[0], options, effort)
    return len(starts) > 0 and len(longest_path(robot, poses, starts, options, effort)) == len(
        poses
    )
