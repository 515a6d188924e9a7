"""Levenberg-Marquardt descents as CUDA kernels, from the functions of the compiled CPU kernel.

What a descent computes (frames, error, Jacobian, damped step with limits as an active set, random
numbers) are the functions of `baselines.linearise`, `baselines.lm_kernel` and `baselines.clock`;
numba compiles them for the device as they stand. Here is what a device needs around them: who
works at which pose.

By lane: a thread takes a pose, descends from its starts one after the other as the CPU does, and
fetches the next pose from a queue, so that no lane waits for a hard pose of its neighbour. After a
few starts it leaves a pose to the second way.

By block: the threads of a block work at one pose, each from a start of its own; after every step
they look whether one has arrived, and the lowest that has gives the answer.

In both ways an answer depends on the pose, its seeds and the settings, on nothing beside it.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import cuda, types
from numpy.typing import NDArray

from baselines.clock import pose_key, uniform
from baselines.damped_step import damped_step
from baselines.linearise import Linearisation, find_error, set_target
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS, LmOptions, _Scratch
from baselines.seed_library import FEATURES, ROTATION_SHARE, SeedLibrary
from robots.chain import Chain

Array = NDArray[np.float64]

WARP = 32
MOST_LANES = 256  # threads of a block that work at one pose, at most
UNDECIDED = -1

# Numbers ahead of those of the chain in the array of constants, and the counters of a launch.
POSITION2, ROTATION2, DAMPING, GAIN, CENTRE, SCALE, HEAD = 0, 1, 2, 3, 4, 7, 10
PATIENCE, PASSES, ITERATIONS, STARTS, REMEMBERED, WHOLE_HEAD = 0, 1, 2, 3, 4, 5
NEXT, LEFT, COUNTERS = 0, 1, 2


def packed_constants(chain: Chain, options: LmOptions, library: SeedLibrary) -> tuple[Array, Any]:
    """Return all constants of a robot and its settings as one float64 and one int64 array."""
    reals = np.concatenate(
        [
            np.array([options.position_tolerance_m**2, options.rotation_tolerance_rad**2]),
            np.array([options.damping, options.damping_gain]),
            library.centre,
            library.scale,
            chain.rotations.ravel(),
            chain.translations.ravel(),
            chain.multiplier,
            chain.offset,
            chain.lower,
            chain.upper,
        ]
    )
    limits = [options.patience, options.max_active_set_passes, options.iterations, options.starts]
    settings = np.array([*limits, len(library.joints)], dtype=np.int64)
    return reals, np.concatenate([settings, chain.prismatic.astype(np.int64), chain.variable])


class Kernels(NamedTuple):
    """The kernels of chains with one number of joints.

    Attributes:
        prepare: Zeroes the counters, and finds the nearest remembered configurations.
        rank: Sorts the seeds of each pose by their error.
        by_lane: A thread a pose.
        by_block: A block a pose.
    """

    prepare: Any
    rank: Any
    by_lane: Any
    by_block: Any


@lru_cache
def kernels(joints: int, dof: int) -> Kernels:
    """Make the kernels for chains of `joints` driven joints and `dof` variables.

    Sizes of arrays in registers and in shared memory must be known to the compiler.
    """
    frames = joints + 1

    @cuda.jit(device=True)
    def load_chain(reals, whole):  # type: ignore[no-untyped-def]
        """Copy the chain into the shared memory of a block; all its threads call this."""
        rotations = cuda.shared.array((frames, 3, 3), types.float64)
        translations = cuda.shared.array((frames, 3), types.float64)
        prismatic = cuda.shared.array(joints, types.boolean)
        variable = cuda.shared.array(joints, types.int64)
        multiplier = cuda.shared.array(joints, types.float64)
        offset = cuda.shared.array(joints, types.float64)
        lower = cuda.shared.array(dof, types.float64)
        upper = cuda.shared.array(dof, types.float64)
        at_translations = HEAD + 9 * frames
        at_multiplier = at_translations + 3 * frames
        at_lower = at_multiplier + 2 * joints
        for k in range(cuda.threadIdx.x, frames, cuda.blockDim.x):
            for i in range(3):
                for j in range(3):
                    rotations[k, i, j] = reals[HEAD + 9 * k + 3 * i + j]
                translations[k, i] = reals[at_translations + 3 * k + i]
            if k < joints:
                prismatic[k] = whole[WHOLE_HEAD + k] != 0
                variable[k] = whole[WHOLE_HEAD + joints + k]
                multiplier[k] = reals[at_multiplier + k]
                offset[k] = reals[at_multiplier + joints + k]
            if k < dof:
                lower[k] = reals[at_lower + k]
                upper[k] = reals[at_lower + dof + k]
        cuda.syncthreads()
        return Chain(rotations, translations, prismatic, variable, multiplier, offset, lower, upper)

    @cuda.jit(device=True)
    def load_pose(poses, row, pose):  # type: ignore[no-untyped-def]
        """Copy a pose (7,) and return its stream key."""
        for i in range(7):
            pose[i] = poses[row, i]
        return np.uint64(pose_key(pose))  # the simulator hands over a number of Python

    @cuda.jit(device=True)
    def begin(chain, seeds, given, known, near, tried, row, key, attempt, q):  # type: ignore[no-untyped-def]
        """Write the `attempt`-th start: seeds, then near remembered ones, then random ones.

        Args:
            chain: Gives the limits.
            seeds: (N, K, dof), or (1, K, dof) for all poses.
            given: K.
            known: (M, dof) remembered configurations.
            near: (S,) which of them to try.
            tried: S, or 0 where nothing is remembered.
            row: Of the pose.
            key: Of its random numbers.
            attempt: Which start.
            q: (dof,) receives it.
        """
        shared = 0 if seeds.shape[0] == 1 else row
        for k in range(dof):
            low, high = chain.lower[k], chain.upper[k]
            if attempt < given:
                q[k] = min(max(seeds[shared, attempt, k], low), high)
            elif attempt < given + tried:
                q[k] = min(max(known[near[attempt - given], k], low), high)
            else:
                share = uniform(key, (attempt - given - tried) * dof + k)
                q[k] = low + share * (high - low)

    @cuda.jit(device=True)
    def nearest_of_stratum(reals, features, count, pose, goal):  # type: ignore[no-untyped-def]
        """Return this thread's nearest remembered pose of every blockDim-th, and its distance."""
        wanted = cuda.local.array(FEATURES, types.float32)
        for i in range(3):
            wanted[i] = (pose[i] - reals[CENTRE + i]) / reals[SCALE + i]
            for j in range(3):
                wanted[3 + 3 * i + j] = ROTATION_SHARE * goal[i, j]
        least, nearest = np.float32(np.inf), 0
        for m in range(cuda.threadIdx.x, count, cuda.blockDim.x):
            distance = np.float32(0.0)
            for i in range(FEATURES):
                difference = features[i, m] - wanted[i]
                distance += difference * difference
            if distance < least:
                least, nearest = distance, m
        return least, nearest

    @cuda.jit(device=True)
    def new_work(pose):  # type: ignore[no-untyped-def]
        """Arrays of one thread; `pose` stands in for those that only the CPU's kernel needs."""
        at = Linearisation(
            cuda.local.array((3, 3), types.float64),
            cuda.local.array((joints, 3), types.float64),
            cuda.local.array((joints, 3), types.float64),
            cuda.local.array(6, types.float64),
            cuda.local.array((dof, 6), types.float64),
            cuda.local.array((3, 3), types.float64),
            cuda.local.array(3, types.float64),
        )
        return _Scratch(
            at,
            cuda.local.array(6, types.float64),
            cuda.local.array(dof, types.float64),
            cuda.local.array(dof, types.boolean),
            cuda.local.array(dof, types.float64),
            pose,
            pose,
        )

    @cuda.jit
    def prepare(reals, whole, poses, features, near, counters):  # type: ignore[no-untyped-def]
        """Nearest remembered configurations of every pose, the nearest first, a block a pose.

        Args:
            reals: Constants.
            whole: Whole constants.
            poses: (N, 7).
            features: (12, M) of the remembered poses.
            near: (N, S) receives indices, S at most WARP.
            counters: Receive zeros.
        """
        lane = cuda.threadIdx.x
        if cuda.blockIdx.x == 0 and lane < COUNTERS:
            counters[lane] = 0
        distances = cuda.shared.array(WARP, types.float32)
        pose = cuda.local.array(7, types.float64)
        s = new_work(pose)
        if whole[REMEMBERED] > 0:
            for row in range(cuda.blockIdx.x, poses.shape[0], cuda.gridDim.x):
                for i in range(7):
                    pose[i] = poses[row, i]
                set_target(pose, s.at)
                least, nearest = nearest_of_stratum(
                    reals, features, whole[REMEMBERED], pose, s.at.goal
                )
                distances[lane] = least
                cuda.syncthreads()
                rank = 0
                for other in range(WARP):
                    if distances[other] < least or (distances[other] == least and other < lane):
                        rank += 1
                if rank < near.shape[1]:
                    near[row, rank] = nearest
                cuda.syncthreads()

    @cuda.jit
    def rank(reals, whole, poses, seeds, position_weight, rotation_weight):  # type: ignore[no-untyped-def]
        """Sort the seeds (N, K, dof) of each pose (N, 7) in place, the smallest error first."""
        chain = load_chain(reals, whole)
        pose = cuda.local.array(7, types.float64)
        s = new_work(pose)
        costs = cuda.local.array(16, types.float64)
        row = cuda.grid(1)
        if row < poses.shape[0]:
            for i in range(7):
                pose[i] = poses[row, i]
            set_target(pose, s.at)
            for head in range(min(seeds.shape[1], 16)):
                for k in range(dof):
                    s.q[k] = min(max(seeds[row, head, k], chain.lower[k]), chain.upper[k])
                distance2, angle2 = find_error(chain, s.q, pose, s.at)
                cost = position_weight * math.sqrt(distance2) + rotation_weight * math.sqrt(angle2)
                place = head
                while place > 0 and cost < costs[place - 1]:
                    costs[place] = costs[place - 1]
                    for k in range(dof):
                        seeds[row, place, k] = seeds[row, place - 1, k]
                    place -= 1
                costs[place] = cost
                for k in range(dof):
                    seeds[row, place, k] = s.q[k]

    @cuda.jit
    def by_lane(  # type: ignore[no-untyped-def]
        reals, whole, poses, seeds, given, known, near,
        starts, answers, least_of, facts, left, counters,
    ):  # fmt: skip
        """Descend, a thread a pose, from the first starts of each.

        Args:
            reals: Constants.
            whole: Whole constants.
            poses: (N, 7) targets.
            seeds: (N or 1, K, dof) starts that come first.
            given: K.
            known: (M, dof) remembered configurations.
            near: (N, S) which of them come next.
            starts: Starts after which a pose is left to `by_block`.
            answers: (N, dof) receives the joints.
            least_of: (N,) receives the squared error of those that are left.
            facts: (3, N) receives status, iterations and starts, whole numbers as float64.
            left: (N,) receives the rows that are left.
            counters: Row that is next, and how many are left.
        """
        chain = load_chain(reals, whole)
        pose = cuda.local.array(7, types.float64)
        best = cuda.local.array(dof, types.float64)
        s = new_work(pose)
        position2, rotation2 = reals[POSITION2], reals[ROTATION2]
        damping, gain = reals[DAMPING], reals[GAIN]
        patience, passes = whole[PATIENCE], whole[PASSES]
        budget, most = whole[ITERATIONS], min(whole[STARTS], starts)
        final = whole[STARTS] <= starts
        known_tried = near.shape[1] if whole[REMEMBERED] > 0 else 0
        rows = poses.shape[0]
        row = cuda.atomic.add(counters, NEXT, 1)
        fresh = True
        key, attempt, iterations, since = np.uint64(0), 0, 0, 0
        least, reference = np.inf, np.inf
        while row < rows:
            if fresh:
                key = load_pose(poses, row, pose)
                set_target(pose, s.at)
                attempt, iterations, since = 0, 0, 0
                least, reference = np.inf, np.inf
                begin(chain, seeds, given, known, near[row], known_tried, row, key, attempt, s.q)
                fresh = False
            distance2, angle2 = find_error(chain, s.q, pose, s.at)
            squared = distance2 + angle2
            found = distance2 <= position2 and angle2 <= rotation2
            if squared < least or found:
                least = squared
                for k in range(dof):
                    best[k] = s.q[k]
            status = UNDECIDED
            again = False
            if found:
                status = FOUND
            elif iterations >= budget:
                status = OUT_OF_ITERATIONS
            elif since == patience:
                since = 0
                if squared > 0.5 * reference:
                    again = True
                    attempt += 1
                    if attempt >= most:
                        status = OUT_OF_STARTS
            if status != UNDECIDED:
                for k in range(dof):
                    answers[row, k] = best[k]
                facts[0, row] = status
                facts[1, row] = iterations
                facts[2, row] = attempt if status == OUT_OF_STARTS else attempt + 1
                if status == OUT_OF_STARTS and not final:
                    least_of[row] = least
                    left[cuda.atomic.add(counters, LEFT, 1)] = row
                row = cuda.atomic.add(counters, NEXT, 1)
                fresh = True
            elif again:
                begin(chain, seeds, given, known, near[row], known_tried, row, key, attempt, s.q)
            else:
                if since == 0:
                    reference = squared
                damped_step(chain, s, None, damping + gain * squared, passes)
                iterations += 1
                since += 1

    @cuda.jit
    def by_block(  # type: ignore[no-untyped-def]
        reals, whole, poses, seeds, given, known, features,
        chosen, answers, least_of, facts, left, counters,
    ):  # fmt: skip
        """Descend, a block a pose, its threads from starts of their own.

        Arguments are those of `by_lane` but for `features`, (12, M) of the poses of `known`, and
        `chosen`: whether only the rows in `left` are asked, as many as `counters` says, whose seeds
        have been tried and for which `least_of` holds what `by_lane` has met. The iterations in
        `facts` are those of all threads.
        """
        lane, width = cuda.threadIdx.x, cuda.blockDim.x
        chain = load_chain(reals, whole)
        near = cuda.shared.array(MOST_LANES, types.int32)
        done = cuda.shared.array(MOST_LANES, types.int32)
        errors = cuda.shared.array(MOST_LANES, types.float64)
        pose = cuda.local.array(7, types.float64)
        best = cuda.local.array(dof, types.float64)
        s = new_work(pose)
        position2, rotation2 = reals[POSITION2], reals[ROTATION2]
        damping, gain = reals[DAMPING], reals[GAIN]
        patience, passes = whole[PATIENCE], whole[PASSES]
        budget, most = whole[ITERATIONS], whole[STARTS]
        strata = width if whole[REMEMBERED] > 0 else 0
        rows = counters[LEFT] if chosen else poses.shape[0]
        for place in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
            row = left[place] if chosen else place
            spent = int(facts[1, row]) if chosen else 0
            tried = int(facts[2, row]) if chosen else 0
            key = load_pose(poses, row, pose)
            set_target(pose, s.at)
            if whole[REMEMBERED] > 0:
                closest, index = nearest_of_stratum(
                    reals, features, whole[REMEMBERED], pose, s.at.goal
                )
                errors[lane] = closest
                cuda.syncthreads()
                order = 0
                for other in range(width):
                    if errors[other] < closest or (errors[other] == closest and other < lane):
                        order += 1
                near[order] = index
            cuda.syncthreads()
            attempt = lane + (given if chosen else 0)
            least, reference, since = np.inf, np.inf, 0
            active = attempt < most
            if active:
                begin(chain, seeds, given, known, near[:width], strata, row, key, attempt, s.q)
            status = UNDECIDED
            while status == UNDECIDED:
                found, moves = False, active
                squared = 0.0
                if active:
                    distance2, angle2 = find_error(chain, s.q, pose, s.at)
                    squared = distance2 + angle2
                    found = distance2 <= position2 and angle2 <= rotation2
                    if squared < least or found:
                        least = squared
                        for k in range(dof):
                            best[k] = s.q[k]
                    if since == patience and not found:
                        since = 0
                        if squared > 0.5 * reference:
                            # The new start is looked at in the next round, with all others.
                            attempt += width
                            active = attempt < most
                            moves = False
                            if active:
                                begin(
                                    chain, seeds, given, known, near[:width], strata,
                                    row, key, attempt, s.q,
                                )  # fmt: skip
                done[lane] = found
                errors[lane] = least
                # Threads of a block pass this point together, so all of them decide alike.
                if cuda.syncthreads_or(np.int32(found)):
                    status = FOUND
                elif spent + width > budget:
                    status = OUT_OF_ITERATIONS
                elif not cuda.syncthreads_or(np.int32(active)):
                    status = OUT_OF_STARTS
                else:
                    if moves:
                        if since == 0:
                            reference = squared
                        damped_step(chain, s, None, damping + gain * squared, passes)
                        since += 1
                    spent += width
                cuda.syncthreads()
            winner = 0
            if status == FOUND:
                while done[winner] == 0:
                    winner += 1
            else:
                for other in range(width):
                    if errors[other] < errors[winner]:
                        winner = other
            if lane == winner:
                if status == FOUND or not chosen or least < least_of[row]:
                    for k in range(dof):
                        answers[row, k] = best[k]
                facts[0, row] = status
                facts[1, row] = spent
                facts[2, row] = tried + attempt + 1
            cuda.syncthreads()

    return Kernels(prepare, rank, by_lane, by_block)
