"""Jumps between waypoints: what a branch flip is, and how a path without one is found.

A solver answers each waypoint by itself, so that two neighbours may lie on different branches of
solutions. It is repaired in two steps, the cheap one first: it follows the branches that the
solver's own answers lie on to both ends of the path, and where none of them reaches that far it
searches all branches (`search`). What flips then had to, as far as that search can tell.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.lm import LevenbergMarquardt
from baselines.lm_kernel import LmOptions
from pipeline.planning.flip_kernel import find_flips
from pipeline.planning.follow_kernel import follow_until_complete
from pipeline.planning.search import QUICK, fewest_flips, one_branch

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]

SEGMENTS = 6  # stretches without a flip whose branches are followed, longest first
SAME_BRANCH = 0.2  # rad or m, nearer solutions are one


class Ends(NamedTuple):
    """Joints that are given at the ends of a path [rad or m], shape (dof,), or None."""

    first: Array | None
    last: Array | None

    def pin(self, joints: Array, found: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
        """Put the given joints at the ends of joints (S, dof) and found (S,), in place."""
        for i, known in zip((0, -1), self, strict=True):
            if known is not None:
                joints[i], found[i] = known, True
        return joints, found


class Answers(NamedTuple):
    """What a query answered.

    Attributes:
        joints: Joints, shape (S, dof).
        found: The solver's claims, shape (S,).
        candidates: All hypotheses, shape (S, K, dof), or None for solvers without any.
    """

    joints: Array
    found: NDArray[np.bool_]
    candidates: Array | None = None


def joint_steps(joints: Array) -> Array:
    """Largest change of a joint from each waypoint to the next.

    Args:
        joints: Joint positions [rad or m], shape (S, dof).

    Returns:
        Steps [rad or m], shape (S - 1,).
    """
    return np.abs(np.diff(joints, axis=0)).max(axis=1)


def branch_flips(robot: Robot, joints: Array, poses: Array) -> NDArray[np.bool_]:
    """Find the steps at which the joints change to another branch of solutions.

    A step is a flip if a joint moves by more than `FLIP_STEP` and, with the joints half way between
    the two waypoints, the tip is further from the pose half way than both a fixed bound
    (`FLIP_DEVIATION`, `FLIP_TURN`) and half of what the tip moves in that step, in position or in
    rotation.

    Args:
        robot: The robot.
        joints: Joint positions at the waypoints [rad or m], shape (S, dof).
        poses: Wanted tip poses, base frame [m, unit quaternion], shape (S, 7).

    Returns:
        Whether step i, from waypoint i to i + 1, is a flip, shape (S - 1,).
    """
    flips = np.zeros(len(joints) - 1, dtype=bool)
    find_flips(robot.chain, np.ascontiguousarray(joints), np.ascontiguousarray(poses), flips)
    return flips


def fits(robot: Robot, joints: Array, found: NDArray[np.bool_], poses: Array) -> bool:
    """Whether joints (S, dof) are claimed to reach all poses (S, 7), and do not flip."""
    return bool(found.all()) and not branch_flips(robot, joints, poses).any()


def kernel_options(solver: Solver | None) -> LmOptions | None:
    """Tolerances and damping of a solver that refines by the kernel of `lm`, else None."""
    kernel = getattr(solver, "kernel", solver)
    return kernel.options(None) if isinstance(kernel, LevenbergMarquardt) else None


def repair_path(
    robot: Robot,
    poses: Array,
    answers: Answers,
    ends: Ends,
    options: LmOptions,
    flip_free_only: bool = False,
) -> tuple[Array, NDArray[np.bool_]]:
    """Replace a path that flips or misses waypoints by a better one, if there is one.

    Args:
        robot: The robot.
        poses: Waypoints, base frame [m, unit quaternion], shape (S, 7).
        answers: Of the solver; its candidates are further configurations to begin from.
        ends: Joints that the path has to start and end with.
        options: Tolerances and damping of the repair.
        flip_free_only: Look for paths without any flip alone; with few flips none is wanted.

    Returns:
        Joints, shape (S, dof), and which waypoints were reached, shape (S,): the answers as they
        were where nothing better was found, by waypoints missed, then flips, then travel.
    """
    joints, found, _ = answers
    if fits(robot, joints, found, poses):
        return joints, found
    paths = [(joints, found)]
    followed = _followed(robot, poses, answers, ends, options)
    if followed is not None:
        paths.append((followed, np.ones(len(poses), dtype=bool)))
    else:
        paths += _searched(robot, poses, ends, options, flip_free_only)
    return min(paths, key=lambda path: _badness(robot, path[0], path[1], poses))


def _searched(
    robot: Robot, poses: Array, ends: Ends, options: LmOptions, flip_free_only: bool
) -> list[tuple[Array, NDArray[np.bool_]]]:
    """Search branches one by one, then all from the start, then all from the target.

    Each only where the one before was not enough: a narrow branch may have no sample at one end
    and many at the other.
    """
    first, last = ends
    if first is None and last is None:
        branch = one_branch(robot, poses, options, QUICK)
        if branch is not None:
            return [(branch, np.ones(len(poses), dtype=bool))]
    paths = []
    if first is not None or last is None:
        path, reached = fewest_flips(robot, poses, options, QUICK, first, last, flip_free_only)
        paths.append(ends.pin(path, reached))
        if _badness(robot, path, reached, poses)[:2] == (0, 0):
            return paths
    path, reached = fewest_flips(
        robot, poses[::-1].copy(), options, QUICK, last, first, flip_free_only
    )
    paths.append(ends.pin(path[::-1].copy(), reached[::-1].copy()))
    return paths


def _followed(
    robot: Robot, poses: Array, answers: Answers, ends: Ends, options: LmOptions
) -> Array | None:
    """Follow the branches of the answers; the first that covers the path, shape (S, dof)."""
    origins, seeds = _beginnings(robot, poses, answers, ends)
    paths = np.empty((len(seeds), len(poses), robot.dof))
    share = QUICK.drift(robot.dof)
    winner = follow_until_complete(
        robot.chain, poses, origins, seeds, options, share, SAME_BRANCH, paths
    )
    if winner < 0:
        return None
    path = np.array(paths[winner])
    path, _ = ends.pin(path, answers.found.copy())
    return None if branch_flips(robot, path, poses).any() else path


def _beginnings(
    robot: Robot, poses: Array, answers: Answers, ends: Ends
) -> tuple[NDArray[np.int64], Array]:
    """Waypoints (K,) and configurations (K, dof) to follow branches from, best first."""
    if ends.first is not None:
        return np.zeros(1, np.int64), ends.first[None]
    last = len(poses) - 1
    if ends.last is not None:
        return np.array([last]), ends.last[None]
    joints, found, candidates = answers
    breaks = branch_flips(robot, joints, poses) | ~found[1:] | ~found[:-1]
    edges = np.concatenate([[0], np.flatnonzero(breaks) + 1, [last + 1]])
    longest = np.argsort(-np.diff(edges), kind="stable")[:SEGMENTS]
    middles = (edges[longest] + edges[longest + 1] - 1) // 2
    origins, seeds = middles, joints[middles]
    if candidates is not None:
        places = np.array([last // 2, 0, last])
        origins = np.concatenate([origins, np.repeat(places, candidates.shape[1])])
        seeds = np.concatenate([seeds, candidates[places].reshape(-1, robot.dof)])
    return origins.astype(np.int64), np.ascontiguousarray(seeds)


def _badness(
    robot: Robot, joints: Array, found: NDArray[np.bool_], poses: Array
) -> tuple[int, int, float]:
    flips = int(branch_flips(robot, joints, poses).sum())
    return int((~found).sum()), flips, float(np.abs(np.diff(joints, axis=0)).sum())
