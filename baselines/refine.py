"""The Levenberg-Marquardt kernel as a function: poses and seeds in, joints out."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numba
import numpy as np
from numpy.typing import NDArray

from baselines import lm_kernel
from baselines.joint_range import joint_range, turn_rows_inside
from baselines.lanes import LINE_BYTES
from baselines.lanes_kernel import refine_lanes
from baselines.lanes_work import Batch, new_room
from baselines.lm_kernel import LmOptions
from baselines.protocol import OUT_OF_ITERATIONS, OUT_OF_TIME, Solution
from baselines.seed_library import SeedLibrary, empty_seed_library
from robots.arguments import compiled_floats
from robots.chain import Chain
from robots.pose_bound import PoseBound, pose_bound, proven_rows
from robots.threads import forked, on_threads, shares

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

Arguments = tuple[Chain, Array, Array, SeedLibrary, LmOptions]
# Writes the seeds of some rows of a batch, on the thread that descends from them.
Seeding = Callable[[slice], None]

# Poses that are worth another thread: starting it takes as long as some hundred of them.
POSES_PER_THREAD = 256
REASONS = {
    lm_kernel.FOUND: "",
    lm_kernel.OUT_OF_ITERATIONS: OUT_OF_ITERATIONS,
    lm_kernel.OUT_OF_TIME: OUT_OF_TIME,
    lm_kernel.OUT_OF_STARTS: "out of starts",
    lm_kernel.IN_COLLISION: "in collision",
    lm_kernel.OUT_OF_REACH: "proven out of reach",
}
_REASON_OF = np.array([REASONS[code] for code in range(len(REASONS))], dtype=object)


@dataclass(frozen=True)
class Refined:
    """What the kernel did to N poses.

    Attributes:
        joints: (N, dof) best joints met, inside the limits [rad or m].
        status: (N,) a key of `REASONS`; 0 where the tolerances are met.
        iterations: (N,) Levenberg-Marquardt steps, summed over starts.
        starts: (N,) seeds and random configurations descended from; 1 is the first seed alone.
        time_s: (N,) time of the pose alone, on its thread [s]; where poses are solved side by side,
            the time of the batch shared out by the configurations that were looked at.
    """

    joints: Array
    status: NDArray[np.int64]
    iterations: NDArray[np.int64]
    starts: NDArray[np.int64]
    time_s: Array

    @property
    def found(self) -> NDArray[np.bool_]:
        """(N,) where the tolerances are met."""
        return self.status == lm_kernel.FOUND

    @classmethod
    def empty(cls, count: int, dof: int) -> Refined:
        """Room for `count` answers of `dof` joints."""
        status, iterations, starts = np.zeros((3, count), dtype=np.int64)
        return cls(np.zeros((count, dof)), status, iterations, starts, np.zeros(count))

    def rows(self, chosen: NDArray[np.bool_]) -> Refined:
        """What was done to some of the poses, where `chosen` (N,) holds."""
        return Refined(
            *(self.joints[chosen], self.status[chosen], self.iterations[chosen]),
            *(self.starts[chosen], self.time_s[chosen]),
        )

    def solution(self) -> Solution:
        """The same as a `Solution`."""
        found = self.found
        reasons = ("",) * len(found) if found.all() else tuple(_REASON_OF[self.status].tolist())
        return Solution(self.joints, found, self.time_s, self.iterations, reasons)


def merged(chosen: NDArray[np.bool_], these: Refined, others: Refined) -> Refined:
    """Put rows back where they were: `these` where `chosen` (N,) holds, `others` elsewhere."""
    columns = {}
    for name in ("joints", "status", "iterations", "starts", "time_s"):
        here, there = getattr(these, name), getattr(others, name)
        columns[name] = np.empty((len(chosen), *here.shape[1:]), dtype=here.dtype)
        columns[name][chosen], columns[name][~chosen] = here, there
    return Refined(**columns)


def thread_count(count: int) -> int:
    """Return ``count``, at most the number of threads that numba has, which 0 means."""
    most: int = numba.config.NUMBA_NUM_THREADS
    return min(count, most) if count else most


@contextmanager
def numba_threads(count: int) -> Iterator[None]:
    """Let numba use ``count`` threads, at most all it has, which 0 means; then it is as before."""
    before = numba.get_num_threads()
    numba.set_num_threads(thread_count(count))
    try:
        yield
    finally:
        numba.set_num_threads(before)


def refine(
    robot: Robot,
    poses: Array,
    seeds: Array,
    options: LmOptions,
    threads: int = 1,
    library: SeedLibrary | None = None,
    side_by_side: bool = True,
    seeding: Seeding | None = None,
) -> Refined:
    """Descend from each pose's seeds in order, then from random configurations, until solved.

    The result of a row depends on its pose and seeds alone as long as no time limit is set. Where a
    bound proves that there is no solution, `options.nearest_starts` of these descents are enough.

    Args:
        robot: The robot.
        poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz.
        seeds: (N, K, dof) configurations to start from, moved into the limits; K may be 0.
        options: Tolerances, damping and budget.
        threads: Threads to use, at most as many as numba has; 0 for so many.
        library: Configurations to start from after the seeds, the nearest first.
        side_by_side: Whether to solve several poses at once in vector registers. A limit of time
            needs them one by one.
        seeding: Writes rows of `seeds`, which is then an array that a kernel takes as it is; None
            if they are written. It may run on several threads, each for rows of its own.
    """
    arguments = (
        robot.chain,
        compiled_floats(poses),
        compiled_floats(seeds),
        empty_seed_library(robot.dof) if library is None else library,
        options,
    )
    if side_by_side and options.time_ns == 0 and options.starts > 0:
        result = _side_by_side(arguments, pose_bound(robot), threads, seeding)
    else:
        result = _one_by_one(arguments, pose_bound(robot), threads, seeding)
    if robot.endless.any():
        turn_rows_inside(joint_range(robot), result.joints)
    return result


def refine_freely(
    chain: Chain,
    poses: Array,
    seeds: Array,
    widths: Array,
    options: LmOptions,
    library: SeedLibrary | None = None,
) -> Refined:
    """Descend as `refine` does under freedoms, pose by pose; endless joints are left as they turn.

    Args:
        chain: Of a robot, or one with other limits.
        poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz.
        seeds: (N, K, dof) configurations to start from.
        widths: (N, 6) of each target, see `baselines.freedom.Freedom` [m and rad].
        options: Tolerances, damping and budget.
        library: Configurations to start from after the seeds, the nearest first.
    """
    dof = seeds.shape[2]
    result, time_ns = Refined.empty(len(poses), dof), np.zeros(len(poses), dtype=np.int64)
    lm_kernel.refine_rows_freely(
        chain,
        compiled_floats(poses),
        compiled_floats(seeds),
        empty_seed_library(dof) if library is None else library,
        options,
        compiled_floats(widths),
        *(result.joints, result.status, result.iterations, result.starts, time_ns),
    )
    np.multiply(time_ns, 1e-9, out=result.time_s)
    return result


def _one_by_one(
    arguments: Arguments, bound: PoseBound, threads: int, seeding: Seeding | None
) -> Refined:
    """Refine by the scalar kernel, which keeps the time of every pose."""
    _, poses, _, _, options = arguments
    if seeding is not None:
        parts = shares(len(poses), thread_count(threads), POSES_PER_THREAD)
        on_threads(len(parts), lambda index: seeding(parts[index]))
    proven = np.zeros(len(poses), dtype=bool)
    _prove(bound, poses, options, proven)
    if not proven.any():
        return _descended(arguments, threads)
    few = options._replace(starts=min(options.starts, options.nearest_starts))
    denied = _descended(_rows(arguments, proven, few), threads)
    denied.status[~denied.found] = lm_kernel.OUT_OF_REACH
    others = _descended(_rows(arguments, ~proven, options), threads)
    return merged(proven, denied, others)


def _prove(bound: PoseBound, poses: Array, options: LmOptions, proven: NDArray[np.bool_]) -> None:
    """Write into proven (N,), which is False, of which poses (N, 7) none can be had."""
    if options.nearest_starts > 0:
        tolerances = options.position_tolerance_m, options.rotation_tolerance_rad
        proven_rows(bound, poses, *tolerances, proven)


def _rows(arguments: Arguments, chosen: NDArray[np.bool_], options: LmOptions) -> Arguments:
    """Some poses of a batch and their seeds, under options of their own."""
    chain, poses, seeds, library, _ = arguments
    return chain, poses[chosen], seeds[chosen], library, options


def _descended(arguments: Arguments, threads: int) -> Refined:
    poses, seeds = arguments[1:3]
    result = Refined.empty(len(poses), seeds.shape[2])
    time_ns = np.zeros(len(poses), dtype=np.int64)
    room = (result.joints, result.status, result.iterations, result.starts, time_ns)
    if threads == 1 or forked():
        lm_kernel.refine_rows(*arguments, *room)
    else:
        with numba_threads(threads):
            lm_kernel.refine_rows_parallel(*arguments, *room)
    np.multiply(time_ns, 1e-9, out=result.time_s)
    return result


def _side_by_side(
    arguments: Arguments, bound: PoseBound, threads: int, seeding: Seeding | None
) -> Refined:
    """Refine by the kernel of lanes.

    Each thread prepares a share of the poses and descends for them; then it takes what is left of
    the other shares that are ready.
    """
    started = time.perf_counter()
    chain, poses, seeds, library, options = arguments
    result = Refined.empty(len(poses), seeds.shape[2])
    proven = np.zeros(len(poses), dtype=bool)
    parts = shares(len(poses), thread_count(threads), POSES_PER_THREAD)
    # Each counter in a line of the cache of its own: threads that share one wait for each other.
    queues = np.zeros((len(parts), 2 * LINE_BYTES // 8), dtype=np.int64)
    batches = [
        Batch(
            *(poses[rows], seeds[rows], proven[rows], result.joints[rows], result.status[rows]),
            *(result.iterations[rows], result.starts[rows], queues[index, :1]),
        )
        for index, rows in enumerate(parts)
    ]
    ready = [False] * len(parts)
    lanes = new_room(len(parts), len(chain.prismatic), seeds.shape[2], len(library.joints))

    def descend(index: int) -> None:
        if seeding is not None:
            seeding(parts[index])
        _prove(bound, batches[index].poses, options, batches[index].proven)
        ready[index] = True
        for part in (*range(index, len(parts)), *range(index)):
            if ready[part]:
                refine_lanes(chain, batches[part], library, options, lanes, index)

    on_threads(len(parts), descend)
    looked_at = result.iterations + result.starts
    seconds = len(parts) * (time.perf_counter() - started)
    np.multiply(looked_at, seconds / max(int(looked_at.sum()), 1), out=result.time_s)
    return result
