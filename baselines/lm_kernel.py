"""Compiled Levenberg-Marquardt inverse kinematics with joint limits as an active set.

One step solves (J Jᵀ + λ I) y = e and moves the joints by Jᵀ y, where e holds the distance to the
target [m] and the rotation vector [rad], and λ follows the squared error (Sugihara,
"Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", IEEE T-RO 2011). A joint
at its limit whose step points outward is frozen and the step is solved again (Nocedal and Wright,
"Numerical Optimization", section 16.5). A descent whose squared error has not halved within
`patience` iterations is given up: the next seed follows, then random configurations.

Every random number depends on the target alone, so that a row of the result does not depend on
the batch around it, its order or the number of threads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from baselines.clock import now_ns, pose_key, uniform
from robots.kinematics import apply_constant, apply_joint

Array = NDArray[np.float64]

FOUND, OUT_OF_ITERATIONS, OUT_OF_TIME, OUT_OF_STARTS = 0, 1, 2, 3


class LmOptions(NamedTuple):
    """What the kernel needs beside robot, targets and seeds.

    Attributes:
        position_tolerance_m: Distance to the target at which a solution is claimed [m].
        rotation_tolerance_rad: Rotation angle at which it is claimed [rad].
        damping: Constant part of λ [m² and rad²].
        damping_gain: λ per squared error.
        patience: Iterations within which the squared error has to halve.
        freezes: How often a step is solved again with joints frozen.
        iterations: Iterations per pose, summed over starts.
        starts: Seeds and random configurations tried per pose.
        time_ns: Time per pose [ns], 0 for no limit.
    """

    position_tolerance_m: float
    rotation_tolerance_rad: float
    damping: float
    damping_gain: float
    patience: int
    freezes: int
    iterations: int
    starts: int
    time_ns: int


class _Scratch(NamedTuple):
    """Arrays that one thread works in."""

    R: Array
    p: Array
    axes: Array
    origins: Array
    jacobian: Array  # (dof, 6), one row a joint
    normal: Array
    error: Array
    solved: Array
    step: Array
    free: NDArray[np.bool_]
    q: Array
    goal: Array
    timespec: NDArray[np.int64]


@njit(cache=True)
def _scratch(joints, dof):  # type: ignore[no-untyped-def]
    return _Scratch(
        np.empty((3, 3)),
        np.empty(3),
        np.empty((joints, 3)),
        np.empty((joints, 3)),
        np.empty((dof, 6)),
        np.empty((6, 6)),
        np.empty(6),
        np.empty(6),
        np.empty(dof),
        np.empty(dof, dtype=np.bool_),
        np.empty(dof),
        np.empty((3, 3)),
        np.empty(2, dtype=np.int64),
    )


@njit(cache=True)
def goal_rotation(pose, goal):  # type: ignore[no-untyped-def]
    """Write the rotation matrix of a pose (7,) into `goal` (3, 3)."""
    w, x, y, z = pose[3], pose[4], pose[5], pose[6]
    goal[0, 0], goal[0, 1], goal[0, 2] = (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
    )
    goal[1, 0], goal[1, 1], goal[1, 2] = (
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
    )
    goal[2, 0], goal[2, 1], goal[2, 2] = (
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )


@njit(cache=True)
def rotation_error(R, goal, error):  # type: ignore[no-untyped-def]
    """Write the rotation vector that turns `R` into `goal`, axes of the base, into error[3:].

    Twice the sine times the axis is the sum of the cross products of the frames' axes (Siciliano
    et al., "Robotics: Modelling, Planning and Control", equation 3.91).
    """
    sx = sy = sz = trace = 0.0
    for k in range(3):
        sx += R[1, k] * goal[2, k] - R[2, k] * goal[1, k]
        sy += R[2, k] * goal[0, k] - R[0, k] * goal[2, k]
        sz += R[0, k] * goal[1, k] - R[1, k] * goal[0, k]
        trace += R[0, k] * goal[0, k] + R[1, k] * goal[1, k] + R[2, k] * goal[2, k]
    sine2 = math.sqrt(sx * sx + sy * sy + sz * sz)
    cosine2 = trace - 1.0
    if sine2 > 1e-9:
        scale = math.atan2(sine2, cosine2) / sine2
    elif cosine2 > 0.0:
        scale = 0.5
    else:
        # Half a turn: any axis does to get away from here, the next step knows better.
        sx, sy, sz, scale = 1.0, 0.0, 0.0, math.pi
    error[3], error[4], error[5] = scale * sx, scale * sy, scale * sz


@njit(cache=True)
def _frames(chain, q, s):  # type: ignore[no-untyped-def]
    """Tip frame, and axis and origin of every joint, for the configuration q (dof,)."""
    R, p = s.R, s.p
    for i in range(3):
        p[i] = chain.translations[0, i]
        for j in range(3):
            R[i, j] = chain.rotations[0, i, j]
    for k in range(chain.prismatic.shape[0]):
        for i in range(3):
            s.axes[k, i] = R[i, 2]
            s.origins[k, i] = p[i]
        position = chain.multiplier[k] * q[chain.variable[k]] + chain.offset[k]
        apply_joint(R, p, chain.prismatic[k], position)
        apply_constant(R, p, chain.rotations[k + 1], chain.translations[k + 1])


@njit(cache=True)
def _jacobian(chain, s):  # type: ignore[no-untyped-def]
    """Geometric Jacobian at the tip, axes of the base, transposed, from `_frames`."""
    J = s.jacobian
    J[:, :] = 0.0
    for k in range(chain.prismatic.shape[0]):
        row, scale = chain.variable[k], chain.multiplier[k]
        zx, zy, zz = scale * s.axes[k, 0], scale * s.axes[k, 1], scale * s.axes[k, 2]
        if chain.prismatic[k]:
            J[row, 0] += zx
            J[row, 1] += zy
            J[row, 2] += zz
            continue
        dx = s.p[0] - s.origins[k, 0]
        dy = s.p[1] - s.origins[k, 1]
        dz = s.p[2] - s.origins[k, 2]
        J[row, 0] += zy * dz - zz * dy
        J[row, 1] += zz * dx - zx * dz
        J[row, 2] += zx * dy - zy * dx
        J[row, 3] += zx
        J[row, 4] += zy
        J[row, 5] += zz


@njit(cache=True, fastmath={"contract", "reassoc"})
def _solve_normal(s, damping):  # type: ignore[no-untyped-def]
    """Solve (J Jᵀ + λ I) y = e over the free joints by Cholesky, y into s.solved."""
    A, J, y = s.normal, s.jacobian, s.solved
    for i in range(6):
        for j in range(i + 1):
            A[i, j] = 0.0
        A[i, i] = damping
    for k in range(J.shape[0]):
        if s.free[k]:
            for i in range(6):
                for j in range(i + 1):
                    A[i, j] += J[k, i] * J[k, j]
    for i in range(6):
        for j in range(i):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            A[i, j] = total * A[j, j]
        total = A[i, i]
        for k in range(i):
            total -= A[i, k] * A[i, k]
        # The diagonal keeps the inverse: a product is cheaper than a quotient.
        A[i, i] = 1.0 / math.sqrt(max(total, 1e-30))
    for i in range(6):
        total = s.error[i]
        for k in range(i):
            total -= A[i, k] * y[k]
        y[i] = total * A[i, i]
    for i in range(5, -1, -1):
        total = y[i]
        for k in range(i + 1, 6):
            total -= A[k, i] * y[k]
        y[i] = total * A[i, i]


@njit(cache=True)
def _step(chain, s, damping, freezes):  # type: ignore[no-untyped-def]
    """Move s.q by one damped step inside the limits, freezing joints that push outward."""
    dof = s.q.shape[0]
    s.free[:] = True
    for _ in range(freezes + 1):
        _solve_normal(s, damping)
        frozen = False
        for k in range(dof):
            if not s.free[k]:
                s.step[k] = 0.0
                continue
            total = 0.0
            for i in range(6):
                total += s.jacobian[k, i] * s.solved[i]
            s.step[k] = total
            if (s.q[k] <= chain.lower[k] and total < 0.0) or (
                s.q[k] >= chain.upper[k] and total > 0.0
            ):
                s.free[k] = False
                frozen = True
        if not frozen:
            break
    for k in range(dof):
        s.q[k] = min(max(s.q[k] + s.step[k], chain.lower[k]), chain.upper[k])


@njit(cache=True)
def _start(chain, seeds, key, attempt, q):  # type: ignore[no-untyped-def]
    """The `attempt`-th configuration to start from: the seeds in order, then random ones."""
    count, dof = seeds.shape[0], q.shape[0]
    for k in range(dof):
        if attempt < count:
            q[k] = min(max(seeds[attempt, k], chain.lower[k]), chain.upper[k])
        else:
            share = uniform(key, (attempt - count) * dof + k)
            q[k] = chain.lower[k] + share * (chain.upper[k] - chain.lower[k])


@njit(cache=True)
def _refine_one(chain, pose, seeds, options, s, best):  # type: ignore[no-untyped-def]
    """Solve one pose; writes the best joints and returns (status, iterations, starts)."""
    started = now_ns(s.timespec) if options.time_ns > 0 else 0
    position2 = options.position_tolerance_m**2
    rotation2 = options.rotation_tolerance_rad**2
    goal_rotation(pose, s.goal)
    key = pose_key(pose)
    error = s.error
    least = np.inf
    iterations = 0
    for attempt in range(options.starts):
        _start(chain, seeds, key, attempt, s.q)
        since, reference = 0, np.inf
        while True:
            _frames(chain, s.q, s)
            for i in range(3):
                error[i] = pose[i] - s.p[i]
            rotation_error(s.R, s.goal, error)
            distance2 = error[0] ** 2 + error[1] ** 2 + error[2] ** 2
            angle2 = error[3] ** 2 + error[4] ** 2 + error[5] ** 2
            squared = distance2 + angle2
            if squared < least:
                least = squared
                best[:] = s.q
            if distance2 <= position2 and angle2 <= rotation2:
                best[:] = s.q
                return FOUND, iterations, attempt + 1
            if iterations >= options.iterations:
                return OUT_OF_ITERATIONS, iterations, attempt + 1
            if (
                options.time_ns > 0
                and iterations & 3 == 3
                and now_ns(s.timespec) - started >= options.time_ns
            ):
                return OUT_OF_TIME, iterations, attempt + 1
            if since == options.patience:
                if squared > 0.5 * reference:
                    break
                since = 0
            if since == 0:
                reference = squared
            _jacobian(chain, s)
            _step(chain, s, options.damping + options.damping_gain * squared, options.freezes)
            iterations += 1
            since += 1
    return OUT_OF_STARTS, iterations, options.starts


@njit(cache=True)
def refine_rows(chain, poses, seeds, options, joints, status, iterations, starts, time_ns):  # type: ignore[no-untyped-def]
    """Solve a batch on one thread."""
    s = _scratch(chain.prismatic.shape[0], joints.shape[1])
    for row in range(poses.shape[0]):
        began = now_ns(s.timespec)
        status[row], iterations[row], starts[row] = _refine_one(
            chain, poses[row], seeds[row], options, s, joints[row]
        )
        time_ns[row] = now_ns(s.timespec) - began


@njit(cache=True, parallel=True)
def refine_rows_parallel(  # type: ignore[no-untyped-def]
    chain, poses, seeds, options, joints, status, iterations, starts, time_ns
):
    """Compute `refine_rows` on all threads of numba; the same joints, bitwise."""
    block = 16
    for b in prange((poses.shape[0] + block - 1) // block):
        r = slice(b * block, min((b + 1) * block, poses.shape[0]))
        refine_rows(
            chain,
            poses[r],
            seeds[r],
            options,
            joints[r],
            status[r],
            iterations[r],
            starts[r],
            time_ns[r],
        )
