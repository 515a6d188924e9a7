"""Search all branches of solutions for the path with the fewest flips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines.lm_kernel import LmOptions
from baselines.refine import refine
from pipeline.planning.flip_kernel import FLIP_STEP
from pipeline.planning.follow_kernel import follow_until_complete
from pipeline.planning.search_kernel import relax, search
from pipeline.planning.tracking_kernel import new_tracker, reach_pose

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

START_ITERATIONS = 60  # of one descent towards a solution of a waypoint
SWEEPS = 20  # of smoothing what random motions in the null space have roughened
TASK = 6  # degrees of freedom of a pose: an arm with no more has no null space


@dataclass(frozen=True)
class Effort:
    """How thoroughly branches are searched.

    Attributes:
        origins: Waypoints from which branches are followed one by one.
        seeds: Random configurations from which solutions of a waypoint are searched.
        samples: Samples of all branches that are carried from waypoint to waypoint.
        copies: Continuations of each sample of a redundant arm: drift, none, random.
        share: Drift of a joint at its limit away from it, per waypoint [rad or m].
        size: Largest random motion of a joint, per waypoint [rad or m].
        gap: Joint distance up to which two samples are one [rad or m].
    """

    origins: int
    seeds: int
    samples: int
    copies: int
    share: float
    size: float
    gap: float

    def drift(self, dof: int) -> float:
        """Return `share` where there is a null space to drift in, else 0."""
        return self.share if dof > TASK else 0.0


# For a plan that nothing cheaper could repair, and to find out whether any plan could.
QUICK = Effort(origins=5, seeds=128, samples=128, copies=4, share=0.05, size=0.15, gap=0.1)
EXHAUSTIVE = Effort(origins=17, seeds=400, samples=400, copies=4, share=0.05, size=0.15, gap=0.1)


def solutions(robot: Robot, pose: Array, options: LmOptions, effort: Effort) -> Array:
    """Solutions of one pose from random configurations, the same for the same pose.

    Args:
        robot: The robot.
        pose: Pose, base frame [m, unit quaternion], shape (7,).
        options: Tolerances and damping.
        effort: How many configurations to start from.

    Returns:
        Joints [rad or m], shape (K, dof); K may be 0.
    """
    generator = np.random.default_rng(effort.seeds)
    seeds = generator.uniform(robot.lower, robot.upper, (effort.seeds, 1, robot.dof))
    seeds[0, 0] = robot.home
    one = options._replace(starts=1, iterations=START_ITERATIONS)
    found = refine(robot, np.tile(pose, (effort.seeds, 1)), seeds, one)
    return np.array(found.joints[found.found])


def one_branch(robot: Robot, poses: Array, options: LmOptions, effort: Effort) -> Array | None:
    """Follow the branches through some of the waypoints, one by one, to both ends of a path.

    Cheaper than `longest_path`, and it starts where a narrow branch may be widest; but each branch
    is followed along one path of joints only, where a redundant arm has many.

    Args:
        robot: The robot.
        poses: Waypoints, base frame, shape (S, 7).
        options: Tolerances and damping.
        effort: How thoroughly to search.

    Returns:
        Joints, shape (S, dof), or None if no branch covers the path.
    """
    share = effort.drift(robot.dof)
    for origin in np.linspace(0, len(poses) - 1, effort.origins).astype(int):
        seeds = solutions(robot, poses[origin], options, effort)
        paths = np.empty((len(seeds), len(poses), robot.dof))
        origins = np.full(len(seeds), origin)
        arguments = (options, share, effort.gap, paths)
        winner = follow_until_complete(robot.chain, poses, origins, seeds, *arguments)
        if winner >= 0:
            return np.array(paths[winner])
    return None


def longest_path(
    robot: Robot,
    poses: Array,
    starts: Array,
    options: LmOptions,
    effort: Effort,
    goal: Array | None = None,
) -> Array:
    """Continue solutions of the first waypoint as far as any branch goes without a flip.

    Args:
        robot: The robot.
        poses: Waypoints, base frame, shape (S, 7).
        starts: Solutions of the first waypoint [rad or m], shape (K, dof), at least one.
        options: Tolerances and damping.
        effort: How thoroughly to search.
        goal: Joints to end at, as near as can be [rad or m], shape (dof,), or None.

    Returns:
        Joints at the first waypoints, shape (L, dof), 1 <= L <= S; the cheapest of the longest.
    """
    count, most, dof = len(poses), effort.samples, robot.dof
    nodes, costs = np.empty((count, most, dof)), np.empty((count, most))
    parents, counts = np.empty((count, most), np.int64), np.empty(count, np.int64)
    length = search(
        robot.chain,
        poses,
        np.ascontiguousarray(starts),
        np.empty(0) if goal is None else goal,
        options,
        effort.copies if dof > TASK else 1,
        effort.share,
        effort.size,
        effort.gap,
        nodes,
        parents,
        costs,
        counts,
    )
    last = counts[length - 1]
    price = costs[length - 1, :last]
    if goal is not None:
        price = np.abs(nodes[length - 1, :last] - goal).max(axis=1)
    chosen, path = int(np.argmin(price)), np.empty((length, dof))
    for i in range(length - 1, -1, -1):
        path[i], chosen = nodes[i, chosen], parents[i, chosen]
    if dof > TASK:
        relax(robot.chain, poses[:length], options, SWEEPS, path)
    return path


def fewest_flips(
    robot: Robot,
    poses: Array,
    options: LmOptions,
    effort: Effort,
    first: Array | None = None,
    goal: Array | None = None,
    flip_free_only: bool = False,
) -> tuple[Array, NDArray[np.bool_]]:
    """Cover a path with as few branches as can be found.

    Going as far as possible before each change is what makes the changes fewest. A waypoint that
    no seed solves is out of reach; there the joints stay as near to the pose as they come without
    a jump.

    Args:
        robot: The robot.
        poses: Waypoints, base frame, shape (S, 7).
        options: Tolerances and damping.
        effort: How thoroughly to search.
        first: Joints at the first waypoint [rad or m], shape (dof,), or None to choose.
        goal: Joints to end at, as near as can be, shape (dof,), or None.
        flip_free_only: Stop at the first flip or waypoint out of reach; the rest stays near.

    Returns:
        Joints, shape (S, dof), and which waypoints were reached, shape (S,).
    """
    joints, found = np.empty((len(poses), robot.dof)), np.zeros(len(poses), dtype=bool)
    i = 0
    while i < len(poses):
        if i == 0 and first is not None:
            starts = first[None]
        else:
            starts = solutions(robot, poses[i], options, effort)
        if len(starts) == 0 and flip_free_only:
            break
        if len(starts) == 0:
            i += 1
            continue
        path = longest_path(robot, poses[i:], starts, options, effort, goal)
        joints[i : i + len(path)], found[i : i + len(path)] = path, True
        i += len(path)
        if flip_free_only:
            break
    _stay_near(robot, poses, options, joints, found)
    return joints, found


def _stay_near(
    robot: Robot, poses: Array, options: LmOptions, joints: Array, found: NDArray[np.bool_]
) -> None:
    """Fill waypoints out of reach, in place, from the waypoint before, or else from the one after.

    Each is as near as one descent comes within a smooth step.
    """
    known = found.copy()
    if not known.any():
        joints[0], known[0] = robot.home, True
    order = [(i, i - 1) for i in range(1, len(joints))]
    order += [(i, i + 1) for i in range(len(joints) - 2, -1, -1)]
    tracker = new_tracker(robot.chain)
    for i, neighbour in order:
        if known[i] or not known[neighbour]:
            continue
        tracker.q[:] = joints[neighbour]
        reach_pose(robot.chain, poses[i], options, False, tracker)
        step = np.clip(tracker.q - joints[neighbour], -0.5 * FLIP_STEP, 0.5 * FLIP_STEP)
        joints[i], known[i] = joints[neighbour] + step, True
