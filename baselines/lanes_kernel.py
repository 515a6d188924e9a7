"""Levenberg-Marquardt on LANES poses side by side: the algorithm of `baselines.lm_kernel`.

Every lane descends for a pose of its own. A lane whose pose is decided takes the next one from a
queue, which the lanes of all threads share. What happens in a lane depends on its pose, its seeds
and the settings alone, bitwise: not on the other lanes, the batch or the threads.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit, prange, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from baselines.clock import pose_key
from baselines.lanes import LANES, load, mask_bits, new_lanes, select, store
from baselines.lanes_kinematics import find_lanes_error, find_lanes_frames, find_lanes_jacobian
from baselines.lanes_step import lanes_damped_step
from baselines.linearise import set_target
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS, _Scratch, _scratch, _start

Array = NDArray[np.float64]

# Rows of `Work.state`, a float64 each a lane.
LEAST, SINCE, REFERENCE, ITERATIONS, ACTIVE, STATES = range(6)


class Work(NamedTuple):
    """Arrays that the lanes of one thread work in.

    Attributes:
        q: (dof, LANES) configurations [rad or m].
        step: (dof, LANES) of the joints.
        free: (dof, LANES) 1 where a joint may move in this step, 0 where it is frozen at a limit.
        best: (dof, LANES) best configurations met.
        target: (12, LANES) rotations of the targets row by row, then their positions [m].
        axes: (6 m, LANES) axes of the joints and points on them.
        jacobian: (6 dof, LANES).
        state: (STATES, LANES) least squared error, iterations since it was looked at last, what it
            was then, iterations in all, and 1 where there is a pose, else 0.
        row: (LANES,) rows of the batch.
        attempt: (LANES,) starts given up so far.
        distances: (LANES, M) to remembered configurations.
    """

    q: Array
    step: Array
    free: Array
    best: Array
    target: Array
    axes: Array
    jacobian: Array
    state: Array
    row: NDArray[np.int64]
    attempt: NDArray[np.int64]
    distances: NDArray[np.float32]


class Batch(NamedTuple):
    """A batch of poses and what is found out about it, see `baselines.refine`.

    Attributes:
        poses: (N, 7).
        seeds: (N, K, dof).
        joints: (N, dof) receives the best joints.
        status: (N,) receives how it ended.
        iterations: (N,) receives the iterations.
        starts: (N,) receives the starts.
        next: (1,) the next row that nobody has taken.
    """

    poses: Array
    seeds: Array
    joints: Array
    status: NDArray[np.int64]
    iterations: NDArray[np.int64]
    starts: NDArray[np.int64]
    next: NDArray[np.int64]


@njit(cache=True)
def _work(joints, dof, library):  # type: ignore[no-untyped-def]
    return Work(
        new_lanes(dof),
        new_lanes(dof),
        new_lanes(dof),
        new_lanes(dof),
        new_lanes(12),
        new_lanes(6 * joints),
        new_lanes(6 * dof),
        new_lanes(STATES),
        np.zeros(LANES, dtype=np.int64),
        np.zeros(LANES, dtype=np.int64),
        np.empty((LANES, library.joints.shape[0]), dtype=np.float32),
    )


@intrinsic
def _take(typing, counter):  # type: ignore[no-untyped-def]
    """Return the first number of an array of int64 and add one, undisturbed by other threads."""
    if not isinstance(counter, types.Array) or counter.dtype != types.int64:
        return None

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        data = context.make_array(kind.args[0])(context, builder, values[0]).data
        one = context.get_constant(types.int64, 1)
        return builder.atomic_rmw("add", data, one, "monotonic")

    return types.int64(counter), emit


@njit(cache=True, fastmath={"contract"}, _nrt=False, forceinline=True)
def _advance(chain, w, options):  # type: ignore[no-untyped-def]
    """Judge all lanes and move those that go on by a step.

    Returns:
        Bits of the lanes that are found, that are out of iterations, and that have stalled.
    """
    state = w.state
    frame = find_lanes_frames(chain, w.q, w.axes)
    error, distance2, angle2 = find_lanes_error(w.target, frame)
    squared = distance2 + angle2
    active = load(state, ACTIVE) > 0.0
    found = distance2 <= options.position_tolerance_m**2
    found = active & found & (angle2 <= options.rotation_tolerance_rad**2)
    least = load(state, LEAST)
    better = (squared < least) | found
    store(state, LEAST, select(better, squared, least))
    for k in range(w.q.shape[0]):
        store(w.best, k, select(better, load(w.q, k), load(w.best, k)))
    iterations, since = load(state, ITERATIONS), load(state, SINCE)
    spent = active & ~found & (iterations >= float(options.iterations))
    reference = load(state, REFERENCE)
    due = since == float(options.patience)
    going = active & ~found & ~spent
    stalled = going & due & (squared > 0.5 * reference)
    since = select(due, 0.0, since)
    store(state, REFERENCE, select(since == 0.0, squared, reference))
    moving = going & ~stalled
    store(state, ITERATIONS, select(moving, iterations + 1.0, iterations))
    store(state, SINCE, since + 1.0)
    if mask_bits(moving) != 0:
        find_lanes_jacobian(chain, w.axes, frame, w.jacobian)
        damping = options.damping + options.damping_gain * squared
        lanes_damped_step(chain, w, error, damping, moving, options.max_active_set_passes)
    return mask_bits(found), mask_bits(spent), mask_bits(stalled)


@njit(cache=True, _nrt=False, forceinline=True)
def _begin(chain, batch, library, w, s, lane):  # type: ignore[no-untyped-def]
    """Put the lane's next start into it."""
    row, attempt = w.row[lane], w.attempt[lane]
    pose, seeds = batch.poses[row], batch.seeds[row]
    known = seeds.shape[0] + library.neighbours
    key = np.uint64(0)
    if attempt >= known:
        key = pose_key(pose)
    elif attempt == seeds.shape[0]:
        set_target(pose, s.at)
    own = _Scratch(s.at, s.solved, s.step, s.free, s.q, s.timespec, w.distances[lane])
    _start(chain, pose, seeds, library, key, attempt, own)
    for k in range(s.q.shape[0]):
        w.q[k, lane] = s.q[k]
    w.state[SINCE, lane] = 0.0
    w.state[REFERENCE, lane] = np.inf


@njit(cache=True, _nrt=False, forceinline=True)
def _fill(batch, w, s, lane):  # type: ignore[no-untyped-def]
    """Take the next pose of the queue into a lane; return whether there was one."""
    row = _take(batch.next)
    if row >= batch.poses.shape[0]:
        w.state[ACTIVE, lane] = 0.0
        return False
    w.row[lane], w.attempt[lane] = row, 0
    pose = batch.poses[row]
    set_target(pose, s.at)
    for i in range(3):
        for j in range(3):
            w.target[3 * i + j, lane] = s.at.goal[i, j]
        w.target[9 + i, lane] = pose[i]
    w.state[ACTIVE, lane], w.state[LEAST, lane] = 1.0, np.inf
    w.state[ITERATIONS, lane] = 0.0
    return True


@njit(cache=True, _nrt=False, forceinline=True)
def _finish(batch, w, lane, status):  # type: ignore[no-untyped-def]
    """Write down what a lane has found."""
    row = w.row[lane]
    batch.status[row], batch.starts[row] = status, w.attempt[lane] + 1
    batch.iterations[row] = np.int64(w.state[ITERATIONS, lane])
    for k in range(w.best.shape[0]):
        batch.joints[row, k] = w.best[k, lane]


@njit(cache=True, _nrt=False)
def _descend(chain, batch, library, options, w, s):  # type: ignore[no-untyped-def]
    """Solve poses until the queue is empty."""
    found, spent, stalled, active = 0, 0, 0, 0
    idle = (1 << LANES) - 1
    while True:
        waiting = found | spent | stalled | idle
        for lane in range(LANES if waiting else 0):
            bit = 1 << lane
            if not waiting & bit:
                continue
            if stalled & bit and w.attempt[lane] + 1 < options.starts:
                w.attempt[lane] += 1
            else:
                if not idle & bit:
                    active -= 1
                    status = FOUND if found & bit else OUT_OF_STARTS
                    _finish(batch, w, lane, OUT_OF_ITERATIONS if spent & bit else status)
                if not _fill(batch, w, s, lane):
                    continue
                active += 1
            _begin(chain, batch, library, w, s, lane)
        if active == 0:
            break
        idle = 0
        found, spent, stalled = _advance(chain, w, options)


@njit(cache=True)
def refine_lanes(chain, batch, library, options):  # type: ignore[no-untyped-def]
    """Solve poses of a batch on one thread until its queue is empty."""
    joints, dof = chain.prismatic.shape[0], batch.joints.shape[1]
    w, s = _work(joints, dof, library), _scratch(joints, dof, library)
    _descend(chain, batch, library, options, w, s)


@njit(cache=True, parallel=True)
def refine_lanes_parallel(chain, batch, library, options, threads):  # type: ignore[no-untyped-def]
    """Compute `refine_lanes` on so many threads of numba; the same joints, bitwise."""
    for _ in prange(threads):
        refine_lanes(chain, batch, library, options)
