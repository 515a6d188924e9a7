"""Which lane descends from which start of which pose, and what follows when a descent ends.

A pose is descended for from its starts in order, each given up when it stalls, as in
`baselines.lm_kernel`. While there are poses nobody has taken, a lane stays with its pose from start
to start. At the end of the queue, lanes that would stand idle descend from later starts of poses
whose first start was given up. They change nothing but the time: a start decides only after all
before it were given up, and what it may cost is what those before it have left.

A pose's record stands in the columns of one lane, its home, wherever its starts are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from baselines.lanes import LANES
from baselines.lanes_work import (
    ACTIVE,
    ATTEMPT,
    CAP,
    ENDED,
    GIVEN_UP,
    HOME,
    ITERATIONS,
    LEAST,
    LIMIT,
    MOST,
    NEXT,
    POSE_LEAST,
    REFERENCE,
    ROW,
    SINCE,
    USED,
    Target,
)
from baselines.linearise import set_target
from baselines.lm_kernel import (
    FOUND,
    OUT_OF_ITERATIONS,
    OUT_OF_REACH,
    OUT_OF_STARTS,
    choose_start,
)
from robots.compiled import njit

GOES_ON, STALLED = -1, OUT_OF_STARTS  # how a descent ended, beside FOUND and OUT_OF_ITERATIONS


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


@njit(_nrt=False, inline="always")
def begin(chain, batch, library, options, w, lane):  # type: ignore[no-untyped-def]
    """Give an idle lane the next start that is worth its time; return whether there was one.

    Args:
        chain: The `Chain`.
        batch: The `Batch`.
        library: `SeedLibrary`.
        options: `LmOptions`.
        w: `Work`.
        lane: Which lane.
    """
    state = w.state
    home = lane
    if state[ROW, lane] < 0.0:
        home = _open(batch, options, state, lane)
    elif state[NEXT, lane] >= state[CAP, lane]:
        home = -1
    if home < 0:
        home = _to_help(state)
    if home < 0:
        return False
    row, attempt = int(state[ROW, home]), int(state[NEXT, home])
    pose = batch.poses[row]
    if attempt == 0 or home != lane or state[HOME, lane] != lane:
        set_target(pose, Target(w.goal[:, :, lane]))
        for i in range(3):
            w.target[9 + i, lane] = pose[i]
    seeds, distances = batch.seeds[row], w.distances[home]
    choose_start(
        chain, pose, seeds, library, attempt, w.goal[:, :, lane], distances, w.start[:, lane]
    )
    state[NEXT, home] = attempt + 1
    state[HOME, lane], state[ATTEMPT, lane] = home, attempt
    leads = state[GIVEN_UP, home] == attempt
    _descend(w, lane, options.iterations - state[USED, home] if leads else options.iterations)
    return True


@njit(_nrt=False)
def _open(batch, options, state, lane):  # type: ignore[no-untyped-def]
    """Take a pose from the queue; return the lane as its home, or -1 where there is none.

    Of a pose that is proven out of reach only the nearest answer is looked for, from few starts.
    """
    row = _take(batch.next)
    if row >= batch.poses.shape[0]:
        return -1
    starts = options.starts
    if batch.proven[row]:
        starts = min(starts, options.nearest_starts)
    state[MOST, lane] = starts
    state[ROW, lane], state[NEXT, lane], state[CAP, lane] = row, 0.0, starts
    state[GIVEN_UP, lane], state[USED, lane], state[POSE_LEAST, lane] = 0.0, 0.0, np.inf
    return lane


@njit(_nrt=False)
def _to_help(state):  # type: ignore[no-untyped-def]
    """Return the home of the pose that fewest lanes work at, -1 if none has starts left.

    A pose whose first start has not been given up is likely to need no other one.
    """
    home, fewest = -1, np.inf
    for k in range(LANES):
        ahead = state[NEXT, k] - state[GIVEN_UP, k]
        if (
            state[ROW, k] >= 0.0
            and state[GIVEN_UP, k] > 0.0
            and state[NEXT, k] < state[CAP, k]
            and ahead < fewest
        ):
            home, fewest = k, ahead
    return home


@njit(_nrt=False)
def _descend(w, lane, limit):  # type: ignore[no-untyped-def]
    """Let a lane descend from its start, with a limit of iterations."""
    state = w.state
    for k in range(w.q.shape[0]):
        w.q[k, lane] = w.start[k, lane]
    state[LEAST, lane], state[SINCE, lane], state[REFERENCE, lane] = np.inf, 0.0, np.inf
    state[ITERATIONS, lane], state[LIMIT, lane], state[ACTIVE, lane] = 0.0, limit, 1.0
    state[ENDED, lane] = GOES_ON


@njit(_nrt=False, inline="always")
def settle(batch, options, w, lane, ended):  # type: ignore[no-untyped-def]
    """Draw the consequences of the end of a lane's descent.

    Args:
        batch: The `Batch`.
        options: `LmOptions`.
        w: `Work`.
        lane: Which lane.
        ended: FOUND, OUT_OF_ITERATIONS or STALLED.

    Returns:
        Bits of the lanes that are idle now.
    """
    state = w.state
    home = int(state[HOME, lane])
    idle = 0
    if home < 0:
        return idle  # an earlier start was decided in this very iteration
    state[ACTIVE, lane], state[ENDED, lane] = 0.0, ended
    if state[ATTEMPT, lane] != state[GIVEN_UP, home]:
        if ended == FOUND:
            state[CAP, home] = min(state[CAP, home], state[ATTEMPT, lane] + 1.0)
            idle |= _dismiss(state, home, state[ATTEMPT, lane])
        return idle
    while True:
        left = options.iterations - state[USED, home]
        used, ended = state[ITERATIONS, lane], int(state[ENDED, lane])
        if used > left or (ended == OUT_OF_ITERATIONS and used < left):
            _descend(w, lane, left)  # it went on beyond the limit, or thought it nearer: once more
            return idle
        state[USED, home] += used
        if ended == FOUND or state[LEAST, lane] < state[POSE_LEAST, home]:
            state[POSE_LEAST, home] = state[LEAST, lane]
            for k in range(w.best.shape[0]):
                w.pose_best[k, home] = w.best[k, lane]
        if ended == STALLED:
            last = state[GIVEN_UP, home] + 1.0 >= state[MOST, home]
            ended = OUT_OF_ITERATIONS if used == left else (OUT_OF_STARTS if last else GOES_ON)
        if ended != GOES_ON:
            _finish(batch, w, home, ended)
            return idle | _close(state, home)
        state[GIVEN_UP, home] += 1.0
        idle |= 1 << lane
        lane = _leading(state, home)
        if lane < 0:
            return idle
        if state[ENDED, lane] == GOES_ON:
            state[LIMIT, lane] = options.iterations - state[USED, home]
            return idle


@njit(_nrt=False)
def _leading(state, home):  # type: ignore[no-untyped-def]
    """Return the lane with the first start of a pose that is not given up, -1 if none has it."""
    if state[NEXT, home] > state[GIVEN_UP, home]:
        for lane in range(LANES):
            if state[HOME, lane] == home and state[ATTEMPT, lane] == state[GIVEN_UP, home]:
                return lane
    return -1


@njit(_nrt=False)
def _dismiss(state, home, attempt):  # type: ignore[no-untyped-def]
    """Make lanes idle that descend from later starts of a pose than this; return their bits."""
    idle = 0
    for lane in range(LANES):
        if state[HOME, lane] == home and state[ATTEMPT, lane] > attempt:
            state[HOME, lane], state[ACTIVE, lane] = -1.0, 0.0
            idle |= 1 << lane
    return idle


@njit(_nrt=False)
def _close(state, home):  # type: ignore[no-untyped-def]
    """Forget a pose that is decided; return bits of the lanes that worked at it."""
    state[ROW, home] = -1.0
    return _dismiss(state, home, -1.0)


@njit(_nrt=False)
def _finish(batch, w, home, status):  # type: ignore[no-untyped-def]
    """Write down how a pose ended."""
    row = int(w.state[ROW, home])
    batch.status[row] = OUT_OF_REACH if batch.proven[row] and status != FOUND else status
    batch.starts[row] = int(w.state[GIVEN_UP, home]) + 1
    batch.iterations[row] = int(w.state[USED, home])
    for k in range(w.pose_best.shape[0]):
        batch.joints[row, k] = w.pose_best[k, home]
