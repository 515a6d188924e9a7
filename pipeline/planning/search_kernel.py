"""Compiled search of all branches at once: dynamic programming over sampled solutions.

The solutions of a waypoint form one or more sheets, points for six joints and curves or surfaces
for redundant arms. The search carries a set of samples of these sheets from waypoint to waypoint:
each sample is continued, also with motions in the null space, samples that came close to one
another become the one with the least travel so far, and those that are lost end. What reaches
the last waypoint has come from the first one without a flip.
"""

from __future__ import annotations

import numpy as np

from baselines.clock import pose_key, uniform
from pipeline.planning.flip_kernel import is_flip
from pipeline.planning.tracking_kernel import avoid_limits, new_tracker, reach_pose
from robots.compiled import njit

GROWTH = 1.5  # of the distance between samples where they are too many


@njit()
def thinned(joints, order, gap, chosen):  # type: ignore[no-untyped-def]
    """Choose rows at a distance from one another, the first in order first.

    The gap grows until the choice fits, so that all sheets stay in it.

    Args:
        joints: Configurations [rad or m], shape (N, dof).
        order: Rows to look at, best first.
        gap: Smallest largest joint distance of two that are chosen [rad or m].
        chosen: Receives rows, shape (most,).

    Returns:
        Number of rows chosen.
    """
    most = chosen.shape[0]
    while True:
        count, full = 0, False
        for row in order:
            new = True
            for j in range(count):
                wide = 0.0
                for k in range(joints.shape[1]):
                    wide = max(wide, abs(joints[row, k] - joints[chosen[j], k]))
                if wide < gap:
                    new = False
                    break
            if new and count == most:
                full = True
                break
            if new:
                chosen[count] = row
                count += 1
        if not full:
            return count
        gap *= GROWTH


@njit(no_cpython_wrapper=True)
def _set_bias(chain, goal, remaining, kind, share, size, key, counter, t):  # type: ignore[no-untyped-def]
    """Write the null-space motion of one copy of a sample into t.bias."""
    if kind == 0 and goal.shape[0] > 0:
        for k in range(t.q.shape[0]):
            t.bias[k] = (goal[k] - t.q[k]) / remaining
    elif kind == 0:
        avoid_limits(chain, share, t)
    else:
        for k in range(t.q.shape[0]):
            t.bias[k] = size * (2.0 * uniform(key, counter * t.q.shape[0] + k) - 1.0)


@njit()
def search(  # type: ignore[no-untyped-def]
    chain, poses, starts, goal, options, copies, share, size, gap, nodes, parents, costs, counts
):
    """Carry samples of all branches from the first waypoint as far as any of them can be continued.

    Args:
        chain: The chain of the robot.
        poses: Waypoints, base frame, shape (S, 7).
        starts: Solutions of the first waypoint [rad or m], shape (K, dof).
        goal: Joints to drift towards [rad or m], shape (dof,), or (0,) for mid-range.
        options: `LmOptions`.
        copies: Continuations of each sample: a drift, none, then random motions; 1 is none alone.
        share: Motion of a joint at its limit away from it [rad or m].
        size: Largest random motion of a joint [rad or m].
        gap: Distance up to which two samples are one [rad or m].
        nodes: Receives the samples, shape (S, N, dof).
        parents: Receives the sample before each, shape (S, N).
        costs: Receives the squared travel up to each, shape (S, N).
        counts: Receives the number of samples of each waypoint, shape (S,).

    Returns:
        Number of waypoints from the first on that have samples.
    """
    most, dof = nodes.shape[1], starts.shape[1]
    t = new_tracker(chain)
    pool, cost = np.empty((most * copies, dof)), np.empty(most * copies)
    parent = np.empty(most * copies, dtype=np.int64)
    chosen = np.empty(most, dtype=np.int64)
    counts[:] = 0
    counts[0] = thinned(starts, np.arange(len(starts)), gap, chosen)
    for n in range(counts[0]):
        nodes[0, n], parents[0, n], costs[0, n] = starts[chosen[n]], -1, 0.0
    for i in range(1, poses.shape[0]):
        key, found = pose_key(poses[i]), 0
        for n in range(counts[i - 1]):
            for copy in range(copies):
                kind = copy if copies > 1 else 1
                t.q[:] = nodes[i - 1, n]
                if kind != 1:
                    left, draw = poses.shape[0] - i, n * copies + copy
                    _set_bias(chain, goal, left, kind, share, size, key, draw, t)
                if not reach_pose(chain, poses[i], options, kind != 1, t):
                    continue
                if is_flip(chain, nodes[i - 1, n], t.q, poses[i - 1], poses[i], t):
                    continue
                pool[found], parent[found] = t.q, n
                cost[found] = costs[i - 1, n] + np.sum((t.q - nodes[i - 1, n]) ** 2)
                found += 1
        if found == 0:
            return i
        counts[i] = thinned(pool[:found], np.argsort(cost[:found]), gap, chosen)
        for n in range(counts[i]):
            row = chosen[n]
            nodes[i, n], parents[i, n], costs[i, n] = pool[row], parent[row], cost[row]
    return poses.shape[0]


@njit()
def cheapest_path(candidates, prices, chosen):  # type: ignore[no-untyped-def]
    """Choose one candidate a waypoint with the least squared travel and price (Viterbi).

    Args:
        candidates: Joints [rad or m], shape (S, K, dof).
        prices: What each candidate costs by itself [rad²], shape (S, K).
        chosen: Receives the index of the candidate, shape (S,).
    """
    steps, count, dof = candidates.shape
    best = prices[0].copy()
    total = np.empty(count)
    parent = np.zeros((steps, count), dtype=np.int64)
    for i in range(1, steps):
        for b in range(count):
            least = np.inf
            for a in range(count):
                travel = best[a]
                for k in range(dof):
                    travel += (candidates[i, b, k] - candidates[i - 1, a, k]) ** 2
                if travel < least:
                    least, parent[i, b] = travel, a
            total[b] = least + prices[i, b]
        best[:] = total
    chosen[steps - 1] = np.argmin(best)
    for i in range(steps - 1, 0, -1):
        chosen[i - 1] = parent[i, chosen[i]]


@njit()
def relax(chain, poses, options, sweeps, joints):  # type: ignore[no-untyped-def]
    """Smooth a path of joints (S, dof) in its null space, in place; the ends stay.

    Every inner waypoint is drawn to the middle of its neighbours and brought back onto its pose;
    a waypoint for which that fails, or that would flip, stays where it was.
    """
    t = new_tracker(chain)
    for sweep in range(sweeps):
        for j in range(1, joints.shape[0] - 1):
            i = j if sweep % 2 == 0 else joints.shape[0] - 1 - j
            t.q[:] = joints[i]
            t.bias[:] = 0.5 * (joints[i - 1] + joints[i + 1]) - joints[i]
            if (
                reach_pose(chain, poses[i], options, True, t)
                and not is_flip(chain, joints[i - 1], t.q, poses[i - 1], poses[i], t)
                and not is_flip(chain, t.q, joints[i + 1], poses[i], poses[i + 1], t)
            ):
                joints[i] = t.q
