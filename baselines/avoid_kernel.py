"""Compiled descent to joints that reach a pose and are free of collision.

Descents of `baselines.lm_kernel` give one configuration after the other that reaches the pose. One
that collides slides within the null space of the Jacobian along the direction that leads away from
what is too near (gradient projection: Siciliano et al., "Robotics: Modelling, Planning and
Control", section 3.5.1; as long a step as takes the linearised sum of squares to zero) until it is
free or gets nowhere; then comes the next start.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.clock import now_ns
from baselines.damped_step import damped_step, project_gradient
from baselines.linearise import (
    Linearisation,
    find_error,
    find_jacobian,
    new_linearisation,
    set_target,
)
from baselines.lm_kernel import FOUND, IN_COLLISION, limited, refine_from
from robots.clearance_kernel import place, push_away, set_obstacles
from robots.compiled import njit
from robots.rows import copy_row

Array = NDArray[np.float64]

RETURN_STEPS = 4  # damped steps that lead back to the target after one of the null space
STALLED = 3  # steps of the null space within which the sum of squares has to fall
FALL = 0.9  # to this share of what it was
NO_MOTION = 1e-6  # share of a squared gradient that counts as none within the null space


class Slide(NamedTuple):
    """How a configuration that collides is moved within the null space.

    Attributes:
        steps: Steps at most; 0 leaves it where it is.
        margin_m: What is nearer than the clearance and this is pushed away [m].
        move: Largest motion of a joint in one step [rad or m].
    """

    steps: int
    margin_m: float
    move: float


class Work(NamedTuple):
    """Arrays that one thread works in; see `damped_step` and `lm_kernel`."""

    at: Linearisation
    solved: Array
    step: Array
    free: NDArray[np.bool_]
    q: Array
    timespec: NDArray[np.int64]
    distances: NDArray[np.float32]
    residual: Array
    gradient: Array
    bias: Array
    reached: Array


def new_work(joints: int, dof: int, remembered: int) -> Work:
    """Room for a chain of `joints` driven joints, `dof` variables, and a seed library."""
    return Work(
        at=new_linearisation(joints, dof),
        solved=np.empty(6),
        step=np.empty(dof),
        free=np.empty(dof, dtype=np.bool_),
        q=np.empty(dof),
        timespec=np.empty(2, dtype=np.int64),
        distances=np.empty(remembered, dtype=np.float32),
        residual=np.empty(6),
        gradient=np.empty(dof),
        bias=np.empty(dof),
        reached=np.zeros(dof),
    )


@njit(_nrt=False)
def _find_bias(chain, w, damping, squared, move):  # type: ignore[no-untyped-def]
    """Write the motion within the null space that leads away; return whether there is any.

    After `find_error`; a joint at a limit that it would be pushed beyond stays where it is.
    """
    find_jacobian(chain, w.at)
    g = w.gradient
    whole = 0.0
    for k in range(g.shape[0]):
        low, high = w.q[k] <= chain.lower[k], w.q[k] >= chain.upper[k]
        w.free[k] = not ((low and g[k] < 0.0) or (high and g[k] > 0.0))
        if w.free[k]:
            whole += g[k] * g[k]
    along, largest = project_gradient(w, damping)
    if along <= NO_MOTION * whole:
        return False
    scale = min(squared / along, move / largest)
    for k in range(g.shape[0]):
        w.bias[k] *= scale
    return True


@njit(_nrt=False)
def _within(options, distance2, angle2):  # type: ignore[no-untyped-def]
    position2 = options.position_tolerance_m**2
    return distance2 <= position2 and angle2 <= options.rotation_tolerance_rad**2


@njit(_nrt=False)
def _step(chain, pose, options, squared, slide, w, iterations):  # type: ignore[no-untyped-def]
    """Move w.q once within the null space and back to the target.

    Returns:
        Whether it moved and reaches the target, and the iterations so far.
    """
    find_error(chain, w.q, pose, w.at)
    if not _find_bias(chain, w, options.damping, squared, slide.move):
        return False, iterations
    passes = options.max_active_set_passes
    damped_step(chain, w, w.bias, options.damping, passes)
    for _ in range(RETURN_STEPS):
        iterations += 1
        distance2, angle2 = find_error(chain, w.q, pose, w.at)
        if _within(options, distance2, angle2):
            return True, iterations
        damping = options.damping + options.damping_gain * (distance2 + angle2)
        damped_step(chain, w, None, damping, passes)
    distance2, angle2 = find_error(chain, w.q, pose, w.at)
    return _within(options, distance2, angle2), iterations


@njit(_nrt=False)
def _slide(chain, pose, options, scene, room, clearance, slide, w, iterations):  # type: ignore[no-untyped-def]
    """Move w.q, which reaches the pose, until it is free.

    Returns:
        The sum of squares that is missing, whether it is free, and the iterations so far.
    """
    place(scene, w.q, room)
    squared, free = push_away(scene, room, clearance, slide.margin_m, w.gradient)
    reference = squared
    for step in range(slide.steps):
        if free or iterations >= options.iterations:
            break
        reaches, iterations = _step(chain, pose, options, squared, slide, w, iterations)
        if not reaches:
            break
        place(scene, w.q, room)
        squared, free = push_away(scene, room, clearance, slide.margin_m, w.gradient)
        if step % STALLED == STALLED - 1:
            if squared > FALL * reference:
                break
            reference = squared
    return squared, free, iterations


@njit(_nrt=False)
def _avoid_one(  # type: ignore[no-untyped-def]
    chain, pose, seeds, library, options, scene, room, clearance, slide, first, w, best
):
    """Solve one pose; writes the best joints and returns (status, iterations, starts)."""
    began = now_ns(w.timespec) if options.time_ns > 0 else 0
    left = options
    attempt, iterations, least, reached = first, 0, np.inf, False
    while True:
        status, iterations, attempt = refine_from(
            chain, pose, seeds, library, left, None, w, w.reached, attempt, iterations
        )
        if status != FOUND:
            break
        reached = True
        copy_row(w.reached, w.q)
        squared, free, iterations = _slide(
            chain, pose, options, scene, room, clearance, slide, w, iterations
        )
        if free:
            copy_row(w.q, best)
            return FOUND, iterations, attempt
        if squared < least:
            least = squared
            copy_row(w.q, best)
        if options.time_ns > 0:
            rest = options.time_ns - (now_ns(w.timespec) - began)
            if rest <= 0:
                break
            left = limited(options, options.starts, rest)
    if not reached:
        copy_row(w.reached, best)
        return status, iterations, attempt
    return IN_COLLISION, iterations, attempt


@njit(nogil=True, _nrt=False)
def avoid_rows(  # type: ignore[no-untyped-def]
    chain, poses, seeds, library, options, scene, obstacles, slide, w, room, first, joints, outcomes
):
    """Solve a batch.

    Args:
        chain: The robot's `Chain`.
        poses: (N, 7) targets in the base frame [m, unit quaternion].
        seeds: (N, K, dof) starts before those of the library and random ones [rad or m].
        library: `SeedLibrary`.
        options: `LmOptions`.
        scene: `Scene` of the robot.
        obstacles: `ObstacleRows` of N poses.
        slide: `Slide`.
        w: `Work`.
        room: `Room` for the largest set of obstacles.
        first: (N,) first start of each pose.
        joints: (N, dof) receives the joints.
        outcomes: (N, 4) receives status, iterations, starts and time [ns].
    """
    for row in range(poses.shape[0]):
        began = now_ns(w.timespec)
        set_obstacles(scene, obstacles, row, room)
        set_target(poses[row], w.at)
        clearance = obstacles.clearance[row]
        status, iterations, starts = _avoid_one(
            *(chain, poses[row], seeds[row], library, options, scene, room, clearance),
            *(slide, first[row], w, joints[row]),
        )
        outcomes[row, 0], outcomes[row, 1], outcomes[row, 2] = status, iterations, starts
        outcomes[row, 3] = now_ns(w.timespec) - began
