"""One query of `lm`, see `baselines.compiled_query`."""

from __future__ import annotations

import numpy as np

from baselines.clock import now_ns
from baselines.compiled_query import REFUSED
from baselines.joint_range import take_initial, turn_nearest
from baselines.lanes_kernel import refine_lanes
from baselines.lanes_work import Batch, new_room
from baselines.lm_kernel import FOUND, OUT_OF_REACH, first_start_only, limited, refine_row
from baselines.taken_poses import take_pose
from robots.chain import Chain
from robots.compiled import njit
from robots.pose_bound import proves_no
from robots.rows import copy_row


@njit(inline="always")
def refine_query(chain, pose, seeds, library, options, answer, timed, bound):  # type: ignore[no-untyped-def]
    """Descend for one pose as `baselines.refine` does, with the same bits.

    The lanes of a vector that have no other pose descend from later starts, so that the poses whose
    first start leads nowhere take a few steps longer and not several times as long.

    Args:
        chain: The robot's `Chain`.
        pose: (7,) target.
        seeds: (K, dof) seeds [rad or m].
        library: `SeedLibrary`.
        options: `LmOptions`.
        answer: (dof,) receives the joints [rad or m].
        timed: None without a limit of time, True with one: numba compiles a version each, of which
            mostly one is needed.
        bound: `PoseBound`.

    Returns:
        Status, iterations, starts and time [ns].
    """
    timespec = np.empty(2, dtype=np.int64)
    began = now_ns(timespec)
    proven = options.nearest_starts > 0 and proves_no(
        bound, pose, options.position_tolerance_m, options.rotation_tolerance_rad
    )
    if timed is not None:
        if proven:
            options = limited(options, min(options.starts, options.nearest_starts), options.time_ns)
        status, iterations, starts, spent = refine_row(chain, pose, seeds, library, options, answer)
        status = OUT_OF_REACH if proven and status != FOUND else status
        return status, iterations, starts, spent
    dof = answer.shape[0]
    counts, proofs = np.zeros((4, 1), dtype=np.int64), np.empty(1, dtype=np.bool_)
    proofs[0] = proven
    batch = Batch(
        pose.reshape((1, 7)),
        seeds.reshape((1, seeds.shape[0], dof)),
        proofs,
        answer.reshape((1, dof)),
        counts[0],
        counts[1],
        counts[2],
        counts[3],
    )
    room = new_room(1, chain.prismatic.shape[0], dof, library.joints.shape[0])
    refine_lanes(chain, batch, library, options, room, np.int64(0))  # no literal: a type of its own
    return counts[0, 0], counts[1, 0], counts[2, 0], now_ns(timespec) - began


@njit()
def drawn_in(chain, guess, max_jump):  # type: ignore[no-untyped-def]
    """Return a chain whose joints stay within a distance [rad or m] of a guess (dof,)."""
    return Chain(
        chain.rotations,
        chain.translations,
        chain.prismatic,
        chain.variable,
        chain.multiplier,
        chain.offset,
        np.maximum(chain.lower, guess - max_jump),
        np.minimum(chain.upper, guess + max_jump),
    )


@njit()
def lm_query(  # type: ignore[no-untyped-def]
    pose, initial, answer, options, timed, joints, home, chain, library, bound, max_jump
):
    """Solve one pose from an initial guess, or else from home.

    With a largest jump the limits are drawn in around the guess, and it is the only start: its
    descent runs along those limits like along any others, and ends inside them.

    Args:
        pose: (7,) target in the base frame, x y z [m], qw qx qy qz.
        initial: (1, dof) guess, or (0, dof) for home [rad or m].
        answer: (dof,) receives the joints [rad or m].
        options: `LmOptions`.
        timed: See `refine_query`.
        joints: `JointRange`.
        home: (dof,) guess where there is none.
        chain: The robot's `Chain`.
        library: `SeedLibrary`.
        bound: `PoseBound`.
        max_jump: How far each joint may be from the guess [rad or m]; None for any distance.

    Returns:
        Status, iterations, starts and time [ns], or (`REFUSED`, 0, 0, 0).
    """
    target, seeds = np.empty(7), np.empty((1, home.shape[0]))
    copy_row(home, seeds[0])
    if not (take_pose(pose, target) and take_initial(initial, joints, seeds)):
        return REFUSED, 0, 0, 0
    if max_jump is None:
        outcome = refine_query(chain, target, seeds, library, options, answer, timed, bound)
    else:
        near = drawn_in(chain, seeds[0], max_jump)
        outcome = refine_row(near, target, seeds, library, first_start_only(options), answer)
    turn_nearest(initial, joints, answer)
    return outcome


@njit()
def near_rows(chain, poses, guesses, library, options, max_jump, answers, outcomes):  # type: ignore[no-untyped-def]
    """Solve a batch within a largest jump, whose limits are each row's own.

    Args:
        chain: The robot's `Chain`.
        poses: (N, 7) targets.
        guesses: (N, 1, dof) initial guesses inside the limits [rad or m].
        library: `SeedLibrary`.
        options: `LmOptions`.
        max_jump: How far each joint may be from its guess [rad or m].
        answers: (N, dof) receives the joints.
        outcomes: (N, 4) receives status, iterations, starts and time [ns].
    """
    once = first_start_only(options)
    for row in range(poses.shape[0]):
        near = drawn_in(chain, guesses[row, 0], max_jump)
        outcome = refine_row(near, poses[row], guesses[row], library, once, answers[row])
        for k in range(4):
            outcomes[row, k] = outcome[k]
