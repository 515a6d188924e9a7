"""The CUDA kernel in which each thread takes a pose and descends from its starts in turn."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import cuda, types

from baselines.damped_step import damped_step
from baselines.linearise import set_target
from baselines.lm_cuda_device import LEFT, LIBRARY_SIZE, NEXT, UNDECIDED, device_functions
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS


def lane_kernel(joints: int, dof: int) -> Any:
    """Make the kernel for chains of `joints` driven joints and `dof` variables."""
    functions = device_functions(joints, dof)
    load_chain, load_settings = functions.load_chain, functions.load_settings
    load_pose, begin, new_work = functions.load_pose, functions.begin, functions.new_work
    evaluate = functions.evaluate

    @cuda.jit
    def by_lane(  # type: ignore[no-untyped-def]
        reals, integers, poses, seeds, given, known, near,
        starts, answers, least_of, facts, left, counters,
    ):  # fmt: skip
        """Descend, a thread a pose, from the first starts of each.

        Args:
            reals: Constants.
            integers: Integer constants.
            poses: (N, 7) targets.
            seeds: (N or 1, K, dof) starts that come first.
            given: K.
            known: (M, dof) remembered configurations.
            near: (N, S) which of them come next.
            starts: Starts after which a pose is left to `by_block`.
            answers: (N, dof) receives the joints.
            least_of: (N,) receives the squared error of those that are left.
            facts: (3, N) receives status, iterations and starts, integers as float64.
            left: (N,) receives the rows that are left.
            counters: Row that is next, and how many are left.
        """
        chain = load_chain(reals, integers)
        pose = cuda.local.array(7, types.float64)
        best = cuda.local.array(dof, types.float64)
        s = new_work(pose)
        settings = load_settings(reals, integers)
        most = min(settings.starts, starts)
        final = settings.starts <= starts
        known_tried = near.shape[1] if integers[LIBRARY_SIZE] > 0 else 0
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
            squared, found, least = evaluate(chain, pose, settings, s, best, least)
            status = UNDECIDED
            again = False
            if found:
                status = FOUND
            elif iterations >= settings.iterations:
                status = OUT_OF_ITERATIONS
            elif since == settings.patience:
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
                damping = settings.damping + settings.gain * squared
                damped_step(chain, s, None, damping, settings.passes)
                iterations += 1
                since += 1

    return by_lane
