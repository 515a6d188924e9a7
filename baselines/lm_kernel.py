"""Compiled Levenberg-Marquardt inverse kinematics with joint limits as an active set.

One step solves (J Jᵀ + λ I) y = e and moves the joints by Jᵀ y, where e holds the distance to the
target [m] and the rotation vector [rad], and λ follows the squared error (Sugihara,
"Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", IEEE Transactions
on Robotics 2011). A joint at its limit whose step points outward is frozen and the step is solved
again (Nocedal and Wright, "Numerical Optimization", section 16.5). A descent whose squared error
has not halved within `patience` iterations is given up: the next seed follows, then remembered
configurations near the target if there is a memory, then random ones.

Functions that allocate nothing are compiled with `_nrt=False`: numba then leaves out the counting
of references to arrays, atomic increments that took almost half of the time.

Every random number depends on the target alone, so that a row of the result does not depend on
the batch around it, its order or the number of threads.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from baselines.clock import now_ns, pose_key, uniform
from baselines.damped_step import damped_step, step_inside
from baselines.freedom_kernel import free_error, free_rows, new_freedom_room
from baselines.linearise import (
    Linearisation,
    find_error,
    find_jacobian,
    new_linearisation,
    set_target,
)
from baselines.seed_library import find_distances, take_nearest
from robots.compiled import njit
from robots.rows import copy_row

Array = NDArray[np.float64]

FOUND, OUT_OF_ITERATIONS, OUT_OF_TIME, OUT_OF_STARTS, IN_COLLISION, OUT_OF_REACH = range(6)


class LmOptions(NamedTuple):
    """What the kernel needs beside robot, targets and seeds.

    Attributes:
        position_tolerance_m: Distance to the target at which a solution is claimed [m].
        rotation_tolerance_rad: Rotation angle at which it is claimed [rad].
        damping: Constant part of λ [m² and rad²].
        damping_gain: λ per squared error.
        patience: Iterations within which the squared error has to halve.
        max_active_set_passes: How often a step is solved again with joints frozen.
        iterations: Iterations per pose, summed over starts.
        starts: Seeds and random configurations tried per pose.
        nearest_starts: The same where it is proven that no configuration has the pose, and only the
            nearest answer is looked for; 0 asks for no proof.
        time_ns: Time per pose [ns], 0 for no limit.
    """

    position_tolerance_m: float
    rotation_tolerance_rad: float
    damping: float
    damping_gain: float
    patience: int
    max_active_set_passes: int
    iterations: int
    starts: int
    nearest_starts: int
    time_ns: int


class _Scratch(NamedTuple):
    """Arrays that one thread works in."""

    at: Linearisation
    solved: Array
    step: Array
    free: NDArray[np.bool_]
    q: Array
    timespec: NDArray[np.int64]
    distances: NDArray[np.float32]


@njit()
def _scratch(joints, dof, library):  # type: ignore[no-untyped-def]
    return _Scratch(
        new_linearisation(joints, dof),
        np.empty(6),
        np.empty(dof),
        np.empty(dof, dtype=np.bool_),
        np.empty(dof),
        np.empty(2, dtype=np.int64),
        np.empty(library.joints.shape[0], dtype=np.float32),
    )


@njit(_nrt=False)
def choose_start(chain, pose, seeds, library, attempt, goal, distances, q):  # type: ignore[no-untyped-def]
    """Write the `attempt`-th start: seeds in order, then near remembered ones, then random ones.

    Args:
        chain: The `Chain`.
        pose: (7,) target.
        seeds: (K, dof) seeds of this pose.
        library: `SeedLibrary`.
        attempt: Which start; those of one pose are to be chosen in order.
        goal: (3, 3) rotation of the target.
        distances: (M,) scratch that is left alone between the starts of a pose.
        q: (dof,) receives the start.
    """
    seeded = seeds.shape[0]
    known = seeded + library.neighbours
    dof = q.shape[0]
    nearest, key = 0, np.uint64(0)
    if attempt >= known:
        key = pose_key(pose)
    elif attempt >= seeded:
        if attempt == seeded:
            find_distances(library, pose, goal, distances)
        nearest = take_nearest(distances)
    for k in range(dof):
        if attempt < known:
            value = seeds[attempt, k] if attempt < seeded else library.joints[nearest, k]
            q[k] = min(max(value, chain.lower[k]), chain.upper[k])
        else:
            share = uniform(key, (attempt - known) * dof + k)
            q[k] = chain.lower[k] + share * (chain.upper[k] - chain.lower[k])


@njit(_nrt=False)
def refine_from(chain, pose, seeds, library, options, freedom, s, best, first, used):  # type: ignore[no-untyped-def]
    """Solve one pose; writes the best joints and returns (status, iterations, starts).

    The start `first` is the first one; `used` iterations are gone already. With freedom None, the
    whole pose, numba compiles a version that knows of none.
    """
    started = now_ns(s.timespec) if options.time_ns > 0 else 0
    position2 = options.position_tolerance_m**2
    rotation2 = options.rotation_tolerance_rad**2
    set_target(pose, s.at)
    least = np.inf
    iterations = used
    for attempt in range(first, options.starts):
        choose_start(chain, pose, seeds, library, attempt, s.at.goal, s.distances, s.q)
        since, reference = 0, np.inf
        while True:
            distance2, angle2 = find_error(chain, s.q, pose, s.at)
            if freedom is not None:
                distance2, angle2 = free_error(freedom, s.at)
            squared = distance2 + angle2
            if squared < least:
                least = squared
                copy_row(s.q, best)
            if distance2 <= position2 and angle2 <= rotation2:
                copy_row(s.q, best)
                return FOUND, iterations, attempt + 1
            if iterations >= options.iterations:
                return OUT_OF_ITERATIONS, iterations, attempt + 1
            if (
                options.time_ns > 0
                and iterations & 3 == 3
                and now_ns(s.timespec) - started >= options.time_ns
            ):
                return OUT_OF_TIME, iterations, attempt + 1
            if since == options.patience:
                if squared > 0.5 * reference:
                    break
                since = 0
            if since == 0:
                reference = squared
            damping = options.damping + options.damping_gain * squared
            if freedom is None:
                damped_step(chain, s, None, damping, options.max_active_set_passes)
            else:
                find_jacobian(chain, s.at)
                free_rows(freedom, s.at)
                step_inside(chain, s, None, damping, options.max_active_set_passes)
            iterations += 1
            since += 1
    return OUT_OF_STARTS, iterations, options.starts


@njit()
def limited(options, starts, time_ns):  # type: ignore[no-untyped-def]
    """Return options with another number of starts and another time."""
    return LmOptions(
        options.position_tolerance_m,
        options.rotation_tolerance_rad,
        options.damping,
        options.damping_gain,
        options.patience,
        options.max_active_set_passes,
        options.iterations,
        starts,
        options.nearest_starts,
        time_ns,
    )


@njit()
def first_start_only(options):  # type: ignore[no-untyped-def]
    """Return options under which the first seed alone is descended from."""
    return limited(options, 1, options.time_ns)


@njit()
def refine_row(chain, pose, seeds, library, options, joints):  # type: ignore[no-untyped-def]
    """Solve one pose (7,) from seeds (K, dof) into joints (dof,).

    Returns:
        Status, iterations, starts and time [ns].
    """
    s = _scratch(chain.prismatic.shape[0], joints.shape[0], library)
    began = now_ns(s.timespec)
    status, iterations, starts = refine_from(
        chain, pose, seeds, library, options, None, s, joints, 0, 0
    )
    return status, iterations, starts, now_ns(s.timespec) - began


@njit()
def refine_rows(  # type: ignore[no-untyped-def]
    chain, poses, seeds, library, options, joints, status, iterations, starts, time_ns
):
    """Solve a batch on one thread."""
    s = _scratch(chain.prismatic.shape[0], joints.shape[1], library)
    for row in range(poses.shape[0]):
        began = now_ns(s.timespec)
        status[row], iterations[row], starts[row] = refine_from(
            chain, poses[row], seeds[row], library, options, None, s, joints[row], 0, 0
        )
        time_ns[row] = now_ns(s.timespec) - began


@njit(parallel=True)
def refine_rows_parallel(  # type: ignore[no-untyped-def]
    chain, poses, seeds, library, options, joints, status, iterations, starts, time_ns
):
    """Compute `refine_rows` on all threads of numba; the same joints, bitwise."""
    block = 16
    for b in prange((poses.shape[0] + block - 1) // block):
        r = slice(b * block, min((b + 1) * block, poses.shape[0]))
        refine_rows(
            chain,
            poses[r],
            seeds[r],
            library,
            options,
            joints[r],
            status[r],
            iterations[r],
            starts[r],
            time_ns[r],
        )


@njit()
def refine_rows_freely(  # type: ignore[no-untyped-def]
    chain, poses, seeds, library, options, widths, joints, status, iterations, starts, time_ns
):
    """Solve a batch on one thread under freedoms, widths (N, 6) [m and rad]."""
    s = _scratch(chain.prismatic.shape[0], joints.shape[1], library)
    room = new_freedom_room()
    for row in range(poses.shape[0]):
        began = now_ns(s.timespec)
        copy_row(widths[row], room.widths)
        status[row], iterations[row], starts[row] = refine_from(
            chain, poses[row], seeds[row], library, options, room, s, joints[row], 0, 0
        )
        time_ns[row] = now_ns(s.timespec) - began
