"""Levenberg-Marquardt on LANES poses side by side: the algorithm of `baselines.lm_kernel`.

Every lane descends for a pose, and those that are done take the next from a queue, which the lanes
of all threads share. An answer depends on its pose, its seeds and the settings alone, bitwise: not
on the other lanes, the batch or the threads.

Nothing here allocates, so that all is compiled with `_nrt=False`: numba then counts no references
to arrays, which would take longer than the arithmetic. The steps of an iteration say
`forceinline=True` each: numba hands that option and the other one down to whatever a function is
the first to call, so that without it the code would depend on who called first.
"""

from __future__ import annotations

from baselines.lanes import LANES, load, mask_bits, select, store
from baselines.lanes_kinematics import find_lanes_error, find_lanes_frames, find_lanes_jacobian
from baselines.lanes_starts import STALLED, begin, settle
from baselines.lanes_step import lanes_damped_step
from baselines.lanes_work import ACTIVE, ITERATIONS, LEAST, LIMIT, REFERENCE, SINCE, work_of
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS
from robots.compiled import njit


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
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
    spent = active & ~found & (iterations >= load(state, LIMIT))
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


@njit(nogil=True, _nrt=False)
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
    w = work_of(room, thread, chain.prismatic.shape[0], batch.joints.shape[1])
    found, spent, stalled = 0, 0, 0
    idle = (1 << LANES) - 1
    while True:
        ended = found | spent | stalled
        for lane in range(LANES if ended else 0):
            bit = 1 << lane
            if ended & bit:
                end = OUT_OF_ITERATIONS if spent & bit else STALLED
                idle |= settle(batch, options, w, lane, FOUND if found & bit else end)
        if idle and (ended or idle == (1 << LANES) - 1):
            for lane in range(LANES):
                if idle & 1 << lane and begin(chain, batch, library, options, w, lane):
                    idle ^= 1 << lane
            if idle == (1 << LANES) - 1:
                break
        found, spent, stalled = _advance(chain, w, options)
