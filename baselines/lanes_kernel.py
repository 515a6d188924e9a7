"""Levenberg-Marquardt on LANES poses side by side: the algorithm of `baselines.lm_kernel`.

Every lane descends for a pose of its own. A lane whose pose is decided takes the next one from a
queue, which the lanes of all threads share. What happens in a lane depends on its pose, its seeds
and the settings alone, bitwise: not on the other lanes, the batch or the threads.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from baselines.lanes import LANES, LINE_BYTES, load, mask_bits, select, store
from baselines.lanes_kinematics import find_lanes_error, find_lanes_frames, find_lanes_jacobian
from baselines.lanes_step import lanes_damped_step
from baselines.linearise import set_target
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS, choose_start

Array = NDArray[np.float64]

# Rows of `Work.state`, a float64 each a lane.
LEAST, SINCE, REFERENCE, ITERATIONS, ACTIVE, ROW, ATTEMPT, STATES = range(8)


class Work(NamedTuple):
    """Arrays that the lanes of one thread work in.

    Attributes:
        q: (dof, LANES) configurations [rad or m].
        step: (dof, LANES) of the joints.
        free: (dof, LANES) 1 where a joint may move in this step, 0 where it is frozen at a limit.
        best: (dof, LANES) best configurations met.
        target: (12, LANES) rotations of the targets row by row, then their positions [m].
        goal: (3, 3, LANES) the rotations in it.
        axes: (6 m, LANES) axes of the joints and points on them.
        jacobian: (6 dof, LANES).
        state: (STATES, LANES) least squared error, iterations since it was looked at last, what it
            was then, iterations in all, 1 where there is a pose, else 0, its row in the batch, and
            how many of its starts were given up.
        distances: (LANES, M) to remembered configurations.
    """

    q: Array
    step: Array
    free: Array
    best: Array
    target: Array
    goal: Array
    axes: Array
    jacobian: Array
    state: Array
    distances: NDArray[np.float32]


class Room(NamedTuple):
    """Memory for the lanes of all threads.

    Attributes:
        lanes: (threads, rows, LANES) all arrays of float64 of `Work`, one after another.
        distances: (threads, LANES, M).
    """

    lanes: Array
    distances: NDArray[np.float32]


class Target(NamedTuple):
    """What `set_target` writes.

    Attributes:
        goal: (3, 3) rotation.
    """

    goal: Array


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


def new_room(threads: int, joints: int, dof: int, remembered: int) -> Room:
    """Room for the lanes of so many threads.

    Args:
        threads: Threads.
        joints: Driven joints of the chain.
        dof: Its variables.
        remembered: Configurations in the seed library.
    """
    rows = 10 * dof + 6 * joints + 12 + STATES
    flat = np.empty((threads * rows + 1) * LANES)
    begin = -flat.ctypes.data % LINE_BYTES // flat.itemsize  # each row in one line of the cache
    lanes = flat[begin : begin + threads * rows * LANES].reshape(threads, rows, LANES)
    return Room(lanes, np.empty((threads, LANES, remembered), dtype=np.float32))


@njit(cache=True, _nrt=False)
def _work(room, thread, joints, dof):  # type: ignore[no-untyped-def]
    """Return the arrays of one thread."""
    lanes, target = room.lanes[thread], 4 * dof
    axes = target + 12
    jacobian = axes + 6 * joints
    state = jacobian + 6 * dof
    return Work(
        lanes[:dof],
        lanes[dof : 2 * dof],
        lanes[2 * dof : 3 * dof],
        lanes[3 * dof : target],
        lanes[target:axes],
        lanes[target : target + 9].reshape((3, 3, LANES)),
        lanes[axes:jacobian],
        lanes[jacobian:state],
        lanes[state:],
        room.distances[thread],
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
def _begin(chain, batch, library, w, lane):  # type: ignore[no-untyped-def]
    """Put the lane's next start into it."""
    row, attempt = int(w.state[ROW, lane]), int(w.state[ATTEMPT, lane])
    choose_start(
        chain,
        batch.poses[row],
        batch.seeds[row],
        library,
        attempt,
        w.goal[:, :, lane],
        w.distances[lane],
        w.q[:, lane],
    )
    w.state[SINCE, lane] = 0.0
    w.state[REFERENCE, lane] = np.inf


@njit(cache=True, _nrt=False, forceinline=True)
def _fill(batch, w, lane):  # type: ignore[no-untyped-def]
    """Take the next pose of the queue into a lane; return whether there was one."""
    row = _take(batch.next)
    if row >= batch.poses.shape[0]:
        w.state[ACTIVE, lane] = 0.0
        return False
    pose = batch.poses[row]
    set_target(pose, Target(w.goal[:, :, lane]))
    for i in range(3):
        w.target[9 + i, lane] = pose[i]
    w.state[LEAST, lane], w.state[ITERATIONS, lane], w.state[ACTIVE, lane] = np.inf, 0.0, 1.0
    w.state[ROW, lane], w.state[ATTEMPT, lane] = row, 0.0
    return True


@njit(cache=True, _nrt=False, forceinline=True)
def _finish(batch, w, lane, status):  # type: ignore[no-untyped-def]
    """Write down what a lane has found."""
    row = int(w.state[ROW, lane])
    batch.status[row] = status
    batch.starts[row] = int(w.state[ATTEMPT, lane]) + 1
    batch.iterations[row] = int(w.state[ITERATIONS, lane])
    for k in range(w.best.shape[0]):
        batch.joints[row, k] = w.best[k, lane]


@njit(cache=True, nogil=True, _nrt=False)
def refine_lanes(chain, batch, library, options, room, thread):  # type: ignore[no-untyped-def]
    """Solve poses of a batch on one thread until its queue is empty.

    Args:
        chain: The `Chain`.
        batch: The `Batch`.
        library: `SeedLibrary`.
        options: `LmOptions`, without a limit of time and with one start at least.
        room: `Room` of all threads.
        thread: Which of them this is.
    """
    w = _work(room, thread, chain.prismatic.shape[0], batch.joints.shape[1])
    for i in range(w.q.shape[0]):  # lanes without a pose are computed as well
        for lane in range(LANES):
            w.q[i, lane] = 0.0
    for i in range(w.target.shape[0]):
        for lane in range(LANES):
            w.target[i, lane] = 0.0
    found, spent, stalled, active = 0, 0, 0, 0
    idle = (1 << LANES) - 1
    while True:
        waiting = found | spent | stalled | idle
        for lane in range(LANES if waiting else 0):
            bit = 1 << lane
            if not waiting & bit:
                continue
            if stalled & bit and w.state[ATTEMPT, lane] + 1.0 < options.starts:
                w.state[ATTEMPT, lane] += 1.0
            else:
                if not idle & bit:
                    active -= 1
                    status = FOUND if found & bit else OUT_OF_STARTS
                    _finish(batch, w, lane, OUT_OF_ITERATIONS if spent & bit else status)
                if not _fill(batch, w, lane):
                    continue
                active += 1
            _begin(chain, batch, library, w, lane)
        if active == 0:
            break
        idle = 0
        found, spent, stalled = _advance(chain, w, options)
