"""What a thread of the CUDA kernels needs before it descends: constants, starts, room to work in.

Sizes of arrays in registers and in shared memory must be known to the compiler, so the functions
are made for each number of joints.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import cuda, types
from numpy.typing import NDArray

from baselines.clock import pose_key, uniform
from baselines.linearise import Linearisation, find_error
from baselines.lm_kernel import LmOptions, _Scratch
from baselines.seed_library import FEATURES, ROTATION_SHARE, SeedLibrary
from robots.chain import Chain

Array = NDArray[np.float64]

# Numbers ahead of those of the chain in the array of constants, and the counters of a launch.
POSITION2, ROTATION2, DAMPING, GAIN, CENTRE, SCALE, HEAD = 0, 1, 2, 3, 4, 7, 10
PATIENCE, PASSES, ITERATIONS, STARTS, LIBRARY_SIZE, INTEGER_HEAD = 0, 1, 2, 3, 4, 5
NEXT, LEFT, COUNTERS = 0, 1, 2
UNDECIDED = -1  # status of a descent that goes on


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


class DescentSettings(NamedTuple):
    """Settings of a descent, see `LmOptions`.

    Attributes:
        position2: Square of the position tolerance [m²].
        rotation2: Square of the rotation tolerance [rad²].
        damping: Constant part of λ [m² and rad²].
        gain: λ per squared error.
        patience: Iterations within which the squared error has to halve.
        passes: How often a step is solved again with joints frozen.
        iterations: Iterations a pose, summed over starts.
        starts: Starts a pose.
    """

    position2: float
    rotation2: float
    damping: float
    gain: float
    patience: int
    passes: int
    iterations: int
    starts: int


class DeviceFunctions(NamedTuple):
    """Functions of a thread, for chains with one number of joints.

    Attributes:
        load_chain: Copies the chain into the shared memory of a block.
        load_settings: Reads the `DescentSettings`.
        load_pose: Copies a pose and returns the key of its random numbers.
        begin: Writes a start.
        evaluate: Finds the error of a configuration and keeps the best one.
        nearest_of_stratum: Searches a thread's share of the seed library.
        new_work: Makes the arrays of one thread.
    """

    load_chain: Any
    load_settings: Any
    load_pose: Any
    begin: Any
    evaluate: Any
    nearest_of_stratum: Any
    new_work: Any


@lru_cache
def device_functions(joints: int, dof: int) -> DeviceFunctions:
    """Make the functions for chains of `joints` driven joints and `dof` variables."""
    frames = joints + 1

    @cuda.jit(device=True)
    def load_chain(reals, integers):  # type: ignore[no-untyped-def]
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
                prismatic[k] = integers[INTEGER_HEAD + k] != 0
                variable[k] = integers[INTEGER_HEAD + joints + k]
                multiplier[k] = reals[at_multiplier + k]
                offset[k] = reals[at_multiplier + joints + k]
            if k < dof:
                lower[k] = reals[at_lower + k]
                upper[k] = reals[at_lower + dof + k]
        cuda.syncthreads()
        return Chain(rotations, translations, prismatic, variable, multiplier, offset, lower, upper)

    @cuda.jit(device=True)
    def load_settings(reals, integers):  # type: ignore[no-untyped-def]
        """Read the settings of the descents."""
        return DescentSettings(
            reals[POSITION2], reals[ROTATION2], reals[DAMPING], reals[GAIN],
            integers[PATIENCE], integers[PASSES], integers[ITERATIONS], integers[STARTS],
        )  # fmt: skip

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
    def evaluate(chain, pose, settings, s, best, least):  # type: ignore[no-untyped-def]
        """Find the error of s.q and keep s.q in `best` (dof,) where it is the smallest so far.

        Returns:
            Squared error, whether it is within the tolerances, and the least squared error.
        """
        distance2, angle2 = find_error(chain, s.q, pose, s.at)
        squared = distance2 + angle2
        found = distance2 <= settings.position2 and angle2 <= settings.rotation2
        if squared < least or found:
            least = squared
            for k in range(dof):
                best[k] = s.q[k]
        return squared, found, least

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

    return DeviceFunctions(
        load_chain, load_settings, load_pose, begin, evaluate, nearest_of_stratum, new_work
    )
