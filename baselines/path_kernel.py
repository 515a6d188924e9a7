"""Compiled following of a path that is known from its first pose to its last.

A motion that is followed pose by pose (`baselines.follow_kernel`) may end where a limit or a
singularity ends its branch of solutions, and nothing tells so before. Of a path that is known it is
noticed at the first attempt, and another one begins again from the start: the same steps with a
linear term beside the barrier of the limits,

    H(q) - pᵀ q

whose random p draws the arm into another posture on the way. Attempts are independent; how many it
takes is geometric (a Las Vegas algorithm: Babai, "Monte-Carlo algorithms in graph isomorphism
testing", 1979).
"""

from __future__ import annotations

import numpy as np

from baselines.follow_kernel import follow_seed, new_follow_work
from baselines.joint_range import take_initial
from robots.compiled import njit
from robots.rows import copy_row


@njit(nogil=True)
def follow_path(  # type: ignore[no-untyped-def]
    poses, start, answers, options, joints, chain, pulls, gains, max_jump
):
    """Follow a path until an attempt comes to its end, or else as far as the best one does.

    Args:
        poses: (S, 7) checked targets in the base frame, x y z [m], qw qx qy qz.
        start: (1, dof) configuration before the first of them [rad or m], checked.
        answers: (S, dof) receives the joints [rad or m]; rows that are not reached are not written.
        options: `LmOptions`; its time is not looked at.
        joints: `JointRange`.
        chain: The robot's `Chain`.
        pulls: (A, dof) p of each attempt [1/rad or 1/m].
        gains: (A,) of each attempt, see `find_null_motion`.
        max_jump: How far a joint may move from pose to pose [rad or m].

    Returns:
        Poses that are reached, from the first one on, and attempts that were made.
    """
    count, dof = answers.shape
    tried, last, seeds = np.empty((count, dof)), np.empty((1, dof)), np.empty((1, dof))
    w = new_follow_work(chain.prismatic.shape[0], dof)
    best = 0
    for attempt in range(gains.shape[0]):
        copy_row(start[0], last[0])
        reached = 0
        while reached < count:
            take_initial(last, joints, seeds)
            found, _ = follow_seed(
                chain, joints, poses[reached], last, seeds, tried[reached], options,
                pulls[attempt], gains[attempt], max_jump, w,
            )  # fmt: skip
            if not found:
                break
            copy_row(tried[reached], last[0])
            reached += 1
        if reached > best:
            best = reached
            answers[:reached] = tried[:reached]
        if best == count:
            return best, attempt + 1
    return best, gains.shape[0]
