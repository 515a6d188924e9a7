"""Memory of the kernel of lanes: the batch, and what the lanes of a thread work in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.lanes import LANES, LINE_BYTES
from robots.compiled import njit

Array = NDArray[np.float64]

# Rows of `Work.state`. Of the descent in a lane: least squared error, iterations since it was
# looked at last and what it was then, iterations, how many there may be, and 1 while it goes on.
LEAST, SINCE, REFERENCE, ITERATIONS, LIMIT, ACTIVE = range(6)
# Where it belongs: the lane with the pose's record or -1, which of its starts this is, and how it
# ended while an earlier start still decides.
HOME, ATTEMPT, ENDED = 6, 7, 8
# Record of a pose: its row or -1, the next start, one past the last that matters, how many there
# are in all, how many are given up and their iterations, and the least squared error of these.
ROW, NEXT, CAP, MOST, GIVEN_UP, USED, POSE_LEAST, STATES = range(9, 17)


class Work(NamedTuple):
    """Arrays that the lanes of one thread work in.

    Attributes:
        q: (dof, LANES) configurations [rad or m].
        step: (dof, LANES) of the joints.
        free: (dof, LANES) 1 where a joint may move in this step, 0 where it is frozen at a limit.
        best: (dof, LANES) best configurations of the descents.
        start: (dof, LANES) where the descents started.
        pose_best: (dof, LANES) best configurations of the starts that were given up.
        target: (12, LANES) rotations of the targets row by row, then their positions [m].
        goal: (3, 3, LANES) the rotations in it.
        axes: (6 m, LANES) axes of the joints and points on them.
        jacobian: (6 dof, LANES).
        state: (STATES, LANES) numbers of a lane, by the names above.
        distances: (LANES, M) of the poses to remembered configurations.
    """

    q: Array
    step: Array
    free: Array
    best: Array
    start: Array
    pose_best: Array
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
    """What `baselines.linearise.set_target` writes.

    Attributes:
        goal: (3, 3) rotation.
    """

    goal: Array


class Batch(NamedTuple):
    """A batch of poses and what is found out about it, see `baselines.refine`.

    Attributes:
        poses: (N, 7).
        seeds: (N, K, dof).
        proven: (N,) whether it is proven that no configuration has the pose.
        joints: (N, dof) receives the best joints.
        status: (N,) receives how it ended.
        iterations: (N,) receives the iterations.
        starts: (N,) receives the starts.
        next: (1,) the next row that nobody has taken.
    """

    poses: Array
    seeds: Array
    proven: NDArray[np.bool_]
    joints: Array
    status: NDArray[np.int64]
    iterations: NDArray[np.int64]
    starts: NDArray[np.int64]
    next: NDArray[np.int64]


@njit()
def new_room(threads, joints, dof, remembered):  # type: ignore[no-untyped-def]
    """Room for the lanes of so many threads.

    Args:
        threads: Threads.
        joints: Driven joints of the chain.
        dof: Its variables.
        remembered: Configurations in the seed library.
    """
    rows = 12 * dof + 6 * joints + 12 + STATES
    flat = np.empty((threads * rows + 1) * LANES)
    begin = -flat.ctypes.data % LINE_BYTES // flat.itemsize  # each row in one line of the cache
    lanes = flat[begin : begin + threads * rows * LANES].reshape(threads, rows, LANES)
    return Room(lanes, np.empty((threads, LANES, remembered), dtype=np.float32))


@njit(_nrt=False)
def work_of(room, thread, joints, dof):  # type: ignore[no-untyped-def]
    """Return the arrays of one thread, its lanes without a pose.

    Args:
        room: `Room`.
        thread: Which thread.
        joints: Driven joints of the chain.
        dof: Its variables.
    """
    lanes, target = room.lanes[thread], 6 * dof
    axes = target + 12
    jacobian = axes + 6 * joints
    state = jacobian + 6 * dof
    # Lanes without a pose are computed as well: they need numbers.
    for row in range(axes):
        for lane in range(LANES):
            lanes[row, lane] = 0.0
    for row in range(state, state + STATES):
        for lane in range(LANES):
            lanes[row, lane] = -1.0
    return Work(
        lanes[:dof],
        lanes[dof : 2 * dof],
        lanes[2 * dof : 3 * dof],
        lanes[3 * dof : 4 * dof],
        lanes[4 * dof : 5 * dof],
        lanes[5 * dof : target],
        lanes[target:axes],
        lanes[target : target + 9].reshape((3, 3, LANES)),
        lanes[axes:jacobian],
        lanes[jacobian:state],
        lanes[state:],
        room.distances[thread],
    )
