"""Levenberg-Marquardt descents as CUDA kernels, from the functions of the compiled CPU kernel.

What a descent computes (frames, error, Jacobian, damped step with limits as an active set, random
numbers) are the functions of `baselines.linearise`, `baselines.damped_step` and `baselines.clock`;
numba compiles them for the device as they stand. The kernels add which thread works at which pose.

By lane (`baselines.lm_cuda_lane`): a thread takes a pose, descends from its starts one after the
other as the CPU does, and fetches the next pose from a queue, so that no thread waits for a hard
pose of its neighbour. After a few starts it leaves a pose to the other kernel.

By block (`baselines.lm_cuda_block`): the threads of a block work at one pose, each from a start of
its own; after every step they look whether one has arrived, and the lowest that has gives the
answer.

In both, an answer depends on the pose, its seeds and the settings, on nothing beside it.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

from numba import cuda, types

from baselines.linearise import find_error, set_target
from baselines.lm_cuda_block import block_kernel
from baselines.lm_cuda_device import COUNTERS, LIBRARY_SIZE, device_functions
from baselines.lm_cuda_lane import lane_kernel

WARP = 32


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
    """Make the kernels for chains of `joints` driven joints and `dof` variables."""
    functions = device_functions(joints, dof)
    load_chain, new_work = functions.load_chain, functions.new_work
    nearest_of_stratum = functions.nearest_of_stratum

    @cuda.jit
    def prepare(reals, integers, poses, features, near, counters):  # type: ignore[no-untyped-def]
        """Nearest remembered configurations of every pose, the nearest first, a block a pose.

        Args:
            reals: Constants.
            integers: Integer constants.
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
        if integers[LIBRARY_SIZE] > 0:
            for row in range(cuda.blockIdx.x, poses.shape[0], cuda.gridDim.x):
                for i in range(7):
                    pose[i] = poses[row, i]
                set_target(pose, s.at)
                least, nearest = nearest_of_stratum(
                    reals, features, integers[LIBRARY_SIZE], pose, s.at.goal
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
    def rank(reals, integers, poses, seeds, position_weight, rotation_weight):  # type: ignore[no-untyped-def]
        """Sort the seeds (N, K, dof) of each pose (N, 7) in place, the smallest error first."""
        chain = load_chain(reals, integers)
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

    return Kernels(prepare, rank, lane_kernel(joints, dof), block_kernel(joints, dof))
