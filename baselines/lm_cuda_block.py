"""The CUDA kernel in which the threads of a block share a pose, each with starts of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import cuda, types

from baselines.damped_step import damped_step
from baselines.linearise import set_target
from baselines.lm_cuda_device import LEFT, LIBRARY_SIZE, UNDECIDED, device_functions
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS

MAX_LANES = 256  # threads of a block that work at one pose


def block_kernel(joints: int, dof: int) -> Any:
    """Make the kernel for chains of `joints` driven joints and `dof` variables."""
    functions = device_functions(joints, dof)
    load_chain, load_settings = functions.load_chain, functions.load_settings
    load_pose, begin, new_work = functions.load_pose, functions.begin, functions.new_work
    evaluate = functions.evaluate
    nearest_of_stratum = functions.nearest_of_stratum

    @cuda.jit
    def by_block(  # type: ignore[no-untyped-def]
        reals, integers, poses, seeds, given, known, features,
        chosen, answers, least_of, facts, left, counters,
    ):  # fmt: skip
        """Descend, a block a pose, its threads from starts of their own.

        Arguments are those of `by_lane` but for `features`, (12, M) of the poses of `known`, and
        `chosen`: whether only the rows in `left` are solved, as many as `counters` says, whose
        seeds have been tried and for which `least_of` holds what `by_lane` has met. The iterations
        in `facts` are those of all threads.
        """
        lane, width = cuda.threadIdx.x, cuda.blockDim.x
        chain = load_chain(reals, integers)
        near = cuda.shared.array(MAX_LANES, types.int32)
        done = cuda.shared.array(MAX_LANES, types.int32)
        errors = cuda.shared.array(MAX_LANES, types.float64)
        pose = cuda.local.array(7, types.float64)
        best = cuda.local.array(dof, types.float64)
        s = new_work(pose)
        settings = load_settings(reals, integers)
        most = settings.starts
        strata = width if integers[LIBRARY_SIZE] > 0 else 0
        rows = counters[LEFT] if chosen else poses.shape[0]
        for place in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
            row = left[place] if chosen else place
            spent = int(facts[1, row]) if chosen else 0
            tried = int(facts[2, row]) if chosen else 0
            key = load_pose(poses, row, pose)
            set_target(pose, s.at)
            if integers[LIBRARY_SIZE] > 0:
                closest, index = nearest_of_stratum(
                    reals, features, integers[LIBRARY_SIZE], pose, s.at.goal
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
                    squared, found, least = evaluate(chain, pose, settings, s, best, least)
                    if since == settings.patience and not found:
                        since = 0
                        if squared > 0.5 * reference:
                            # The new start is evaluated in the next round, with all others.
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
                elif spent + width > settings.iterations:
                    status = OUT_OF_ITERATIONS
                elif not cuda.syncthreads_or(np.int32(active)):
                    status = OUT_OF_STARTS
                else:
                    if moves:
                        if since == 0:
                            reference = squared
                        damping = settings.damping + settings.gain * squared
                        damped_step(chain, s, None, damping, settings.passes)
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

    return by_block
