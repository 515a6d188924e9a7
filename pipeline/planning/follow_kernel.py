"""Compiled following of single branches of solutions from one end of a path to the other."""

from __future__ import annotations

import numpy as np

from pipeline.planning.flip_kernel import is_flip
from pipeline.planning.tracking_kernel import avoid_limits, new_tracker, reach_pose
from robots.compiled import njit


@njit(no_cpython_wrapper=True)
def _follow(chain, poses, origin, options, share, path, t):  # type: ignore[no-untyped-def]
    """Continue path[origin] to both ends of the path; NaN where it is lost."""
    reached = 1
    for direction in (1, -1):
        i = origin + direction
        while 0 <= i < poses.shape[0]:
            before = path[i - direction]
            good = False
            for biased in (share > 0.0, False):
                t.q[:] = before
                if biased:
                    avoid_limits(chain, share, t)
                good = reach_pose(chain, poses[i], options, biased, t) and not is_flip(
                    chain, before, t.q, poses[i - direction], poses[i], t
                )
                if good or not biased:
                    break
            if not good:
                break
            path[i] = t.q
            reached += 1
            i += direction
    return reached


@njit()
def follow_until_complete(  # type: ignore[no-untyped-def]
    chain, poses, origins, seeds, options, share, apart, paths
):
    """Follow one branch after another until one of them reaches both ends of the path.

    A seed that leads to a configuration which an earlier branch already went through is skipped.

    Args:
        chain: The chain of the robot.
        poses: Waypoints, base frame, shape (S, 7).
        origins: Waypoint that each seed is for, shape (K,).
        seeds: Configurations near a solution of that waypoint [rad or m], shape (K, dof).
        options: `LmOptions`.
        share: Motion of a joint at its limit away from it, per waypoint [rad or m]; 0 for none.
        apart: Largest joint distance up to which two solutions are one [rad or m].
        paths: Receives the branches, NaN where one is lost, shape (K, S, dof).

    Returns:
        Index of the branch that is complete, or -1.
    """
    t = new_tracker(chain)
    for n in range(seeds.shape[0]):
        paths[n] = np.nan
        t.q[:] = seeds[n]
        if not reach_pose(chain, poses[origins[n]], options, False, t):
            continue
        known = False
        for other in range(n):
            if np.abs(paths[other, origins[n]] - t.q).max() < apart:  # false for NaN
                known = True
                break
        if known:
            continue
        paths[n, origins[n]] = t.q
        if _follow(chain, poses, origins[n], options, share, paths[n], t) == poses.shape[0]:
            return n
    return -1
