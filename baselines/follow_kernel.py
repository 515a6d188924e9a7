"""Compiled following of a motion: from the answer of one pose to that of the next.

Steps of Levenberg-Marquardt alone (`baselines.lm_kernel`) move a redundant arm as little as they
can, and it drifts to where the limit of a joint ends its branch of solutions. Here the first step
adds a motion within the null space of the Jacobian that lowers

    H(q) = - sum log(1 - x_k^2), x_k = (q_k - middle_k) / half range_k

by gradient projection (Liegeois, "Automatic Supervisory Control of the Configuration and Behavior
of Multibody Mechanisms", IEEE Transactions on Systems, Man and Cybernetics 1977); the logarithm is
the barrier of interior-point methods (Nocedal and Wright, "Numerical Optimization", section 19.6).
No joint moves further by it than a share of what the step towards the target moves the joint that
moves most: where the target stands still the arm does, and a motion does not depend on how many
waypoints a second it is cut into.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.clock import now_ns
from baselines.compiled_query import REFUSED
from baselines.damped_solve import damped_solve
from baselines.damped_step import damped_step, project_gradient, step_inside
from baselines.joint_range import take_initial, turn_nearest
from baselines.linearise import (
    Linearisation,
    find_error,
    find_jacobian,
    new_linearisation,
    set_target,
)
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS
from baselines.lm_query import drawn_in
from baselines.taken_poses import take_pose
from robots.compiled import njit
from robots.rows import copy_row

Array = NDArray[np.float64]

STEPS = 12  # after which a pose that is not reached is left to the solver's search
NEAREST = 1.0 - 1e-4  # |x| beyond which a joint counts as so far from its middle


class FollowWork(NamedTuple):
    """Arrays that one thread works in; see `damped_step`."""

    at: Linearisation
    solved: Array
    residual: Array
    step: Array
    free: NDArray[np.bool_]
    q: Array
    gradient: Array
    curvature: Array
    bias: Array


@njit()
def new_follow_work(joints, dof):  # type: ignore[no-untyped-def]
    """Room for a chain of `joints` driven joints and `dof` variables."""
    return FollowWork(
        new_linearisation(joints, dof),
        np.empty(6),
        np.empty(6),
        np.empty(dof),
        np.empty(dof, dtype=np.bool_),
        np.empty(dof),
        np.empty(dof),
        np.empty(dof),
        np.empty(dof),
    )


@njit(_nrt=False)
def limit_barrier(joints, q, gradient, curvature):  # type: ignore[no-untyped-def]
    """Write the first and the second derivatives of H along each joint.

    Args:
        joints: `JointRange`; one that turns for ever, or has no range, has no part in H.
        q: (dof,) [rad or m].
        gradient: (dof,) receives dH / dq_k.
        curvature: (dof,) receives d²H / dq_k², above zero where the joint has a part.
    """
    for k in range(q.shape[0]):
        half = 0.5 * (joints.upper[k] - joints.lower[k])
        gradient[k], curvature[k] = 0.0, 0.0
        if joints.endless[k] or half <= 0.0:
            continue
        x = min(max((q[k] - joints.lower[k]) / half - 1.0, -NEAREST), NEAREST)
        room = 1.0 - x * x
        gradient[k] = 2.0 * x / (room * half)
        curvature[k] = 2.0 * (1.0 + x * x) / (room * room * half * half)


@njit(_nrt=False)
def find_null_motion(joints, w, pull, gain, damping):  # type: ignore[no-untyped-def]
    """Write into w.bias the motion within the null space, after `find_error` and `find_jacobian`.

    It leads down the projected gradient to where a quadratic model of H - pᵀ q is least, or no
    further than the bound.

    Args:
        joints: `JointRange`.
        w: `FollowWork`; q and at stand for a configuration.
        pull: (dof,) p, which way each joint is drawn [1/rad or 1/m], or None for no way.
        gain: Bound of the motion of a joint, as a share of the largest in the step to the target.
        damping: λ of both steps [m² and rad²].
    """
    J, dof = w.at.jacobian, w.q.shape[0]
    w.free[:] = True
    damped_solve(J, w.free, w.at.error, damping, w.solved)
    bound = 0.0
    for k in range(dof):
        moved = 0.0
        for i in range(6):
            moved += J[k, i] * w.solved[i]
        bound = max(bound, gain * abs(moved))
    limit_barrier(joints, w.q, w.gradient, w.curvature)
    if pull is not None:
        for k in range(dof):
            w.gradient[k] -= pull[k]
    along, largest = project_gradient(w, damping)
    bend = 0.0
    for k in range(dof):
        bend += w.curvature[k] * w.bias[k] * w.bias[k]
    scale = 0.0
    if along > 0.0 and bend > 0.0:
        scale = min(along / bend, bound / largest)
    for k in range(dof):
        w.bias[k] *= -scale


@njit(_nrt=False)
def follow_from(chain, joints, pose, options, pull, gain, w):  # type: ignore[no-untyped-def]
    """Descend from w.q to the next pose (7,), at least one step; w.q is where it ended.

    Returns:
        Whether the pose is reached, and the steps.
    """
    position2 = options.position_tolerance_m**2
    rotation2 = options.rotation_tolerance_rad**2
    passes = options.max_active_set_passes
    most = min(STEPS, options.iterations)
    set_target(pose, w.at)
    steps = 0
    while True:
        distance2, angle2 = find_error(chain, w.q, pose, w.at)
        if steps > 0 and distance2 <= position2 and angle2 <= rotation2:
            return True, steps
        if steps >= most:
            return False, steps
        damping = options.damping + options.damping_gain * (distance2 + angle2)
        if steps == 0:
            find_jacobian(chain, w.at)
            find_null_motion(joints, w, pull, gain, damping)
            step_inside(chain, w, w.bias, damping, passes)
        else:
            damped_step(chain, w, None, damping, passes)
        steps += 1


@njit()
def follow_seed(  # type: ignore[no-untyped-def]
    chain, joints, target, last, seeds, answer, options, pull, gain, max_jump, w
):
    """Descend from the answer to one pose to the next pose.

    Args:
        chain: The robot's `Chain`.
        joints: `JointRange`.
        target: (7,) checked pose.
        last: (1, dof) answer to the pose before as it was given [rad or m].
        seeds: (1, dof) the same inside the limits.
        answer: (dof,) receives the joints [rad or m].
        options: `LmOptions`.
        pull: See `find_null_motion`.
        gain: See `find_null_motion`.
        max_jump: See `follow_query`.
        w: `FollowWork`.

    Returns:
        Whether the pose is reached, and the steps.
    """
    copy_row(seeds[0], w.q)
    if max_jump is None:
        reached, steps = follow_from(chain, joints, target, options, pull, gain, w)
    else:
        near = drawn_in(chain, seeds[0], max_jump)
        reached, steps = follow_from(near, joints, target, options, pull, gain, w)
    copy_row(w.q, answer)
    turn_nearest(last, joints, answer)
    return reached, steps


@njit()
def follow_query(pose, last, answer, options, joints, chain, gain, max_jump):  # type: ignore[no-untyped-def]
    """Solve the pose that follows an answer.

    Args:
        pose: (7,) target in the base frame, x y z [m], qw qx qy qz.
        last: (1, dof) answer to the pose before [rad or m].
        answer: (dof,) receives the joints [rad or m].
        options: `LmOptions`; its time is not looked at, `STEPS` are sooner done.
        joints: `JointRange`.
        chain: The robot's `Chain`.
        gain: See `find_null_motion`.
        max_jump: How far each joint may be from the last answer [rad or m]; None for any distance.

    Returns:
        Status, iterations, starts and time [ns], or (`REFUSED`, 0, 0, 0).
    """
    dof = answer.shape[0]
    target, seeds = np.empty(7), np.empty((1, dof))
    if not (take_pose(pose, target) and take_initial(last, joints, seeds)):
        return REFUSED, 0, 0, 0
    timespec = np.empty(2, dtype=np.int64)
    began = now_ns(timespec)
    w = new_follow_work(chain.prismatic.shape[0], dof)
    reached, steps = follow_seed(
        chain, joints, target, last, seeds, answer, options, None, gain, max_jump, w
    )
    return FOUND if reached else OUT_OF_ITERATIONS, steps, 1, now_ns(timespec) - began
